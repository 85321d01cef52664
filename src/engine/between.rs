//! A look for what may hide between the nodes of a window.
//!
//! The sweeps leave the arguments of functions and the divisors on the nodes. Where none of them changes much from a
//! node to the next, nothing hides, and that is so in nearly all windows. Elsewhere intervals tell (see `enclosure`).
//!
//! The nodes of a window that passes a knot of a table follow no polynomial, and its error falls only like a low power
//! of its length. So the window is solved again to end there, and the next one begins with the polynomial behind the
//! knot.

#[cfg(test)]
mod tests;

use pulp::{Simd, WithSimd};

use super::POINTS;
use super::enclosure::{Enclosure, HIDDEN_SHARE, Hidden, tolerated_rates};
use super::kernel::{On, leaving};
use super::local::larger;
use super::rule::Order;
use super::solved::WindowNodes;
use super::touch::{Touched, interpolated};
use super::tuning::KINK;
use super::window::Solver;
use crate::formula::{BENT, Function, Kind, Watched, watched_registers};
use crate::number::root::root;
use crate::number::spline::Table;
use crate::number::vector::{Lanes, Level, Nodes};

/// Looks between the nodes of windows.
pub(super) struct Between {
    /// Made when it is first needed.
    enclosure: Option<Enclosure>,
    /// Where active coordinates are at the start of the run.
    start: Vec<Option<f64>>,
    /// The registers of what must not change much, and true if all of it has registers.
    watched: Vec<Watched>,
    is_all: bool,
    /// True for each of those that does not change much on all of the window that was looked at.
    gentle: Vec<bool>,
    /// True if a kink is between its first node and its last one.
    has_kink: bool,
    touched: Vec<Touched>,
}

/// The smoothness of a window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// By how much each Legendre mode is smaller than the one before, where divisors and the like have zeros beside the
    /// window, and 1 where there is a kink in it. The highest modes that the nodes see need not show it: what is smooth
    /// may be larger in those before.
    pub(super) decay: f64,
    /// The part of the window before the first knot of a table, if it passes one.
    pub(super) knot: Option<f64>,
}

/// The kink or jump that a window is at.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) enum Kink {
    #[default]
    Far,
    /// Windows are cut to meet it, and this one ends before it.
    Ahead,
    Inside,
    /// It is met to rounding of the place where it is: no shorter window knows more, and what it is off by is part of
    /// the estimate.
    Met,
}

impl Kink {
    pub(super) fn is_inside(self) -> bool {
        matches!(self, Self::Inside | Self::Met)
    }
}

impl Between {
    /// For windows of a run; `None` where nothing can hide.
    pub(super) fn new(Solver { geometry, system, start, .. }: &Solver<'_, POINTS>) -> Option<Self> {
        let unknowns = [&system.positions, &system.momenta].map(|registers| registers.iter());
        let depends = geometry
            .hamiltonian
            .program
            .depends_on(|variable| unknowns.clone().into_iter().flatten().any(|register| *register == variable));
        let steps = system.passes.iter().map(|pass| &pass.steps).chain([&system.others]).flatten();
        let (watched, is_all) = watched_registers(steps, &depends);
        let can_hide = !is_all || !watched.is_empty();
        let gentle = vec![false; watched.len()];
        let at_start = |a: usize| geometry.active().contains(&a).then(|| start.q[a].high);
        let start = (0..geometry.dimension()).map(at_start).collect();
        can_hide.then_some(Self {
            enclosure: None,
            start,
            watched,
            is_all,
            gentle,
            has_kink: false,
            touched: Vec::new(),
        })
    }

    /// Looks at the solved window.
    pub(super) fn look(&mut self, solver: &Solver<'_, POINTS>) -> Seen {
        let registers = &solver.system.registers;
        let look = Level::Best.dispatch(On((&registers[..], &self.watched[..], &mut self.gentle[..])));
        self.has_kink = look.has_kink;
        let knot = if look.passes_knot { self.first_knot(solver) } else { None };
        Seen { decay: if look.has_kink || knot.is_some() { 1.0 } else { look.decay }, knot }
    }

    #[cold]
    fn first_knot(&self, solver: &Solver<'_, POINTS>) -> Option<f64> {
        let (nodes, points) = (solver.fractions(), solver.rule.points());
        let knots = self.watched.iter().filter_map(|&Watched { register, kind, .. }| match kind {
            Kind::Table(table) => first_knot(table, nodes, &solver.system.registers[register].0[..points]),
            _ => None,
        });
        knots.min_by(f64::total_cmp)
    }

