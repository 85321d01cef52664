//! Independent checks of a world-line in a scene of n coordinates. They use its nodes, the operator and the geometry.

use std::borrow::Cow;

use super::deviations::Fields;
use super::verdict::Reason;
use super::warnings::{rounding_warning, unproved_warning};
use super::{Common, Diagnostics, Sawtooth};
use crate::action::Form;
use crate::geometry::{Observable, Start};
use crate::number::norm::max_abs;
use crate::number::{Real, sum};
use crate::solve::{Joint, WorldLine};

/// What a user wants to see conserved.
#[derive(Debug, Clone)]
pub struct InvariantDeviation<S = f64> {
    /// Its name.
    pub name: String,
    /// Its value at the start.
    pub value: S,
    /// The deviation on the nodes. At the last node of a window in the strong form it is that of the values that are
    /// handed on.
    pub delta: Vec<S>,
    /// Largest deviation of what the next window starts with, at the ends of the windows.
    pub max_ends: S,
}

/// The energy of a scene that is the lift of Newton's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyDeviation<S = f64> {
    /// The charge p_t/p_s at the start.
    pub value: S,
    /// Largest difference between ½mv² + V and the charge at the ends of the windows.
    pub max_ends: S,
}

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

/// What is measured on a world-line of a scene alone.
#[derive(Debug, Clone)]
pub struct SceneMeasures<S = f64> {
    /// In the lift of Newton's law: the energy of the values that the next window starts with.
    pub energy: Option<EnergyDeviation<S>>,
    /// The size of K's terms besides the largest one, at most over the nodes: what motion contributes to K.
    pub motion: f64,
    /// The sawtooth of every coordinate that is active.
    pub sawtooth: Vec<(usize, Sawtooth<S>)>,
    /// The work balance of coordinates that only a force acts on.
    pub work: Vec<WorkBalance<S>>,
}

impl<S: Real> Diagnostics<S, SceneMeasures<S>> {
    /// Measures `line`. `sums` are the conserved sums to look at, as constants by coordinate, and `invariants` the
    /// formulas of the user, with their names.
    ///
    /// A scene that is the lift of Newton's law has t first and s last.
    pub fn of_scene(
        line: &WorldLine<S>,
        sums: &[Vec<(usize, S)>],
        invariants: &mut [(String, Observable<S>)],
        is_lifted: bool,
    ) -> Self {
        let measured =
            Self::of(Fields::new(line), sums, |fields, common| SceneMeasures::new(fields, common, is_lifted));
        let (tangent, norm, start) = (measured.tangent(line), &measured.norm, &line.place.start);
        let invariants = invariants.iter_mut().map(|each| deviation(line, &tangent, each, norm.value)).collect();
        let delta_energy = is_lifted.then(|| {
            let deviations = norm.delta.iter().zip(tangent[0].iter());
            deviations.map(|(&delta, &t_dot)| energy_off(start, norm.value + delta, t_dot)).collect()
        });
        Self { delta_energy, invariants, ..measured }
    }

    /// This says in words what is suspicious about `line`, which was measured.
    pub fn warnings(&self, line: &WorldLine<S>) -> Vec<String> {
        self.suspicions(line).iter().map(Reason::to_string).collect()
    }

    /// The same, each with its remedy.
    pub fn suspicions(&self, line: &WorldLine<S>) -> Vec<Reason> {
        let names = line.geometry().names();
        let of = |(a, sawtooth): &(usize, Sawtooth<S>)| sawtooth.warning(&names[*a], range(&line.q[*a]), line.digits);
        let sawtooth = self.measures.sawtooth.iter().filter_map(of);
        let rounding = rounding_warning::<S>(line.iterations.last_correction, line.digits);
        let unproved = unproved_warning(line.windows_unproved);
        sawtooth.chain(drift_warning(self, line)).chain(unproved).chain(rounding).collect()
    }
}

