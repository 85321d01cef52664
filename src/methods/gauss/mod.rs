//! Collocation on Gauss nodes: symplectic, symmetric, of order 2s.

mod unit;

use self::unit::{TOGETHER, Unit, differences, modes, once, twice};
use super::composition::Sum;
use super::driver::{BeginEqual, EqualSteps, Walker, equal_steps};
use super::equations::{Counted, Equations, World};
use super::peer::Method;
use super::{About, Failure, Output, Setting, Step, Trajectory};

/// Iterations allowed for a step.
const MOST_ITERATIONS: usize = 60;
/// Below this the iteration has only rounding left, if it no longer converges.
const ROUNDING: f64 = 1e-12;

/// The Gauss–Legendre Runge–Kutta method as it is written for x″ = a(x),
///
/// ```text
/// X = x + h c w + h² A² a(X),   x⁺ = x + h w + h² Σ b_j (1 − c_j) a_j,   w⁺ = w + h Σ b_j a_j,   t⁺ = t + h Σ b_j u_j,
/// ```
///
/// and as Y = y + h A f(Y), y⁺ = y + h Σ b_j f_j for equations of the first order. Both are solved by fixed-point
/// iteration from the polynomial of the step before, with compensated summation: as in Hairer, McLachlan, Razakarivony
/// (2008), "Achieving Brouwer's law with implicit Runge–Kutta methods", but for the tables, which are in `f64`. Between
/// the ends of steps t, x and w are the integrals of the polynomials through a and u at the stages: of order s + 1 in w
/// and t, and in all for equations of the first order.
///
/// The iteration ends when the error of the unknowns is below the tolerance, relative to their size; 0 goes to
/// rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gauss {
    /// Number of stages s: 2, 4, 6, 8 or 12.
    pub stages: usize,
}

impl Method for Gauss {
    fn about(&self) -> About {
        About {
            name: format!("Gauss {}", self.stages),
            curve: "Gauss–Legendre",
            order: Some(2 * self.stages),
            step: Step::Iterated,
            has_dense_output: true,
            needs_second_order: false,
            coarsest: 0.05,
            source: "Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231",
        }
    }

    /// # Panics
    /// If there is no method with this number of stages.
    fn drive<W: World>(&self, world: &W, output: &Output, setting: Setting) -> Result<Trajectory<W::Point>, Failure> {
        match self.stages {
            2 => sized::<2, W>(world, output, setting),
            4 => sized::<4, W>(world, output, setting),
            6 => sized::<6, W>(world, output, setting),
            8 => sized::<8, W>(world, output, setting),
            12 => sized::<12, W>(world, output, setting),
            stages => panic!("no Gauss method of {stages} stages"),
        }
    }
}

fn sized<const S: usize, W: World>(
    world: &W,
    output: &Output,
    Setting { count, tolerance }: Setting,
) -> Result<Trajectory<W::Point>, Failure> {
    let (unit, h) = (Unit::shared(S), world.length() / count as f64);
    let tables = Tables::<S>::scaled(unit, h, world.is_separable());
    equal_steps(world, output, count, &Scaled { unit, tables, h, tolerance })
}

/// The method of S stages with steps of length `h`.
struct Scaled<const S: usize> {
    unit: &'static Unit,
    tables: Tables<S>,
    h: f64,
    tolerance: f64,
}

impl<const S: usize> BeginEqual for Scaled<S> {
    type Walk<'m, E: Equations> = Walk<'m, E, S>;

    #[inline(always)]
    fn begin<E: Equations>(&self, equations: &E) -> Walk<'_, E, S> {
        let start = equations.start();
        let mut sums = equations.rows(Sum::new(0.0));
        for (sum, &value) in sums.as_mut().iter_mut().zip(start.as_ref()) {
            *sum = Sum::new(value);
        }
        let rates = equations.rows([0.0; S]);
        let stages = Stages {
            places: rates.clone(),
            rates,
            at: start.clone(),
            out: start.clone(),
            changes: equations.rows([0.0; 2]),
            sizes: start.clone(),
        };
        Walk { method: self, start, sums, stages, is_first: true }
    }
}

/// The tables, scaled with the step; matrices by columns.
struct Tables<const S: usize> {
    /// h c.
    hc: [f64; S],
    /// h² A² for equations of the second order, and h A for those of the first.
    matrix: [[f64; S]; S],
    /// h b.
    weight: [f64; S],
    /// h² b (1 − c).
    position: [f64; S],
    /// Values of the interpolating polynomial at the nodes of the next step.
    next: [[f64; S]; S],
}

