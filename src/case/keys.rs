//! The keys of a case file in words: the list that the manual page prints and the case reference repeats.

/// A key of a case file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// Its dotted name.
    pub name: &'static str,
    /// What it takes.
    pub kind: &'static str,
    /// What it is where it is left out; `required`, or nothing.
    pub default: &'static str,
    /// What it means.
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
        "the speed of light. The motion is Newton's in the limit of large c; run says how far it is from that. \
         Some thousand times the largest speed is enough, and more costs digits of K.",
    ),
    key("initial.t", "number", "0.0", "the time at the start"),
    key("initial.x", "number", "required", "the position at the start"),
    key("initial.t_dot", "number", "required", "dt/dγ at the start. With 1, γ runs like time does at the start."),
    key("initial.x_dot", "number", "", "dx/dγ at the start"),
    key("initial.velocity", "number", "", "dx/dt at the start: x_dot = velocity · t_dot"),
    key("grid.gamma_i", "number", "0.0", "the first value of γ"),
    key("grid.gamma_f", "number > gamma_i", "1.0", "the last value of γ"),
    key("grid.t_f", "number > initial.t", "", "the time at which to end, in place of gamma_f. Needs t_dot > 0."),
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
        "the error allowed in t and x. The program then chooses operator and windows.",
    ),
    key(
        "expect.status",
        "string",
        "\"converged\"",
        "how the solve must end. A name from the [list of statuses](files.md#statuses).",
    ),
    key("expect.t_final", "number", "", "t at the last node"),
    key("expect.x_final", "number", "", "x at the last node"),
    key("expect.tolerance", "number > 0", "", "the largest difference allowed. Required with t_final or x_final."),
];
