//! Advice for mistakes in the keys of a case.

use super::CaseError;
use super::keys::{KEYS, SCENE_KEYS};
use super::potential::{KINDS, POTENTIALS, key_of_kind};
use super::reader::Field;
use crate::formula::similar::nearest;

/// The dotted names of the keys that stand in the tables of a case file; what stands deeper belongs to a potential, and
/// names of coordinates and of the case's own are not among them.
fn known() -> impl Iterator<Item = &'static str> + Clone {
    let is_fixed = |name: &&str| !name.contains("NAME") && !["q", "q_dot", "p_q", "q_final"].contains(&last(name));
    let keys = KEYS.iter().chain(SCENE_KEYS.iter()).flat_map(|key| key.name.split(", ")).filter(is_fixed);
    keys.chain(["events", "invariants", "plot"]).filter(|name| name.matches('.').count() < 2)
}

/// The last part of a dotted key.
fn last(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(_, last)| last)
}

/// Returns the key that an unknown one of the table `path` was probably meant to be: one of this name in another table,
/// a similar one of `own`, those of this table, or a similar one of any table.
pub(super) fn for_key(key: &str, path: &str, own: &[&str]) -> Option<String> {
    let table = |name: &'static str| name.rsplit_once('.').map_or("", |(table, _)| table);
    let elsewhere = known().find(|name| last(name) == key && table(name) != path);
    let anywhere = || known().find(|name| nearest(key, known().map(last)) == Some(last(name)));
    elsewhere.or_else(|| nearest(key, own.iter().copied())).or_else(anywhere).map(str::to_owned)
}

/// Returns the word that an unknown one was probably meant to be, by the deserialiser's message about it.
pub(super) fn for_word(message: &str) -> Option<String> {
    let mut quoted = message.strip_prefix("unknown variant ")?.split('`').skip(1).step_by(2);
    let word = quoted.next()?;
    nearest(word, quoted).map(|meant| format!("did you mean `{meant}`?"))
}

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
    ];
    // As dotted keys, with the tables that they belong to.
    let mut keys: Vec<(String, Field<'_>)> = Vec::new();
    for (name, key, _) in needed.into_iter().filter(|(.., is_needed)| *is_needed) {
        match root.get(name) {
            None => keys.push((name.to_owned(), root.clone())),
            Some(table) if !key.is_empty() && table.get(key).is_none() => keys.push((format!("{name}.{key}"), table)),
            Some(_) => {}
        }
    }
    for kind in KINDS.iter().filter_map(|kind| root.table("potential").get(kind)).filter(Field::is_table) {
        let key = key_of_kind(&kind.key);
        if !key.is_empty() && kind.get(key).is_none() {
            keys.push((format!("{}.{key}", kind.path), kind));
        }
    }
    let (_, table) = keys.first()?;
    let message = match keys.as_slice() {
        [(key, _)] if key == "initial.x_dot" => "neither x_dot nor velocity is given".to_owned(),
        [(key, _)] => format!("missing field `{}`", last(key)),
        keys => {
            let dotted = keys.iter().map(|(key, _)| format!("`{key}`"));
            format!("missing fields {}", dotted.collect::<Vec<_>>().join(", "))
        }
    };
    let needed = REMEDIES.iter().filter(|(of, _)| keys.iter().any(|(key, _)| of.contains(&key.as_str())));
    let needed: Vec<String> = needed.map(|(_, help)| help.replace("POTENTIALS", POTENTIALS)).collect();
    Some(table.error(message).with_hint((!needed.is_empty()).then(|| needed.join("\n"))))
}

/// Remedies for missing keys.
const REMEDIES: [(&[&str], &str); 5] = [
    (&["potential"], "[potential]: POTENTIALS"),
    (&["initial"], "[initial] needs x, t_dot (dt/dgamma) and either x_dot (dx/dgamma) or velocity (dx/dt)"),
    (
        &["initial.t_dot"],
        "initial.t_dot is dt/dgamma at the start; with 1, gamma runs like time does there. Newton's law needs none: \
         particle.law = \"newtonian\"",
    ),
    (&["initial.x_dot"], "give exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)"),
    (
        &["scheme", "grid", "scheme.sbp", "grid.n_gamma"],
        "give scheme.sbp and grid.n_gamma, or solver.accuracy in place of both",
    ),
];
