//! Collocation on Gauss nodes: symplectic, symmetric, of order 2s.

use std::sync::OnceLock;

use super::composition::Sum;
use super::driver::{Counted, EqualSteps, Walker, equal_steps};
use super::force::Force;
use super::{About, Failure, Output, Peer, Problem, Setting, State, Step, Trajectory};

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
/// by fixed-point iteration from the polynomial of the step before, with compensated summation: as in Hairer,
/// McLachlan, Razakarivony (2008), "Achieving Brouwer's law with implicit Runge–Kutta methods", but for the tables,
/// which are in `f64`. Between the ends of steps t, x and w are the integrals of the polynomials through a and u at the
/// stages: of order s + 1 in w and t.
///
/// The iteration ends when the error of X is below the tolerance, relative to its size; 0 goes to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gauss {
    /// Number of stages s: 2, 4, 6, 8, 10 or 12.
    pub stages: usize,
}

impl Gauss {
    fn sized<const S: usize>(problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        let h = problem.length / setting.count as f64;
        let unit = Unit::shared(S);
        let tables = Tables::<S>::scaled(unit, h);
        let start = problem.start();
        let [t, x, w] = [start.elapsed, start.x, start.w].map(Sum::new);
        let (a, u, is_first) = ([0.0; S], [0.0; S], true);
        let walk = Walk { unit, tables: &tables, h, tolerance: setting.tolerance, start, t, x, w, a, u, is_first };
        equal_steps(problem, output, setting.count, walk)
    }
}

impl Peer for Gauss {
    fn about(&self) -> About {
        About {
            name: format!("Gauss {}", self.stages),
            curve: "Gauss–Legendre",
            order: Some(2 * self.stages),
            step: Step::Iterated,
            has_dense_output: true,
            coarsest: 0.05,
            source: "Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231",
        }
    }

    /// # Panics
    /// If there is no method with this number of stages.
    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        match self.stages {
            2 => Self::sized::<2>(problem, output, setting),
            4 => Self::sized::<4>(problem, output, setting),
            6 => Self::sized::<6>(problem, output, setting),
            8 => Self::sized::<8>(problem, output, setting),
            10 => Self::sized::<10>(problem, output, setting),
            12 => Self::sized::<12>(problem, output, setting),
            stages => panic!("no Gauss method of {stages} stages"),
        }
    }
}

/// The tables for a step of length 1, made once in the life of the program; matrices by columns.
struct Unit {
    c: Vec<f64>,
    b: Vec<f64>,
    /// A².
    square: Vec<f64>,
    /// Values of the interpolating polynomial at the nodes of the next step.
    next: Vec<f64>,
    /// Coefficients of the interpolating polynomial: that of P_k over 2(2k + 1), as
    /// ∫P_k = (P_{k+1} − P_{k−1})/(2(2k + 1)) with P_{−1} = −1.
    modes: Vec<f64>,
}

/// P_0 … P_n at z.
fn legendre(n: usize, z: f64) -> Vec<f64> {
    let mut p = vec![1.0, z];
    for k in 1..n {
        p.push(((2 * k + 1) as f64 * z * p[k] - k as f64 * p[k - 1]) / (k + 1) as f64);
    }
    p
}

impl Unit {
    /// Most stages.
    const MOST: usize = 12;

