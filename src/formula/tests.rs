//! Derivatives, reduced and fused programs, schedules, and values on the way to which something overflows.

use proptest::prelude::*;

use super::algebra::run_at;
use super::{Graph, Level, Names, NodeId, Program, parse};
use crate::number::{Extended, Real};

fn nodes<S: Real>(graph: &mut Graph<S>, variables: &[&str], formulas: &[impl AsRef<str>]) -> Vec<NodeId> {
    formulas.iter().map(|formula| parse(formula.as_ref(), variables, &Names::new(), graph).unwrap()).collect()
}

/// All outputs at one point, as they come.
fn values<S: Real>(program: &Program<S>, variables: [f64; 4]) -> Vec<S> {
    let mut registers = program.registers(|constant| [constant]);
    variables.iter().enumerate().for_each(|(place, &value)| registers[place] = [S::from(value)]);
    run_at(program.steps_to(program.outputs.len()), &mut registers);
    (0..program.outputs.len()).map(|output| registers[program.output(output)][0]).collect()
}

fn is_same(one: f64, other: f64) -> bool {
    one.to_bits() == other.to_bits() || one.is_nan() && other.is_nan()
}

#[test]
fn powers_beside_each_other_are_no_powers_of_powers() {
    let mut graph = Graph::<f64>::default();
    let sum = nodes(&mut graph, &["x"], &[["x^2"; 600].join("+")]);
    assert_eq!(values(&Program::new(&mut graph, 1, &sum), [3.0, 0.0, 0.0, 0.0]), [5400.0]);
}

#[test]
fn derivatives_by_the_last_of_many_variables() {
    let mut graph = Graph::<f64>::default();
    let variables: Vec<_> = (0..80).map(|variable| graph.variable(variable)).collect();
    let sum = variables.iter().copied().reduce(|sum, variable| graph.add(sum, variable)).unwrap();
    let all = graph.written("s + x^2*y", &[("s", sum), ("x", variables[70]), ("y", variables[3])]);
    for (variable, others) in [(2, vec![]), (69, vec![]), (79, vec![]), (70, vec![70, 3]), (3, vec![70, 3])] {
        let derivative = graph.derivative(all, variable);
        let contains = graph.variables_of(derivative, 80);
        assert!((0..80).filter(|&v| contains[v]).all(|v| others.contains(&v)), "{variable}");
        assert_eq!(others.is_empty(), graph.is(derivative, 1.0), "{variable}");
    }
}

#[test]
fn what_is_equal_is_computed_once() {
    // x^4 is the square of x^2, of which the derivative in x needs the product with x.
    for (expression, outputs, steps) in
        [("x^4 + x^2", 1, 3), ("x*y + y*x", 1, 2), ("x/8 + x*0.125", 1, 2), ("0*exp(x) + y", 2, 0)]
    {
        let mut graph = Graph::<f64>::default();
        let f = nodes(&mut graph, &["x", "y"], &[expression])[0];
        let derivative = graph.derivative(f, 0);
        assert_eq!(graph.derivative(f, 0), derivative, "memoised");
        let program = Program::new(&mut graph, 2, &[f, derivative]);
        assert_eq!(program.steps_to(outputs).len(), steps, "{expression}");
    }
}

