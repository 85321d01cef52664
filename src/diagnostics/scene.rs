//! Independent checks of a world-line in a scene of n coordinates. They use its nodes, the operator and the geometry.

use super::Sawtooth;
use super::rows::{corrected, derivative, handed_on, largest};
use super::warnings::rounding_warning;
use crate::action::{Form, Layout};
use crate::geometry::{Geometry, Lagrangian, Observable, Samples};
use crate::norm::max_abs;
use crate::scalar::{Real, sum};
use crate::solve::WindowGrid;
use crate::solve::scene::{SceneJoint, SceneWindow, WorldLine};

/// How far a momentum, or a sum of momenta, is from its value at the start of the run.
#[derive(Debug, Clone)]
pub struct ChargeDeviation<S = f64> {
    /// Constants c^a of Σ c^a p_a, for the coordinates that occur.
    pub terms: Vec<(usize, S)>,
    /// Its value at the start.
    pub value: S,
    /// The deviation on the nodes.
    pub delta: Vec<S>,
    /// The same with the multipliers' share κ_a/H_N at the last node of each window.
    pub corrected: Vec<S>,
    /// Largest |delta| where the charge is exact: at all nodes but the last of each window (strong), or at all (weak).
    pub max_interior: S,
    /// Largest |delta| at the last node of a window.
    pub max_last: S,
    /// Largest |corrected|.
    pub max_corrected: S,
}

/// What a user wants to see conserved.
#[derive(Debug, Clone)]
pub struct InvariantDeviation<S = f64> {
    /// Its name.
    pub name: String,
    /// Its value at the start.
    pub value: S,
    /// The deviation on the nodes. At the last node of a window it is that of the values that are handed on.
    pub delta: Vec<S>,
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

/// Everything that is measured on a world-line.
#[derive(Debug, Clone)]
pub struct SceneDiagnostics<S = f64> {
    /// dq^a/dγ on the nodes: Dq^a (weak: D̄q^a), and at the last node of a window in the strong form, where D takes up
    /// the defect, what the next window starts with.
    pub tangent: Vec<Vec<S>>,
    /// The charges of the ignorable coordinates, in order.
    pub charges: Vec<ChargeDeviation<S>>,
    /// Conserved sums of the momenta of active coordinates.
    pub sums: Vec<ChargeDeviation<S>>,
    /// ΔG_a = (Dp_a) − f_a − F_a of every coordinate; in the weak form with D̄ and the initial momenta.
    pub delta_g: Vec<Vec<S>>,
    /// Largest |ΔG_a| over the nodes whose row of D does not reach the last node of the window (weak: all nodes).
    pub max_delta_g: S,
    /// K at the start.
    pub k: S,
    /// ΔK = g_ab Dq^a Dq^b − K on the nodes.
    pub delta_k: Vec<S>,
    /// In the lift of Newton's law: the energy ½mv² + V of the computed positions and velocities minus the charge
    /// p_t/p_s, which is −K/(2 ṫ p_s).
    pub delta_energy: Option<Vec<S>>,
    /// The same at the ends of the windows, for the values that the next window starts with.
    pub energy: Option<EnergyDeviation<S>>,
    /// Largest |ΔK| over the interior nodes.
    pub max_delta_k: S,
    /// Largest |ΔK| at the ends of the windows, for the values that the next window starts with.
    pub max_delta_k_ends: S,
    /// The size of K's terms besides the largest one, at most over the nodes: what motion contributes to K.
    pub motion: f64,
    /// The sawtooth of every coordinate that is active.
    pub sawtooth: Vec<(usize, Sawtooth<S>)>,
    /// The work balance of coordinates that only a force acts on.
    pub work: Vec<WorkBalance<S>>,
    /// The invariants of the user, in their order.
    pub invariants: Vec<InvariantDeviation<S>>,
}

/// One window with everything on its nodes.
struct Measured<'l, S> {
    grid: WindowGrid<'l, S>,
    /// Dq^a or D̄q^a.
    velocities: Vec<&'l [S]>,
    samples: Samples<S>,
    /// F_a on the nodes, zero where no force acts.
    forces: Vec<Vec<S>>,
}