impl<const S: usize> Tables<S> {
    fn scaled(unit: &Unit, h: f64, is_second_order: bool) -> Self {
        let Unit { c, b, first, square, next, .. } = unit;
        let (scale, matrix) = if is_second_order { (h * h, square) } else { (h, first) };
        Self {
            hc: std::array::from_fn(|i| h * c[i]),
            matrix: std::array::from_fn(|j| std::array::from_fn(|i| scale * matrix[j * S + i])),
            weight: std::array::from_fn(|j| h * b[j]),
            position: std::array::from_fn(|j| h * h * b[j] * (1.0 - c[j])),
            next: std::array::from_fn(|j| std::array::from_fn(|i| next[j * S + i])),
        }
    }
}

pub(super) struct Walk<'m, E: Equations, const S: usize> {
    method: &'m Scaled<S>,
    /// Where the last step began.
    start: E::Rows<f64>,
    sums: E::Rows<Sum<true>>,
    stages: Stages<E, S>,
    is_first: bool,
}

/// The stages of a step.
struct Stages<E: Equations, const S: usize> {
    /// The rates of quadratures, and those from which the unknowns follow.
    rates: E::Rows<[f64; S]>,
    /// The unknowns.
    places: E::Rows<[f64; S]>,
    /// One of the stages, and the derivatives there.
    at: E::Rows<f64>,
    out: E::Rows<f64>,
    /// By how much the last iteration and the one before changed each unknown.
    changes: E::Rows<[f64; 2]>,
    /// The size of each kind of unknowns.
    sizes: E::Rows<f64>,
}

/// `out` += Σ_j column_j v_j.
#[inline(always)]
fn multiply<const S: usize>(columns: &[[f64; S]; S], v: &[f64; S], out: &mut [f64; S]) {
    for (column, v) in columns.iter().zip(v) {
        for i in 0..S {
            out[i] += column[i] * v;
        }
    }
}

#[inline(always)]
fn dot<const S: usize>(a: &[f64; S], b: &[f64; S]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[inline(always)]
fn largest<const S: usize>(values: [f64; S]) -> f64 {
    values.iter().fold(0.0, |largest: f64, v| if v.abs() > largest { v.abs() } else { largest })
}

impl<E: Equations, const S: usize> Stages<E, S> {
    /// Solves for the rates at the stages of a step, where those that drive the unknowns are a guess.
    #[inline(always)]
    fn iterate(
        self,
        equations: &mut Counted<E>,
        Scaled { tables, tolerance, .. }: &Scaled<S>,
        sums: &E::Rows<Sum<true>>,
    ) -> Result<Self, Failure> {
        let Self { mut rates, mut places, mut at, mut out, mut changes, mut sizes } = self;
        let (parts, sums) = (equations.equations.parts(), sums.as_ref());
        for k in parts.unknowns() {
            places.as_mut()[k] = [f64::INFINITY; S];
            changes.as_mut()[k][0] = f64::INFINITY;
        }
        for iteration in 1.. {
            sizes.as_mut().fill(0.0);
            for k in parts.unknowns() {
                let (sum, driving) = (sums[k], k + parts.behind());
                let mut shift = [sum.low; S];
                if parts.is_second_order {
                    let w = sums[driving].value;
                    shift = std::array::from_fn(|i| sum.low + tables.hc[i] * w);
                }
                multiply(&tables.matrix, &rates.as_ref()[driving], &mut shift);
                let now = shift.map(|shift| sum.value + shift);
                let before = std::mem::replace(&mut places.as_mut()[k], now);
                let change = largest::<S>(std::array::from_fn(|i| now[i] - before[i]));
                let changes = &mut changes.as_mut()[k];
                *changes = [change, changes[0]];
                let (size, here) = (&mut sizes.as_mut()[equations.equations.kind(k)], largest(now));
                *size = if *size > here { *size } else { here };
            }
            for i in 0..S {
                for k in parts.unknowns() {
                    at.as_mut()[k] = places.as_ref()[k][i];
                }
                equations.rates(&at, &mut out);
                for k in 0..parts.quadratures {
                    rates.as_mut()[k][i] = out.as_ref()[k];
                }
                for k in parts.driving() {
                    rates.as_mut()[k][i] = out.as_ref()[k];
                }
            }
            let (mut is_done, mut is_finite) = (true, true);
            for k in parts.unknowns() {
                let size = sizes.as_ref()[equations.equations.kind(k)];
                is_done &= is_solved(changes.as_ref()[k], size, *tolerance);
                is_finite &= size.is_finite();
            }
            if is_done {
                break;
            }
            if iteration == MOST_ITERATIONS || !is_finite {
                return Err(Failure::NotConverged);
            }
        }
        Ok(Self { rates, places, at, out, changes, sizes })
    }
}

impl<E: Equations, const S: usize> Walker<E> for Walk<'_, E, S> {
    #[inline(always)]
    fn state(&self, state: &mut E::Rows<f64>) {
        for (state, sum) in state.as_mut().iter_mut().zip(self.sums.as_ref()) {
            *state = sum.value;
        }
    }

    #[inline(always)]
    fn inside(&mut self, equations: &mut Counted<E>, fractions: &[f64], states: &mut Vec<E::Rows<f64>>) {
        let (Scaled { unit, h, .. }, parts, start) = (self.method, equations.equations.parts(), self.start.as_ref());
        for fractions in fractions.chunks(TOGETHER) {
            let mut together = [1.0; TOGETHER];
            together[..fractions.len()].copy_from_slice(fractions);
            let differences = differences(S, together);
            let first = states.len();
            states.resize(first + fractions.len(), self.start.clone());
            for k in (0..parts.quadratures).chain(parts.driving()) {
                let modes = modes(unit, &self.stages.rates.as_ref()[k]);
                let once = once(&modes, &differences);
                for (state, once) in states[first..].iter_mut().zip(once) {
                    state.as_mut()[k] = start[k] + h * once;
                }
                if parts.is_second_order && k >= parts.quadratures {
                    let position = k - parts.behind();
                    let twice = twice(&modes, &differences);
                    for ((state, twice), s) in states[first..].iter_mut().zip(twice).zip(fractions) {
                        state.as_mut()[position] = start[position] + (h * s * start[k] + h * h * twice);
                    }
                }
            }
        }
    }
}

