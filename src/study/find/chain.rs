//! Derivatives of residuals by numbers of the start and of the end of a run, from the linearised equations that the run
//! has carried along.
//!
//! ```text
//! dR/du = ∂R/∂u + ∂R/∂z₀ dz₀/du + ∂R/∂z₁ (Φ dz₀/du + ż₁ dΓ/du)
//! ```
//!
//! z₀ and z₁ are the states at both ends, Φ the derivative of active coordinates and momenta at the end by those at the
//! start, and Γ the length of the run in γ. Φ does not know the positions of ignorable coordinates at the end, nor what
//! their momenta do to the others: where one of these matters there is no derivative from it.

use nalgebra::DMatrix;

use super::problem::{Evaluation, Problem};
use super::states::{Gradient, Residuals, quotient, step_of};
use crate::case::Case;
use crate::geometry::Geometry;
use crate::number::{Extended, Real};
use crate::solve::{Limit, WorldLine};

/// Φ of a run, by rows: positions, then momenta, of the motion and not of the reversed one. `None` if the run has not
/// carried it, or it has grown out of the range of numbers.
pub(super) fn matrix(line: &WorldLine) -> Option<DMatrix<f64>> {
    let m = line.geometry().active().len();
    let joints = line.sensitivity.as_ref()?.joints();
    if joints.len() != line.windows.len() + 1 || m == 0 {
        return None;
    }
    let sign = |k: usize| if k < m { 1.0 } else { line.signed(1.0) };
    let last = joints.last()?;
    Some(DMatrix::from_fn(2 * m, 2 * m, |i, j| sign(i) * last[i * 2 * m + j] * sign(j)))
}

/// The start of a case and its end, with one unknown changed.
struct Changed {
    q: Vec<Extended>,
    p: Vec<Extended>,
    /// The length of γ, or the value of the coordinate that ends the run.
    limit: Extended,
    residuals: Vec<Extended>,
}

/// The change of a state with an unknown; `None` where it is not known.
struct Change {
    q: Vec<Option<f64>>,
    p: Vec<Option<f64>>,
}

/// The derivative of the residuals by unknown `j`, if the linearised equations give it.
pub(super) fn column(problem: &Problem, here: &Evaluation, phi: &DMatrix<f64>, j: usize) -> Option<Vec<f64>> {
    if problem.find.unknowns[j].is_in_equations {
        return None;
    }
    let (ends, gradients) = here.at_ends.as_ref()?;
    let value = Extended::from(here.values[j]);
    let step = step_of(value);
    let [above, below] = [changed(problem, here, j, value + step)?, changed(problem, here, j, value - step)?];
    let difference = |above: &[Extended], below: &[Extended]| -> Vec<f64> {
        above.iter().zip(below).map(|(above, below)| quotient(*above, *below, step)).collect()
    };
    let (q, p) = (difference(&above.q, &below.q), difference(&above.p, &below.p));
    let of_limit = quotient(above.limit, below.limit, step);
    let residuals = Residuals::new(&here.case, &problem.find.goal)?;
    let rates = residuals.rates(&ends[1])?;
    let end = at_end(&here.case, here.run.line.geometry(), (&q, &p, of_limit), phi, &rates)?;
    let [q, p] = [q, p].map(|part| part.into_iter().map(Some).collect());
    let start = Change { q, p };
    let explicit = difference(&above.residuals, &below.residuals);
    let total = |(explicit, gradient): (f64, &Gradient)| {
        Some(explicit + product(&gradient[0], &start)? + product(&gradient[1], &end)?)
    };
    explicit.into_iter().zip(gradients).map(total).collect()
}

fn changed(problem: &Problem, here: &Evaluation, j: usize, value: Extended) -> Option<Changed> {
    let mut values: Vec<String> = here.values.iter().map(|value| format!("{value:?}")).collect();
    values[j] = value.to_decimal(Extended::MOST_DIGITS);
    let case = problem.case(&values, false).ok()?;
    let start = case.start::<Extended>();
    let limit = match case.limit::<Extended>() {
        Limit::Length(length) | Limit::Value { value: length, .. } => length,
    };
    let residuals = Residuals::new(&case, &problem.find.goal)?.at(&here.at_ends.as_ref()?.0)?;
    // In a case of x the start counts t from itself.
    let q = case.initial.q.iter().map(|q| case.value(q)).chain(start.q.into_iter().skip(case.initial.q.len()));
    Some(Changed { q: q.collect(), p: start.p, limit, residuals })
}

/// The change of the end, where that of the start and of the limit is this.
fn at_end(
    case: &Case,
    geometry: &Geometry,
    (q, p, of_limit): (&[f64], &[f64], f64),
    phi: &DMatrix<f64>,
    rates: &[Vec<f64>; 2],
) -> Option<Change> {
    let (n, active) = (geometry.dimension(), geometry.active());
    let scene = &case.geometry_text;
    // In the lift of Newton's law t runs like γ, and no motion depends on the momentum of t; that of s is a mass.
    let is_plain_lift = case.is_lifted() && scene.conformal.is_none() && scene.tau.is_none();
    let is_same_start = q.iter().chain(p).all(|change| *change == 0.0);
    if geometry.ignorable().any(|a| p[a] != 0.0 && !(is_plain_lift && a == 0)) {
        return None;
    }
    let mut end = Change { q: vec![is_same_start.then_some(0.0); n], p: p.iter().map(|&p| Some(p)).collect() };
    let m = active.len();
    let of_start: Vec<f64> = active.iter().map(|&a| q[a]).chain(active.iter().map(|&a| p[a])).collect();
    for row in 0..2 * m {
        let change = (0..2 * m).map(|k| phi[(row, k)] * of_start[k]).sum();
        (if row < m { &mut end.q } else { &mut end.p })[active[row % m]] = Some(change);
    }
    if is_plain_lift {
        end.q[0] = Some(q[0]);
    }
    let direction = if case.is_backward() { -1.0 } else { 1.0 };
    let longer = match case.limit::<f64>() {
        Limit::Length(_) => direction * of_limit,
        Limit::Value { coordinate, .. } => (of_limit - end.q[coordinate]?) / rates[0][coordinate],
    };
    for (changes, rates) in [(&mut end.q, &rates[0]), (&mut end.p, &rates[1])] {
        for (change, rate) in changes.iter_mut().zip(rates) {
            *change = change.map(|change| change + rate * longer);
        }
    }
    Some(end)
}

/// The change of a residual with this gradient; `None` if it depends on what is not known.
fn product([of_q, of_p]: &[Vec<f64>; 2], Change { q, p }: &Change) -> Option<f64> {
    let parts = of_q.iter().zip(q).chain(of_p.iter().zip(p)).filter(|(gradient, _)| **gradient != 0.0);
    parts.map(|(gradient, change)| Some(gradient * (*change)?)).sum()
}
