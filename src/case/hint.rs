//! Advice for mistakes in the keys of a case.

use toml_edit::{Item, Table};

use super::CaseError;
use super::keys::{KEYS, SCENE_KEYS};
use super::potential::POTENTIALS;
use super::source::Source;
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
pub(super) fn for_key<'k>(key: &str, path: &str, own: impl Iterator<Item = &'k str>) -> Option<String> {
    let table = |name: &'static str| name.rsplit_once('.').map_or("", |(table, _)| table);
    let elsewhere = known().find(|name| last(name) == key && table(name) != path);
    let anywhere = || known().find(|name| nearest(key, known().map(last)) == Some(last(name)));
    let meant = elsewhere.map(str::to_owned).or_else(|| nearest(key, own).map(str::to_owned));
    meant.or_else(|| anywhere().map(str::to_owned))
}

/// Returns the word that an unknown one was probably meant to be, by the deserialiser's message about it.
pub(super) fn for_word(message: &str) -> Option<String> {
    let mut quoted = message.strip_prefix("unknown variant ")?.split('`').skip(1).step_by(2);
    let word = quoted.next()?;
    nearest(word, quoted).map(|meant| format!("did you mean `{meant}`?"))
}

/// The mistake of a case of the paper that lacks required keys, with its place and what to do; it names all of them.
pub(super) fn missing(root: &Table, source: &Source) -> Option<CaseError> {
    let table = |name: &str| root.get(name).and_then(Item::as_table_like);
    let has = |name: &str, key: &str| table(name).is_some_and(|table| table.contains_key(key));
    // As (table, key); the table of a key at the top level is empty.
    let mut keys: Vec<(&str, &str)> = Vec::new();
    let mut need = |name, key: &'static str, is_needed: bool| match table(name) {
        _ if !is_needed => {}
        None => keys.push(("", name)),
        Some(table) if !key.is_empty() && !table.contains_key(key) => keys.push((name, key)),
        Some(_) => {}
    };
    let is_begun = !has("initial", "from");
    let lacks =
        |others: &[&str]| is_begun && table("initial").is_some() && !others.iter().any(|other| has("initial", other));
    let is_chosen = has("solver", "accuracy") || has("solver", "tolerance");
    let sbp = table("scheme").and_then(|scheme| scheme.get("sbp")).and_then(Item::as_str);
    need("potential", "", true);
    need("initial", "x", is_begun);
    need("initial", "t_dot", lacks(&["p_t", "solve"]));
    need("initial", "x_dot", lacks(&["p_x", "velocity", "solve"]));
    need("scheme", "sbp", !is_chosen);
    // A spectral element has a fixed number of nodes.
    need("grid", "n_gamma", !is_chosen && !sbp.is_some_and(|sbp| sbp.starts_with("GLL")));
    let potential = table("potential");
    let of_kinds =
        [("linear", "alpha"), ("quartic", "kappa"), ("polynomial", "coefficients"), ("formula", "expression")];
    keys.extend(of_kinds.iter().filter(|(kind, key)| {
        let kind = potential.and_then(|potential| potential.get(kind)).and_then(Item::as_table_like);
        kind.is_some_and(|kind| !kind.contains_key(key))
    }));
    let (first, _) = *keys.first()?;
    let item = root.get(first).or_else(|| potential.and_then(|potential| potential.get(first)));
    let message = match keys.as_slice() {
        [("initial", "x_dot")] => "neither x_dot nor velocity is given".to_owned(),
        [(_, key)] => format!("missing field `{key}`"),
        keys => {
            let dotted = keys.iter().map(|(table, key)| match *table {
                "" => format!("`{key}`"),
                kind if of_kinds.iter().any(|(other, _)| *other == kind) => format!("`potential.{kind}.{key}`"),
                table => format!("`{table}.{key}`"),
            });
            format!("missing fields {}", dotted.collect::<Vec<_>>().join(", "))
        }
    };
    Some(source.error(item.map_or(Some(0..0), Item::span), message, remedy(&keys)))
}

/// What to do about missing keys.
fn remedy(missing: &[(&str, &str)]) -> Option<String> {
    let of_grid = "give scheme.sbp and grid.n_gamma, or solver.accuracy in place of both";
    let helps: [(&[(&str, &str)], String); 5] = [
        (&[("", "potential")], format!("[potential]: {POTENTIALS}")),
        (
            &[("", "initial")],
            "[initial] needs x, t_dot (dt/dgamma) and either x_dot (dx/dgamma) or velocity (dx/dt)".to_owned(),
        ),
        (
            &[("initial", "t_dot")],
            "initial.t_dot is dt/dgamma at the start; with 1, gamma runs like time does there. Newton's law needs \
             none: particle.law = \"newtonian\""
                .to_owned(),
        ),
        (
            &[("initial", "x_dot")],
            "give exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)".to_owned(),
        ),
        (&[("", "scheme"), ("", "grid"), ("scheme", "sbp"), ("grid", "n_gamma")], of_grid.to_owned()),
    ];
    let needed = helps.into_iter().filter(|(keys, _)| keys.iter().any(|key| missing.contains(key)));
    let needed: Vec<String> = needed.map(|(_, help)| help).collect();
    (!needed.is_empty()).then(|| needed.join("\n"))
}
