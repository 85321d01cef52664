//! Advice for mistakes in the keys of a case.

use toml_edit::{Item, Table};

use crate::similar::nearest;

/// Every key of a case file.
const KEYS: [&str; 29] = [
    "title",
    "potential.free",
    "potential.linear",
    "potential.quartic",
    "potential.polynomial",
    "potential.formula",
    "particle.mass",
    "particle.c",
    "initial.t",
    "initial.x",
    "initial.t_dot",
    "initial.x_dot",
    "initial.velocity",
    "grid.gamma_i",
    "grid.gamma_f",
    "grid.t_f",
    "grid.n_gamma",
    "grid.windows",
    "scheme.sbp",
    "scheme.form",
    "scheme.regularised",
    "solver.system",
    "solver.digits",
    "solver.max_iterations",
    "solver.accuracy",
    "expect.status",
    "expect.t_final",
    "expect.x_final",
    "expect.tolerance",
];

/// The last part of a dotted key.
fn last(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(_, last)| last)
}

/// What an unknown key or word was probably meant to be, judged by the deserialiser's message about it.
pub(super) fn for_unknown(message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let word = quoted.next()?;
    let meant = if message.starts_with("unknown field `") {
        // First a key of this name in another table, then a similar key of this table, then a similar key of any table.
        let elsewhere = KEYS.into_iter().find(|key| last(key) == word);
        let anywhere = || KEYS.into_iter().find(|key| nearest(word, KEYS.map(last)) == Some(last(key)));
        elsewhere.or_else(|| nearest(word, quoted)).or_else(anywhere)?
    } else if message.starts_with("unknown variant `") {
        nearest(word, quoted)?
    } else {
        return None;
    };
    Some(format!("did you mean `{meant}`?"))
}

/// The required keys that a case lacks.
pub(super) struct Missing<'a> {
    /// The missing keys as (table, key); the table of a key at the top level is empty.
    keys: Vec<(&'static str, &'static str)>,
    /// The table of the first missing key.
    pub(super) item: Option<&'a Item>,
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
        need("initial", &["x", "t_dot"]);
        if table("initial").is_some() && !has("initial", "velocity") {
            need("initial", &["x_dot"]);
        }
        if !has("solver", "accuracy") {
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

    /// What is wrong.
    pub(super) fn message(&self) -> String {
        match self.keys.as_slice() {
            [("initial", "x_dot")] => "neither x_dot nor velocity is given".to_owned(),
            [(_, key)] => format!("missing field `{key}`"),
            keys => {
                let dotted = keys.iter().map(|(table, key)| match *table {
                    "" => format!("`{key}`"),
                    kind if KEYS.contains(&format!("potential.{kind}").as_str()) => format!("`potential.{kind}.{key}`"),
                    table => format!("`{table}.{key}`"),
                });
                format!("missing fields {}", dotted.collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// What to do.
    pub(super) fn help(&self, potentials: &str) -> Option<String> {
        let is_missing = |keys: &[(&str, &str)]| keys.iter().any(|key| self.keys.contains(key));
        let helps = [
            (is_missing(&[("", "potential")]), format!("[potential]: {potentials}")),
            (
                is_missing(&[("", "initial")]),
                "[initial] needs x, t_dot (dt/dgamma) and either x_dot (dx/dgamma) or velocity (dx/dt)".to_owned(),
            ),
            (
                is_missing(&[("initial", "t_dot")]),
                "initial.t_dot is dt/dgamma at the start; with 1, gamma runs like time does there".to_owned(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Case;

    /// The deserialiser's message about an unknown key lists the keys that it knows.
    #[test]
    fn the_known_keys_are_those_of_a_case() {
        for table in ["particle", "initial", "grid", "scheme", "solver", "expect"] {
            let text = format!("potential.free = {{}}\n[{table}]\nzzz = 1\n");
            let error = Case::parse("case", &text, &[]).unwrap_err();
            let listed: Vec<&str> = error.message.split('`').skip(1).step_by(2).skip(1).collect();
            let known = KEYS.into_iter().filter_map(|key| key.strip_prefix(table)?.strip_prefix('.'));
            assert_eq!(listed, known.collect::<Vec<_>>(), "{table}");
        }
    }
}
