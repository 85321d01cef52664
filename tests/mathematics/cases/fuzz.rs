//! Targets of random texts: case files, formulas, metrics and `--set`. The corpus is the cases that are built in, and
//! the words that occur in them. Whatever is read is written so that it reads back the same; whatever is refused is
//! refused with a message and, where it is the case's fault, a place in it. Nothing panics or takes long, and what is
//! solved is finite.
//!
//! `FUZZ_CASES=100000 cargo test --profile tests --test mathematics fuzz` tries as many texts of every kind.

use std::time::{Duration, Instant};

use geodesic_ivp::case::{Case, KEYS, builtin};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::geometry::value_of;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::{Solution, solve};
use proptest::prelude::*;
use proptest::sample::select;

/// No text of a few hundred characters takes longer to read.
const MOST_SECONDS: Duration = Duration::from_secs(5);

/// Pieces of cases that a random text is made of, and pieces that do not belong there.
fn words() -> Vec<&'static str> {
    let words = "x y t r phi f m pi e norm q_dot x_dot r_dot p_phi 0 1 -1 2.5 1e-3 1e999 -1e308 5e-324 nan inf \
                 18446744073709551616 + - * / ^ ( ) (( sin( sqrt( abs( ln( atan( = == [ ] [[ { } {} ' , . # é √";
    words.split_whitespace().chain(["\"", " ", "\n", "\\", "\0", "\t"]).collect()
}

/// A word in a case becomes one of these.
#[derive(Debug, Clone)]
enum Edit {
    Replace(&'static str),
    Insert(&'static str),
    Remove(usize),
    RepeatLine,
    /// The rest is that of another case.
    Splice(usize, usize),
}

fn edit() -> impl Strategy<Value = Edit> {
    prop_oneof![
        select(words()).prop_map(Edit::Replace),
        select(words()).prop_map(Edit::Insert),
        (1..40_usize).prop_map(Edit::Remove),
        Just(Edit::RepeatLine),
        (0..builtin::NAMES.len(), 0..2000_usize).prop_map(|(case, at)| Edit::Splice(case, at)),
    ]
}

fn text_of(case: usize) -> &'static str {
    builtin::text(builtin::NAMES[case]).expect("it is built in")
}

/// Changes the text at about this share of it.
fn edited(text: &str, share: f64, edit: &Edit) -> String {
    let boundary = |text: &str, at: usize| (at.min(text.len())..=text.len()).find(|&at| text.is_char_boundary(at));
    let at = boundary(text, (share * text.len() as f64) as usize).unwrap_or(text.len());
    let (before, after) = text.split_at(at);
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
    match edit {
        Edit::Replace(word) => format!("{before}{word}{}", after.trim_start_matches(is_word)),
        Edit::Insert(word) => format!("{before}{word}{after}"),
        Edit::Remove(count) => format!("{before}{}", after.chars().skip(*count).collect::<String>()),
        Edit::RepeatLine => {
            let line = after.split_inclusive('\n').nth(1).unwrap_or("");
            format!("{before}{after}{line}")
        }
        Edit::Splice(case, from) => {
            let other = text_of(*case);
            format!("{before}{}", &other[boundary(other, *from).unwrap_or(other.len())..])
        }
    }
}

/// Reads a case, and says whether it is one.
fn read(text: &str, settings: &[String]) -> Result<bool, TestCaseError> {
    let start = Instant::now();
    let is_case = match Case::parse("case", text, settings) {
        Ok(case) => {
            let _ = (case.warnings(), case.title.as_deref(), case.coordinates());
            let written = case.to_toml();
            let again = Case::parse("again", &written, &[]);
            prop_assert!(again.is_ok(), "{}\nis not read again:\n{written}", again.unwrap_err());
            let again = again.map(|case| case.to_toml()).unwrap_or_default();
            prop_assert_eq!(again, written);
            true
        }
        Err(error) => {
            prop_assert!(!error.message.is_empty(), "{}", text);
            if let Some(span) = error.span.clone() {
                prop_assert!(
                    error.text.get(span.clone()).is_some(),
                    "{error}: {span:?} is no place in\n{}",
                    error.text
                );
            }
            false
        }
    };
    prop_assert!(start.elapsed() < MOST_SECONDS, "{:?}: {text}", start.elapsed());
    Ok(is_case)
}

/// A formula as the grammar has it, or nearly.
fn formula() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        select(vec!["x", "y", "r", "t", "a", "pi", "1", "2.5", "1e-3", "0", "1e999", "z"]).prop_map(str::to_owned),
        "[0-9.e+-]{1,6}",
    ];
    leaf.prop_recursive(6, 40, 2, |inner| {
        let operator = select(vec!["+", "-", "*", "/", "^", "**", " "]);
        let function = select(vec!["sin", "cos", "sqrt", "exp", "ln", "abs", "tanh", "acos", "atan", "atan2", "", "-"]);
        prop_oneof![
            (inner.clone(), operator, inner.clone()).prop_map(|(a, op, b)| format!("{a}{op}{b}")),
            (function, inner).prop_map(|(name, a)| format!("{name}({a})")),
        ]
    })
}

/// A case with that formula of V, and of two coordinates if it is a scene.
fn of_formula(formula: &str, is_scene: bool) -> String {
    let [table, initial] = match is_scene {
        true => ["coordinates = [\"x\", \"y\"]\nparameters = { a = 0.5 }\n", "y = 0.4\ny_dot = 0.1\n"],
        false => ["", ""],
    };
    format!(
        "[potential]\n{table}formula = {formula:?}\n[initial]\nx = 0.3\n{initial}t_dot = 1.0\nx_dot = 0.2\n\
         [grid]\ngamma_f = 1\nn_gamma = 16\n[scheme]\nsbp = \"SBP21\"\n"
    )
}

