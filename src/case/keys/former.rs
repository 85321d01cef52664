//! Places of keys that are read for one version more, and the places that they have now.

/// The tables of parameters before there was one for all formulas of a case.
pub(in crate::case) const FORMER: [&str; 4] =
    ["metric.parameters", "potential.formula.parameters", "potential.parameters", "pair.parameters"];

/// The table in their place.
pub(in crate::case) const PARAMETERS: &str = "parameters";

/// Returns true if a dotted name is that of a former table.
pub(in crate::case) fn is_former(dotted: &str) -> bool {
    FORMER.contains(&dotted)
}

/// The former table that a dotted key is, or lies in, and the dotted key that takes its place.
pub(in crate::case) fn replaced(dotted: &str) -> Option<(&'static str, String)> {
    FORMER.into_iter().find_map(|place| {
        let rest = dotted.strip_prefix(place)?;
        (rest.is_empty() || rest.starts_with('.')).then(|| (place, format!("{PARAMETERS}{rest}")))
    })
}
