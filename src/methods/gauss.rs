//! Collocation on Gauss nodes: symplectic, symmetric, of order 2s.

use std::sync::OnceLock;

use super::composition::Sum;
use super::force::{Force, WithForce, dispatch};
use super::{Failure, Marks, Output, Problem, State, Trajectory, check};

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauss {
    /// Number of stages s: 2, 4, 6, 8, 10 or 12.
    pub stages: usize,
    /// The iteration ends when the error of X is below this, relative to its size; 0 goes to rounding.
    pub tolerance: f64,
}

impl Gauss {
    /// The world-line in this number of `steps` of equal length.
    ///
    /// # Errors
    /// [`Failure`].
    ///
    /// # Panics
    /// If there is no method with this number of stages.
    pub fn run(&self, problem: &Problem, output: &Output, steps: usize) -> Result<Trajectory, Failure> {
        match self.stages {
            2 => self.sized::<2>(problem, output, steps),
            4 => self.sized::<4>(problem, output, steps),
            6 => self.sized::<6>(problem, output, steps),
            8 => self.sized::<8>(problem, output, steps),
            10 => self.sized::<10>(problem, output, steps),
            12 => self.sized::<12>(problem, output, steps),
            stages => panic!("no Gauss method of {stages} stages"),
        }
    }

    fn sized<const S: usize>(&self, problem: &Problem, output: &Output, steps: usize) -> Result<Trajectory, Failure> {
        let h = problem.length / steps as f64;
        let unit = Unit::shared(S);
        let tables = Tables::<S>::scaled(unit, h);
        let tolerance = self.tolerance;
        dispatch(&problem.metric, problem.q_t(), March { problem, output, steps, unit, tables: &tables, h, tolerance })
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

struct March<'a, const S: usize> {
    problem: &'a Problem,
    output: &'a Output,
    steps: usize,
    unit: &'a Unit,
    tables: &'a Tables<S>,
    h: f64,
    tolerance: f64,
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

impl<const S: usize> WithForce for March<'_, S> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with(self, mut force: impl Force) -> Self::Output {
        let Self { problem, output, steps, unit, tables, h, tolerance } = self;
        let State { elapsed, x, w } = problem.start();
        let [mut t, mut x, mut w] = [elapsed, x, w].map(Sum::<true>::new);
        let (mut a, mut u) = ([force.at(x.value).1; S], [0.0; S]);
        let mut sweeps = 0;
        let mut first = true;
        let mut marks = Marks::new(output, steps);
        let mut states = Vec::with_capacity(output.marks.len());
        let last = Marks::last(output, steps);
        for step in 0..last {
            if !first {
                let mut guess = [0.0; S];
                multiply(&tables.next, &a, &mut guess);
                a = guess;
            }
            first = false;
            let base: [f64; S] = std::array::from_fn(|i| x.low + tables.hc[i] * w.value);
            let mut z = [f64::INFINITY; S];
            let mut change_before = f64::INFINITY;
            let mut iteration = 0;
            loop {
                let mut shift = base;
                multiply(&tables.square, &a, &mut shift);
                let now = shift.map(|shift| x.value + shift);
                let change = largest::<S>(std::array::from_fn(|i| now[i] - z[i]));
                z = now;
                for i in 0..S {
                    (u[i], a[i]) = force.at(z[i]);
                }
                iteration += 1;
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
            sweeps += iteration;
            let start = State { elapsed: t.value, x: x.value, w: w.value };
            x.add(h * w.value + (h * w.low + dot(&tables.position, &a)));
            w.add(dot(&tables.weight, &a));
            t.add(dot(&tables.weight, &u));
            let mut waiting = marks.within(step);
            while waiting.is_some() {
                let (mut fractions, mut count) = ([1.0; TOGETHER], 0);
                while let Some(fraction) = waiting.filter(|_| count < TOGETHER) {
                    fractions[count] = fraction;
                    count += 1;
                    waiting = marks.within(step);
                }
                let is_inside = fractions[0] < 1.0;
                let points = if is_inside { inside(unit, &u, &a, fractions) } else { Default::default() };
                for l in 0..count {
                    let s = h * fractions[l];
                    let state = if fractions[l] < 1.0 {
                        State {
                            elapsed: start.elapsed + h * points[0][l],
                            x: start.x + (s * start.w + h * h * points[1][l]),
                            w: start.w + h * points[2][l],
                        }
                    } else {
                        State { elapsed: t.value, x: x.value, w: w.value }
                    };
                    check(&problem.metric, state)?;
                    states.push(state);
                }
            }
        }
        Ok(Trajectory { states, evaluations: sweeps * S, steps: last })
    }
}
