//! Symmetric compositions of the Störmer–Verlet step.

use super::driver::{EqualSteps, Method, Task, Walker, equal_steps};
use super::equations::{Equations, Parts};
use super::{Failure, Trajectory};

/// Drift x ← x + h w and kick (w, t) ← (w, t) + h (a, u)(x) in turns. With t as a coordinate whose momentum is the
/// parameter Q_t, each is the exact flow of a part of the Hamiltonian: the whole is symplectic and symmetric. It needs
/// equations of that kind, where no rate but that of x depends on w. It has no dense output: the number of its steps is
/// a multiple of the intervals of the output.
pub(super) struct Composition {
    /// The first half of the symmetric lengths of the kicks, with the middle one.
    half: &'static [f64],
    /// True if sums carry what their rounding drops.
    compensated: bool,
}

#[allow(clippy::excessive_precision)] // The constants as they are published, to 18 digits.
impl Composition {
    pub(super) const VERLET: Self = Self { half: &[1.0], compensated: false };

    /// Kahan, Li, "Composition constants for raising the orders of unconventional schemes for ordinary differential
    /// equations", Math. Comp. 66 (1997) 1089–1099, as in Hairer, Lubich, Wanner, "Geometric Numerical Integration",
    /// V.3.2.
    pub(super) const KAHAN_LI_6: Self = Self {
        half: &[
            0.392_161_444_007_314_14,
            0.332_599_136_789_359_43,
            -0.706_246_172_557_639_36,
            0.082_213_596_293_550_8,
            0.798_543_990_934_829_96,
        ],
        compensated: false,
    };

    /// From the same place.
    pub(super) const KAHAN_LI_8: Self = Self {
        half: &[
            0.130_202_483_088_890_09,
            0.561_162_981_775_108_38,
            -0.389_474_962_644_847_29,
            0.158_841_906_555_155_6,
            -0.395_903_894_133_237_57,
            0.184_539_640_978_315_71,
            0.258_374_387_686_322_05,
            0.295_011_723_609_310_3,
            -0.605_508_533_830_034_5,
        ],
        compensated: false,
    };

    pub(super) const KAHAN_LI_8_COMPENSATED: Self = Self { compensated: true, ..Self::KAHAN_LI_8 };

    /// The lengths of kicks and drifts for steps of length `h`.
    fn lengths(&self, h: f64) -> [Vec<f64>; 2] {
        let n = 2 * self.half.len() - 1;
        let kicks: Vec<f64> = (0..n).map(|k| h * self.half[k.min(n - 1 - k)]).collect();
        // The last drift of a step and the first of the next are one.
        let drifts = (0..n).map(|k| 0.5 * (kicks[k] + kicks[(k + 1) % n])).collect();
        [kicks, drifts]
    }
}

impl Method for Composition {
    #[inline(always)]
    fn integrate<E: Equations>(&self, equations: E, task: &Task<'_>) -> Result<Trajectory, Failure> {
        let (steps, intervals) = (task.setting.count, task.output.intervals);
        assert!(steps > 0 && steps.is_multiple_of(intervals), "{steps} steps on {intervals} intervals");
        if !equations.parts().is_second_order {
            return Err(Failure::NotSeparable);
        }
        let [kicks, drifts] = self.lengths(task.problem.length / steps as f64);
        let (at, low, rates) = (equations.start(), equations.rows(0.0), equations.rows(0.0));
        if self.compensated {
            equal_steps(equations, task, Walk::<E, true> { kicks: &kicks, drifts: &drifts, at, low, rates })
        } else {
            equal_steps(equations, task, Walk::<E, false> { kicks: &kicks, drifts: &drifts, at, low, rates })
        }
    }
}

/// A state on its way, whose numbers are compensated sums if C.
struct Walk<'l, E: Equations, const C: bool> {
    kicks: &'l [f64],
    drifts: &'l [f64],
    at: E::Rows<f64>,
    /// What rounding dropped from the sums.
    low: E::Rows<f64>,
    /// The derivatives at the state.
    rates: E::Rows<f64>,
}

impl<E: Equations, const C: bool> Walker<E> for Walk<'_, E, C> {
    #[inline(always)]
    fn state(&self) -> &E::Rows<f64> {
        &self.at
    }
}

/// Adds `term` to a sum; if C, by Kahan's step.
#[inline(always)]
fn add<const C: bool>(sum: &mut f64, low: &mut f64, term: f64) {
    if C {
        let term = term + *low;
        let next = *sum + term;
        *low = term - (next - *sum);
        *sum = next;
    } else {
        *sum += term;
    }
}

/// Moves positions for a time `length`.
#[inline(always)]
fn drift<const C: bool>(at: &mut [f64], low: &mut [f64], parts: Parts, length: f64) {
    for k in parts.unknowns() {
        let w = at[k + parts.behind()];
        add::<C>(&mut at[k], &mut low[k], length * w);
    }
}

impl<E: Equations, const C: bool> EqualSteps<E> for Walk<'_, E, C> {
    #[inline(always)]
    fn advance(self, equations: &mut E, steps: usize) -> Result<Self, Failure> {
        let parts = equations.parts();
        let Self { kicks, drifts, mut at, mut low, mut rates } = self;
        let last = kicks.len() - 1;
        drift::<C>(at.as_mut(), low.as_mut(), parts, 0.5 * kicks[0]);
        for step in 1..=steps {
            for k in 0..=last {
                equations.rates(&at, &mut rates);
                let (sums, low) = (at.as_mut(), low.as_mut());
                for kicked in [parts.driving(), 0..parts.quadratures] {
                    for j in kicked {
                        add::<C>(&mut sums[j], &mut low[j], kicks[k] * rates.as_ref()[j]);
                    }
                }
                let length = if k == last && step == steps { 0.5 * kicks[last] } else { drifts[k] };
                drift::<C>(sums, low, parts, length);
            }
        }
        Ok(Self { kicks, drifts, at, low, rates })
    }
}
