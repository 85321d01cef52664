//! The keys of a scene, for advice about a key in the wrong table.

/// Every key with a fixed name.
const KEYS: [&str; 47] = [
    "title",
    "metric.coordinates",
    "metric.components",
    "metric.definitions",
    "metric.parameters",
    "metric.one_form",
    "metric.force",
    "metric.conformal",
    "metric.preset",
    "potential.coordinates",
    "potential.formula",
    "potential.free",
    "potential.linear",
    "potential.quartic",
    "potential.polynomial",
    "potential.one_form",
    "potential.force",
    "potential.conformal",
    "potential.parameters",
    "particle.mass",
    "particle.masses",
    "particle.c",
    "particle.law",
    "initial.norm",
    "initial.solve",
    "grid.gamma_i",
    "grid.gamma_f",
    "grid.t_f",
    "grid.n_gamma",
    "grid.windows",
    "grid.until",
    "scheme.sbp",
    "scheme.form",
    "solver.system",
    "solver.digits",
    "solver.max_iterations",
    "expect.status",
    "expect.gamma_final",
    "expect.tolerance",
    "events",
    "invariants",
    "plot",
    "grid",
    "scheme",
    "solver",
    "expect",
    "initial",
];

/// The key of that name in a table other than `path`.
pub(super) fn elsewhere(word: &str, path: &str) -> Option<String> {
    let parts = |key: &'static str| key.rsplit_once('.').unwrap_or(("", key));
    let found = KEYS.into_iter().find(|key| {
        let (table, last) = parts(key);
        last == word && table != path
    });
    found.map(str::to_owned)
}