#[test]
fn functions_of_two_arguments_are_what_they_are_called() {
    let values = |formula: &str, at: [f64; 2]| -> [f64; 3] {
        let mut graph = Graph::default();
        let value = nodes(&mut graph, &["x", "y"], &[formula])[0];
        let [by_x, by_y] = [0, 1].map(|variable| graph.derivative(value, variable));
        Program::new(&mut graph, 2, &[value, by_x, by_y]).values(&at)
    };
    for (x, y) in [(0.3, -1.2), (-0.7, -1e-9), (-0.7, 1e-9), (2.0, 2.0), (-3.0, 0.0), (1e200, 1.0), (0.0, -2.0)] {
        let square: f64 = x * x + y * y;
        let less = f64::from(x < y);
        for (formula, expected) in [
            ("min(x, y)", [x.min(y), less, 1.0 - less]),
            ("max(y, x)", [x.max(y), 1.0 - f64::from(x <= y), f64::from(x <= y)]),
            ("hypot(x, y)", [x.hypot(y), x / x.hypot(y), y / x.hypot(y)]),
            ("atan2(y, x)", [y.atan2(x), -y / square, x / square]),
            ("sign(x)*step(y)", [if y >= 0.0 && x != 0.0 { x.signum() } else { 0.0 }, 0.0, 0.0]),
        ] {
            for (found, expected) in values(formula, [x, y]).into_iter().zip(expected) {
                let is_near = (found - expected).abs() <= 4e-15 * expected.abs().max(1e-300);
                assert!(is_near || square.is_infinite(), "{formula} at {x}, {y}: {found} is not {expected}");
            }
        }
    }
    assert!(values("min(x, 2)", [f64::NAN, 0.0])[0].is_nan() && values("step(x)", [-0.0, 0.0])[0] == 1.0);
    let mistake = |formula| parse(formula, &["x"], &Names::<f64>::new(), &mut Graph::default()).unwrap_err().message;
    assert_eq!(mistake("min(x)"), "the function 'min' has two arguments: expected a comma, found ')'");
    assert_eq!(mistake("atan2"), "the function 'atan2' needs its two arguments in parentheses");
    assert!(mistake("sin(x, x)").starts_with("expected an operator or the ')'"), "{}", mistake("sin(x, x)"));
}

/// f, f′ and f″ at x, at a point alone and among others.
fn derivatives<S: Real>(formula: &str, x: f64) -> [S; 3] {
    let mut graph = Graph::default();
    let f = nodes(&mut graph, &["x"], &[formula])[0];
    let first = graph.derivative(f, 0);
    let second = graph.derivative(first, 0);
    let program = Program::new(&mut graph, 1, &[f, first, second]);
    let [alone, fused] = [&program, &program.fused()].map(|program| program.values(&[S::from(x)]));
    let points = vec![S::from(x); 100];
    let mut rows = [(); 3].map(|()| vec![S::ZERO; 100]);
    program.sample(&[&points], &mut rows.each_mut().map(Vec::as_mut_slice));
    for ((row, value), fused) in rows.iter().zip(&alone).zip(fused) {
        let is_near = (fused - *value).abs() <= S::from(1e-9) * (S::ONE + value.abs());
        assert!(is_near || !fused.is_finite(), "{formula} at {x:?}: {fused:?}, {value:?}");
        let is_close = |a: S| a == *value || a.is_nan() && value.is_nan();
        assert!(row.iter().all(|&a| is_close(a)), "{formula} at {x:?}: {row:?}, {value:?}");
    }
    alone
}

fn check<S: Real>(formula: &str, x: f64, expected: [f64; 3]) {
    let found = derivatives::<S>(formula, x).map(S::to_f64);
    let is_close = |(found, expected): (&f64, &f64)| (found - expected).abs() <= 1e-8 * expected.abs().max(1.0);
    assert!(found.iter().zip(&expected).all(is_close), "{formula} at {x}: {found:?}, {expected:?}");
}

