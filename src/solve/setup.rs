//! The problem to be solved: a world-line in a space-time, and the settings of the solve.

use serde::{Deserialize, Serialize};

use super::acting::Change;
use super::continuation::Carried;
use super::grid::SHOWN;
use super::world_line::{Place, origin_of};
use crate::action::Form;
use crate::engine::{Accuracy, Handed};
use crate::geometry::{Direction, Observable};
use crate::number::Real;
use crate::sbp::SbpName;

/// The system of equations that is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum System {
    /// The collocation system that holds at the critical point. Its solution is certified on the doubled action.
    #[default]
    PhysicalLimit,
    /// ∇E_IVP = 0 in all 4N + 8 unknowns (4N in the weak form).
    Doubled,
}

/// The largest extent of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit<S = f64> {
    /// After this length of γ.
    Length(S),
    /// Where a coordinate reaches a value.
    Value {
        /// The coordinate.
        coordinate: usize,
        /// Its value at the end.
        value: S,
    },
}

/// A formula at whose first change of sign in a direction a run ends.
#[derive(Debug, Clone)]
pub struct Until<S = f64> {
    /// The formula.
    pub formula: Observable<S>,
    /// The same in `f64`.
    pub rough: Observable,
    /// Which changes count.
    pub direction: Direction,
    /// The change of the state there, if it is not to end the whole run.
    pub change: Option<Change>,
}

/// The settings by which a world-line is computed, in one coordinate and in scenes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The operator.
    pub sbp: SbpName,
    /// The form of the action.
    pub form: Form,
    /// True if the action has the regularised operator D̄ or, to show what that is for, D.
    pub regularised: bool,
    /// The nodes of a window.
    pub n_gamma: usize,
    /// Windows of one length.
    pub windows: usize,
    /// Which system is solved.
    pub system: System,
    /// Significant decimal digits of the solution.
    pub digits: u32,
    /// Most Newton iterations of a window.
    pub max_iterations: usize,
    /// The accuracy that operator and windows are chosen for, if they are to be: the operator, the form, the number of
    /// nodes and of windows say nothing then. Such a solve is one of the physical limit in `f64`.
    pub accuracy: Option<Accuracy>,
    /// True if such a solve also carries small changes of the start along.
    pub sensitivity: bool,
    /// True if a run is judged: compared with another solve, which costs as much again.
    pub is_judged: bool,
}

impl Settings {
    /// True if another march goes beside the run, which judges it on its way.
    pub fn is_judged_on_its_way(&self) -> bool {
        self.is_judged && self.accuracy.is_some()
    }

    /// Returns true if more digits are asked for than `f64` has.
    pub fn is_extended(&self) -> bool {
        self.digits > f64::MOST_DIGITS
    }

    /// The same with at most as many digits as `S` has.
    pub fn within<S: Real>(self) -> Self {
        Self { digits: self.digits.min(S::MOST_DIGITS), ..self }
    }
}

/// Everything that a solver is told. The numbers are valid: enough nodes for the operator, an end after the start.
#[derive(Debug, Clone)]
pub struct Setup<S: Real = f64> {
    /// The space-time and the start.
    pub place: Place<S>,
    /// The same in `f64`, where first guesses and linear algebra work.
    pub rough: Place,
    /// The coordinate that counts from an origin, and the origin: in a potential t from t_i, so that a shift of t_i
    /// shifts t and changes no other digit. That coordinate is 0 at the start of `place`.
    pub origin: Option<(usize, S)>,
    /// The first value of γ.
    pub gamma_i: S,
    /// True if γ falls from there. Lengths count from it in any case, and velocities and momenta of `place` are those
    /// of the reversed motion.
    pub is_backward: bool,
    /// The state that the run takes over from the one that it continues, if it does.
    pub carried: Option<Carried<S>>,
    /// The part of the start that its doubles lack, as few decimals are doubles: where small changes grow, it would be
    /// an error of the run.
    pub dropped: Handed,
    /// Where the run ends at the latest.
    pub limit: Limit<S>,
    /// Formulas at whose first change of sign it ends before that.
    pub until: Vec<Until<S>>,
    /// The signs of these formulas at the start, where they are known; where a formula is zero there, the value that it
    /// has to exceed before a change of sign is none of rounding.
    pub sides: Vec<[f64; 2]>,
    /// The parameters that events have set so far, by their places, with their values.
    pub set: Vec<(usize, f64)>,
    /// Sizes of coordinates below which an accuracy is absolute.
    pub floors: Vec<(usize, f64)>,
    /// The settings by which it is computed.
    pub settings: Settings,
}

impl<S: Real> From<&Self> for Setup<S> {
    fn from(setup: &Self) -> Self {
        setup.clone()
    }
}

impl<S: Real> Setup<S> {
    /// Returns true if an event changes the state.
    pub fn has_acting_events(&self) -> bool {
        self.until.iter().any(|until| until.change.is_some())
    }

