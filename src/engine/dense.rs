//! A window between its nodes.
//!
//! The slopes on the nodes are those of a polynomial, and its integral from the start of the window is the motion: at
//! the end of the window it is the end, so that windows join. On Lobatto nodes it is more accurate than the nodes
//! themselves, whose errors slopes carry on only by their derivatives.
//!
//! ```text
//! x(s) = x₀ + h Σ_k a_k ∫_0^s P_k,    ∫_0^s P_k = (P_{k+1} − P_{k−1})/2(2k + 1), or (1 + P_1)/2 for k = 0,
//! ```
//!
//! with P_k at 2s − 1, and once more for positions where accelerations are the slopes.

use super::MOST_POINTS;
use crate::number::Compensated;

/// Places that are computed side by side.
const LANES: usize = 8;

/// The motion over a window.
#[derive(Debug, Clone)]
pub struct Dense {
    pub(super) q: Vec<Curve>,
    pub(super) p: Vec<Curve>,
    /// The degree of the curves.
    pub(super) degree: usize,
}

/// The most coefficients of a curve: those of slopes, integrated twice.
const MOST_MODES: usize = MOST_POINTS + 2;

/// a and b of P_{k+1} = a x P_k − b P_{k−1}.
fn recurrence(k: usize) -> [f64; 2] {
    [(2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64]
}

/// P_0, P_1, … at x.
fn legendre(x: f64) -> [f64; MOST_MODES] {
    let (mut before, mut now) = (0.0, 1.0);
    std::array::from_fn(|k| {
        let [up, down] = recurrence(k);
        let here = now;
        (before, now) = (now, up * x * now - down * before);
        here
    })
}

/// A function of s by the Legendre coefficients of what it is ahead of its start.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    pub(super) start: Compensated<f64>,
    pub(super) end: f64,
    pub(super) increment: Vec<f64>,
}

impl Curve {
    fn at(&self, fraction: f64, legendre: &[f64]) -> f64 {
        if fraction == 1.0 {
            return self.end;
        }
        let increment: f64 = self.increment.iter().zip(legendre).map(|(c, p)| c * p).sum();
        self.start.high + (self.start.low + increment)
    }
}

impl Dense {
    /// q^a of all coordinates and p_a of active ones at a fraction in [0, 1] of the window.
    ///
    /// # Panics
    /// If there is not as much room as there are values.
    pub fn at(&self, fraction: f64, q: &mut [f64], p: &mut [f64]) {
        // Sums of coefficients have rounding errors, and the start has none.
        let legendre = if fraction == 0.0 { [0.0; MOST_MODES] } else { legendre(2.0 * fraction - 1.0) };
        for (curves, out) in [(&self.q, q), (&self.p, p)] {
            assert_eq!(curves.len(), out.len(), "a place for each value");
            out.iter_mut().zip(curves).for_each(|(out, curve)| *out = curve.at(fraction, &legendre));
        }
    }

    /// Adds q^a of all coordinates and p_a of active ones at many fractions in [0, 1] to rows.
    pub(crate) fn append(&self, fractions: impl Iterator<Item = f64>, q: &mut [Vec<f64>], p: &mut [Vec<f64>]) {
        let mut fractions = fractions.peekable();
        let mut sums = vec![[0.0; LANES]; q.len() + p.len()];
        while fractions.peek().is_some() {
            let mut x = [0.0; LANES];
            let filled = x.iter_mut().zip(&mut fractions).map(|(x, fraction)| *x = 2.0 * fraction - 1.0).count();
            self.increments(&x, &mut sums);
            let curves = self.q.iter().chain(&self.p).zip(q.iter_mut().chain(&mut *p));
            for ((curve, row), sums) in curves.zip(&sums) {
                row.extend(sums[..filled].iter().map(|increment| curve.start.high + (curve.start.low + increment)));
            }
        }
    }