impl<S: Real> SceneMeasures<S> {
    fn new(fields: &Fields<'_, S>, _: &Common<'_, S>, is_lifted: bool) -> Self {
        let (line, geometry, start) = (fields.run, fields.run.geometry(), &fields.run.place.start);
        Self {
            motion: fields.motion(),
            sawtooth: geometry.active().iter().map(|&a| (a, Sawtooth::new(&line.q[a], line.grids()))).collect(),
            work: work(fields),
            energy: is_lifted.then(|| {
                let of = |end: Joint<'_, S>| {
                    let q_dot = line.velocities(end);
                    energy_off(start, geometry.norm(end.q, &q_dot), q_dot[0])
                };
                let ends: Vec<S> = line.views().map(|view| of(view.end)).collect();
                EnergyDeviation { value: start.p[0] / start.p[start.p.len() - 1], max_ends: max_abs(&ends) }
            }),
        }
    }
}

/// In the lift of Newton's law: what the energy of positions and velocities differs by from p_t/p_s where K, which is 0
/// on a world-line, has this value.
pub(crate) fn energy_off<S: Real>(start: &Start<S>, k: S, t_dot: S) -> S {
    let p_s = start.p[start.p.len() - 1];
    -k / ((p_s + p_s) * t_dot)
}

/// A drift of K beyond this share of what motion contributes to it makes the world-line doubtful.
const DOUBTFUL: f64 = 1e-2;

fn drift_warning<S: Real>(diagnostics: &Diagnostics<S, SceneMeasures<S>>, line: &WorldLine<S>) -> Option<Reason> {
    let (norm, motion) = (&diagnostics.norm, diagnostics.measures.motion);
    let drift = norm.max_ends.max(norm.max_interior).to_f64();
    let is_small = drift <= DOUBTFUL * motion;
    // A force changes K.
    if is_small || motion == 0.0 || !line.geometry().structure().force.is_empty() {
        return None;
    }
    let share = drift / motion;
    let finding = format!(
        "K drifts by {drift:.1e}, {share:.1e} of what motion contributes to it: the charges are exact, and the \
         world-line is not to be trusted"
    );
    Some(Reason::new(finding, "raise n_gamma or windows"))
}

/// The least and the largest of them.
fn range<S: Real>(row: &[S]) -> [f64; 2] {
    let numbers = || row.iter().map(|value| value.to_f64());
    [numbers().fold(f64::INFINITY, f64::min), numbers().fold(f64::NEG_INFINITY, f64::max)]
}

/// The work of the force on coordinates that the Lagrangian does not depend on.
fn work<S: Real>(fields: &Fields<'_, S>) -> Vec<WorkBalance<S>> {
    let line = fields.run;
    let structure = line.geometry().structure();
    let depends = |a: usize| structure.first.iter().any(|term| term.by == [a]);
    let forced = structure.force.iter().map(|term| term.a).filter(|&a| !depends(a));
    // In the strong form the equations hold at all nodes but the last, and no sum of them is the whole work.
    let forced = forced.filter(|_| line.form == Form::Weak);
    forced
        .map(|coordinate| {
            let force = &fields.forces[coordinate];
            let work = sum(line.grids().map(|grid| grid.sbp().integrate(&force[grid.nodes()])));
            let gained = line.last_joint().p[coordinate] - line.place.start.p[coordinate];
            WorkBalance { coordinate, work, defect: gained - work }
        })
        .collect()
}

fn deviation<S: Real>(
    line: &WorldLine<S>,
    tangent: &[Cow<'_, [S]>],
    (name, invariant): &mut (String, Observable<S>),
    k: S,
) -> InvariantDeviation<S> {
    let (geometry, start) = (line.geometry(), &line.place.start);
    let value = invariant.at(&start.q, &start.q_dot, &start.p, k);
    let rows: Vec<Vec<S>> = (0..tangent.len()).map(|a| line.q(a).collect()).collect();
    let at = |node: usize| {
        let q: Vec<S> = rows.iter().map(|row| row[node]).collect();
        let q_dot: Vec<S> = tangent.iter().map(|row| row[node]).collect();
        let p = geometry.momenta(&q, &q_dot);
        invariant.at(&q, &q_dot, &p, k) - value
    };
    let delta = (0..line.nodes()).map(at).collect();
    let ends = line.views().map(|view| view.end);
    let ends: Vec<S> = ends.map(|end| invariant.at(end.q, &line.velocities(end), end.p, k) - value).collect();
    InvariantDeviation { name: name.clone(), value, delta, max_ends: max_abs(&ends) }
}
