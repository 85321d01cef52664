//! One window: what becomes of a set of errors from its start to its end.
//!
//! With e = x − y, w = B e and d = v − f(y)
//!
//! ```text
//! w′ = E e + B (Q − d),     E = W + B J(y),     Q = f(y + e) − f(y) − J(y) e,
//! w(h) = e(0) + g ± δ,      g = −∫ B d in the middle,      e(h) = A w(h) ± |I − A B(h)| ε,     |e| ≤ ε on the window.
//! ```
//!
//! For the difference η of two motions of a set d falls out, and Q(e) − Q(e′) takes the place of Q.

use pulp::{Simd, WithSimd};

use super::algebras::{Discs, LANES, Obstacle};
use super::approximate::Approximate;
use super::defect::{Defect, Found};
use super::ellipse::{Bounds, Ellipse};
use super::equations::Equations;
use super::matrices::{Matrices, applied};
use super::proved::{Added, Proved};
use super::set::Set;
use super::tables::{LEBESGUE, TABLES, UP};
use crate::number::ball::Disc;
use crate::number::norm::larger;

/// What a window may add to the error besides rounding, relative to sizes.
const AIM: f64 = 1e-22;
/// The size of E over a window that is worth its length.
const ADJOINT: f64 = 1e-6;
/// The same of sets of starts, whose errors are no roundings: what it adds to them is in no column of the start.
const OF_SETS: f64 = 1e-10;
/// A window that adds so many times more than it may is tried again with a shorter one.
const TOO_MUCH: f64 = 1e3;
/// More than underflow takes away from products of bounds.
const TINY: f64 = 1e-290;

/// Why a window is not proved.
pub(super) enum Refused {
    /// What formulas do on its ellipse.
    Obstacle(Obstacle),
    /// No bound follows.
    Unbounded,
}

/// Room to prove windows in.
pub(super) struct Prover<'g> {
    pub(super) equations: Equations<'g>,
    pub(super) approximate: Approximate,
    pub(super) defect: Defect,
    pub(super) ellipse: Ellipse,
}

impl Prover<'_> {
    /// Proves the window of length `h` from a set.
    #[inline(always)]
    pub(super) fn window(&mut self, set: &Set, h: f64) -> Result<Proved, Refused> {
        let Self { equations, approximate, defect, ellipse } = self;
        let start = &set.start;
        let modes = approximate.slopes(equations, start, h).ok_or(Refused::Unbounded)?;
        let e_0 = set.sizes();
        let found = defect.at_nodes(equations, start, h, &modes);
        let jacobian = ellipse.jacobian_at(equations, &found.places);
        let bounds = ellipse.bounds(equations, (start, h), &grown(equations, &jacobian, h, &e_0), &modes);
        let bounds = bounds.map_err(|obstacle| obstacle.map_or(Refused::Unbounded, Refused::Obstacle))?;
        let coefficients = approximate.adjoint(equations, start, h, &modes).ok_or(Refused::Unbounded)?;
        let matrices = Matrices::new(equations, h, &coefficients, &jacobian, &bounds).ok_or(Refused::Unbounded)?;
        let closing =
            Closing { equations, h, bounds: &bounds, matrices: &matrices, defect: defect_most(&found, &bounds) };
        let epsilon = closing.epsilon(&e_0).ok_or(Refused::Unbounded)?;
        let apart = set.differences.as_ref().map(|differences| closing.apart(&differences.set.radii(), &epsilon));
        let apart = apart.map(|apart| apart.ok_or(Refused::Unbounded)).transpose()?;
        let (gain, parts) = closing.gain(&found, &epsilon).ok_or(Refused::Unbounded)?;
        let sizes = sizes(&found, start);
        let quality = closing.quality(&parts, (&sizes, &e_0), set).ok_or(Refused::Unbounded)?;
        let delta = added(&parts);
        let Closing { defect, .. } = closing;
        // A comparison that is false for NaN.
        if quality < TOO_MUCH {
            let added = Added { delta, epsilon };
            return Ok(Proved { h, modes, gain, added, apart, defect, matrices, bounds, quality, sizes });
        }
        Err(Refused::Unbounded)
    }
}

/// The proof of a window, compiled for the machine: what is not inlined has a call for each fused multiplication.
pub(super) struct Window<'w, 'g> {
    pub(super) prover: &'w mut Prover<'g>,
    pub(super) set: &'w Set,
    pub(super) h: f64,
}

impl WithSimd for Window<'_, '_> {
    type Output = Result<Proved, Refused>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        self.prover.window(self.set, self.h)
    }
}

