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
use crate::sbp::polynomial::extent;

/// Places that are computed side by side.
const LANES: usize = 8;

/// The motion over a window.
#[derive(Debug, Clone)]
pub struct Dense {
    pub(super) q: Vec<Curve>,
    pub(super) p: Vec<Curve>,
}

/// The most coefficients of a curve: those of slopes, integrated twice.
const MOST_MODES: usize = MOST_POINTS + 2;

/// The factors a and b of P_{k+1} = a x P_k − b P_{k−1}.
const FACTORS: [[f64; 2]; MOST_MODES] = {
    let (mut factors, mut k) = ([[0.0; 2]; MOST_MODES], 0);
    while k < MOST_MODES {
        factors[k] = [(2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64];
        k += 1;
    }
    factors
};

/// So many of P_0, P_1, … at several x side by side; zeros behind them.
fn legendre<const L: usize>(x: [f64; L], modes: usize) -> [[f64; L]; MOST_MODES] {
    let (mut before, mut now, mut all) = ([0.0; L], [1.0; L], [[0.0; L]; MOST_MODES]);
    for (values, [up, down]) in all.iter_mut().zip(FACTORS).take(modes) {
        *values = now;
        let next = std::array::from_fn(|i| up * x[i] * now[i] - down * before[i]);
        before = std::mem::replace(&mut now, next);
    }
    all
}

/// A function of s by the Legendre coefficients of what it is ahead of its start.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    pub(super) start: Compensated<f64>,
    pub(super) end: f64,
    pub(super) increment: Vec<f64>,
}

impl Curve {
    /// The number of its coefficients.
    fn modes(&self) -> usize {
        self.increment.len()
    }

    /// The values at the places at which the Legendre polynomials have these values, a row for each degree.
    fn at<const L: usize>(&self, legendre: &[[f64; L]]) -> [f64; L] {
        let mut increments = [0.0; L];
        for (c, values) in self.increment.iter().zip(legendre) {
            increments.iter_mut().zip(values).for_each(|(sum, p)| *sum += c * p);
        }
        increments.map(|increment| self.start.high + (self.start.low + increment))
    }
}

impl Dense {
    /// q^a of all coordinates and p_a of active ones at a fraction in [0, 1] of the window.
    ///
    /// # Panics
    /// If there is not as much room as there are values.
    pub fn at(&self, fraction: f64, q: &mut [f64], p: &mut [f64]) {
        // Sums of coefficients have rounding errors, and the start has none.
        let modes = if fraction == 0.0 { 0 } else { self.modes() };
        let legendre = legendre([2.0 * fraction - 1.0], modes);
        for (curves, out) in [(&self.q, q), (&self.p, p)] {
            assert_eq!(curves.len(), out.len(), "a place for each value");
            for (out, curve) in out.iter_mut().zip(curves) {
                [*out] = if fraction == 1.0 { [curve.end] } else { curve.at(&legendre) };
            }
        }
    }

    /// The largest number of coefficients of a curve.
    fn modes(&self) -> usize {
        self.q.iter().chain(&self.p).map(Curve::modes).max().unwrap_or(0)
    }

    /// Adds q^a of all coordinates and p_a of active ones at many fractions in [0, 1] to rows.
    pub(crate) fn append(&self, fractions: impl Iterator<Item = f64>, q: &mut [Vec<f64>], p: &mut [Vec<f64>]) {
        let (mut fractions, modes) = (fractions.peekable(), self.modes());
        while fractions.peek().is_some() {
            let mut x = [0.0; LANES];
            let filled = x.iter_mut().zip(&mut fractions).map(|(x, fraction)| *x = 2.0 * fraction - 1.0).count();
            let legendre = legendre(x, modes);
            for (curve, row) in self.q.iter().chain(&self.p).zip(q.iter_mut().chain(&mut *p)) {
                row.extend_from_slice(&curve.at(&legendre)[..filled]);
            }
        }
    }

    /// By how much q^a changes at most, and what the window leaves open of it.
    pub(crate) fn extent_of_q(&self, a: usize) -> [f64; 2] {
        extent(&self.q[a].increment)
    }

    /// The same of the momentum of the active coordinate with that place.
    pub(crate) fn extent_of_p(&self, place: usize) -> [f64; 2] {
        extent(&self.p[place].increment)
    }

    /// q^a of one coordinate.
    pub(super) fn position(&self, a: usize, fraction: f64) -> f64 {
        if fraction == 1.0 {
            self.q[a].end
        } else {
            self.q[a].at(&legendre([2.0 * fraction - 1.0], self.q[a].modes()))[0]
        }
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