    /// The part of the window that was solved at which the motion touches a place where a force jumps, in a run to an
    /// accuracy. The first window of a run may leave such a place.
    pub(super) fn touches(&mut self, solver: &Solver<'_, POINTS>, accuracy: f64, is_first: bool) -> Option<f64> {
        let (registers, nodes) = (&solver.system.registers, solver.fractions());
        self.touched.resize_with(self.watched.len(), Touched::default);
        let all = self.watched.iter().zip(&mut self.touched);
        let jumps = all.filter(|(look, _)| matches!(look.kind, Kind::Side(Function::Sign | Function::Step)));
        let looks = jumps.filter_map(|(look, touched)| {
            touched.look(nodes, &registers[look.register].0[..nodes.len()], accuracy, is_first)
        });
        looks.min_by(f64::total_cmp)
    }

    /// Looks for something that may hide in the window that was looked at, of length `h`, in a run of this length to an
    /// accuracy. Its change is in units of the most that is tolerated there.
    pub(super) fn hides(&mut self, solver: &Solver<'_, POINTS>, h: f64, length: f64, accuracy: f64) -> Option<Hidden> {
        let (registers, nodes) = (&solver.system.registers, &solver.rule.nodes[0].0);
        let mut watched = self.watched.iter().zip(&self.gentle);
        // The values of an argument that has a kink in it tell nothing of it between the nodes.
        let is_seen = self.is_all
            && !self.has_kink
            && watched.all(|(look, gentle)| *gentle || changes_little(look, nodes, &registers[look.register].0));
        if is_seen { None } else { self.hides_in_intervals(solver, h, length, accuracy) }
    }

    #[inline(never)]
    fn hides_in_intervals(
        &mut self,
        solver: &Solver<'_, POINTS>,
        h: f64,
        length: f64,
        accuracy: f64,
    ) -> Option<Hidden> {
        let (geometry, momenta) = (solver.geometry, &solver.initial.p);
        if self.enclosure.is_none() {
            self.enclosure = Enclosure::of_geometry(geometry, momenta);
        }
        let enclosure = self.enclosure.as_mut()?;
        let (active, n, nodes) = (geometry.active(), geometry.dimension(), &solver.rule.nodes[0].0);
        enclosure.path.begin(solver.fractions());
        for row in 0..solver.system.iterated() {
            let variable = active[row % active.len()] + if row < active.len() { 0 } else { 2 * n };
            let slopes = &solver.slope_nodes(row).0;
            let mut values = solver.unknown_nodes(row).0;
            if !self.has_kink {
                leave_start(&mut values);
            }
            enclosure.path.push(variable, &values, |k| {
                let distance = h * (nodes[k + 1] - nodes[k]);
                match solver.system.order {
                    Order::First => distance * (slopes[k + 1] - slopes[k]),
                    Order::Second => 0.5 * distance * distance * (slopes[k] + slopes[k + 1]),
                }
            });
        }
        let tolerances = || {
            let mut state: Vec<f64> = solver.start.q.iter().map(|q| q.high).chain(momenta.iter().copied()).collect();
            active.iter().zip(&solver.start.p).for_each(|(&a, p)| state[n + a] = p.high);
            let share = HIDDEN_SHARE * accuracy;
            let weight = |a: usize| {
                let (inverse, way) =
                    (solver.inverse_size(a), self.start[a].map_or(f64::INFINITY, |q| way(solver, a, q)));
                inverse * (share / larger(share * way * inverse, f64::EPSILON)).max(1.0)
            };
            let weights: Vec<f64> = (0..n).map(weight).collect();
            tolerated_rates(geometry, &weights, [&state[..]], length, HIDDEN_SHARE * accuracy)
        };
        // A window can be shortened, and is not looked at more closely. A kink is where it is for as long as its gap.
        let hidden = enclosure.hidden(tolerances, f64::INFINITY).into_iter().map(|hidden| {
            let gap = h * (nodes[hidden.pair + 1] - nodes[hidden.pair]);
            let most = if hidden.has_kink { (KINK * length / gap).max(1.0) } else { 1.0 };
            Hidden { change: hidden.change / most, ..hidden }
        });
        hidden.max_by(|one, other| one.change.total_cmp(&other.change)).filter(|hidden| hidden.change > 1.0)
    }
}

/// The largest distance in the window of an active coordinate from where it was at the start of the run. What has not
/// begun to move may be pushed by its rounding alone, and what has by an accuracy of its way: as no error is there,
/// none shows how a push grows, as on top of a hill.
fn way(solver: &Solver<'_, POINTS>, a: usize, start: f64) -> f64 {
    let place = solver.geometry.active().iter().position(|&other| other == a);
    let nodes = place.into_iter().flat_map(|place| &solver.unknown_nodes(place).0);
    nodes.fold(0.0, |most, q| larger(most, (q - start).abs()))
}

pub(super) struct Looked {
    has_kink: bool,
    passes_knot: bool,
    /// The slowest decay of modes, where there is no kink.
    decay: f64,
}