#[test]
fn an_overflow_on_the_way_to_finite_values_is_none() {
    type Expected = fn(f64) -> [f64; 3];
    let kinds: [(&str, Expected); 10] = [
        ("1/(1 + exp(x))", |_| [0.0; 3]),
        ("exp(x)/(1 + exp(x))", |_| [1.0, 0.0, 0.0]),
        ("(exp(x) - exp(-x))/(exp(x) + exp(-x))", |_| [1.0, 0.0, 0.0]),
        ("ln(1 + exp(x))", |x| [x, 1.0, 0.0]),
        ("log10(1 + exp(x))", |x| [x / std::f64::consts::LN_10, 1.0 / std::f64::consts::LN_10, 0.0]),
        ("1/cosh(x)^2", |_| [0.0; 3]),
        ("sinh(x)/cosh(x)", |_| [1.0, 0.0, 0.0]),
        ("x*exp(-x^2)", |_| [0.0; 3]),
        ("sqrt(4 + exp(2*x))*exp(-x)", |_| [1.0, 0.0, 0.0]),
        ("(1 + exp(x))^2*exp(-2*x)", |_| [1.0, 0.0, 0.0]),
    ];
    let steeper = [6.0, 6.6, 8.0, 20.0].map(|x| ("exp(-exp(x))", x, [0.0; 3]));
    let far = [360.0, 705.0, 709.5, 712.0, 1e4, 1e6];
    let far = kinds.iter().flat_map(|(formula, expected)| far.map(|x| (*formula, x, expected(x))));
    for (formula, x, expected) in far.chain(steeper) {
        check::<f64>(formula, x, expected);
        check::<Extended>(formula, x, expected);
    }
    for (formula, x) in [("exp(x)", 1e4), ("ln(-x)", 2.0), ("1/(x - 2)", 2.0), ("(1 + exp(exp(x)))/exp(exp(x))", 1e3)] {
        assert!(!derivatives::<f64>(formula, x)[0].is_finite(), "{formula}");
    }
    assert!(derivatives::<f64>("x", f64::NAN)[0].is_nan());
}

/// The variable a does not vary, p varies most often.
const VARIABLES: [&str; 4] = ["a", "q", "u", "p"];

fn level(variable: usize) -> Level {
    [0, 1, 1, 2][variable]
}

