//! Formulas of the motion at the states of the solver.

use crate::geometry::{Observable, Start};
use crate::number::Real;
use crate::solve::WorldLine;

/// The rounding error of 1 in a run of so many digits.
pub(super) fn epsilon<S: Real>(line: &WorldLine<S>) -> S {
    S::EPSILON.max(S::from(0.1_f64.powi(line.digits as i32)))
}

/// A formula at the states of the solver, whose t may count from an origin, and whose motion may be the reversed one.
pub(super) fn of_inside<S: Real>(
    line: &WorldLine<S>,
    formula: &mut Observable<S>,
    norm: S,
) -> impl FnMut(&[S], &[S], &[S]) -> S {
    let is_plain = !line.is_backward && line.origin.is_none();
    move |q, q_dot, p| {
        if is_plain {
            return formula.at(q, q_dot, p, norm);
        }
        let state = Start { q: q.to_vec(), q_dot: q_dot.to_vec(), p: p.to_vec() };
        let Start { mut q, q_dot, p } = line.turned(state);
        q.iter_mut().enumerate().for_each(|(a, q)| *q += line.origin_of(a));
        formula.at(&q, &q_dot, &p, norm)
    }
}