/// Looks at the range that everything that is watched has on the nodes, and tells what is gentle.
impl WithSimd for On<(&[Nodes<POINTS>], &[Watched], &mut [bool])> {
    type Output = Looked;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> Looked {
        let On((registers, watched, gentle)) = self;
        let (mut has_kink, mut passes_knot, mut ratio) = (false, false, 1.0_f64);
        for (look, gentle) in watched.iter().zip(gentle) {
            let kind = look.kind;
            let inside = if let Kind::Side(_) = kind { Some(leaving(&registers[look.register])) } else { None };
            let values = Lanes::new(s, inside.as_ref().unwrap_or(&registers[look.register]));
            let (least, most) = (-values.neg().largest(), values.largest());
            // At most one of three changes in turn goes back.
            let margin = 2.0 * BENT * (most - least);
            *gentle = look.is_gentle([least - margin, most + margin]);
            if kind == Kind::Ratio && least * most > 0.0 {
                ratio = ratio.max(most / least).max(least / most);
            }
            has_kink |= look.has_kink_between([least, most]);
            if let Kind::Table(table) = kind {
                passes_knot |= table.passed([least, most]) != Some(0);
            }
        }
        // What is linear and changes by this ratio has a zero so far away that Bernstein's ellipse through it has the
        // parameter (√ratio + 1)/(√ratio − 1).
        let root = ratio.sqrt();
        Looked { has_kink, passes_knot, decay: (root - 1.0) / (root + 1.0) }
    }
}

/// True if a value that is this on the nodes changes little from each to the next.
#[inline(never)]
fn changes_little<const N: usize>(look: &Watched, nodes: &[f64; N], values: &[f64; N]) -> bool {
    look.changes_little(nodes, values, &mut [0.0; N])
}

/// Places that differ by this part of them are one: their rounding, and that of what they are compared with in an
/// argument.
pub(super) const ONE_PLACE: f64 = 4.0 * f64::EPSILON;
/// The same where a jump is met: it may be high, and what it is off by is as large as the window.
pub(super) const MET: f64 = f64::EPSILON;

/// Moves the first node by the rounding of its place: what a window before has met there is behind.
fn leave_start(values: &mut [f64; POINTS]) {
    let (way, place) = (values[1] - values[0], ONE_PLACE * values[0].abs());
    if way.abs() > place {
        values[0] += place.copysign(way);
    }
}

/// Returns true if places in a window of this length differ by no more than `place` of them, so that rounding hides
/// where a function jumps: by what they differ, and by what they would with the speed that coordinates other than
/// clocks have elsewhere, as they may turn here. What begins to move in the window, or has only just begun, says
/// nothing of its place. Where γ itself has no digits, places have none.
pub(super) fn is_at_one_place(solver: &Solver<'_, POINTS>, gamma: f64, length: f64, place: f64) -> bool {
    let Solver { scales, rows, system, .. } = solver;
    if length <= ONE_PLACE * gamma {
        return true;
    }
    let mut known = rows[..system.positions.len()].iter().zip(&scales.clocks).filter(|(row, _)| !row.size.grows());
    known.all(|(row, &is_clock)| {
        let (now, elsewhere) = (row.increment.abs() * row.size.inverse, length / scales.time);
        let part = if is_clock { now } else { now.max(elsewhere) };
        part <= place * row.start.high.abs() * row.size.inverse
    })
}

/// Returns true if places in a window differ by no more than their rounding: that of the start may put it on either
/// side of a surface.
pub(super) fn stays_at_one_place(solver: &Solver<'_, POINTS>) -> bool {
    let Solver { scales, rows, system, .. } = solver;
    let mut known = rows[..system.positions.len()].iter().zip(&scales.clocks).filter(|(_, is_clock)| !**is_clock);
    known.all(|(row, _)| row.increment.abs() <= ONE_PLACE * row.start.high.abs())
}

/// A knot in this first or last part of a window is at its end. What the force is off by there grows with the square
/// of the time behind the knot at least, so that the error is this part to the third power.
const AT_END: f64 = 1e-6;

/// The part of the window before the first knot that the argument passes, by its values on the nodes; `None` where it
/// passes none, but for those at the ends of the window.
fn first_knot(table: Table, nodes: &[f64], values: &[f64]) -> Option<f64> {
    // A function that is less smooth would have to be met to the last digit.
    if table.smoothness() == 0 {
        return None;
    }
    (1..values.len()).find_map(|k| {
        let [before, after] = [values[k - 1], values[k]];
        let mut knots = table.between(before, after).map(|knot| {
            let ahead = |at: f64| interpolated(nodes, values, at) - knot;
            let on_nodes = [k - 1, k].into_iter().find(|&k| values[k] == knot).map(|k| nodes[k]);
            on_nodes
                .unwrap_or_else(|| root([nodes[k - 1], before - knot], [nodes[k], after - knot], 0.1 * AT_END, ahead))
        });
        knots.find(|at| (AT_END..1.0 - AT_END).contains(at))
    })
}
