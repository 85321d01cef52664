use proptest::prelude::*;

use super::super::{Graph, Names, NodeId, Program, parse};
use crate::number::{Extended, Real};

/// The variable a does not vary, p varies most often.
fn level(variable: usize) -> super::Level {
    [0, 1, 1, 2][variable]
}

fn nodes<S: Real>(graph: &mut Graph<S>, formulas: &[impl AsRef<str>]) -> Vec<NodeId> {
    let variables = ["a", "q", "u", "p"];
    formulas.iter().map(|formula| parse(formula.as_ref(), &variables, &Names::new(), graph).unwrap()).collect()
}

fn values<S: Real>(program: &Program<S>, variables: [f64; 4]) -> Vec<S> {
    let mut registers = program.registers(|constant| constant);
    variables.iter().enumerate().for_each(|(place, &value)| registers[place] = S::from(value));
    program.run_once(program.outputs(), &mut registers);
    (0..program.outputs()).map(|output| registers[program.output(output)]).collect()
}

/// Expressions with their derivatives, all of which a program computes.
fn programs<S: Real>(formulas: &[String]) -> [Program<S>; 2] {
    let mut graph = Graph::default();
    let mut roots = nodes(&mut graph, formulas);
    for root in roots.clone() {
        roots.extend([1, 3].map(|variable| graph.derivative(root, variable)));
    }
    let plain = Program::new(&mut graph, 4, &roots);
    let reduced = graph.reduced(&roots, level);
    [plain, Program::new(&mut graph, 4, &reduced)]
}

fn expression() -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(vec!["a", "q", "u", "p", "0.7", "3", "2*a*q"]).prop_map(String::from);
    leaf.prop_recursive(5, 40, 2, |inner| {
        let operation = prop::sample::select(vec!["+", "-", "*", "/"]);
        let binary = (inner.clone(), operation, inner.clone());
        let power = (inner.clone(), prop::sample::select(vec!["2", "3", "-1", "20", "-2", "1.5"]));
        prop_oneof![
            4 => binary.prop_map(|(one, operation, other)| format!("({one} {operation} {other})")),
            1 => power.prop_map(|(base, exponent)| format!("({base})^({exponent})")),
            // The sine of a large number has no digits.
            1 => inner.prop_map(|one| format!("sin({one}/(1 + ({one})^2))")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// In 70 digits nothing but rounding differs, so that what cancels leaves many digits.
    #[test]
    fn values_stay(formulas in prop::collection::vec(expression(), 3)) {
        let [plain, reduced] = programs::<Extended>(&formulas);
        for variables in [[1.3, 0.4, -0.6, 0.9], [-0.7, 2.5, 0.1, -3.0]] {
            let [plain, reduced] = [values(&plain, variables), values(&reduced, variables)];
            // What is zero may be a difference of slopes as large as the values, and the rounding of these.
            let rounding = plain.iter().map(|v| v.to_f64().abs()).filter(|v| v.is_finite()).fold(0.0, f64::max) * 1e-60;
            for (expected, value) in plain.into_iter().zip(reduced) {
                // 0/0 may have become a number, and numbers beyond all bounds may lie on either side of them.
                if expected.is_finite() && expected.to_f64().abs() < 1e30 {
                    let error = (value - expected).abs().to_f64();
                    let allowed = 1e-25 * expected.to_f64().abs().max(1e-10) + rounding;
                    prop_assert!(error <= allowed, "{expected:?} {value:?}");
                }
            }
        }
    }

    /// Products and sums at once are the same numbers, where both are rounded.
    #[test]
    fn fused_programs_are_the_same(formulas in prop::collection::vec(expression(), 3)) {
        for program in programs::<f64>(&formulas) {
            let fused = program.fused();
            prop_assert!(fused.steps_to(fused.outputs()).len() <= program.steps_to(program.outputs()).len());
            let [one, other] = [&program, &fused].map(|program| values(program, [1.3, 0.4, -0.6, 0.9]));
            for (one, other) in one.iter().zip(&other) {
                prop_assert!(one.to_bits() == other.to_bits() || one.is_nan() && other.is_nan());
            }
        }
    }
}

/// Steps of a plain, a reduced and a fused program.
fn steps(formulas: &[&str]) -> [usize; 3] {
    let mut graph = Graph::<f64>::default();
    let roots = nodes(&mut graph, formulas);
    let plain = Program::new(&mut graph, 4, &roots);
    let reduced = graph.reduced(&roots, level);
    let reduced = Program::new(&mut graph, 4, &reduced);
    [&plain, &reduced, &reduced.fused()].map(|program| program.steps_to(program.outputs()).len())
}

#[test]
fn there_are_fewer_steps() {
    for (formulas, expected) in [
        // One reciprocal and two products.
        (&["q/u", "p/u", "1/u"][..], [3, 3, 3]),
        // q (1 + 2u), where the sum and a product are one step.
        (&["q + 2*q*u"], [3, 3, 2]),
        (&["q*u + p*u + q*p"], [5, 4, 3]),
        // Like terms, and what is one number times another one.
        (&["3*u^2/3 - u^2 + q"], [5, 0, 0]),
        (&["-(q - u)*p", "(q - u)*a"], [4, 4, 4]),
        (&["q^2*u", "q^2*p", "u*p*q"], [5, 5, 5]),
    ] {
        assert_eq!(steps(formulas), expected, "{formulas:?}");
    }
}

#[test]
fn differences_of_nearly_equal_numbers_stay_exact() {
    let mut graph = Graph::<f64>::default();
    let roots = nodes(&mut graph, &["0.1*(q - u) + a*p - 0.1*p*a"]);
    let reduced = graph.reduced(&roots, level);
    let program = Program::new(&mut graph, 4, &reduced);
    assert_eq!(values(&program, [0.0, 1e15 + 0.125, 1e15, 1.0]), [0.0125]);
}

/// Counts the steps that need a variable of at least this level.
fn steps_from(formula: &str, least: super::Level) -> usize {
    let mut graph = Graph::<f64>::default();
    let roots = nodes(&mut graph, &[formula]);
    let reduced = graph.reduced(&roots, level);
    let program = Program::new(&mut graph, 4, &reduced);
    let depends = program.depends_on(|variable| level(variable) >= least);
    program.schedule([program.output(0)], |register| !depends[register]).len()
}

#[test]
fn what_varies_less_is_multiplied_first() {
    assert_eq!(steps_from("a*q*a*u/a^4*3", 1), 2);
    assert_eq!(steps_from("3*p*q/a*p/(u + q)", 2), 2);
    assert_eq!(steps_from("(a + q)*p*(a + u) - p*sin(u)*q", 2), 1);
}

/// k² of a number k is beyond the range of numbers, or zero, while (k q)² is not.
#[test]
fn units_far_from_one_stay_in_range() {
    for unit in [1e-100, 1e100] {
        let [_, reduced] = programs::<f64>(&[format!("(q/{:e})*(q/{:e})", unit * unit, unit * unit)]);
        let found = values(&reduced, [1.0, unit, 1.0, 1.0])[0] * unit * unit;
        assert!((found - 1.0).abs() < 1e-14, "{unit:e}: {found}");
    }
}
