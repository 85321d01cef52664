//! Intervals hold every value, computed in 40 digits or in `f64`.

use std::iter;

use proptest::prelude::*;

use super::{BOXES, Enclosed, Enclosure};
use crate::formula::{Function, Graph, Kind, Names, NodeId, Program, Steep, Watched, plain};
use crate::number::{Extended, Real};

/// The interval of the only output on a box; all eight boxes agree.
fn enclose(program: &Program<f64>, intervals: &[[f64; 2]]) -> [f64; 2] {
    let program = plain(program, 1);
    let mut enclosed = Enclosed::new(program.clone());
    for (variable, &interval) in intervals.iter().enumerate() {
        (0..BOXES).for_each(|k| enclosed.set(variable, k, interval));
    }
    enclosed.run(program.steps_to(1));
    let found = enclosed.interval(program.output(0), 0);
    assert!((1..BOXES).all(|k| enclosed.interval(program.output(0), k) == found), "{found:?}");
    assert!(found[0] < f64::INFINITY && found[1] > -f64::INFINITY && found[0] <= found[1], "{found:?}");
    found
}

fn program<S: Real>(make: impl Fn(&mut Graph<S>) -> NodeId, variables: usize) -> Program<S> {
    let mut graph = Graph::default();
    let node = make(&mut graph);
    Program::new(&mut graph, variables, &[node])
}

fn call<S: Real>(function: Function) -> Program<S> {
    let make = |graph: &mut Graph<S>| {
        let x = graph.variable(0);
        graph.call(function, x)
    };
    program(make, 1)
}

/// Returns true if the interval holds the value in `f64` and the exact one. What is not defined or overflows is not a
/// value; where `f64` has none, functions of extended precision may return anything.
fn holds([lo, hi]: [f64; 2], value: f64, exact: Extended) -> bool {
    let inside = value.is_infinite() || lo <= value && value <= hi;
    value.is_nan() || inside && (!exact.is_finite() || Extended::from(lo) <= exact && exact <= Extended::from(hi))
}

/// Numbers of all sizes up to 10^`most`, also 0 and what is next to it.
fn number(most: f64) -> impl Strategy<Value = f64> {
    let special = prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, 5e-324, -5e-324, f64::MIN_POSITIVE, 0.5, 1e-300]);
    let any =
        (-20.0..most, any::<bool>()).prop_map(|(size, sign)| if sign { 10_f64.powf(size) } else { -10_f64.powf(size) });
    prop_oneof![1 => special, 4 => any, 3 => -3.0..3.0]
}

/// An interval, and points in it.
fn interval(most: f64) -> impl Strategy<Value = ([f64; 2], Vec<f64>)> {
    let width = prop_oneof![Just(0.0), (-18.0..1.5).prop_map(|size: f64| 10_f64.powf(size))];
    (number(most), width, prop::collection::vec(0.0..=1.0, 4)).prop_map(|(lo, width, places): (f64, f64, Vec<f64>)| {
        let hi = lo + width * if lo.abs() > 1e3 { lo.abs() } else { 1.0 };
        let points = places.iter().map(|place| (lo + place * (hi - lo)).clamp(lo, hi));
        ([lo, hi], points.chain([lo, hi]).collect())
    })
}

/// Expressions in x and y. They have no constants but exact exponents: a graph rounds what follows from constants
/// alone.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(vec!["x", "y"]).prop_map(String::from);
    leaf.prop_recursive(5, 30, 2, |inner| {
        let names = ["sin", "cos", "tan", "exp", "ln", "sqrt", "tanh", "abs", "atan", "cosh", "sinh"];
        prop_oneof![
            (inner.clone(), prop::sample::select(vec!["+", "-", "*", "/"]), inner.clone())
                .prop_map(|(one, operation, other)| format!("({one} {operation} {other})")),
            (inner.clone(), prop::sample::select(vec!["2", "3", "-2", "0.5", "1.75"]))
                .prop_map(|(base, power)| format!("({base})^({power})")),
            (prop::sample::select(names.to_vec()), inner).prop_map(|(name, one)| format!("{name}({one})")),
        ]
    })
}

fn parsed<S: Real>(text: &str) -> Program<S> {
    program(|graph| crate::formula::parse(text, &["x", "y"], &Names::new(), graph).unwrap(), 2)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn functions_hold_their_values(
        (_, function) in prop::sample::select(Function::NAMED),
        (ends, points) in interval(9.0),
    ) {
        let found = enclose(&call(function), &[ends]);
        for x in points {
            let exact: Extended = function.apply(Extended::from(x));
            prop_assert!(holds(found, function.apply(x), exact), "{function:?} {ends:?} at {x:e}: {found:?} {exact}");
        }
    }

    #[test]
    fn expressions_hold_their_values(
        text in expression(),
        (x_ends, x) in interval(3.0),
        (y_ends, y) in interval(3.0),
    ) {
        let (plain, exact) = (parsed::<f64>(&text), parsed::<Extended>(&text));
        let found = enclose(&plain, &[x_ends, y_ends]);
        for (x, y) in x.into_iter().zip(y) {
            let [value]: [f64; 1] = plain.values(&[x, y]);
            let [exact]: [Extended; 1] = exact.values(&[Extended::from(x), Extended::from(y)]);
            // Overflow in between makes something else of it.
            let value = if exact.is_finite() && value.is_finite() { value } else { f64::NAN };
            prop_assert!(holds(found, value, exact), "{text} at {x:e}, {y:e}: {found:?}, {value:e}, {exact}");
        }
    }
}