/// About what errors become of these on the way: (1 + h |J| + ½ h² |J|²) e. A velocity that is known has an error as
/// soon as the place has one, and polydiscs need room for it.
fn grown(equations: &Equations<'_>, jacobian: &[Discs], h: f64, e_0: &[f64]) -> Vec<f64> {
    let sizes: Vec<f64> = jacobian.iter().map(|discs| discs.largest(Disc::size)).collect();
    let (mut all, mut term) = (e_0.to_vec(), e_0.to_vec());
    for part in [h, 0.5 * h] {
        let mut next = vec![0.0; e_0.len()];
        for (entry, size) in equations.entries.iter().zip(&sizes) {
            next[entry.row] += part * size * term[entry.column];
        }
        all.iter_mut().zip(&next).for_each(|(sum, next)| *sum += next);
        term = next;
    }
    all
}

/// δ, with what underflows.
fn added(parts: &[Vec<f64>; 3]) -> Vec<f64> {
    (0..parts[0].len()).map(|i| (parts.iter().map(|part| part[i]).sum::<f64>() + TINY) * UP).collect()
}

/// The largest |y| of every unknown on the nodes.
fn sizes(found: &Found, start: &[f64]) -> Vec<f64> {
    let of = |(k, start): (usize, &f64)| {
        let nodes =
            found.places.get(k).map_or(0.0, |place| place.re.iter().fold(0.0, |most: f64, y| most.max(y.abs())));
        nodes.max(start.abs())
    };
    start.iter().enumerate().map(of).collect()
}

/// A bound of |d| on the window: Λ times that at the nodes, and what interpolation leaves.
pub(super) fn defect_most(found: &Found, bounds: &Bounds) -> Vec<f64> {
    let most = |k: usize| {
        let at_nodes = (0..LANES).fold(0.0, |most, i| larger(most, found.middle[k][i].abs() + found.radius[k][i]));
        (LEBESGUE * at_nodes + TABLES.interpolation * bounds.defect[k] + TINY) * UP
    };
    (0..found.middle.len()).map(most).collect()
}

/// The bounds that close a window.
struct Closing<'w, 'g> {
    equations: &'w Equations<'g>,
    h: f64,
    bounds: &'w Bounds,
    matrices: &'w Matrices,
    defect: Vec<f64>,
}

impl Closing<'_, '_> {
    /// A bound of |Q| for |e| ≤ ε. With s = max ε_k/R_k < ½, by Schwarz' lemma on the disc of all ζ e′, |ζ| < 1, where
    /// e = s e′ has |e′_k| ≤ R_k: |J(y + θe) − J(y)| ≤ 2 S θ s, if no error within the polydisc changes J by more than
    /// 2 S. Then |Q| ≤ ∫_0^1 2 S θ s dθ ε = S s ε.
    fn remainder(&self, epsilon: &[f64]) -> Option<Vec<f64>> {
        Some(self.spread(self.share(epsilon)?, epsilon))
    }

    /// s, if it is small enough.
    fn share(&self, epsilon: &[f64]) -> Option<f64> {
        let active = epsilon.iter().zip(&self.bounds.reach).take(self.equations.active);
        let share = active.fold(0.0, |most, (e, reach)| larger(most, e / reach)) * UP;
        (share < 0.5).then_some(share)
    }

    /// S s e.
    fn spread(&self, share: f64, e: &[f64]) -> Vec<f64> {
        let mut q = vec![0.0; e.len()];
        for (entry, spread) in self.equations.entries.iter().zip(&self.bounds.spread) {
            q[entry.row] += spread * share * e[entry.column] * UP + TINY;
        }
        q
    }

    /// h (Ē ε + B̄ q).
    fn way(&self, epsilon: &[f64], q: &[f64]) -> Vec<f64> {
        let (of_e, of_b) = (applied(&self.matrices.e_most, epsilon), applied(&self.matrices.b_most, q));
        of_e.iter().zip(of_b).map(|(e, b)| self.h * (e + b) * UP).collect()
    }

    fn plus(one: &[f64], other: &[f64]) -> Vec<f64> {
        one.iter().zip(other).map(|(a, b)| (a + b) * UP).collect()
    }

    /// ε with Ā (|e(0)| + h (Ē ε + B̄ (Q̄(ε) + d̄))) < ε. Then |e| < ε on all of the window, and the motion exists
    /// there: at the first place where it fails some |e_k| would be ε_k, and also less.
    fn epsilon(&self, e_0: &[f64]) -> Option<Vec<f64>> {
        self.closed(e_0, &self.defect, |epsilon| self.remainder(epsilon))
    }