/// The programs of formulas, plain and reduced.
fn programs<S: Real>(formulas: &[impl AsRef<str>], has_derivatives: bool) -> [Program<S>; 2] {
    let mut graph = Graph::default();
    let mut roots = nodes(&mut graph, &VARIABLES, formulas);
    for root in roots.clone().into_iter().filter(|_| has_derivatives) {
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
        let call = (prop::sample::select(vec!["sin", "cos"]), inner);
        prop_oneof![
            4 => binary.prop_map(|(one, operation, other)| format!("({one} {operation} {other})")),
            1 => power.prop_map(|(base, exponent)| format!("({base})^({exponent})")),
            // The sine of a large number has no digits.
            1 => call.prop_map(|(name, one)| format!("{name}({one}/(1 + ({one})^2))")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// In 70 digits nothing but rounding differs, so that what cancels leaves many digits.
    #[test]
    fn values_stay(formulas in prop::collection::vec(expression(), 3)) {
        let [plain, reduced] = programs::<Extended>(&formulas, true);
        for variables in [[1.3, 0.4, -0.6, 0.9], [-0.7, 2.5, 0.1, -3.0]] {
            let [plain, reduced] = [&plain, &reduced].map(|program| values(program, variables));
            // A value of zero may be a difference of slopes as large as the values, and have their rounding.
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

    /// Products and sums at once are the same numbers, where both are rounded. Schedule by schedule, on one register
    /// file, outputs are what the whole program gives, to the last bit.
    #[test]
    fn fused_programs_and_schedules_are_the_program(formulas in prop::collection::vec(expression(), 3)) {
        for program in programs::<f64>(&formulas, true) {
            let fused = program.fused();
            prop_assert!(fused.steps_to(fused.outputs.len()).len() <= program.steps_to(program.outputs.len()).len());
            for program in [&program, &fused] {
                let [varies, moves] = [1, 2].map(|least| program.depends_on(|variable| level(variable) >= least));
                let outputs = |count: usize| (0..count).map(|output| program.output(output));
                let all = program.outputs.len();
                let fixed = program.schedule(0..program.size(), |register| varies[register]);
                let varying = program.schedule(outputs(all), |register| !varies[register]);
                let again = program.schedule(outputs(2), |register| !moves[register]);
                let mut registers = program.registers(|constant| [constant]);
                registers[0] = [1.3];
                run_at(&fixed, &mut registers);
                for (q, u, [p, moved]) in [(0.4, -0.6, [0.9, 0.2]), (2.5, 0.1, [-3.0, 1.5])] {
                    let agree = |p: f64, count: usize, registers: &[[f64; 1]]| {
                        let expected = values(&fused, [1.3, q, u, p]);
                        outputs(count).zip(expected).all(|(output, expected)| is_same(registers[output][0], expected))
                    };
                    (registers[1], registers[2], registers[3]) = ([q], [u], [p]);
                    run_at(&varying, &mut registers);
                    prop_assert!(agree(p, all, &registers));
                    registers[3] = [moved];
                    run_at(&again, &mut registers);
                    prop_assert!(agree(moved, 2, &registers));
                }
            }
        }
    }
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
        let [plain, reduced] = programs::<f64>(formulas, false);
        let steps = [&plain, &reduced, &reduced.fused()].map(|program| program.steps_to(program.outputs.len()).len());
        assert_eq!(steps, expected, "{formulas:?}");
    }
    // Factors that vary less are multiplied first.
    for (formula, least, expected) in
        [("a*q*a*u/a^4*3", 1, 2), ("3*p*q/a*p/(u + q)", 2, 2), ("(a + q)*p*(a + u) - p*sin(u)*q", 2, 1)]
    {
        let [_, program] = programs::<f64>(&[formula], false);
        let depends = program.depends_on(|variable| level(variable) >= least);
        let steps = program.schedule([program.output(0)], |register| !depends[register]);
        assert_eq!(steps.len(), expected, "{formula}");
    }
}

#[test]
fn reduced_expressions_stay_exact_and_in_range() {
    let [_, program] = programs::<f64>(&["0.1*(q - u) + a*p - 0.1*p*a"], false);
    assert_eq!(values(&program, [0.0, 1e15 + 0.125, 1e15, 1.0]), [0.0125]);
    // k² of a number k is beyond the range of numbers, or zero, while (k q)² is not.
    for unit in [1e-100, 1e100] {
        let [_, reduced] = programs::<f64>(&[format!("(q/{:e})*(q/{:e})", unit * unit, unit * unit)], true);
        let found = values(&reduced, [1.0, unit, 1.0, 1.0])[0] * unit * unit;
        assert!((found - 1.0).abs() < 1e-14, "{unit:e}: {found}");
    }
}

/// Each node knows which of many variables it has, and derivatives are formed of the terms that contain one.
#[test]
fn a_sum_of_many_variables_has_short_derivatives() {
    let mut graph = Graph::<f64>::default();
    let names: Vec<String> = (0..300).map(|k| format!("x{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let text: Vec<String> = (1..300).map(|k| format!("x{}*x{k}^2", k - 1)).collect();
    let sum = nodes(&mut graph, &names, &[text.join(" + ")])[0];
    assert!((0..300).all(|variable| graph.may_contain(sum, variable)) && !graph.may_contain(sum, 300));
    let slopes: Vec<NodeId> = (0..300).map(|variable| graph.derivative(sum, variable)).collect();
    for (k, &slope) in slopes.iter().enumerate() {
        // It is the slope of x_{k−1} x_k² + x_k x_{k+1}².
        let others = (0..300).filter(|&other| graph.may_contain(slope, other));
        let wanted = (k.saturating_sub(1)..(k + 2).min(300)).filter(|&other| k > 0 || other > 0);
        assert_eq!(others.collect::<Vec<_>>(), wanted.collect::<Vec<_>>(), "{k}");
        let share = |other: usize| graph.may_share(slope, slopes[other]);
        assert!((0..300).all(|other| share(other) == (other.abs_diff(k) <= 2)), "{k}");
    }
}
