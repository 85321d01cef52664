//! What several test files need.

use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::{Case, Solution, solve};

/// The base case of the paper, quartic potential; everything else is an override of it.
pub(crate) const QUARTIC: &str = r#"
[potential]
quartic = { kappa = 0.5 }

[initial]
t = 0.0
x = 1.0
t_dot = 1.0
x_dot = 0.1

[grid]
n_gamma = 32

[scheme]
sbp = "SBP21"
"#;

/// `QUARTIC` with overrides, separated by white space.
pub(crate) fn case(overrides: &str) -> Case {
    let overrides: Vec<String> = overrides.split_whitespace().map(str::to_owned).collect();
    Case::parse("test", QUARTIC, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// The solution of `QUARTIC` with overrides.
pub(crate) fn solved(overrides: &str) -> Solution {
    solved_in(overrides)
}

/// The solution of `QUARTIC` with overrides in another arithmetic.
pub(crate) fn solved_in<S: Arithmetic>(overrides: &str) -> Solution<S> {
    solve(&case(overrides)).unwrap_or_else(|error| panic!("{overrides}: {error}"))
}

/// max |a − b|.
pub(crate) fn distance<S: Arithmetic>(a: &[S], b: &[S]) -> S {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(&a, &b)| (a - b).abs()).fold(S::ZERO, S::max)
}