    /// Computes by how much the curves, those of positions first, are ahead of their starts where 2s − 1 is `x`.
    fn increments(&self, x: &[f64; LANES], sums: &mut [[f64; LANES]]) {
        sums.fill([0.0; LANES]);
        let (mut before, mut now) = ([0.0; LANES], [1.0; LANES]);
        for k in 0..=self.degree {
            for (curve, sum) in self.q.iter().chain(&self.p).zip(&mut *sums) {
                let c = curve.increment.get(k).copied().unwrap_or(0.0);
                sum.iter_mut().zip(&now).for_each(|(sum, p)| *sum += c * p);
            }
            let [up, down] = recurrence(k);
            for ((before, now), x) in before.iter_mut().zip(&mut now).zip(x) {
                (*before, *now) = (*now, up * x * *now - down * *before);
            }
        }
    }

    /// q^a of one coordinate.
    pub(super) fn position(&self, a: usize, fraction: f64) -> f64 {
        self.q[a].at(fraction, &legendre(2.0 * fraction - 1.0))
    }
}

/// The coefficients of the integral from s = 0 over a window of length h.
pub(super) fn integrated(coefficients: &[f64], h: f64) -> Vec<f64> {
    let mut integral = vec![0.0; coefficients.len() + 1];
    for (k, c) in coefficients.iter().enumerate() {
        let share = 0.5 * h * c / (2 * k + 1) as f64;
        integral[k + 1] += share;
        integral[k.saturating_sub(1)] += if k == 0 { share } else { -share };
    }
    integral
}

#[cfg(test)]
mod tests {
    use super::super::tests::{kerr, lifted, schwarzschild, well};
    use super::super::{Accuracy, Engine};
    use crate::geometry::{Geometry, Start};

    /// The curves of all windows with their places in γ.
    fn curves((geometry, start): &(Geometry, Start), length: f64, accuracy: f64) -> Vec<(f64, f64, super::Dense)> {
        let wanted = Accuracy::Local(accuracy);
        let mut engine = Engine::accurate(geometry, start, length, wanted, 16).unwrap();
        let mut curves = Vec::new();
        while let Some(window) = engine.next().unwrap() {
            curves.push((window.gamma, window.length, window.dense()));
        }
        curves
    }

    fn at(curves: &[(f64, f64, super::Dense)], gamma: f64) -> Vec<f64> {
        let place = curves.partition_point(|curve| curve.0 <= gamma) - 1;
        let (start, length, dense) = &curves[place];
        let (mut q, mut p) = (vec![0.0; dense.q.len()], vec![0.0; dense.p.len()]);
        dense.at((gamma - start) / length, &mut q, &mut p);
        [q, p].concat()
    }

    /// Between nodes the motion is as accurate as on them.
    #[test]
    fn places_between_nodes_are_accurate() {
        let henon_heiles = lifted("(x^2 + y^2)/2 + x^2*y - y^3/3", &["x", "y"], &[0.1, 0.2], &[0.3, -0.1]);
        for (scene, length) in [(henon_heiles, 20.0), (well(), 8.0), (schwarzschild(), 300.0), (kerr(), 60.0)] {
            let exact = curves(&scene, length, 1e-13);
            for accuracy in [1e-5, 1e-8, 1e-11] {
                let found = curves(&scene, length, accuracy);
                for k in 1..1000 {
                    let gamma = length * f64::from(k) / 1000.0;
                    for (found, exact) in at(&found, gamma).iter().zip(at(&exact, gamma)) {
                        let off = (found - exact).abs() / exact.abs().max(1.0);
                        assert!(off < 2.0 * accuracy, "{accuracy:e} at {gamma}: {off:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn windows_join() {
        for (geometry, start) in [well(), kerr()] {
            let wanted = Accuracy::Local(1e-6);
            let mut engine = Engine::accurate(&geometry, &start, 20.0, wanted, 16).unwrap();
            while let Some(window) = engine.next().unwrap() {
                let dense = window.dense();
                let (mut q, mut p) = (vec![0.0; dense.q.len()], vec![0.0; dense.p.len()]);
                for (fraction, state) in [(0.0, window.start()), (1.0, window.end())] {
                    dense.at(fraction, &mut q, &mut p);
                    assert_eq!((&q, &p), (&state.positions(), &state.momenta()));
                }
                let end = [q.clone(), p.clone()].concat();
                dense.at(1.0 - 1e-12, &mut q, &mut p);
                for (near, end) in [q.clone(), p.clone()].concat().iter().zip(end) {
                    assert!((near - end).abs() < 1e-10 * end.abs().max(1.0), "{near} {end}");
                }
            }
        }
    }
}
