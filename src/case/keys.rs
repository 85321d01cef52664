//! The keys of a case file in words: the lists that the manual page prints, and `docs/cases.md` repeats.

/// A key of a case file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// Its dotted name.
    pub name: &'static str,
    /// The kind of value that it takes.
    pub kind: &'static str,
    /// Its default, `required`, or nothing.
    pub default: &'static str,
    /// Its meaning.
    pub meaning: &'static str,
}

/// Makes a [`Key`]; with this function every entry of the list is short.
const fn key(name: &'static str, kind: &'static str, default: &'static str, meaning: &'static str) -> Key {
    Key { name, kind, default, meaning }
}

/// Every key, table by table. A case has exactly one of `potential.free` to `potential.formula`.
pub const KEYS: &[Key] = &[
    key("title", "string, one line", "none", "A name for people. It heads the output and the pictures."),
    key("potential.free", "table", "", "V = 0"),
    key("potential.linear", "table", "", "V = alpha x"),
    key("potential.linear.alpha", "number", "required", "the slope"),
    key("potential.quartic", "table", "", "V = kappa x⁴"),
    key("potential.quartic.kappa", "number", "required", "the factor"),
    key("potential.polynomial", "table", "", "V = c₀ + c₁x + c₂x² + …"),
    key("potential.polynomial.coefficients", "numbers", "required", "c₀, c₁, c₂, …"),
    key("potential.formula", "table, or a string", "", "V from an expression"),
    key("potential.formula.expression", "string", "required", "V as a formula in x"),
    key("potential.formula.parameters", "table of numbers", "none", "the names used in it"),
    key("particle.mass", "number > 0", "1.0", "the mass m"),
    key(
        "particle.c",
        "number > 0",
        "1.0",
        "the speed of light; Newton's law has none. The motion is Newton's in the limit of large c; run says how far \
         it is from that. Some thousand times the largest speed is enough, and more costs digits of K.",
    ),
    key("initial.t", "number", "0.0", "the time at the start"),
    key("initial.x", "number", "required", "the position at the start"),
    key("initial.t_dot", "number", "required", "dt/dγ at the start. With 1, γ runs like time does at the start."),
    key("initial.x_dot", "number", "", "dx/dγ at the start"),
    key("initial.velocity", "number", "", "dx/dt at the start: x_dot = velocity · t_dot"),
    key("initial.from", "string", "", "the folder of an earlier run: its end is the start, to the last bit"),
    key("grid.gamma_i", "number", "0.0", "the first value of γ"),
    key("grid.gamma_f", "number", "1.0", "the last value of γ. Below gamma_i, the run goes backward."),
    key(
        "grid.t_f",
        "number",
        "",
        "the time at which to end, in place of gamma_f. An earlier one lets the run go backward.",
    ),
    key(
        "grid.n_gamma",
        "whole number",
        "required",
        "nodes of a window. At least 3, 8, 12, 16 for SBP21, 42, 63, 84. A spectral element fixes it.",
    ),
    key(
        "grid.windows",
        "whole number ≥ 1",
        "1",
        "the range is cut into so many windows; each continues the one before",
    ),
    key(
        "scheme.sbp",
        "string",
        "required",
        "\"SBP21\", \"SBP42\", \"SBP63\", \"SBP84\", or \"GLL2\" … \"GLL64\", a spectral element of that many nodes",
    ),
    key(
        "scheme.form",
        "string",
        "\"strong\"",
        "\"strong\": the paper's, with multipliers. \"weak\": none; Q_t is exact at every node.",
    ),
    key(
        "scheme.regularised",
        "true or false",
        "true",
        "false puts D in the place of D̄, to show why it must not. Needs the strong form and system = \"doubled\".",
    ),
    key(
        "solver.system",
        "string",
        "\"physical-limit\"",
        "\"physical-limit\": the collocation system that the critical point is. \"doubled\": all unknowns of the \
         action.",
    ),
    key("solver.max_iterations", "whole number ≥ 1", "50", "most Newton iterations of a window"),
    key("solver.digits", "16 … 70", "16", "significant digits. 16 is double precision, more is extended precision."),
    key(
        "solver.accuracy",
        "number in (0, 1)",
        "",
        "the error allowed in t and x at any node, relative to their sizes. The program then chooses operator and \
         windows.",
    ),
    key(
        "solver.tolerance",
        "number in (0, 1)",
        "",
        "the same for every window by itself, without a promise for the run: it goes to its end, and says until where \
         positions are good. For chaotic motion.",
    ),
    key(
        "solver.floor",
        "table of numbers",
        "none",
        "sizes of coordinates below which accuracy and tolerance are absolute: { phi = 1e-6 }",
    ),
    key(
        "solver.sensitivity",
        "true or false",
        "false",
        "true, with accuracy or tolerance: also how small changes of the start grow, in sensitivity.csv, with the \
         Lyapunov exponent and MEGNO.",
    ),
    key(
        "expect.status",
        "string",
        "\"converged\"",
        "how the solve must end. A name from the [list of statuses](results.md#statuses).",
    ),
    key("expect.t_final", "number", "", "t at the last node"),
    key("expect.x_final", "number", "", "x at the last node"),
    key("expect.tolerance", "number > 0", "", "the largest difference allowed. Required with t_final or x_final."),
];

