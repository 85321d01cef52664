//! Formulas: the grammar, and V, V′, V″ against dual numbers. What is refused is in `tests/cmd/malformed-formulas.md`.

use num_dual::{Dual2_64, DualNum, second_derivative};
use proptest::prelude::*;

use crate::common::Formula;

fn formula(expression: &str) -> Formula {
    Formula::new(expression, &[("a", 0.7), ("b_2", -1.3)]).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn precedence_and_numbers() {
    for (expression, x, expected) in [
        ("-x^2", 3.0, -9.0),
        ("2^3^2", 0.0, 512.0),
        ("2^-x", 3.0, 0.125),
        ("-x^-2", 2.0, -0.25),
        ("--x", 5.0, 5.0),
        ("+x - -x", 5.0, 10.0),
        ("1e-3 + 2.5E+1*x", 2.0, 50.001),
        (".5*x", 4.0, 2.0),
        ("8/4/2", 0.0, 1.0),
        ("8 - 4 - 2", 0.0, 2.0),
        ("2*x^2*3", 2.0, 24.0),
        ("x*-2", 3.0, -6.0),
        (" ( x + 1 ) * ( x - 1 ) ", 3.0, 8.0),
        ("pi", 0.0, std::f64::consts::PI),
        ("a + b_2", 0.0, 0.7 - 1.3),
        ("log10(1000)", 0.0, 3.0),
        ("abs(x)", -2.0, 2.0),
        ("(-8)^(1/3)", 0.0, f64::NAN),
    ] {
        let value = formula(expression).at(x)[0];
        let close = (value - expected).abs() < 1e-12 || (value.is_nan() && expected.is_nan());
        assert!(close, "{expression} at {x}: {value}, expected {expected}");
    }
}

/// The same expression for dual numbers.
type Oracle = fn(Dual2_64) -> Dual2_64;

const EXPRESSIONS: [(&str, Oracle); 16] = [
    ("x^4/2", |x| x.powi(4) / 2.0),
    ("a*(1 - exp(-b_2*x))^2", |x| (-((x * 1.3).exp()) + 1.0).powi(2) * 0.7),
    ("sin(x)*cos(2*x)", |x| x.sin() * (x * 2.0).cos()),
    ("tan(x/3)", |x| (x / 3.0).tan()),
    ("sinh(x) - cosh(x/2)*tanh(x)", |x| x.sinh() - (x / 2.0).cosh() * x.tanh()),
    ("asin(x/4) + acos(x/5)*atan(x)", |x| (x / 4.0).asin() + (x / 5.0).acos() * x.atan()),
    ("ln(x^2 + 1)/sqrt(x^2 + 2)", |x| (x.powi(2) + 1.0).ln() / (x.powi(2) + 2.0).sqrt()),
    ("log10(3 + x)", |x| (x + 3.0).log10()),
    ("(x^2 + 1)^a", |x| (x.powi(2) + 1.0).powf(0.7)),
    ("2^x", |x| (x * std::f64::consts::LN_2).exp()),
    ("(x^2+1)^sin(x)", |x| (x.sin() * (x.powi(2) + 1.0).ln()).exp()),
    ("1/(1 + x^2)", |x| (x.powi(2) + 1.0).recip()),
    ("(x + 3)^-3", |x| (x + 3.0).powi(-3)),
    ("abs(x + 10)*x", |x| (x + 10.0) * x),
    ("-(x - 1)^2*(x + 2)", |x| -(x - 1.0).powi(2) * (x + 2.0)),
    ("exp(sin(exp(x/2)))", |x| (x / 2.0).exp().sin().exp()),
];

proptest! {
    #[test]
    fn derivatives_agree_with_dual_numbers(x in -2.5..2.5_f64) {
        for (expression, oracle) in EXPRESSIONS {
            let jet = formula(expression).at(x);
            let (value, first, second) = second_derivative(oracle, x);
            for (name, got, want) in [("V", jet[0], value), ("V'", jet[1], first), ("V''", jet[2], second)] {
                let size = 1.0 + want.abs();
                prop_assert!((got - want).abs() <= 1e-11 * size, "{name} of {expression} at {x}: {got}, {want}");
            }
        }
    }

    #[test]
    fn blocks_of_points_agree_with_single_points(x in proptest::collection::vec(-2.5..2.5_f64, 1..200)) {
        for (expression, _) in EXPRESSIONS {
            let formula = formula(expression);
            for (k, jet) in formula.sample(&x).into_iter().enumerate() {
                prop_assert_eq!(jet, formula.at(x[k]));
            }
        }
    }
}
