//! The start of a case in numbers: velocities and momenta from each other, and one of them from K.
//!
//! With G = (g_ab), P the coordinates whose momenta are given and V the others, p = G q̇ + A is solved for the q̇ in P:
//!
//! ```text
//! G_PP q̇_P = p_P − A_P − G_PV q̇_V
//! ```
//!
//! If one rate u is to be found from K, q̇ = α + β u, and K = (βᵀGβ) u² + 2 (αᵀGβ) u + αᵀGα.

use super::start_data::{Rate, Sign, StartData};
use crate::geometry::{Geometry, Start, value_of};
use crate::number::Real;

/// Rounding errors of this many units in the last place, for each coordinate, are to be expected in a sum.
const ROUNDING: f64 = 16.0;

/// Why there is no start, what to do, and the key in `[initial]` that it is about; without a key it is about all.
#[derive(Debug, Clone, Default)]
pub(super) struct NoStart {
    pub(super) message: String,
    pub(super) help: Option<String>,
    pub(super) key: String,
}

impl NoStart {
    /// Numbers that are not finite.
    pub(super) fn not_finite() -> Self {
        let message = "a velocity, a momentum or K is not a finite number at the start".to_owned();
        Self { message, ..Self::default() }
    }

    /// A rate that does not follow from K.
    fn unsolved(message: String, help: impl Into<String>) -> Self {
        Self { message, help: Some(help.into()), key: "solve".to_owned() }
    }
}

/// The start that the data describe, and whether the two roots for the unknown rate are one. `is_double` says whether
/// they are known to be one, or to be two; without it a discriminant below rounding is zero, where `rounding` is the
/// relative accuracy of the data.
pub(super) fn solve<S: Real>(
    data: &StartData,
    geometry: &Geometry<S>,
    parameters: &[(String, String)],
    rounding: f64,
    is_double: Option<bool>,
) -> Result<(Start<S>, bool), NoStart> {
    let number = |text: &String| value_of::<S>(text, parameters).map_err(|_| NoStart::not_finite());
    let q: Vec<S> = data.q.iter().map(number).collect::<Result<_, _>>()?;
    let given = |rate: &Rate| match rate {
        Rate::Velocity(text) | Rate::Momentum(text) => number(text),
        _ => Ok(S::ZERO),
    };
    let mut given: Vec<S> = data.rates.iter().map(given).collect::<Result<_, _>>()?;
    let is_momentum: Vec<bool> = data.rates.iter().map(Rate::is_momentum).collect();
    let seen = |a: usize, rate: S| if is_momentum[a] { geometry.seen(a, rate) } else { rate };
    given.iter_mut().enumerate().for_each(|(a, rate)| *rate = seen(a, *rate));
    let (matrix, one_form) = matrix(geometry, &q);
    let undetermined = || undetermined(data, geometry.names());
    let velocities = |one_form: &[S], given: &[S]| velocities(&matrix, one_form, &is_momentum, given);
    let (mut q_dot, mut is_double_root) = (velocities(&one_form, &given).ok_or_else(undetermined)?, false);
    let unknown = data.rates.iter().enumerate().find_map(|(a, rate)| match rate {
        Rate::VelocityFromNorm(sign) | Rate::MomentumFromNorm(sign) => Some((a, *sign)),
        _ => None,
    });
    if let (Some((a, sign)), Some(norm)) = (unknown, &data.norm) {
        let (alpha, norm) = (&mut q_dot, number(norm)?);
        let mut direction = vec![S::ZERO; given.len()];
        direction[a] = seen(a, S::ONE);
        let beta = velocities(&vec![S::ZERO; given.len()], &direction).ok_or_else(undetermined)?;
        let (square, square_size) = form(&matrix, &beta, &beta);
        let (middle, middle_size) = form(&matrix, alpha, &beta);
        let (rest, rest_size) = form(&matrix, alpha, alpha);
        let sizes = [square_size, middle_size, rest_size + norm.abs()];
        let rounding = rounding_of_norm(given.len(), rounding);
        let quadratic = Quadratic { square, middle, rest: rest - norm, sizes, rounding, is_double };
        let unknown = key_of_rate(data.rates[a].is_momentum(), &geometry.names()[a]);
        let root;
        (root, is_double_root) = quadratic.root(&unknown, sign, norm)?;
        given[a] = seen(a, root);
        alpha.iter_mut().zip(&beta).for_each(|(alpha, &beta)| *alpha += beta * root);
    }
    let mut p = geometry.momenta(&q, &q_dot);
    let momenta = p.iter_mut().zip(&given).zip(&is_momentum);
    momenta.filter(|(_, is_momentum)| **is_momentum).for_each(|((p, given), _)| *p = *given);
    let is_finite = q_dot.iter().chain(&p).all(|value| value.is_finite());
    if is_finite { Ok((Start { q, q_dot, p }, is_double_root)) } else { Err(NoStart::not_finite()) }
}