impl<S: Real> SceneDiagnostics<S> {
    /// Measures `line`. `sums` are the conserved sums to look at, as constants by coordinate, and `invariants` the
    /// formulas of the user, with their names.
    ///
    /// A scene that is the lift of Newton's law has t first and s last.
    pub fn new(
        line: &WorldLine<S>,
        sums: &[Vec<(usize, S)>],
        invariants: &mut [(String, Observable<S>)],
        is_lifted: bool,
    ) -> Self {
        let geometry = line.geometry();
        let n = geometry.dimension();
        let velocities: Vec<Vec<S>> = (0..n).map(|a| velocity(line, a)).collect();
        let windows: Vec<Measured<'_, S>> =
            line.windows.iter().map(|window| measured(line, window, &velocities)).collect();
        let momenta: Vec<Vec<S>> = (0..n).map(|a| on_nodes(&windows, |at, k| at.momentum(geometry, a, k))).collect();
        let ignorable = geometry.ignorable().map(|a| vec![(a, S::ONE)]);
        let charge = |terms: Vec<(usize, S)>| charge(line, &momenta, terms);
        let k = geometry.norm(&line.place.start.q, &line.place.start.q_dot);
        let delta_k = on_nodes(&windows, |at, node| at.norm(geometry, node) - k);
        let motion = on_nodes(&windows, |at, node| at.motion(geometry, node));
        let delta_g: Vec<Vec<S>> = (0..n).map(|a| residual(line, &windows, &momenta[a], a)).collect();
        let ends = line.windows.iter().map(|window| geometry.norm(&window.end.q, &window.end.q_dot) - k);
        let tangent: Vec<Vec<S>> = (0..n).map(|a| tangent(line, a, &velocities[a])).collect();
        Self {
            charges: ignorable.map(charge).collect(),
            sums: sums.iter().cloned().map(charge).collect(),
            max_delta_g: delta_g
                .iter()
                .map(|row| largest(row, line.grids().map(|grid| grid.uncoupled())))
                .fold(S::ZERO, S::max),
            max_delta_k: largest(&delta_k, line.grids().map(|grid| grid.exact())),
            max_delta_k_ends: max_abs(&ends.collect::<Vec<_>>()),
            motion: largest(&motion, line.grids().map(|grid| grid.exact())).to_f64(),
            sawtooth: geometry.active().iter().map(|&a| (a, Sawtooth::new(&line.q[a], line.grids()))).collect(),
            work: work(line, &windows),
            invariants: invariants.iter_mut().map(|invariant| deviation(line, &tangent, invariant, k)).collect(),
            delta_energy: is_lifted.then(|| {
                let deviations = delta_k.iter().zip(&tangent[0]);
                deviations.map(|(&delta, &t_dot)| energy_off(line, k + delta, t_dot)).collect()
            }),
            energy: is_lifted.then(|| {
                let of = |end: &SceneJoint<S>| energy_off(line, geometry.norm(&end.q, &end.q_dot), end.q_dot[0]);
                let start = &line.place.start;
                let ends: Vec<S> = line.windows.iter().map(|window| of(&window.end)).collect();
                EnergyDeviation { value: start.p[0] / start.p[n - 1], max_ends: max_abs(&ends) }
            }),
            tangent,
            delta_g,
            k,
            delta_k,
        }
    }
}

/// What the energy of positions and velocities differs by from p_t/p_s where K has this value.
fn energy_off<S: Real>(line: &WorldLine<S>, k: S, t_dot: S) -> S {
    let p_s = line.place.start.p[line.place.start.p.len() - 1];
    -k / ((p_s + p_s) * t_dot)
}

/// A drift of K beyond this share of what motion contributes to it makes the world-line doubtful.
const DOUBTFUL: f64 = 1e-2;

