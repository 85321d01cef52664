//! Malformed cases that no page can show: each ends with the exit code and the message that say what is wrong and
//! where. What people write by mistake is in `tests/cmd/malformed-cases.md` and the pages beside it.

use std::fs::File;

use crate::common::{Folder, failed, stderr};

/// A valid case.
const QUARTIC: &str = r#"title = "Quartic"

[potential]
quartic = { kappa = 0.5 }

[particle]
mass = 1.0
c = 1.0

[initial]
t = 0.0
x = 1.0
x_dot = 0.1
t_dot = 1.0

[grid]
gamma_f = 1.0
n_gamma = 32

[scheme]
sbp = "SBP21"
"#;

fn edited(from: &str, to: &str) -> String {
    assert_eq!(QUARTIC.matches(from).count(), 1, "{from:?} must stand in the case once");
    QUARTIC.replace(from, to)
}

fn with_formula(expression: &str) -> String {
    edited("quartic = { kappa = 0.5 }", &format!("formula = {{ expression = \"{expression}\" }}"))
}

#[test]
fn invalid_cases_are_refused_where_they_are_wrong() {
    let folder = Folder::new();
    folder.write("case.toml", QUARTIC);
    folder.succeeds("run case.toml --out earlier");
    let column = |character: usize| format!("4:{}", "formula = { expression = \"".len() + character);
    let not_finite = edited("x = 1.0", "x = nan");
    let finite = "'initial.x' must be a finite number";
    for (text, at, message) in [
        (with_formula(&"(".repeat(1000)), column(65), "nested more than 64 deep"),
        (with_formula(&"sin(".repeat(100)), column(257), "nested more than 64 deep"),
        (with_formula(&"-".repeat(60_000)), column(60_001), "found the end"),
        (with_formula(&"2^".repeat(30_000)), column(1026), "more than 512 powers of powers"),
        (String::new(), "1:1".to_owned(), "missing fields `potential`, `initial`, `scheme`, `grid`"),
        ("{\"title\": 1}".to_owned(), "1:1".to_owned(), "expected key"),
        (edited("x = 1.0", &format!("x = {}", "[".repeat(100_000))), "12:85".to_owned(), "recursion"),
        (not_finite.replace('\n', "\r\n"), "12:5".to_owned(), finite),
        (format!("\u{feff}{not_finite}"), "12:5".to_owned(), finite),
    ] {
        folder.write("case.toml", &text);
        let words = format!("error:  … {message} … case.toml:{at}\n");
        let commands = ["check case.toml", "run case.toml --out new", "run case.toml --out earlier"];
        folder.refuses(&commands.map(|command| (command, 2, &*words)));
        let case = File::open(folder.path("case.toml")).unwrap();
        let piped = failed(&folder.program("run - --out new").stdin(case).output().unwrap(), 2);
        assert!(piped.contains(message) && piped.contains(&format!("<stdin>:{at}\n")), "{piped}");
    }
}

#[test]
fn extreme_formulas_end_in_order() {
    let folder = Folder::new();
    for (expression, code) in [
        (format!("{}x{}", "(".repeat(63), ")".repeat(63)), 0),
        (format!("{}x", "-".repeat(1000)), 0),
        (format!("x{}", "^x".repeat(500)), 0),
        ("x^1e300".to_owned(), 2),
    ] {
        folder.write("case.toml", with_formula(&expression));
        let output = folder.run("run case.toml --out new --quiet");
        assert_eq!(output.status.code(), Some(code), "{expression}: {}", stderr(&output));
    }
}

#[test]
fn a_spacelike_start_is_a_warning() {
    let folder = Folder::new();
    let warning = failed(&folder.run("run quartic --out new --quiet --set initial.x_dot=10.0"), 0);
    assert!(warning.starts_with("warning: the initial tangent is spacelike"), "{warning}");
    assert!(folder.has("new/trajectory.csv"));
}
