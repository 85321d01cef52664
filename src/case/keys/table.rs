//! The table of keys. In every table of a case they stand in the order in which messages list them.

use super::Cases::{All, MakesScene, OfX, Scenes};
use super::Kind::{
    Column, Count, Digits, Expression, Flag, Formula, Formulas, Keys, Line, Named, Names, Norm, Number, Numbers,
    Positive, Share, Start, Table, Text, Value, Values, Whole, Word,
};
use super::{Key, Words};

/// Makes the table. The comment on a key is its meaning, and what stands in parentheses are its name, its kind, what
/// holds without it, and the cases that have it.
macro_rules! table {
    ($($(#[doc = $meaning:literal])+ ($name:literal, $kind:expr, $default:literal, $cases:expr);)+) => {
        &[$(Key {
            name: $name,
            kind: $kind,
            default: $default,
            cases: $cases,
            meaning: concat!($($meaning),+).trim_ascii_start(),
        }),+]
    };
}

/// Every key of a case. Exactly one of `potential.free` to `potential.formula` is given in a case of x.
pub static KEYS: &[Key] = table! {
    /// A name for people. It heads the output and the pictures.
    ("title", Line, "none", All);
    /// named numbers, or formulas in each other, for all formulas of the case
    ("parameters", Named(&Start), "none", All);

    /// the names of the coordinates, in the order of the columns
    ("metric.coordinates", Names, "", MakesScene);
    /// g_ab by pairs of names: `{ "t t" = "f", "t phi" = "a*w" }`
    ("metric.components", Named(&Formula), "", MakesScene);
    /// named expressions, which may use each other
    ("metric.definitions", Named(&Formula), "none", MakesScene);
    /// A_a: `{ t = "e*x", y = "-b*x" }`, the electromagnetic potential times the charge per mass
    ("metric.one_form", Named(&Formula), "none", MakesScene);
    /// F_a in coordinates and velocities: `{ r = "-k*r_dot" }`
    ("metric.force", Named(&Formula), "none", MakesScene);
    /// a factor Ω of the metric. It changes neither path nor charges, only the pace of γ. Where K is not 0 it adds the
    /// coordinate tau.
    ("metric.conformal", Formula, "", MakesScene);
    /// a metric by name, in place of coordinates and components
    ("metric.preset", Word(Words::Preset), "", MakesScene);

    /// the coordinates of V; without it `["x"]`, or those of the force if there is no V
    ("potential.coordinates", Names, "", MakesScene);
    /// V = 0
    ("potential.free", Table, "", All);
    /// V = alpha x
    ("potential.linear", Table, "", All);
    /// the slope of V
    ("potential.linear.alpha", Number, "required", All);
    /// V = kappa x⁴
    ("potential.quartic", Table, "", All);
    /// the factor of x⁴
    ("potential.quartic.kappa", Number, "required", All);
    /// V = c₀ + c₁x + c₂x² + …
    ("potential.polynomial", Table, "", All);
    /// c₀, c₁, c₂, … of V
    ("potential.polynomial.coefficients", Numbers, "required", All);
    /// V from an expression; a table with the key below is taken, too
    ("potential.formula", Expression, "", All);
    /// V as a formula in the coordinates
    ("potential.formula.expression", Expression, "required", All);
    /// A of L = ½mv² − V + A·v: a magnetic field, a rotating frame
    ("potential.one_form", Named(&Formula), "none", MakesScene);
    /// named expressions, which may use each other
    ("potential.definitions", Named(&Formula), "none", MakesScene);
    /// a force in Newton's sense besides −∂V: `{ x = "-k*x_dot" }`
    ("potential.force", Named(&Formula), "none", MakesScene);
    /// a factor Ω of the metric of Newton's law
    ("potential.conformal", Formula, "", MakesScene);

    /// the same as `potential.force`, where there is no potential: Newton's law with V = 0
    ("force.q", Formula, "", MakesScene);

    /// bodies that move by Newton's law, one table `[[body]]` for each: the name of this one
    ("body.name", Text, "required", MakesScene);
    /// the mass of the body, which may be 0
    ("body.mass", Value, "required", MakesScene);
    /// its place, by two or three numbers or formulas: the coordinates are x_NAME, y_NAME, z_NAME
    ("body.position", Values, "required", MakesScene);
    /// its velocity, by as many numbers or formulas
    ("body.velocity", Values, "required", MakesScene);
    /// the energy of each pair in their distance r and masses m_1 and m_2: `"-G*m_1*m_2/r"`
    ("pair.formula", Expression, "", Scenes);

    /// the mass m
    ("particle.mass", Positive, "1.0", All);
    /// a mass for each coordinate in place of `mass`, which may be a formula in t: `{ x = "m0 - k*t" }`
    ("particle.masses", Named(&Formula), "none", MakesScene);
    /// the speed of light; Newton's law has none. The motion is Newton's in the limit of large c; `run` says how far it
    /// is from that. Some thousand times the largest speed is enough, and more costs digits of K.
    ("particle.c", Positive, "1.0", All);
    /// `"relativistic"`, the metric of the paper, diag(c² + 2V/m, −m_a/m, …), or `"newtonian"`
    ("particle.law", Word(Words::Law), "\"relativistic\"", MakesScene);

    /// the time at the start
    ("initial.t", Start, "0", OfX);
    /// the position at the start
    ("initial.x", Start, "required in a case of x", OfX);
    /// dt/dγ at the start. With 1, γ runs like time does at the start.
    ("initial.t_dot", Start, "required in a case of x", OfX);
    /// dx/dγ at the start
    ("initial.x_dot", Start, "", OfX);
    /// dx/dt at the start, where x, of whatever name, is the one coordinate besides t: x_dot = velocity · t_dot
    ("initial.velocity", Start, "", All);
    /// the folder of an earlier run: its end is the start, to the last bit
    ("initial.from", Text, "", All);
    /// the place, for each coordinate q; an ignorable one may be left out and is 0. An interval, `[0.99, 1.01]`, asks
    /// for a [proof](trust.md#what-is-proved) of where all motions from there end, and the run takes its middle.
    ("initial.q", Start, "", Scenes);
    /// dq/dγ at the start, for each coordinate q whose momentum is not given
    ("initial.q_dot", Start, "", Scenes);
    /// the momentum of a coordinate q at the start, in place of dq/dγ
    ("initial.p_q", Start, "", Scenes);
    /// a number for K, `"timelike"` (1) or `"null"` (0), in place of the rate of one coordinate
    ("initial.norm", Norm, "", Scenes);
    /// the rate that follows from K: `{ r_dot = "+" }`, with `"+"` for the larger root; where there is only one, it is
    /// that
    ("initial.solve", Named(&Word(Words::Sign)), "", Scenes);

    /// the first value of γ
    ("grid.gamma_i", Value, "0", All);
    /// the last value of γ. Below gamma_i, the run goes backward.
    ("grid.gamma_f", Value, "required without t_f", All);
    /// the time at which to end, in place of gamma_f. An earlier one lets the run go backward.
    ("grid.t_f", Value, "", All);
    /// nodes of a window. At least 3, 8, 12, 16 for SBP21, 42, 63, 84. A spectral element fixes it.
    ("grid.n_gamma", Whole, "required on a given grid", All);
    /// the range is cut into so many windows; each continues the one before
    ("grid.windows", Count, "1", All);
    /// beside gamma_f or t_f: end earlier, where this formula of coordinates and velocities first changes its sign
    ("grid.until", Formula, "", All);

    /// `"SBP21"`, `"SBP42"`, `"SBP63"`, `"SBP84"`, or `"GLL2"` … `"GLL64"`, a spectral element of that many nodes
    ("scheme.sbp", Word(Words::Operator), "required on a given grid", All);
    /// `"strong"`: the paper's, with multipliers. `"weak"`: none; Q_t is exact at every node.
    ("scheme.form", Word(Words::Form), "\"strong\"", All);
    /// `false` puts D in the place of D̄, to show why it must not. Needs the strong form and `system = "doubled"`.
    ("scheme.regularised", Flag, "true", All);

    /// `"physical-limit"`: the collocation system that the critical point is. `"doubled"`: all unknowns of the action.
    ("solver.system", Word(Words::System), "\"physical-limit\"", All);
    /// significant digits. 16 is double precision, more is extended precision.
    ("solver.digits", Digits, "16", All);
    /// most Newton iterations of a window
    ("solver.max_iterations", Count, "50", All);
    /// the error allowed in t and x at any node, relative to their sizes. The program then chooses operator and
    /// windows.
    ("solver.accuracy", Share, "", All);
    /// the error allowed in every window by itself, without a promise for the run: it goes to its end, and says until
    /// where positions are good. For chaotic motion.
    ("solver.tolerance", Share, "", All);
    /// sizes of coordinates below which accuracy and tolerance are absolute: `{ phi = 1e-6 }`
    ("solver.floor", Named(&Value), "none", All);
    /// true, with accuracy or tolerance: also how small changes of the start grow, in `sensitivity.csv`, with the
    /// Lyapunov exponent and MEGNO, in `growth.csv`.
    ("solver.sensitivity", Flag, "false", All);
    /// false: nothing is compared with the run, which costs half as much; its error is not known, and the verdict is
    /// doubtful. `--no-error` is the same. With accuracy or tolerance the run is the one that would have been judged,
    /// if one round was enough.
    ("solver.error", Flag, "true", All);
    /// true: `run` also [proves](trust.md#what-is-proved) where the motion ends, and how far the run is from there;
    /// false: it does not. Without it a run with `solver.accuracy` does so if that takes [some 0.2
    /// seconds](trust.md#what-is-proved) or less.
    ("solver.proof", Flag, "", All);

    /// how the solve must end. A name from the [list of statuses](results.md#statuses).
    ("expect.status", Word(Words::Status), "\"converged\"", All);
    /// t at the last node
    ("expect.t_final", Value, "", OfX);
    /// x at the last node
    ("expect.x_final", Value, "", OfX);
    /// for a coordinate q, the value at the end that `check --run` compares with, up to `expect.tolerance`
    ("expect.q_final", Value, "", Scenes);
    /// γ at the end, to compare in the same way
    ("expect.gamma_final", Value, "", Scenes);
    /// the largest difference allowed. Required with what ends in _final.
    ("expect.tolerance", Positive, "", All);

    /// a formula in coordinates, velocities q_dot, momenta p_q and `norm`: how much it changes is reported
    ("invariants.NAME", Formula, "", All);

    /// an event is where this formula of coordinates and velocities changes its sign
    ("events.NAME.when", Formula, "required", All);
    /// which changes count: `"up"`, `"down"` or `"both"`
    ("events.NAME.direction", Word(Words::Direction), "\"both\"", All);
    /// true: the first one ends the run
    ("events.NAME.until", Flag, "false", All);
    /// it changes the state or a parameter: `{ z_dot = "-0.9*z_dot", k = "k/2" }`
    ("events.NAME.set", Named(&Formula), "", All);

    /// for `find`: the [numbers that are to be found](guide.md#to-find-a-start), each by its key. Each has a number in
    /// the case, from which the search starts: `["initial.x_dot", "grid.t_f", "parameters.k"]`
    ("find.unknowns", Keys, "required", All);
    /// formulas of coordinates, velocities and momenta that are to be 0 at the end, where start(x) is x at the start:
    /// `["x - 3", "y - start(y)"]`
    ("find.meet", Formulas, "", All);
    /// true, in place of `find.meet`: all active coordinates but t, and their velocities, return
    ("find.periodic", Flag, "false", All);
    /// in place of `find.meet`, observations that the run is fitted to: the columns of this file,
    /// `{ file = "obs.csv", t = "t", x = "x", sigma_x = "s" }`, or without a file arrays
    ("find.data.file", Text, "", All);
    /// the values of γ at which they were made, in place of the times `t`
    ("find.data.gamma", Column, "", All);
    /// for an observed coordinate q, the standard deviations; without them all are equal
    ("find.data.sigma_q", Column, "", All);
    /// the observations of a coordinate q; of t, the times at which they were made
    ("find.data.q", Column, "", All);

    /// the axis to the right of the pictures of the orbit and of the events, a formula of coordinates and velocities
    ("plot.x", Formula, "", All);
    /// the axis upwards of these pictures
    ("plot.y", Formula, "", All);

    /// a function of one argument, NAME(r) in formulas: a spline through the points of this file,
    /// `{ file = "points.csv", x = "r", y = "v" }`, or through `{ x = [numbers], y = [numbers] }`
    ("tables.NAME.file", Text, "", All);
    /// the arguments, or the name of their column
    ("tables.NAME.x", Column, "required", All);
    /// the values, or the name of their column
    ("tables.NAME.y", Column, "required", All);
    /// `"cubic"`, whose second derivative is 0 at both ends, `"clamped"`, whose first one is, or `"quintic"`, of degree
    /// 5, whose third and fourth ones are
    ("tables.NAME.spline", Word(Words::Spline), "\"cubic\"", All);
    /// `"refused"`, or `"linear"`: beyond its points the function goes on as its tangent
    ("tables.NAME.outside", Word(Words::Outside), "\"refused\"", All);
};