impl<S: Real> SceneDiagnostics<S> {
    /// What is suspicious about `line`, the world-line that was measured, in words.
    pub fn warnings(&self, line: &WorldLine<S>) -> Vec<String> {
        let names = line.geometry().names();
        let of = |(a, sawtooth): &(usize, Sawtooth<S>)| sawtooth.warning(&names[*a], amplitude(&line.q[*a]));
        let sawtooth = self.sawtooth.iter().filter_map(of);
        let rounding = rounding_warning::<S>(line.last_correction, line.digits);
        sawtooth.chain(self.drift_warning()).chain(rounding).collect()
    }

    fn drift_warning(&self) -> Option<String> {
        let drift = self.max_delta_k_ends.max(self.max_delta_k).to_f64();
        let is_small = drift <= DOUBTFUL * self.motion;
        if is_small || self.motion == 0.0 || !self.work.is_empty() {
            return None;
        }
        let share = drift / self.motion;
        Some(format!(
            "K drifts by {drift:.1e}, {share:.1e} of what motion contributes to it: the charges are exact, and the \
             world-line is not to be trusted; raise n_gamma or windows"
        ))
    }
}

/// Half the range of a row.
fn amplitude<S: Real>(row: &[S]) -> f64 {
    let numbers = || row.iter().map(|value| value.to_f64());
    0.5 * (numbers().fold(f64::NEG_INFINITY, f64::max) - numbers().fold(f64::INFINITY, f64::min))
}

fn measured<'l, S: Real>(
    line: &'l WorldLine<S>,
    window: &'l SceneWindow<S>,
    velocities: &'l [Vec<S>],
) -> Measured<'l, S> {
    let (geometry, grid, rows) = (line.geometry(), line.grid(window), line.rows(window));
    let points = grid.points();
    let velocities: Vec<&[S]> = velocities.iter().map(|row| &row[grid.nodes()]).collect();
    let mut samples = geometry.room(points);
    geometry.fill(&rows, &mut samples).expect("a solution lies inside the domain");
    let mut forces = vec![Vec::new(); geometry.dimension()];
    if geometry.has_force() {
        let structure = geometry.structure();
        let mut force = Samples::zeros(structure.force_rows, points);
        geometry.fill_force(&rows, &velocities, &mut force);
        for term in &structure.force {
            forces[term.a] = (0..points).map(|k| force.at(term.value, k)).collect();
        }
    }
    Measured { grid, velocities, samples, forces }
}

impl<S: Real> Measured<'_, S> {
    /// q̇^b at node k, or 1 for the one-form.
    fn velocity(&self, b: usize, k: usize) -> S {
        self.velocities.get(b).map_or(S::ONE, |row| row[k])
    }

    fn momentum(&self, geometry: &Geometry<S>, a: usize, k: usize) -> S {
        geometry.structure().momentum(&self.samples, |b| self.velocity(b, k), a, k)
    }

    fn norm(&self, geometry: &Geometry<S>, k: usize) -> S {
        geometry.structure().norm(&self.samples, |a| self.velocity(a, k), k)
    }

    fn motion(&self, geometry: &Geometry<S>, k: usize) -> S {
        geometry.structure().motion(&self.samples, |a| self.velocity(a, k), k)
    }

    /// f_a + F_a.
    fn force(&self, geometry: &Geometry<S>, a: usize, k: usize) -> S {
        let own = geometry.structure().force(&self.samples, |b| self.velocity(b, k), a, k);
        own + self.forces[a].get(k).copied().unwrap_or(S::ZERO)
    }
}

/// A value for every node of every window.
fn on_nodes<S: Real>(windows: &[Measured<'_, S>], value: impl Fn(&Measured<'_, S>, usize) -> S) -> Vec<S> {
    windows.iter().flat_map(|at| (0..at.grid.points()).map(|k| value(at, k)).collect::<Vec<_>>()).collect()
}