    /// The same of the difference η of two motions that are within ε, which begins within `eta_0`: J is the same to
    /// 2 S s all the way from one of them to the other, so that |Q(e) − Q(e′)| ≤ 2 S s |η|.
    fn apart(&self, eta_0: &[f64], epsilon: &[f64]) -> Option<Added> {
        let share = 2.0 * self.share(epsilon)?;
        let most = self.closed(eta_0, &vec![0.0; eta_0.len()], |eta| Some(self.spread(share, eta)))?;
        let way = self.way(&most, &self.spread(share, &most));
        Some(Added { delta: way.iter().map(|way| (way + TINY) * UP).collect(), epsilon: most })
    }

    /// The bound with a given |d| and Q̄ as a function of it.
    fn closed(&self, e_0: &[f64], d: &[f64], q: impl Fn(&[f64]) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
        let next = |epsilon: &[f64]| {
            let q = Self::plus(&q(epsilon)?, d);
            Some(applied(&self.matrices.a_most, &Self::plus(e_0, &self.way(epsilon, &q))))
        };
        let first = Self::plus(e_0, &self.way(&vec![0.0; e_0.len()], d));
        let enlarged: fn(&f64) -> f64 = |e| e * 1.1 + TINY;
        let mut epsilon: Vec<f64> = applied(&self.matrices.a_most, &first).iter().map(enlarged).collect();
        for _ in 0..10 {
            let found = next(&epsilon)?;
            if found.iter().zip(&epsilon).all(|(found, epsilon)| found < epsilon) {
                return Some(epsilon);
            }
            epsilon = found.iter().map(enlarged).collect();
        }
        None
    }

    /// g, and the parts of δ: radii of the sum, what the quadrature leaves, and E ε + B Q.
    #[inline(always)]
    fn gain(&self, found: &Found, epsilon: &[f64]) -> Option<(Vec<f64>, [Vec<f64>; 3])> {
        let (d, half) = (self.matrices.d, 0.5 * self.h);
        let q = self.remainder(epsilon)?;
        let (mut gain, mut radii, mut left) = (vec![0.0; d], vec![0.0; d], vec![0.0; d]);
        for i in 0..d {
            for k in 0..d {
                let (at, mut sum, mut room) = (i * d + k, 0.0, 0.0);
                if self.matrices.b_most[at] == 0.0 {
                    continue;
                }
                let (b, slack) = (&self.matrices.b[at], self.matrices.slack[at]);
                let nodes = b.iter().zip(&TABLES.weights).zip(found.middle[k].iter().zip(&found.radius[k]));
                for ((b, weight), (middle, radius)) in nodes {
                    sum += weight * b * middle;
                    // 36 roundings of each term, and of the table.
                    let off = 40.0 * f64::EPSILON * b.abs() + slack;
                    room += weight * (b.abs() * radius + off * (middle.abs() + radius));
                }
                gain[i] -= half * sum;
                // And those of the sum over k.
                let of_sum = (d + 4) as f64 * f64::EPSILON * self.matrices.b_most[at] * 2.0 * self.defect[k];
                radii[i] += half * (room + of_sum) * UP;
                left[i] += half * TABLES.quadrature * self.matrices.b_there[at] * self.bounds.defect[k] * UP;
            }
        }
        Some((gain, [radii, left, self.way(epsilon, &q)]))
    }

    /// What the window adds besides rounding, as a part of what it may.
    fn quality(&self, [radii, left, _]: &[Vec<f64>; 3], (sizes, e_0): (&[f64], &[f64]), set: &Set) -> Option<f64> {
        // What a shorter window makes smaller: its own share of the error within.
        let none = vec![0.0; sizes.len()];
        let own = applied(&self.matrices.a_most, &self.way(&none, &self.defect));
        let own_way = self.way(&own, &self.remainder(&own)?);
        // An unknown that has hardly begun to move may be smaller than the bound of its error.
        let scale = |k: usize| set.size(k, sizes[k]).max(1e-3 * set.size_of_kind(k));
        let share = |i: usize| (own_way[i] + left[i]) / (0.3 * radii[i] + AIM * scale(i).max(e_0[i]) + TINY);
        // Unknowns that rest at 0 with all of their kind have no scale.
        let counts = |k: usize| k < self.equations.active && scale(k) > TINY;
        let worst = (0..self.equations.active).filter(|&k| counts(k)).map(share).fold(0.0, larger);
        let d = self.matrices.d;
        let e = (0..d * d).filter(|at| counts(at % d) && counts(at / d)).map(|at| {
            let (row, column) = (at / d, at % d);
            let of_errors = e_0[column] / (e_0[row] + AIM * scale(row));
            self.matrices.e_most[at] * self.h * (scale(column) / scale(row)).min(of_errors)
        });
        let e = e.fold(0.0, larger);
        // E falls like h^16, the rest like h^64.
        let adjoint = if set.differences.is_some() { OF_SETS } else { ADJOINT };
        Some(larger(worst, (e / adjoint).powi(4)))
    }
}

#[cfg(test)]
mod tests;