#[test]
fn edges() {
    let of = |function, lo, hi| enclose(&call(function), &[[lo, hi]]);
    assert_eq!(of(Function::Sin, 1e300, 2e300), [-1.0, 1.0]);
    assert_eq!(of(Function::Sin, -f64::INFINITY, f64::INFINITY), [-1.0, 1.0]);
    assert_eq!(of(Function::Tanh, -f64::INFINITY, f64::INFINITY), [-1.0, 1.0]);
    assert_eq!(of(Function::Exp, -f64::INFINITY, f64::INFINITY), [0.0, f64::INFINITY]);
    assert_eq!(of(Function::Sign, -1e-300, 1e-300), [-1.0, 1.0]);
    assert_eq!(of(Function::Abs, -2.0, 1.0), [0.0, 2.0]);
    assert_eq!(of(Function::Tan, 1.0, 2.0), [-f64::INFINITY, f64::INFINITY]);
    assert_eq!(of(Function::Ln, -2.0, -1.0), [-f64::INFINITY, f64::INFINITY]);
    let [lo, hi] = of(Function::Ln, -1.0, 1.0);
    assert!(lo == -f64::INFINITY && (0.0..1e-300).contains(&hi));
    let [lo, hi] = of(Function::Exp, 700.0, 800.0);
    assert!(lo > 1e304 && hi == f64::INFINITY);
    let [lo, hi] = of(Function::Exp, -1e9, -1e8);
    assert!(lo == 0.0 && hi < 1e-300);
    assert_eq!(enclose(&parsed("1/x"), &[[-1.0, 1.0], [0.0; 2]]), [-f64::INFINITY, f64::INFINITY]);
    // A wall far away: overflow is no obstacle.
    let [lo, hi] = enclose(&parsed("1/cosh(x)^2"), &[[1e6, 2e6], [0.0; 2]]);
    assert!(lo.abs() < 1e-300 && hi < 1e-300);
}

/// The findings on a way of three nodes, where x and y move as given.
fn hidden(text: &str, x: [f64; 3], y: [f64; 3]) -> Vec<usize> {
    let mut enclosure = Enclosure::new(&parsed(text), 1, |_| true, iter::empty()).unwrap();
    enclosure.path.begin(&[0.0, 1.0, 2.0]);
    enclosure.path.push(0, &x, |_| 0.0);
    enclosure.path.push(1, &y, |_| 0.0);
    enclosure.hidden(|| vec![1e-9], 0.0).into_iter().map(|found| found.pair).collect()
}

#[test]
fn what_is_zero_on_all_of_the_way_has_no_side_to_change() {
    assert!(hidden("sign(0.1*x + y/3)", [0.0; 3], [0.0; 3]).is_empty());
    assert_eq!(hidden("sign(0.1*x + y/3)", [0.0; 3], [0.0, 0.0, 1e-300]), [1]);
    assert_eq!(hidden("sign(0.1*x + 1e-320)", [-1e-310, 0.0, 0.0], [0.0; 3]), [0]);
}

#[test]
fn pieces_know_that_variables_change_together() {
    // On the box of each pair the divisor may be 0; on the way it is 1.
    assert!(hidden("1/(x-y)", [1.0, 3.0, 6.0], [0.0, 2.0, 5.0]).is_empty());
    assert_eq!(hidden("1/(x-y)", [1.0, 3.0, 6.0], [0.0, 2.0, 7.0]), [1]);
    // The exponent is smallest on the way from the second node to the third, or falls all the way.
    assert_eq!(hidden("exp(-(x*y))", [1.0, 2.0, 0.0], [1.0, 1.0, 6.0]), [1]);
    assert!(hidden("exp(-(x*y))", [1.0, 2.0, 4.0], [1.0, 2.0, 2.0]).is_empty());
    assert_eq!(hidden("tanh(x*y)", [-1.0, 2.0, 4.0], [1.0, 2.0, 2.0]), [0, 1]);
}