    fn shared(s: usize) -> &'static Self {
        static UNITS: [OnceLock<Unit>; Unit::MOST + 1] = [const { OnceLock::new() }; Unit::MOST + 1];
        UNITS[s].get_or_init(|| Self::new(s))
    }

    fn new(s: usize) -> Self {
        let slope = |p: &[f64], z: f64| s as f64 * (p[s - 1] - z * p[s]) / (1.0 - z * z);
        let node = |i: usize| {
            let mut z = -(std::f64::consts::PI * (i as f64 + 0.75) / (s as f64 + 0.5)).cos();
            for _ in 0..20 {
                let p = legendre(s, z);
                z -= p[s] / slope(&p, z);
            }
            z
        };
        let z: Vec<f64> = (0..s).map(node).collect();
        let c: Vec<f64> = z.iter().map(|z| 0.5 * (1.0 + z)).collect();
        let weight = |&z: &f64| {
            let slope = slope(&legendre(s, z), z);
            1.0 / ((1.0 - z * z) * slope * slope)
        };
        let b: Vec<f64> = z.iter().map(weight).collect();
        // A_ij = b_j Σ_k (2k+1) P_k(c_j) ∫_0^{c_i} P_k, exact for the polynomials that matter.
        let a = |i: usize, j: usize| {
            let (at_i, at_j) = (legendre(s + 1, z[i]), legendre(s, z[j]));
            let terms = (1..s).map(|k| at_j[k] * (at_i[k + 1] - at_i[k - 1]));
            0.5 * b[j] * (terms.sum::<f64>() + 1.0 + z[i])
        };
        let square = |i: usize, j: usize| (0..s).map(|k| a(i, k) * a(k, j)).sum::<f64>();
        let lagrange = |i: usize, j: usize| {
            let others = (0..s).filter(|&k| k != j);
            others.map(|k| (1.0 + c[i] - c[k]) / (c[j] - c[k])).product::<f64>()
        };
        let columns =
            |f: &dyn Fn(usize, usize) -> f64| (0..s).flat_map(|j| (0..s).map(move |i| f(i, j))).collect::<Vec<f64>>();
        // The norm of P_k cancels the denominator but for a half.
        let mode = |k: usize, j: usize| 0.5 * b[j] * legendre(s, z[j])[k];
        let modes = columns(&mode);
        Self { square: columns(&square), next: columns(&lagrange), modes, c: c.clone(), b: b.clone() }
    }
}

/// The tables, scaled with the step; matrices by columns.
struct Tables<const S: usize> {
    /// h c.
    hc: [f64; S],
    /// h² A².
    square: [[f64; S]; S],
    /// h b.
    weight: [f64; S],
    /// h² b (1 − c).
    position: [f64; S],
    /// Values of the interpolating polynomial at the nodes of the next step.
    next: [[f64; S]; S],
}

impl<const S: usize> Tables<S> {
    fn scaled(unit: &Unit, h: f64) -> Self {
        let Unit { c, b, square, next, .. } = unit;
        Self {
            hc: std::array::from_fn(|i| h * c[i]),
            square: std::array::from_fn(|j| std::array::from_fn(|i| h * h * square[j * S + i])),
            weight: std::array::from_fn(|j| h * b[j]),
            position: std::array::from_fn(|j| h * h * b[j] * (1.0 - c[j])),
            next: std::array::from_fn(|j| std::array::from_fn(|i| next[j * S + i])),
        }
    }
}

struct Walk<'a, const S: usize> {
    unit: &'a Unit,
    tables: &'a Tables<S>,
    h: f64,
    tolerance: f64,
    /// Where the last step began.
    start: State,
    t: Sum<true>,
    x: Sum<true>,
    w: Sum<true>,
    /// a and u at the stages of the last step.
    a: [f64; S],
    u: [f64; S],
    is_first: bool,
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

/// Points that are computed together.
const TOGETHER: usize = 8;

