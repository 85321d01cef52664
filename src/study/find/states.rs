//! What is to vanish as a function of the states at the two ends of a run, and its derivatives.
//!
//! Formulas are differentiated by differences in 70 digits: with steps of 1e-20 a central difference has 40 digits, so
//! that of a double none is lost.

use crate::case::{Case, Condition, Goal};
use crate::geometry::{Geometry, Start};
use crate::number::{Extended, Real};
use crate::solve::WorldLine;
use crate::study::run::Run;

/// The step of differences, relative to the size of what changes.
const STEP: f64 = 1e-20;

/// Positions and momenta, of the motion and not of the reversed one.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) q: Vec<Extended>,
    pub(super) p: Vec<Extended>,
}

/// The states at the start and at the end of a run.
pub(super) type Ends = [State; 2];

/// The derivatives of a residual by q and p of both ends, in the order of [`Ends`].
pub(super) type Gradient = [[Vec<f64>; 2]; 2];

/// The two ends of a run.
pub(super) fn ends(run: &Run) -> Ends {
    let first = run.before.first().map_or(&run.line, |(first, _)| first);
    let wide = |numbers: &[f64]| numbers.iter().map(|&number| Extended::from(number)).collect();
    let state = |Start { q, p, .. }: &Start| State { q: wide(q), p: wide(p) };
    [state(&start_of(first)), state(&run.line.end())]
}

/// The start of a world-line as a user sees it.
fn start_of(line: &WorldLine) -> Start {
    let mut start = line.turned((*line.place.start).clone());
    start.q.iter_mut().enumerate().for_each(|(a, q)| *q += line.origin_of(a));
    start
}

/// What is to vanish in a case, if that depends on the ends of its run alone.
pub(super) struct Residuals<'c> {
    case: &'c Case,
    kind: Kind<'c>,
    geometry: Geometry<Extended>,
}

enum Kind<'c> {
    Meet(&'c [Condition]),
    Return,
}

impl<'c> Residuals<'c> {
    /// Those of a case; `None` if data are to be met.
    pub(super) fn new(case: &'c Case, goal: &'c Goal) -> Option<Self> {
        let kind = match goal {
            Goal::Meet(conditions) => Kind::Meet(conditions),
            Goal::Periodic => Kind::Return,
            Goal::Data(_) => return None,
        };
        Some(Self { case, kind, geometry: case.geometry() })
    }

    /// The active coordinates but for the time, which have to return.
    pub(super) fn returning(geometry: &Geometry<Extended>) -> Vec<usize> {
        let names = geometry.names();
        geometry.active().iter().copied().filter(|&a| names[a] != "t").collect()
    }

    /// Their names.
    pub(super) fn names(&self) -> Vec<String> {
        let names = self.geometry.names();
        match self.kind {
            Kind::Meet(conditions) => conditions.iter().map(|condition| condition.text.clone()).collect(),
            Kind::Return => {
                let active = Self::returning(&self.geometry);
                let places = active.iter().map(|&a| names[a].clone());
                places.chain(active.iter().map(|&a| format!("{}_dot", names[a]))).collect()
            }
        }
    }

    /// The residuals; `None` where a state lies outside of the domain.
    pub(super) fn at(&self, [start, end]: &Ends) -> Option<Vec<Extended>> {
        let full = |State { q, p }: &State| {
            let q_dot = self.geometry.velocities(q, p).ok()?;
            Some(Start { q: q.clone(), q_dot, p: p.clone() })
        };
        let (start, end) = (full(start)?, full(end)?);
        match self.kind {
            Kind::Meet(conditions) => {
                let norm = self.geometry.norm(&start.q, &start.q_dot);
                Some(conditions.iter().map(|condition| condition.at(self.case, &start, &end, norm)).collect())
            }
            Kind::Return => {
                let active = Self::returning(&self.geometry);
                let places = active.iter().map(|&a| end.q[a] - start.q[a]);
                Some(places.chain(active.iter().map(|&a| end.q_dot[a] - start.q_dot[a])).collect())
            }
        }
    }

    /// The gradient of each residual.
    pub(super) fn gradients(&self, ends: &Ends) -> Option<Vec<Gradient>> {
        let n = self.geometry.dimension();
        let count = self.at(ends)?.len();
        let none = || [(); 2].map(|()| [(); 2].map(|()| vec![0.0; n]));
        let mut gradients: Vec<Gradient> = (0..count).map(|_| none()).collect();
        for place in 0..4 * n {
            let (end, kind, a) = (place / (2 * n), place / n % 2, place % n);
            let number = |ends: &mut Ends, change: Extended| {
                let state = &mut ends[end];
                (if kind == 0 { &mut state.q } else { &mut state.p })[a] += change;
            };
            let value = if kind == 0 { ends[end].q[a] } else { ends[end].p[a] };
            let step = step_of(value);
            let at = |change: Extended| {
                let mut ends = ends.clone();
                number(&mut ends, change);
                self.at(&ends)
            };
            let [above, below] = [at(step)?, at(-step)?];
            for ((gradient, above), below) in gradients.iter_mut().zip(above).zip(below) {
                gradient[end][kind][a] = quotient(above, below, step);
            }
        }
        Some(gradients)
    }

    /// The rates of the end with γ: those of positions, and of momenta.
    pub(super) fn rates(&self, State { q, p }: &State) -> Option<[Vec<f64>; 2]> {
        let q_dot = self.geometry.velocities(q, p).ok()?;
        let p_dot = self.geometry.forces(q, &q_dot);
        Some([q_dot, p_dot].map(|rates| rates.iter().map(|rate| rate.to_f64()).collect()))
    }
}

/// The step by which a number is changed.
pub(super) fn step_of(value: Extended) -> Extended {
    let size = value.abs();
    Extended::from(STEP) * if size == Extended::ZERO { Extended::ONE } else { size }
}

/// The central difference of two values, each of which is this step away.
pub(super) fn quotient(above: Extended, below: Extended, step: Extended) -> f64 {
    ((above - below) / (step + step)).to_f64()
}