/// The keys that scenes have besides, with what they mean. q stands for any coordinate, and
/// NAME for a name of the case's own.
pub const SCENE_KEYS: &[(&str, &str)] = &[
    ("metric.coordinates", "their names, in the order of the columns"),
    ("metric.components", "g_ab by pairs of names: { \"t t\" = \"f\", \"t phi\" = \"a*w\" }"),
    ("metric.definitions", "named expressions, which may use each other"),
    ("metric.parameters", "named numbers, or formulas in each other"),
    ("metric.one_form", "A_a: { t = \"e*x\", y = \"-b*x\" }, the electromagnetic potential times the charge per mass"),
    ("metric.force", "F_a in coordinates and velocities: { r = \"-k*r_dot\" }"),
    (
        "metric.conformal",
        "a factor Ω of the metric. It changes neither path nor charges, only the pace of γ. Where K is not 0 it adds \
         the coordinate tau.",
    ),
    ("metric.preset", "a metric by name, in place of coordinates and components"),
    ("potential.coordinates", "the coordinates of V; without it [\"x\"]"),
    ("potential.definitions", "named expressions, which may use each other"),
    ("potential.parameters", "named numbers or formulas in each other, for all formulas of this table"),
    ("potential.one_form", "A of L = ½mv² − V + A·v: a magnetic field, a rotating frame"),
    ("force.q", "the same as potential.force, where there is no potential: Newton's law with V = 0"),
    ("potential.force", "a force in Newton's sense besides −∂V: { x = \"-k*x_dot\" }"),
    ("potential.conformal", "a factor Ω of the metric of Newton's law"),
    ("particle.law", "\"relativistic\", the metric of the paper, diag(c² + 2V/m, −m_a/m, …), or \"newtonian\""),
    ("particle.masses", "a mass for each coordinate, which may be a formula in t: { x = \"m0 - k*t\" }"),
    ("body.name, body.mass", "bodies that move by Newton's law, one table [[body]] for each; the mass may be 0"),
    (
        "body.position, body.velocity",
        "two or three numbers or formulas each: the coordinates are x_NAME, y_NAME, z_NAME",
    ),
    ("pair.formula", "the energy of each pair in their distance r and masses m_1 and m_2: \"-G*m_1*m_2/r\""),
    ("pair.parameters", "named numbers or formulas in each other"),
    ("initial.q", "the place, for each coordinate q; an ignorable one may be left out and is 0"),
    ("initial.q_dot, initial.p_q", "for each coordinate either dq/dγ or its momentum"),
    ("initial.norm", "a number for K, \"timelike\" (1) or \"null\" (0), in place of the rate of one coordinate"),
    ("initial.solve", "that rate, which follows from K: { r_dot = \"+\" }, with \"+\" for the larger root"),
    (
        "grid.until",
        "beside gamma_f or t_f: end earlier, where this formula of coordinates and velocities first changes its sign",
    ),
    (
        "invariants.NAME",
        "a formula in coordinates, velocities q_dot, momenta p_q and norm: how much it changes is reported",
    ),
    (
        "events.NAME",
        "a table: when, a formula of coordinates and velocities, direction, \"up\", \"down\" or \"both\", and until = \
         true to end the run there, or set to change the state or a parameter there: { z_dot = \"-0.9*z_dot\", \
         k = \"k/2\" }",
    ),
    (
        "tables.NAME",
        "a function of one argument, NAME(r) in formulas: a cubic spline through { x = [numbers], y = [numbers] }, or \
         through the columns { file = \"points.csv\", x = \"r\", y = \"v\" }",
    ),
    (
        "tables.NAME.spline",
        "\"cubic\", whose second derivative is 0 at both ends, \"clamped\", whose first one is, or \"quintic\", of \
         degree 5, whose third and fourth ones are",
    ),
    ("tables.NAME.outside", "\"refused\", or \"linear\": beyond its points the function goes on as its tangent"),
    (
        "plot.x, plot.y",
        "the axes of the pictures of the orbit and of the events, as formulas of coordinates and velocities",
    ),
    (
        "expect.q_final",
        "for a coordinate q, the value at the end that check --run compares with, up to expect.tolerance",
    ),
    ("expect.gamma_final", "the same for γ at the end"),
];