/// The key of the velocity or of the momentum along a coordinate.
fn key_of_rate(is_momentum: bool, name: &str) -> String {
    if is_momentum { format!("p_{name}") } else { format!("{name}_dot") }
}

/// Momenta that do not determine velocities.
fn undetermined(data: &StartData, names: &[String]) -> NoStart {
    let momenta: Vec<usize> = (0..names.len()).filter(|&a| data.rates[a].is_momentum()).collect();
    let list =
        |is_momentum| momenta.iter().map(|&a| key_of_rate(is_momentum, &names[a])).collect::<Vec<_>>().join(", ");
    let is_given = matches!(data.rates[momenta[0]], Rate::Momentum(_));
    NoStart {
        message: format!("{} do not determine {}", list(true), list(false)),
        help: Some(
            "the metric has no inverse in these coordinates alone: give a velocity in place of a momentum".to_owned(),
        ),
        key: if is_given { key_of_rate(true, &names[momenta[0]]) } else { "solve".to_owned() },
    }
}

/// Returns true if K has this value at a state, but for rounding.
pub(super) fn has_norm<S: Real>(geometry: &Geometry<S>, state: &Start<S>, norm: S) -> bool {
    let rounding: S = rounding_of_norm(geometry.dimension(), 0.0);
    (geometry.norm(&state.q, &state.q_dot) - norm).abs() <= rounding * (size_of_norm(geometry, state) + norm.abs())
}

/// A state of Newton's law with the energy that its other momenta have: p_t is such that K is 0, which is linear in it
/// as t goes with γ. `None` outside the domain.
pub(super) fn with_energy<S: Real>(geometry: &Geometry<S>, Start { q, mut p, .. }: Start<S>) -> Option<Start<S>> {
    let q_dot = geometry.velocities(&q, &p).ok()?;
    p[0] -= geometry.norm(&q, &q_dot).half() / q_dot[0];
    Some(Start { q_dot: geometry.velocities(&q, &p).ok()?, q, p })
}

/// Σ |g_ab q̇^a q̇^b|, beside which a K of rounding errors is zero.
pub(super) fn size_of_norm<S: Real>(geometry: &Geometry<S>, start: &Start<S>) -> S {
    form(&matrix(geometry, &start.q).0, &start.q_dot, &start.q_dot).1
}

/// Rounding errors of K that are to be expected, relative to [`size_of_norm`].
pub(super) fn rounding_of_norm<S: Real>(dimension: usize, rounding: f64) -> S {
    S::from(rounding.max(S::EPSILON.to_f64()) * ROUNDING * dimension as f64)
}

/// g_ab and A_a at a point.
fn matrix<S: Real>(geometry: &Geometry<S>, q: &[S]) -> (Vec<Vec<S>>, Vec<S>) {
    let at: Vec<&[S]> = q.iter().map(std::slice::from_ref).collect();
    let (n, samples) = (geometry.dimension(), geometry.values_at(&at));
    let (mut matrix, mut one_form) = (vec![vec![S::ZERO; n]; n], vec![S::ZERO; n]);
    for term in &geometry.structure().values {
        let ([a, b], value) = (term.ab, samples.at(term.value, 0));
        if b == n {
            one_form[a] = value;
        } else {
            (matrix[a][b], matrix[b][a]) = (value, value);
        }
    }
    (matrix, one_form)
}

/// aᵀ G b, and the sum of the magnitudes of its terms.
fn form<S: Real>(matrix: &[Vec<S>], a: &[S], b: &[S]) -> (S, S) {
    let terms = matrix.iter().zip(a).flat_map(|(row, &a)| row.iter().zip(b).map(move |(&g, &b)| g * a * b));
    terms.fold((S::ZERO, S::ZERO), |(sum, size), term| (sum + term, size + term.abs()))
}

/// The velocities, unless the metric has no inverse for them, where `given` are momenta of some coordinates and
/// velocities of the others.
fn velocities<S: Real>(matrix: &[Vec<S>], one_form: &[S], is_momentum: &[bool], given: &[S]) -> Option<Vec<S>> {
    let unknown: Vec<usize> = (0..given.len()).filter(|&a| is_momentum[a]).collect();
    let known: Vec<usize> = (0..given.len()).filter(|&a| !is_momentum[a]).collect();
    let row = |&a: &usize| {
        let known = known.iter().fold(given[a] - one_form[a], |rest, &b| rest - matrix[a][b] * given[b]);
        unknown.iter().map(|&b| matrix[a][b]).chain([known]).collect()
    };
    let solution = eliminate(unknown.iter().map(row).collect())?;
    let mut velocities = given.to_vec();
    for (&a, velocity) in unknown.iter().zip(solution) {
        velocities[a] = velocity;
    }
    Some(velocities)
}