#[test]
fn what_changes_little_is_gentle() {
    let is_gentle = |kind, interval| Watched::new(0, kind, 1.0).is_gentle(interval);
    let unknown = [-f64::INFINITY, f64::INFINITY];
    let sides = [Function::Abs, Function::Sign, Function::Step].map(Kind::Side);
    let others = [Kind::Ratio, Kind::Base, Kind::Exponent, Kind::Step, Kind::Angle, Kind::Edge];
    for kind in others.into_iter().chain(sides) {
        assert!(!is_gentle(kind, unknown), "{kind:?}");
    }
    assert!(is_gentle(Kind::Ratio, [1.0, 1.5]) && is_gentle(Kind::Ratio, [-1.5, -1.0]));
    assert!(!is_gentle(Kind::Ratio, [-1.0, 1.0]) && !is_gentle(Kind::Ratio, [0.0, 1.0]));
    assert!(is_gentle(Kind::Step, [7.0, 7.5]) && !is_gentle(Kind::Step, [0.0, 5.0]));
    for side in sides {
        assert!(is_gentle(side, [1e-300, 1.0]) && !is_gentle(side, [-1e-300, 1.0]));
    }
    // A step is 1 at 0, and the sign is 0 there.
    assert_eq!(sides.map(|side| is_gentle(side, [0.0, 1.0])), [true, false, true]);
    assert_eq!(sides.map(|side| is_gentle(side, [-1.0, 0.0])), [true, false, false]);
    assert!(is_gentle(Kind::Edge, [-0.5, 0.5]) && !is_gentle(Kind::Edge, [0.5, 1.0]));
}

/// A power multiplies the logarithm of what its base may change by, and the exponent of what it is a power of.
#[test]
fn powers_of_what_changes_are_steeper() {
    for power in [2.0, 40.0, 1300.0] {
        let of = |kind| Watched::new(0, kind, power);
        let gentle = 1.0 + 2.0 / power;
        assert!(of(Kind::Ratio).is_gentle([1.0, gentle]) && of(Kind::Exponent).is_gentle([0.0, 2.0 / power]));
        let steep = 1.0 + 3.0_f64.exp() / power;
        assert!(!of(Kind::Ratio).is_gentle([1.0, steep]) && !of(Kind::Exponent).is_gentle([0.0, 2.1 / power]));
        // A power is small where its base is, and larger than on the nodes where its base is.
        assert!(of(Kind::Base).is_gentle_between([-0.5, 1.0], [-0.5, 1.0]));
        assert!(!of(Kind::Base).is_gentle_between([-0.5, steep], [-0.5, 1.0]));
    }
}

/// Products of products hide no power: what x is to the 40th power in is as steep as x^40, however it is written.
#[test]
fn chains_of_products_are_powers() {
    let watched = |text: &str| {
        let steep = Steep::new(&parsed(text), 1, |variable| variable == 0);
        steep.map_or_else(Vec::new, |steep| steep.watched)
    };
    let is_watched = |text: &str, kind: Kind, power: f64| {
        watched(text).iter().any(|look| *look == Watched::new(look.register, kind, power))
    };
    assert!(is_watched("cos(x)^40", Kind::Base, 40.0) && is_watched("(cos(x)^8*cos(x)^2)^4", Kind::Base, 40.0));
    assert!(is_watched("1/(1 + x^2)^40", Kind::Ratio, 40.0) && is_watched("1/sqrt(1 + x^2)^80", Kind::Ratio, 40.0));
    assert!(is_watched("exp(-x^2)^40", Kind::Exponent, 40.0) && is_watched("1/exp(x^2)^40", Kind::Exponent, 40.0));
    assert!(is_watched("((cos(x)^2 + 1)^5 + 1)^4", Kind::Base, 40.0));
    assert!(is_watched("1/x", Kind::Ratio, 1.0) && is_watched("exp(x)", Kind::Exponent, 1.0));
    assert!(watched("x^4").is_empty() && watched("(x^2 - 1)^2").is_empty());
}

/// Two changes of sign between the same two nodes are not seen, nor is one there and back; one is, also of one argument
/// that is a multiple of another one.
#[test]
fn one_change_of_sign_is_seen_between_two_nodes() {
    let x = [0.0, 1.0, 2.0];
    assert!(hidden("step(x - 1.5)*step(x - 0.4)", x, x).is_empty());
    assert_eq!(hidden("step(x - 1.4)*step(1.6 - x)", x, x), [1]);
    assert_eq!(hidden("abs(x - 0.4) - 2*abs(x - 0.5) + abs(x - 0.6)", x, x), [0]);
    assert!(hidden("step(x - 1.4) - 3*step(1.4 - x)", x, x).is_empty());
    // The kink of one argument may make another one change its sign there and back.
    for text in ["step(0.1 - abs(x - 0.5))", "max(0, 1 - abs(x - 0.5)/0.1)", "sign(abs(x - 0.5) - 0.1)"] {
        assert_eq!(hidden(text, x, x), [0], "{text}");
    }
    // The second argument is largest between the nodes.
    assert!(hidden("step(y)", x, [-1.0, -2.0, -3.0]).is_empty());
    assert_eq!(hidden("step(0.24 - (y - 0.5)^2)", x, x), [0]);
}
