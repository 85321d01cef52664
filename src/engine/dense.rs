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
    use super::super::tests::{kerr, well};
    use super::super::{Accuracy, Engine};

    #[test]
    fn windows_join() {
        for (geometry, start) in [well(), kerr()] {
            let mut engine = Engine::accurate(&geometry, &start, 20.0, Accuracy::Local(1e-6), 16).unwrap();
            while let Some(window) = engine.next().unwrap() {
                let dense = window.dense();
                let at = |fraction: f64| {
                    let (mut q, mut p) = (vec![0.0; dense.q.len()], vec![0.0; dense.p.len()]);
                    dense.at(fraction, &mut q, &mut p);
                    [q, p].concat()
                };
                let [start, end] = [window.start(), window.end()].map(|it| [it.positions(), it.momenta()].concat());
                assert_eq!([at(0.0), at(1.0)], [start, end.clone()]);
                for (near, end) in at(1.0 - 1e-12).iter().zip(end) {
                    assert!((near - end).abs() < 1e-10 * end.abs().max(1.0), "{near} {end}");
                }
            }
        }
    }
}
