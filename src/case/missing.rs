//! The keys that a case of the paper lacks.

use super::CaseError;
use super::hint::last;
use super::keys;
use super::potential::POTENTIALS;
use super::reader::Field;
use super::settings::{END, NO_END, SCHEME};

/// The mistake of a case of the paper that lacks required keys, with its place and what to do; it names all of them.
pub(super) fn missing(root: &Field<'_>) -> Option<CaseError> {
    let has = |table: &str, key: &str| root.table(table).get(key).is_some();
    let is_begun = !has("initial", "from");
    let lacks =
        |others: &[&str]| is_begun && root.get("initial").is_some() && !others.iter().any(|key| has("initial", key));
    let is_chosen = has("solver", "accuracy") || has("solver", "tolerance");
    let sbp = root.table("scheme").get("sbp").and_then(|sbp| sbp.as_str());
    let needed = [
        ("potential", "", true),
        ("initial", "x", is_begun),
        ("initial", "t_dot", lacks(&["p_t", "solve"])),
        ("initial", "x_dot", lacks(&["p_x", "velocity", "solve"])),
        ("scheme", "sbp", !is_chosen),
        // A spectral element has a fixed number of nodes.
        ("grid", "n_gamma", !is_chosen && !sbp.is_some_and(|sbp| sbp.starts_with("GLL"))),
        ("grid", "gamma_f", !has("grid", "t_f")),
    ];
    // As dotted keys, with the tables that they belong to.
    let mut lacking: Vec<(String, Field<'_>)> = Vec::new();
    for (name, key, _) in needed.into_iter().filter(|(.., is_needed)| *is_needed) {
        match root.get(name) {
            None if lacking.iter().any(|(other, _)| other == name) => {}
            // A grid is nothing but its end where nodes are chosen.
            None if key == "gamma_f" => lacking.push((format!("{name}.{key}"), root.clone())),
            None => lacking.push((name.to_owned(), root.clone())),
            Some(table) if !key.is_empty() && table.get(key).is_none() => {
                lacking.push((format!("{name}.{key}"), table));
            }
            Some(_) => {}
        }
    }
    for kind in keys::potentials().filter_map(|kind| root.table("potential").get(kind)).filter(Field::is_table) {
        if let Some(key) = keys::of_potential(&kind.key).filter(|key| kind.get(key).is_none()) {
            lacking.push((format!("{}.{key}", kind.path), kind));
        }
    }
    let (_, table) = lacking.first()?;
    let message = match lacking.as_slice() {
        [(key, _)] if key == "initial.x_dot" => "neither x_dot nor velocity is given".to_owned(),
        [(key, _)] if key == "grid.gamma_f" => NO_END.to_owned(),
        [(key, _)] => format!("missing field `{}`", last(key)),
        keys => {
            let dotted = keys.iter().map(|(key, _)| format!("`{key}`"));
            format!("missing fields {}", dotted.collect::<Vec<_>>().join(", "))
        }
    };
    let needed = REMEDIES.iter().filter(|(of, _)| lacking.iter().any(|(key, _)| of.contains(&key.as_str())));
    let needed: Vec<String> = needed.map(|(_, help)| help.replace("POTENTIALS", POTENTIALS)).collect();
    Some(table.error(message).with_hint((!needed.is_empty()).then(|| needed.join("\n"))))
}

/// Remedies for missing keys.
const REMEDIES: [(&[&str], &str); 6] = [
    (&["potential"], "[potential]: POTENTIALS"),
    (&["initial"], "[initial] needs x, t_dot (dt/dgamma) and either x_dot (dx/dgamma) or velocity (dx/dt)"),
    (
        &["initial.t_dot"],
        "initial.t_dot is dt/dgamma at the start; with 1, gamma runs like time does there. Newton's law needs none: \
         particle.law = \"newtonian\"",
    ),
    (&["initial.x_dot"], "give exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)"),
    (&["scheme", "grid", "scheme.sbp", "grid.n_gamma"], SCHEME),
    (&["grid", "grid.gamma_f"], END),
];
