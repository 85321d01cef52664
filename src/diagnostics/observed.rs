//! The quantities that a case watches beside charges and K: its invariants, Newton's energy, the work of a force.

use std::borrow::Cow;

use super::deviations::{Deviation, Fields};
use crate::action::Form;
use crate::geometry::{Observable, Start};
use crate::number::{Real, sum};
use crate::solve::WorldLine;

/// The balance of a charge that a force changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkBalance<S = f64> {
    /// The coordinate a.
    pub coordinate: usize,
    /// Σ_k H_k F_a, summed over the windows.
    pub work: S,
    /// p_a at the end − p_a at the start − work.
    pub defect: S,
}

/// Measures the formulas of the user, with their names, on a run with this tangent, which starts with the norm `k`.
pub(super) fn invariants<S: Real>(
    line: &WorldLine<S>,
    tangent: &[Cow<'_, [S]>],
    formulas: &mut [(String, Observable<S>)],
    k: S,
) -> Vec<(String, Deviation<S>)> {
    let q: Vec<Vec<S>> = (0..tangent.len()).map(|a| line.q(a).collect()).collect();
    let positions: Vec<&[S]> = q.iter().map(Vec::as_slice).collect();
    let velocities: Vec<&[S]> = tangent.iter().map(|row| &**row).collect();
    let momenta = line.geometry().rows_of_momenta(&positions, &velocities);
    let mut here = Start::clone(&line.place.start);
    let measured = |(name, formula): &mut (String, Observable<S>)| {
        let Start { q, q_dot, p } = &*line.place.start;
        let value = formula.at(q, q_dot, p, k);
        let at = |node: usize| {
            here.q.iter_mut().zip(&positions).for_each(|(value, row)| *value = row[node]);
            here.q_dot.iter_mut().zip(&velocities).for_each(|(value, row)| *value = row[node]);
            here.p.iter_mut().zip(&momenta).for_each(|(value, row)| *value = row[node]);
            formula.at(&here.q, &here.q_dot, &here.p, k) - value
        };
        let delta = (0..line.nodes()).map(at).collect();
        let ends = line.views().map(|view| view.end);
        let ends = ends.map(|end| formula.at(end.q, &line.velocities(end), end.p, k) - value);
        (name.clone(), Deviation::new(value, delta, ends.collect()))
    };
    formulas.iter_mut().map(measured).collect()
}

/// Measures the energy ½mv² + V of a run of Newton's law, whose charge is p_t/p_s: they differ by −K/(2 ṫ p_s).
pub(super) fn energy<S: Real>(line: &WorldLine<S>, norm: &Deviation<S>, t_dot: &[S]) -> Deviation<S> {
    let start = &line.place.start;
    let at_end = |q_dot: Vec<S>, q: &[S]| energy_off(start, line.geometry().norm(q, &q_dot), q_dot[0]);
    let ends = line.views().map(|view| at_end(line.velocities(view.end), view.end.q)).collect();
    let nodes = norm.delta.iter().zip(t_dot);
    let delta = nodes.map(|(&delta, &t_dot)| energy_off(start, norm.value + delta, t_dot)).collect();
    Deviation::new(start.p[0] / start.p[start.p.len() - 1], delta, ends)
}

/// In the lift of Newton's law: what the energy of positions and velocities differs by from p_t/p_s where K, which is 0
/// on a world-line, has this value.
pub(crate) fn energy_off<S: Real>(start: &Start<S>, k: S, t_dot: S) -> S {
    let p_s = start.p[start.p.len() - 1];
    -k / ((p_s + p_s) * t_dot)
}

/// The work of the force on coordinates that the Lagrangian does not depend on.
pub(super) fn work<S: Real>(fields: &Fields<'_, S>) -> Vec<WorkBalance<S>> {
    let line = fields.run;
    let structure = line.geometry().structure();
    let depends = |a: usize| structure.first.iter().any(|term| term.by == [a]);
    let forced = structure.force.iter().map(|term| term.a).filter(|&a| !depends(a));
    // In the strong form the equations hold at all nodes but the last, and no sum of them is the whole work.
    let forced = forced.filter(|_| line.form == Form::Weak);
    forced
        .map(|coordinate| {
            let force = &fields.forces[coordinate];
            let work = sum(line.windows.iter().map(|window| window.sbp().integrate(&force[window.nodes()])));
            let gained = line.last_joint().p[coordinate] - line.joint(0).p[coordinate];
            WorkBalance { coordinate, work: line.signed(work), defect: line.signed(gained - work) }
        })
        .collect()
}