impl<E: Equations, const S: usize> EqualSteps<E> for Walk<'_, E, S> {
    #[inline(always)]
    fn advance(self, equations: &mut Counted<E>, steps: usize) -> Result<Self, Failure> {
        let Self { method, mut start, mut sums, mut stages, mut is_first } = self;
        let Scaled { tables, h, .. } = method;
        let parts = equations.equations.parts();
        for _ in 0..steps {
            if is_first {
                // A first guess, which does not count.
                equations.equations.rates(&start, &mut stages.out);
                for k in parts.driving() {
                    stages.rates.as_mut()[k] = [stages.out.as_ref()[k]; S];
                }
                is_first = false;
            } else {
                for k in parts.driving() {
                    let mut guess = [0.0; S];
                    multiply(&tables.next, &stages.rates.as_ref()[k], &mut guess);
                    stages.rates.as_mut()[k] = guess;
                }
            }
            stages = stages.iterate(equations, method, &sums)?;
            let (sums, rates) = (sums.as_mut(), stages.rates.as_ref());
            for (start, sum) in start.as_mut().iter_mut().zip(&*sums) {
                *start = sum.value;
            }
            if parts.is_second_order {
                for k in parts.unknowns() {
                    let Sum { value: w, low } = sums[k + parts.behind()];
                    sums[k].add(h * w + (h * low + dot(&tables.position, &rates[k + parts.behind()])));
                }
            }
            for driven in [parts.driving(), 0..parts.quadratures] {
                for k in driven {
                    sums[k].add(dot(&tables.weight, &rates[k]));
                }
            }
        }
        Ok(Self { method, start, sums, stages, is_first })
    }
}

/// Whether an unknown of that size is solved, after its last change and the one before.
#[inline(always)]
fn is_solved([change, change_before]: [f64; 2], size: f64, tolerance: f64) -> bool {
    // The error left is about that share of the change by which changes shrink.
    let rate = change / change_before;
    let left = if change_before.is_finite() { change * rate.min(1.0) } else { change };
    left <= tolerance * size || change <= f64::EPSILON / 4.0 * size || (rate > 0.5 && change <= ROUNDING * size)
}