fn charge<S: Real>(line: &WorldLine<S>, momenta: &[Vec<S>], terms: Vec<(usize, S)>) -> ChargeDeviation<S> {
    let value = sum(terms.iter().map(|&(a, c)| c * line.place.start.p[a]));
    let delta: Vec<S> = (0..line.nodes()).map(|k| sum(terms.iter().map(|&(a, c)| c * momenta[a][k])) - value).collect();
    let share = |(window, grid): (&SceneWindow<S>, WindowGrid<'_, S>)| {
        let layout = Layout::new(momenta.len(), grid.points(), line.form);
        let kappa = |&(a, c): &(usize, S)| c * window.multipliers[layout.kappa(a)];
        (!window.multipliers.is_empty()).then(|| sum(terms.iter().map(kappa)))
    };
    let corrected = corrected(line.grids(), &delta, line.windows.iter().zip(line.grids()).map(share));
    ChargeDeviation {
        max_interior: largest(&delta, line.grids().map(|grid| grid.exact())),
        max_last: largest(&delta, line.grids().map(|grid| grid.last())),
        max_corrected: max_abs(&corrected),
        terms,
        value,
        delta,
        corrected,
    }
}

/// (Dp_a) − f_a − F_a on the nodes.
fn residual<S: Real>(line: &WorldLine<S>, windows: &[Measured<'_, S>], momentum: &[S], a: usize) -> Vec<S> {
    let mut residual = derivative(line.grids(), momentum, line.windows.iter().map(|window| window.start.p[a]));
    let forces = on_nodes(windows, |at, k| at.force(line.geometry(), a, k));
    residual.iter_mut().zip(forces).for_each(|(residual, force)| *residual += -force);
    residual
}

/// Dq^a or D̄q^a on the nodes.
fn velocity<S: Real>(line: &WorldLine<S>, a: usize) -> Vec<S> {
    let starts = line.windows.iter().map(|window| line.start_of_rows(window).q[a]);
    derivative(line.grids(), &line.q[a], starts)
}

/// dq^a/dγ on the nodes.
fn tangent<S: Real>(line: &WorldLine<S>, a: usize, velocity: &[S]) -> Vec<S> {
    match line.form {
        Form::Weak => velocity.to_vec(),
        Form::Strong => {
            handed_on(line.grids(), velocity.to_vec(), line.windows.iter().map(|window| window.end.q_dot[a]))
        }
    }
}

/// The work of the force on coordinates that the Lagrangian does not depend on.
fn work<S: Real>(line: &WorldLine<S>, windows: &[Measured<'_, S>]) -> Vec<WorkBalance<S>> {
    let structure = line.geometry().structure();
    let depends = |a: usize| structure.first.iter().any(|term| term.by == [a]);
    let forced = structure.force.iter().map(|term| term.a).filter(|&a| !depends(a));
    // In the strong form the equations hold at all nodes but the last, and no sum of them is the whole work.
    let forced = forced.filter(|_| line.form == Form::Weak);
    forced
        .map(|coordinate| {
            let work = sum(windows.iter().map(|at| at.grid.sbp().integrate(&at.forces[coordinate])));
            let gained = line.end().p[coordinate] - line.place.start.p[coordinate];
            WorkBalance { coordinate, work, defect: gained - work }
        })
        .collect()
}

fn deviation<S: Real>(
    line: &WorldLine<S>,
    tangent: &[Vec<S>],
    (name, invariant): &mut (String, Observable<S>),
    k: S,
) -> InvariantDeviation<S> {
    let (geometry, start) = (line.geometry(), &line.place.start);
    let value = invariant.at(&start.q, &start.q_dot, &start.p, k);
    let rows: Vec<Vec<S>> = (0..tangent.len()).map(|a| line.q(a).collect()).collect();
    let at = |node: usize| {
        let [q, q_dot] = [&rows, tangent].map(|rows| rows.iter().map(|row| row[node]).collect::<Vec<_>>());
        let p = geometry.momenta(&q, &q_dot);
        invariant.at(&q, &q_dot, &p, k) - value
    };
    InvariantDeviation { name: name.clone(), value, delta: (0..line.nodes()).map(at).collect() }
}