/// ∫u, ∬a and ∫a over [0, s] for several s, by the values of u and a at the stages.
#[inline(always)]
fn inside<const S: usize>(unit: &Unit, u: &[f64; S], a: &[f64; S], s: [f64; TOGETHER]) -> [[f64; TOGETHER]; 3] {
    let (mut t, mut w) = ([0.0; S], [0.0; S]);
    for (j, column) in unit.modes.chunks_exact(S).enumerate() {
        for k in 0..S {
            t[k] += column[k] * u[j];
            w[k] += column[k] * a[j];
        }
    }
    let mut out = [[0.0; TOGETHER]; 3];
    let (mut p, mut before) = ([1.0; TOGETHER], [-1.0; TOGETHER]);
    for k in 0..=S {
        let share = 0.5 / (2 * k + 1) as f64;
        let [t, w, w_before, w_after] = [
            t.get(k).copied().unwrap_or(0.0),
            w.get(k).copied().unwrap_or(0.0),
            w[k.saturating_sub(1)],
            w.get(k + 1).copied().unwrap_or(0.0),
        ];
        let x = share * (w_before - w_after);
        let (next, last) = ((2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64);
        for l in 0..TOGETHER {
            let after = next * (2.0 * s[l] - 1.0) * p[l] - last * before[l];
            let difference = after - before[l];
            out[0][l] += t * difference;
            out[1][l] += x * difference;
            out[2][l] += w * difference;
            (before[l], p[l]) = (p[l], after);
        }
    }
    out
}

#[inline(always)]
fn dot<const S: usize>(a: &[f64; S], b: &[f64; S]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[inline(always)]
fn largest<const S: usize>(values: [f64; S]) -> f64 {
    values.iter().fold(0.0, |largest: f64, v| if v.abs() > largest { v.abs() } else { largest })
}

/// Solves for a and u at the stages of a step from (`x`, `w`), where `a` is a guess.
#[inline(always)]
fn iterate<const S: usize>(
    force: &mut Counted<impl Force>,
    (tables, tolerance): (&Tables<S>, f64),
    (x, w): (Sum<true>, f64),
    (a, u): (&mut [f64; S], &mut [f64; S]),
) -> Result<(), Failure> {
    let base: [f64; S] = std::array::from_fn(|i| x.low + tables.hc[i] * w);
    let mut z = [f64::INFINITY; S];
    let mut change_before = f64::INFINITY;
    for iteration in 1.. {
        let mut shift = base;
        multiply(&tables.square, a, &mut shift);
        let now = shift.map(|shift| x.value + shift);
        let change = largest::<S>(std::array::from_fn(|i| now[i] - z[i]));
        z = now;
        for i in 0..S {
            (u[i], a[i]) = force.at(z[i]);
        }
        let size = largest(z);
        // The error left is about that share of the change by which changes shrink.
        let rate = change / change_before;
        let left = if change_before.is_finite() { change * rate.min(1.0) } else { change };
        if left <= tolerance * size || change <= f64::EPSILON / 4.0 * size {
            break;
        }
        if rate > 0.5 && change <= ROUNDING * size {
            break;
        }
        if iteration == MOST_ITERATIONS || !size.is_finite() {
            return Err(Failure::NotConverged);
        }
        change_before = change;
    }
    Ok(())
}

impl<const S: usize> Walker for Walk<'_, S> {
    #[inline(always)]
    fn state(&self) -> State {
        State { elapsed: self.t.value, x: self.x.value, w: self.w.value }
    }

    #[inline(always)]
    fn inside<F: Force>(&mut self, _: &mut Counted<F>, fractions: &[f64], states: &mut Vec<State>) {
        let (h, start) = (self.h, self.start);
        for fractions in fractions.chunks(TOGETHER) {
            let mut together = [1.0; TOGETHER];
            together[..fractions.len()].copy_from_slice(fractions);
            let [t, x, w] = inside(self.unit, &self.u, &self.a, together);
            for (l, fraction) in fractions.iter().enumerate() {
                states.push(State {
                    elapsed: start.elapsed + h * t[l],
                    x: start.x + (h * fraction * start.w + h * h * x[l]),
                    w: start.w + h * w[l],
                });
            }
        }
    }
}

impl<const S: usize> EqualSteps for Walk<'_, S> {
    #[inline(always)]
    fn advance<F: Force>(&mut self, force: &mut Counted<F>, steps: usize) -> Result<(), Failure> {
        let Self { tables, h, tolerance, mut t, mut x, mut w, mut a, mut u, .. } = *self;
        for _ in 0..steps {
            if self.is_first {
                a = [force.guess(x.value).1; S];
                self.is_first = false;
            } else {
                let mut guess = [0.0; S];
                multiply(&tables.next, &a, &mut guess);
                a = guess;
            }
            iterate(force, (tables, tolerance), (x, w.value), (&mut a, &mut u))?;
            self.start = State { elapsed: t.value, x: x.value, w: w.value };
            x.add(h * w.value + (h * w.low + dot(&tables.position, &a)));
            w.add(dot(&tables.weight, &a));
            t.add(dot(&tables.weight, &u));
        }
        (self.t, self.x, self.w, self.a, self.u) = (t, x, w, a, u);
        Ok(())
    }
}