    /// The length of γ that the start is looked at with.
    pub(crate) fn reach(&self) -> f64 {
        let start = &self.rough.start;
        match self.limit {
            Limit::Length(length) => length.to_f64(),
            Limit::Value { coordinate: a, value } => {
                let way = (value - self.origin_of(a)).to_f64() - start.q[a];
                (way / start.q_dot[a]).abs()
            }
        }
    }

    /// The same in `f64`.
    pub(crate) fn in_f64(&self) -> Setup {
        let until = |Until { rough, direction, change, .. }: &Until<S>| Until {
            formula: rough.clone(),
            rough: rough.clone(),
            direction: *direction,
            change: change.clone(),
        };
        let carried = |Carried { sums, handed, error, sensitivity }: &Carried<S>| Carried {
            sums: sums.iter().map(|low| low.to_f64()).collect(),
            handed: handed.clone(),
            error: error.clone(),
            sensitivity: sensitivity.clone(),
        };
        Setup {
            place: self.rough.clone(),
            rough: self.rough.clone(),
            origin: self.origin.map(|(coordinate, origin)| (coordinate, origin.to_f64())),
            gamma_i: self.gamma_i.to_f64(),
            is_backward: self.is_backward,
            carried: self.carried.as_ref().map(carried),
            dropped: self.dropped.clone(),
            limit: match self.limit {
                Limit::Length(length) => Limit::Length(length.to_f64()),
                Limit::Value { coordinate, value } => Limit::Value { coordinate, value: value.to_f64() },
            },
            until: self.until.iter().map(until).collect(),
            sides: self.sides.clone(),
            set: self.set.clone(),
            floors: self.floors.clone(),
            settings: self.settings.within::<f64>(),
        }
    }

    /// The state that the engine begins with besides the start.
    pub(crate) fn handed(&self) -> &Handed {
        self.carried.as_ref().map_or(&self.dropped, |carried| &carried.handed)
    }

    /// Returns true if a coordinate is the one that counts from an origin.
    pub(super) fn counts_from_origin(&self, a: usize) -> bool {
        self.origin.is_some_and(|(coordinate, _)| coordinate == a)
    }

    /// The origin that a coordinate counts from.
    pub(crate) fn origin_of(&self, a: usize) -> S {
        origin_of(self.origin, a)
    }
}

/// Bytes per node of the banded systems of the physical limit with two fields, always in `f64`: a fixed part, and one
/// for every order. They grow with the square of the number of fields.
const BANDED: [f64; 2] = [45.0, 18.0];
/// The same for the factors of the doubled system with two coordinates, all of which grow with the order.
const DOUBLED: [f64; 2] = [0.0, 440.0];
/// Bytes of a list without its elements.
const LIST: f64 = 24.0;
/// The program itself.
const PROGRAM: f64 = 6e6;

/// About how many bytes solving `setup` and writing its tables takes, with `samples` samples, in the memory of a few
/// windows if it `is_streamed`. The constants come from runs of a hundred thousand nodes, whose memory the estimate
/// meets within a third. With an accuracy asked for, the nodes are not known beforehand and do not count.
pub fn bytes_needed<S: Real>(setup: &Setup<S>, is_streamed: bool, samples: usize) -> f64 {
    let (geometry, settings) = (&setup.place.geometry, &setup.settings);
    let (number, samples, nodes) = (size_of::<S>() as f64, samples as f64, settings.n_gamma as f64);
    let (structure, n) = (geometry.structure(), geometry.dimension() as f64);
    // A node keeps its solution, its diagnostics, and what writing the tables needs. Each row of the structure is one
    // number more.
    let of_node = 10.0 * n + (structure.rows + structure.force_rows) as f64;
    // A window keeps its end, its multipliers, and what is measured there; a sample keeps three lists of values.
    let (of_window, of_sample) = (30.0 * n, 1.0 + 3.0 * n);
    let shown = (SHOWN as f64 / nodes).ceil().min(settings.windows as f64);
    let windows = if is_streamed { shown } else { settings.windows as f64 };
    let numbers = windows * (of_node * nodes + of_window) + of_sample * samples;
    let fields = 2.0 * geometry.active().len() as f64;
    PROGRAM + number * numbers + LIST * 3.0 * samples + nodes * bytes_of_solver(settings, n, fields)
}

/// Bytes per node of a window for the linear systems of so many coordinates, or fields of the physical limit.
fn bytes_of_solver(settings: &Settings, coordinates: f64, fields: f64) -> f64 {
    let order = settings.sbp.coefficients().map_or(0, |table| table.interior_order) as f64;
    let factors = |[constant, by_order]: [f64; 2], size: f64| (size / 2.0).powi(2) * (constant + by_order * order);
    match (settings.system, settings.form) {
        (System::Doubled, _) => factors(DOUBLED, coordinates),
        // Two-step leapfrog is explicit.
        (System::PhysicalLimit, Form::Strong) if order == 2.0 => 0.0,
        (System::PhysicalLimit, _) => factors(BANDED, fields),
    }
}
