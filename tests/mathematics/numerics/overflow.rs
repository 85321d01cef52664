//! What overflows on the way to finite values is no end of the domain: 1/(1 + exp z) = (1 − tanh(z/2))/2, of which the
//! right side does not overflow.

use std::sync::atomic::AtomicBool;

use geodesic_ivp::case::{Form, SbpName};
use geodesic_ivp::number::Extended;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::study::convergence::{Convergence, sweep};
use geodesic_ivp::{Case, Solution, solve};

/// A hill that overflows beyond x = 14.6, as it is written first.
const HILL: [&str; 4] = [
    "0.3*(1 - tanh(25*(abs(x) - 0.4)))/2",
    "0.3/(1 + exp(50*(abs(x) - 0.4)))",
    "0.3*(1 - exp(50*(abs(x) - 0.4))/(1 + exp(50*(abs(x) - 0.4))))",
    "0.15 - 0.15*sinh(25*(abs(x) - 0.4))/cosh(25*(abs(x) - 0.4))",
];

const ACCURACY: &str = "[grid]\ngamma_f = 30.0\n[solver]\naccuracy = 1e-10\n";

fn case(formula: &str, rest: &str) -> Case {
    let start = "[initial]\nx = 0.3\nt_dot = 1.0\nx_dot = 0.4\n";
    let text = format!("[potential]\nformula = \"{formula}\"\n{start}{rest}");
    Case::parse("hill", &text, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// t and x at the end.
fn end<S: Arithmetic>(formula: &str, rest: &str) -> [f64; 2] {
    let solution: Solution<S> = solve(&case(formula, rest)).unwrap_or_else(|none| panic!("{formula}, {rest}: {none}"));
    let last = |row: &[S]| row[row.len() - 1].to_f64();
    let [t, x] = [solution.t().collect::<Vec<S>>(), solution.x().to_vec()].map(|row| last(&row));
    assert!(x > 20.0, "{x}");
    [t, x]
}

fn agree(formula: &str, found: [f64; 2], expected: [f64; 2], rest: &str) {
    let is_close = |(found, expected): (&f64, &f64)| (found - expected).abs() < 1e-8 * expected.abs();
    assert!(found.iter().zip(&expected).all(is_close), "{formula}, {rest}: {found:?}, {expected:?}");
}

#[test]
fn runs_go_on_where_exponentials_overflow() {
    let grid = |scheme: &str, more: &str| {
        format!("[grid]\ngamma_f = 30.0\n{more}\n[scheme]\n{scheme}\n[solver]\nsystem = \"physical-limit\"\n")
    };
    let windows = "n_gamma = 16\nwindows = 200";
    let settings = [
        ACCURACY.to_owned(),
        grid("sbp = \"SBP42\"", "n_gamma = 2001"),
        grid("sbp = \"GLL16\"\nform = \"weak\"", windows),
        grid("sbp = \"GLL16\"", windows),
        grid("sbp = \"SBP42\"", "n_gamma = 601").replace("physical-limit", "doubled"),
    ];
    for rest in &settings {
        let expected = end::<f64>(HILL[0], rest);
        HILL[1..].iter().for_each(|formula| agree(formula, end::<f64>(formula, rest), expected, rest));
    }
    let digits = grid("sbp = \"GLL16\"\nform = \"weak\"", windows) + "digits = 40\n";
    agree(HILL[1], end::<Extended>(HILL[1], &digits), end::<Extended>(HILL[0], &digits), &digits);
}

/// The reference of a convergence study.
#[test]
fn convergence_is_measured_beyond_an_overflow() {
    let of = |formula: &str| {
        let rest = "[grid]\ngamma_f = 30.0\nn_gamma = 32\n[scheme]\nsbp = \"SBP42\"\n";
        let schemes = [(SbpName::Sbp42, Form::Strong)];
        let swept: Convergence = sweep(&case(formula, rest), &schemes, &[400, 800], &AtomicBool::new(false), &|_| {})
            .unwrap_or_else(|none| panic!("{formula}: {none}"));
        swept.reference.end
    };
    let [smooth, overflows] = [HILL[0], HILL[1]].map(of);
    agree(HILL[1], [overflows[0], overflows[1]], [smooth[0], smooth[1]], "converge");
}