/// The solution of a linear system whose rows end with the right-hand side, by Gauss–Jordan elimination with full
/// pivoting; `None` if the system is singular.
fn eliminate<S: Real>(mut rows: Vec<Vec<S>>) -> Option<Vec<S>> {
    let order = rows.len();
    let scales = equilibrate(&mut rows);
    let singular = S::EPSILON * S::from(order as f64);
    let mut columns: Vec<usize> = Vec::new();
    for step in 0..order {
        let free = (0..order).filter(|column| !columns.contains(column));
        let places = free.flat_map(|column| (step..order).map(move |row| (row, column)));
        let larger = |best: (usize, usize), next: (usize, usize)| {
            if rows[next.0][next.1].abs() > rows[best.0][best.1].abs() { next } else { best }
        };
        let (row, column) = places.reduce(larger)?;
        let pivot = rows[row][column];
        if !pivot.is_finite() || pivot.abs() <= singular {
            return None;
        }
        rows.swap(step, row);
        let pivot_row = rows[step].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(row, _)| *row != step) {
            let factor = row[column] / pivot;
            for (entry, &other) in row.iter_mut().zip(&pivot_row) {
                *entry -= factor * other;
            }
        }
        columns.push(column);
    }
    let mut solution = vec![S::ZERO; order];
    for (row, column) in rows.iter().zip(columns) {
        solution[column] = row[order] / row[column] * scales[column];
    }
    Some(solution)
}

/// Scales rows and then columns by powers of two, which costs no digits, until the largest entry of each is about 1:
/// coordinates may have any units. Returns the factors of the unknowns.
fn equilibrate<S: Real>(rows: &mut [Vec<S>]) -> Vec<S> {
    let order = rows.len();
    let reciprocal = |largest: S| match largest.to_f64().log2().floor() {
        exponent if exponent.is_finite() => S::from(2.0_f64.powf(-exponent)),
        _ => S::ONE,
    };
    for row in rows.iter_mut() {
        let scale = reciprocal(row[..order].iter().fold(S::ZERO, |largest, entry| largest.max(entry.abs())));
        row.iter_mut().for_each(|entry| *entry *= scale);
    }
    let mut scales = Vec::new();
    for column in 0..order {
        let scale = reciprocal(rows.iter().fold(S::ZERO, |largest, row| largest.max(row[column].abs())));
        rows.iter_mut().for_each(|row| row[column] *= scale);
        scales.push(scale);
    }
    scales
}

/// square u² + 2 middle u + rest = 0, with the sums of magnitudes that the coefficients come from.
struct Quadratic<S> {
    square: S,
    middle: S,
    rest: S,
    sizes: [S; 3],
    rounding: S,
    is_double: Option<bool>,
}

impl<S: Real> Quadratic<S> {
    /// The root that the sign says, and whether the two roots are one.
    fn root(&self, unknown: &str, sign: Option<Sign>, norm: S) -> Result<(S, bool), NoStart> {
        let Self { square, middle, rest, .. } = *self;
        let [square_size, middle_size, rest_size] = self.sizes;
        if !(square_size + middle_size + rest_size).is_finite() {
            return Err(NoStart::not_finite());
        }
        if square.abs() <= self.rounding * square_size {
            return self.linear_root(unknown);
        }
        let discriminant = middle * middle - square * rest;
        let size = middle_size * middle_size + square.abs() * rest_size;
        let is_double = self.is_double.unwrap_or(discriminant.abs() <= self.rounding * size);
        if is_double {
            return Ok((-middle / square, true));
        }
        if discriminant < S::ZERO {
            // A negative discriminant of a start that is known to have two roots is a rounding error.
            if self.is_double.is_some() {
                return Ok((-middle / square, true));
            }
            let extreme = (rest + norm - middle * middle / square).to_f64();
            let bound = if square < S::ZERO { "at most" } else { "at least" };
            let norm = norm.to_f64();
            return Err(NoStart::unsolved(
                format!("no real {unknown} gives K = {norm}: K is {bound} {extreme} whatever {unknown} is"),
                format!("change the other velocities and momenta, or take a norm of {bound} {extreme}"),
            ));
        }
        // The sum has no cancellation; the other root follows from the product of both, or is its opposite.
        let far = -(middle + middle.signum() * discriminant.sqrt());
        let one = far / square;
        let other = if middle == S::ZERO { -one } else { rest / far };
        let (smaller, larger) = if one < other { (one, other) } else { (other, one) };
        Ok((if sign == Some(Sign::Minus) { smaller } else { larger }, false))
    }

    /// The only root, which is the larger one and the smaller one.
    fn linear_root(&self, unknown: &str) -> Result<(S, bool), NoStart> {
        if self.middle.abs() <= self.rounding * self.sizes[1] {
            let message = format!("K does not depend on {unknown}, so that norm cannot determine it");
            return Err(NoStart::unsolved(message, "solve for another velocity or momentum"));
        }
        Ok((-self.rest / (self.middle + self.middle), false))
    }
}