/// A scene with those components, a definition of y, and a force along r.
fn of_metric(components: &[(&str, String)], definition: &str, force: &str) -> String {
    let components: Vec<String> = components.iter().map(|(ab, value)| format!("{ab:?} = {value:?}")).collect();
    format!(
        "[metric]\ncoordinates = [\"t\", \"r\", \"phi\"]\nparameters = {{ a = 0.5 }}\n\
         definitions = {{ y = {definition:?} }}\ncomponents = {{ {} }}\nforce = {{ r = {force:?} }}\n\
         [initial]\nr = 3.0\nt_dot = 1.0\nr_dot = 0.1\nphi_dot = 0.2\n[grid]\ngamma_f = 1\nn_gamma = 16\n\
         [scheme]\nsbp = \"SBP21\"\n",
        components.join(", ")
    )
}

/// Solves a case, if the text is one. What is found is finite on every node.
fn solved(text: &str) -> Result<(), TestCaseError> {
    let start = Instant::now();
    let rows: Vec<Vec<f64>> = match Case::parse("case", text, &[]) {
        Err(_) => return Ok(()),
        Ok(case) if case.is_of_x => match solve(&case) {
            Err(_) => return Ok(()),
            Ok::<Solution, _>(solution) => {
                let measured = Diagnostics::new(&solution);
                vec![solution.t().collect(), solution.x().to_vec(), measured.norm.delta, measured.delta_g[1].clone()]
            }
        },
        Ok(case) => match solve(&case) {
            Err(_) => return Ok(()),
            Ok::<WorldLine, _>(line) => {
                let measured = Diagnostics::of(&line, &[], &mut [], false);
                let rows = (0..case.coordinates().len()).map(|a| line.q(a).collect());
                // Where a formula has t in it there may be no charge.
                let charges = measured.charges.into_iter().map(|charge| charge.delta);
                rows.chain([measured.norm.delta]).chain(charges).collect()
            }
        },
    };
    prop_assert!(rows.iter().flatten().all(|value| value.is_finite()), "{text}: {rows:?}");
    prop_assert!(start.elapsed() < MOST_SECONDS, "{:?}: {text}", start.elapsed());
    Ok(())
}

/// The text around the random parts is a case, so that a refusal is one of these parts.
#[test]
fn simple_formulas_are_cases() {
    let diagonal = [("t t", "y"), ("r r", "-1/a"), ("phi phi", "-r^2")].map(|(ab, value)| (ab, value.to_owned()));
    let texts = [of_formula("x^2", false), of_formula("x^2 + a*y", true), of_metric(&diagonal, "1 + a", "0.1*r")];
    for text in texts {
        assert!(matches!(read(&text, &[]), Ok(true)), "{text}");
    }
}

/// Exponents of any size have a power in 71 digits, too.
#[test]
fn powers_of_extended_numbers_take_any_exponent() {
    let value = |text: &str| value_of::<Extended>(text, &[]);
    assert_eq!(value("atan(pi)^ln(0)").unwrap(), Extended::ZERO);
    assert!(value("atan(pi)^(-ln(0))").is_err());
    let off = (value("(1 + 1e-20)^1e22").unwrap() - value("exp(100 - 5e-19)").unwrap()) / value("exp(100)").unwrap();
    assert!(off.abs().to_f64() < 1e-36, "{off:?}");
}

/// Pairs of coordinates, and what is none.
const PAIRS: [&str; 7] = ["t t", "r r", "t r", "phi phi", "r phi", "t", "r q"];

/// So many texts of each kind are tried.
fn cases() -> u32 {
    std::env::var("FUZZ_CASES").map_or(1500, |count| count.parse().expect("FUZZ_CASES is a number"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn case_files(case in 0..builtin::NAMES.len(), edits in prop::collection::vec((0.0..1.0_f64, edit()), 0..6)) {
        let text = edits.iter().fold(text_of(case).to_owned(), |text, (share, edit)| edited(&text, *share, edit));
        let is_case = read(&text, &[])?;
        prop_assert!(is_case || !edits.is_empty(), "{} is built in", builtin::NAMES[case]);
    }

    #[test]
    fn formulas(formula in formula(), is_scene in any::<bool>()) {
        read(&of_formula(&formula, is_scene), &[])?;
    }

    #[test]
    fn solved_formulas_are_finite(formula in formula(), is_scene in any::<bool>()) {
        solved(&of_formula(&formula, is_scene))?;
    }

    #[test]
    fn metrics(
        components in prop::collection::vec((select(&PAIRS[..]), formula()), 1..5),
        definition in formula(),
        force in formula(),
    ) {
        read(&of_metric(&components, &definition, &force), &[])?;
    }

    #[test]
    fn settings(
        case in 0..builtin::NAMES.len(),
        settings in prop::collection::vec(
            (0..KEYS.len(), prop::collection::vec(select(words()), 0..4)), 1..4
        ),
    ) {
        let setting = |(k, words): &(usize, Vec<&str>)| format!("{}={}", KEYS[*k].name, words.concat());
        let settings: Vec<String> = settings.iter().map(setting).collect();
        read(text_of(case), &settings)?;
    }
}
