//! Keys and tables that exclude each other.

/// Two keys, or tables, that exclude each other.
pub(in crate::case) struct Exclusion {
    pub(in crate::case) one: &'static str,
    /// The one at which a mistake is told.
    pub(in crate::case) other: &'static str,
    /// The message where both are given.
    pub(in crate::case) message: &'static str,
    /// The remedy.
    pub(in crate::case) help: &'static str,
}

const BODIES: &str = "bodies move by Newton's law in the energy of their pairs, [pair] formula";
const CHOSEN: &str = "the program chooses operator and windows itself: leave n_gamma and windows out";
const PRESET: &str = "a preset has its own coordinates and components";
const GOAL: &str = "keep exactly one of find.meet, find.periodic and find.data";
const VELOCITY: &str = "keep exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)";
const ACCURACY: &str =
    "keep accuracy for an error of the whole run, or tolerance for a run that goes on whatever errors grow to";

/// Makes the list: keys, what is said of the second one where both are given, and what to do.
macro_rules! exclusive {
    ($($one:literal, $other:literal: $message:expr => $help:expr;)+) => {
        &[$(Exclusion { one: $one, other: $other, message: $message, help: $help }),+]
    };
}

/// All of them. An override of either, if they stand in tables, removes the other one, unless that is overridden too.
pub(in crate::case) static EXCLUSIVE: &[Exclusion] = exclusive! {
    "body", "metric": "both [[body]] and [metric] are given" => BODIES;
    "body", "potential": "both [[body]] and [potential] are given" => BODIES;
    "body", "force": "both [[body]] and [force] are given" => BODIES;
    "metric", "force": "[force] belongs to a potential, and the case has a metric"
        => "a force in a metric is metric.force";
    "metric", "potential": "both a metric and a potential are given"
        => "a case has exactly one of [metric] and [potential]";
    "metric.preset", "metric.coordinates": "'metric.coordinates' and 'metric.preset' are both given" => PRESET;
    "metric.preset", "metric.components": "'metric.components' and 'metric.preset' are both given" => PRESET;
    "force", "potential.force": "both [force] and potential.force are given" => "keep one of them";
    "initial.x_dot", "initial.velocity": "both x_dot and velocity are given" => VELOCITY;
    "initial.p_x", "initial.velocity": "both p_x and velocity are given" => VELOCITY;
    "solver.accuracy", "solver.tolerance": "both solver.accuracy and solver.tolerance are given" => ACCURACY;
    "solver.accuracy", "grid.n_gamma": "both solver.accuracy and grid.n_gamma are given" => CHOSEN;
    "solver.accuracy", "grid.windows": "both solver.accuracy and grid.windows are given" => CHOSEN;
    "solver.tolerance", "grid.n_gamma": "both solver.tolerance and grid.n_gamma are given" => CHOSEN;
    "solver.tolerance", "grid.windows": "both solver.tolerance and grid.windows are given" => CHOSEN;
    "find.meet", "find.periodic": "both find.meet and find.periodic are given" => GOAL;
    "find.meet", "find.data": "both find.meet and find.data are given" => GOAL;
    "find.periodic", "find.data": "both find.periodic and find.data are given" => GOAL;
    "grid.gamma_f", "grid.t_f": "both gamma_f and t_f are given" => "keep exactly one of grid.gamma_f and grid.t_f";
};
