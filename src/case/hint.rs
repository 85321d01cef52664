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
    let of_scenes = SCENE_KEYS.iter().flat_map(|(names, _)| names.split(", "));
    let is_fixed = |name: &&str| !name.contains("NAME") && !["q", "q_dot", "p_q", "q_final"].contains(&last(name));
    let keys = KEYS.iter().map(|key| key.name).chain(of_scenes).filter(is_fixed);
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

/// The required keys that a case lacks.
pub(super) struct Missing<'a> {
    /// The missing keys as (table, key); the table of a key at the top level is empty.
    keys: Vec<(&'static str, &'static str)>,
    /// The table of the first missing key.
    item: Option<&'a Item>,
}

impl<'a> Missing<'a> {
    /// Looks for all required keys; `None` if every one is there.
    pub(super) fn in_case(root: &'a Table) -> Option<Self> {
        let table = |name: &str| root.get(name).and_then(Item::as_table_like);
        let has = |name: &str, key: &str| table(name).is_some_and(|table| table.contains_key(key));
        let mut keys = Vec::new();
        let mut need = |name: &'static str, wanted: &[&'static str]| match table(name) {
            None => keys.push(("", name)),
            Some(table) => keys.extend(wanted.iter().filter(|key| !table.contains_key(key)).map(|key| (name, *key))),
        };
        need("potential", &[]);
        let is_continued = has("initial", "from");
        if !is_continued {
            need("initial", &["x"]);
        }
        for (rate, others) in [("t_dot", ["p_t", "solve"]), ("x_dot", ["p_x", "velocity"])] {
            let is_given = others.iter().any(|other| has("initial", other)) || has("initial", "solve");
            if table("initial").is_some() && !is_given && !is_continued {
                need("initial", &[rate]);
            }
        }
        if !has("solver", "accuracy") && !has("solver", "tolerance") {
            need("scheme", &["sbp"]);
            let sbp = table("scheme").and_then(|scheme| scheme.get("sbp")).and_then(Item::as_str);
            // A spectral element has a fixed number of nodes.
            if !sbp.is_some_and(|sbp| sbp.starts_with("GLL")) {
                need("grid", &["n_gamma"]);
            }
        }
        let potential = table("potential");
        for (kind, key) in
            [("linear", "alpha"), ("quartic", "kappa"), ("polynomial", "coefficients"), ("formula", "expression")]
        {
            let item = potential.and_then(|potential| potential.get(kind)).and_then(Item::as_table_like);
            if item.is_some_and(|item| !item.contains_key(key)) {
                keys.push((kind, key));
            }
        }
        let (first, _) = *keys.first()?;
        let item = root.get(first).or_else(|| potential.and_then(|potential| potential.get(first)));
        Some(Self { keys, item })
    }

    /// The mistake, with its place and what to do.
    pub(super) fn error(&self, source: &Source) -> CaseError {
        source.error(self.item.map_or(Some(0..0), Item::span), self.message(), self.help())
    }

    /// The mistake in words.
    fn message(&self) -> String {
        match self.keys.as_slice() {
            [("initial", "x_dot")] => "neither x_dot nor velocity is given".to_owned(),
            [(_, key)] => format!("missing field `{key}`"),
            keys => {
                let dotted = keys.iter().map(|(table, key)| match *table {
                    "" => format!("`{key}`"),
                    kind if known().any(|key| key.strip_prefix("potential.") == Some(kind)) => {
                        format!("`potential.{kind}.{key}`")
                    }
                    table => format!("`{table}.{key}`"),
                });
                format!("missing fields {}", dotted.collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// The remedy.
    fn help(&self) -> Option<String> {
        let is_missing = |keys: &[(&str, &str)]| keys.iter().any(|key| self.keys.contains(key));
        let helps = [
            (is_missing(&[("", "potential")]), format!("[potential]: {POTENTIALS}")),
            (
                is_missing(&[("", "initial")]),
                "[initial] needs x, t_dot (dt/dgamma) and either x_dot (dx/dgamma) or velocity (dx/dt)".to_owned(),
            ),
            (
                is_missing(&[("initial", "t_dot")]),
                "initial.t_dot is dt/dgamma at the start; with 1, gamma runs like time does there. Newton's law needs \
                 none: particle.law = \"newtonian\""
                    .to_owned(),
            ),
            (
                is_missing(&[("initial", "x_dot")]),
                "give exactly one of initial.x_dot (dx/dgamma) and initial.velocity (dx/dt)".to_owned(),
            ),
            (
                is_missing(&[("", "scheme"), ("", "grid"), ("scheme", "sbp"), ("grid", "n_gamma")]),
                "give scheme.sbp and grid.n_gamma, or solver.accuracy in place of both".to_owned(),
            ),
        ];
        let needed: Vec<String> = helps.into_iter().filter(|(needed, _)| *needed).map(|(_, help)| help).collect();
        (!needed.is_empty()).then(|| needed.join("\n"))
    }
}
