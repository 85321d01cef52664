//! A measure of the sawtooth, an oscillation in which even and odd nodes move apart.

use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::Window;

/// The amplitude of the (−1)^k component of `u`: max_k |δ⁴u_k| / 16.
///
/// The fourth difference δ⁴u = u_{k−2} − 4u_{k−1} + 6u_k − 4u_{k+1} + u_{k+2} of A(−1)^k is 16A(−1)^k, so a pure
/// sawtooth is measured exactly, while a smooth u contributes only h⁴|u⁽⁴⁾|/16. `None` with fewer than five nodes.
pub fn sawtooth<S: Real>(u: &[S]) -> Option<S> {
    let [four, six, sixteenth] = [4.0, 6.0, 1.0 / 16.0].map(S::from);
    let fourth_difference = |w: &[S]| sixteenth * (w[0] + w[4] - four * (w[1] + w[3]) + six * w[2]).abs();
    u.windows(5).map(fourth_difference).reduce(larger)
}

/// max_k |δ⁶u_k| / 64, which is again A for A(−1)^k, and h⁶|u⁽⁶⁾|/64 for a smooth u. `None` with fewer than seven
/// nodes.
fn sixth_difference<S: Real>(u: &[S]) -> Option<S> {
    let [six, fifteen, twenty, share] = [6.0, 15.0, 20.0, 1.0 / 64.0].map(S::from);
    let difference = |w: &[S]| {
        let even = w[0] + w[6] + fifteen * (w[2] + w[4]);
        share * (even - six * (w[1] + w[5]) - twenty * w[3]).abs()
    };
    u.windows(7).map(difference).reduce(larger)
}

/// The sawtooth of a row of values on the nodes of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sawtooth<S = f64> {
    /// Its largest amplitude in a window, see [`sawtooth()`]; `None` with too few nodes, and for spectral elements.
    pub amplitude: Option<S>,
    /// 1/64 of the largest sixth difference in a window. For a pure sawtooth it is the amplitude, and for a smooth
    /// motion far less than the fourth difference gives. `None` with too few nodes, and for spectral elements.
    pub sixth_difference: Option<f64>,
}

impl<S: Real> Sawtooth<S> {
    /// The sawtooth of `row` in the windows that are equidistant; the last node of the strong form is left out.
    pub(super) fn new(row: &[S], windows: &[Window<S>]) -> Self {
        let windows = || windows.iter().filter(|window| window.is_equidistant()).map(|window| &row[window.exact()]);
        Self {
            amplitude: windows().filter_map(sawtooth).reduce(larger),
            sixth_difference: windows().filter_map(sixth_difference).map(S::to_f64).reduce(larger),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_the_amplitude_and_ignores_cubics() {
        let cubic = |k: i32| f64::from(k * k * k - 2 * k * k + 7);
        let smooth: Vec<f64> = (0..20).map(cubic).collect();
        assert_eq!(sawtooth(&smooth), Some(0.0));
        let rough: Vec<f64> = (0..20).map(|k| cubic(k) + if k % 2 == 0 { 0.25 } else { -0.25 }).collect();
        assert_eq!(sawtooth(&rough), Some(0.25));
        assert_eq!(sawtooth(&rough[..4]), None);
        assert_eq!((sixth_difference(&smooth), sixth_difference(&rough)), (Some(0.0), Some(0.25)));
        assert_eq!(sixth_difference(&rough[..6]), None);
    }
}
