//! What overflows on the way to finite values is no end of the domain: 1/(1 + exp z) = (1 − tanh(z/2))/2, of which the
//! right side does not overflow.

use geodesic_ivp::Status;
use geodesic_ivp::case::{Case, Form, SbpName};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::geometry::Geometry;
use geodesic_ivp::methods::{Output, PEERS, Problem, Setting, Step};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::convergence::Sweep;
use geodesic_ivp::study::errors::reference_error;

use crate::common::{failure, line_of, parsed};

/// A hill that overflows beyond x = 14.6, as it is written first.
const HILL: [&str; 4] = [
    "0.3*(1 - tanh(25*(abs(x) - 0.4)))/2",
    "0.3/(1 + exp(50*(abs(x) - 0.4)))",
    "0.3*(1 - exp(50*(abs(x) - 0.4))/(1 + exp(50*(abs(x) - 0.4))))",
    "0.15 - 0.15*sinh(25*(abs(x) - 0.4))/cosh(25*(abs(x) - 0.4))",
];

const ACCURACY: &str = "solver.accuracy = 1e-10\n";
const STRONG: &str = "scheme.sbp = 'SBP42'\n";

/// Elements in so many windows.
fn elements(form: &str, windows: usize) -> String {
    format!("scheme = {{ sbp = 'GLL16', form = '{form}' }}\ngrid = {{ n_gamma = 16, windows = {windows} }}\n")
}

fn hill(formula: &str, rest: &str) -> Case {
    let start = "initial = { x = 0.3, t_dot = 1.0, x_dot = 0.4 }";
    parsed(&format!("potential.formula = \"{formula}\"\n{start}\n{rest}"), &["grid.gamma_f=30.0"])
}

/// t and x at the end.
fn end_of<S: Real>(formula: &str, rest: &str) -> [f64; 2] {
    let line: WorldLine<S> = line_of(&hill(formula, rest));
    let [t, x] = [line.t().last(), line.x().last().copied()].map(|last| last.unwrap().to_f64());
    assert!(x > 20.0, "{x}");
    [t, x]
}

fn agree(found: [f64; 2], expected: [f64; 2], what: &str) {
    let is_close = |(found, expected): (&f64, &f64)| (found - expected).abs() < 1e-8 * expected.abs();
    assert!(found.iter().zip(&expected).all(is_close), "{what}: {found:?}, {expected:?}");
}

#[test]
fn runs_go_on_where_exponentials_overflow() {
    let settings = [
        ACCURACY.to_owned(),
        format!("{STRONG}grid.n_gamma = 2001\n"),
        elements("weak", 200),
        elements("strong", 200),
        format!("{STRONG}grid.n_gamma = 601\nsolver.system = 'doubled'\n"),
    ];
    for rest in &settings {
        let expected = end_of::<f64>(HILL[0], rest);
        HILL[1..]
            .iter()
            .for_each(|formula| agree(end_of::<f64>(formula, rest), expected, &format!("{formula} {rest}")));
    }
    let digits = elements("weak", 200) + "solver.digits = 40\n";
    agree(end_of::<Extended>(HILL[1], &digits), end_of::<Extended>(HILL[0], &digits), &digits);
    // The reference of a convergence study.
    let [smooth, overflows] = [HILL[0], HILL[1]].map(|formula| {
        let (case, schemes) =
            (hill(formula, &format!("{STRONG}grid.n_gamma = 32\n")), [(SbpName::Sbp42, Form::Strong)]);
        let sweep = Sweep::<f64>::new(&case, &schemes, &[400, 800]).unwrap_or_else(|none| panic!("{formula}: {none}"));
        let end = sweep.run(&|_, _| ()).reference.end;
        [end[0], end[1]]
    });
    agree(overflows, smooth, "converge");
}

/// Three smooth discs on the unit circle, with their height and width, the start and the length of the run.
fn disks([height, width]: [f64; 2], [x, y, x_dot, y_dot]: [f64; 4], length: f64, rest: &str) -> Case {
    let centres = [("- 0.995004", "- 0.099833"), ("+ 0.583960", "- 0.811782"), ("+ 0.411044", "+ 0.911616")];
    let discs = centres.map(|(a, b)| format!("h/(1 + exp((sqrt((x {a})^2 + (y {b})^2) - 0.4)/w))")).join(" + ");
    let text = format!(
        "potential = {{ coordinates = ['x', 'y'], formula = '{discs}', \
         parameters = {{ h = {height}, w = {width} }} }}\n\
         initial = {{ x = {x}, y = {y}, x_dot = {x_dot}, y_dot = {y_dot} }}\nparticle.law = 'newtonian'\n{rest}"
    );
    parsed(&text, &[&format!("grid.gamma_f={length:?}")])
}

fn first(length: f64, rest: &str) -> Case {
    disks([2.843, 0.0088026], [0.0691458, 0.0200234, 0.492534, 0.805463], length, rest)
}

const LENGTH: f64 = 5.90825;
const END: [f64; 2] = [2.97915981, 4.77890017];

/// x and y are those `expected`, to their eight digits, and so are the measures of the run numbers.
fn check<S: Real>(case: &Case, expected: [f64; 2]) {
    let line: WorldLine<S> = line_of(case);
    let q = line.end().q;
    for (found, expected) in q[1..3].iter().zip(expected) {
        assert!((found.to_f64() - expected).abs() < 1e-8, "{q:?}");
    }
    let diagnostics = Diagnostics::of(&line, &[], &mut [], case.is_lifted());
    assert!(diagnostics.norm.max_ends.to_f64() < 1e-6 && diagnostics.max_delta_g.is_finite());
    assert!(line.gradient_norm.to_f64() < 1e-8);
    assert!(reference_error(&case.setup(), &line, &[]).is_some(), "the reference gets there");
}

#[test]
fn discs_end_where_they_should() {
    let strong = format!("{STRONG}grid.n_gamma = 401\n");
    for scheme in [ACCURACY, &elements("strong", 40), &elements("weak", 40), &strong] {
        check::<f64>(&first(LENGTH, scheme), END);
    }
    check::<f64>(&first(LENGTH, &format!("{strong}solver.system = 'doubled'\n")), END);
    check::<Extended>(&first(LENGTH, &(elements("weak", 40) + "solver.digits = 40\n")), END);
    let other = disks([4.94777, 0.0052314], [0.0330365, 0.0152144, -0.472044, 0.775422], 3.6856, ACCURACY);
    check::<f64>(&other, [-1.00445048, -0.63859572]);
    // Far outside there is no force, whatever the exponent: a particle goes on for ever.
    for (length, end) in [(60.0, [29.6205, 48.4309]), (2000.0, [983.97, 1610.27])] {
        let q = line_of::<f64>(&first(length, ACCURACY)).end().q;
        assert!(q[1..3].iter().zip(end).all(|(q, end)| (q / end - 1.0).abs() < 2e-2), "{q:?}");
    }
}

#[test]
fn other_methods_go_on() {
    let case = first(LENGTH, ACCURACY);
    let geometry: Geometry = case.geometry();
    let start = case.start_in(&geometry);
    let problem = Problem { space: geometry.into(), start, length: LENGTH, g00: None };
    for peer in PEERS {
        let setting = match peer.about().step {
            Step::Constant | Step::Iterated => Setting::steps(1200),
            Step::Adaptive => Setting::tolerance(1e-11),
        };
        let trajectory = peer.run(&problem, &Output::even(1), setting);
        let trajectory = trajectory.unwrap_or_else(|none| panic!("{}: {none}", peer.name()));
        let q = trajectory.states.last().unwrap().q;
        assert!(q[1..3].iter().zip(END).all(|(q, end)| (q - end).abs() < 1e-8), "{}: {q:?}", peer.name());
    }
}

/// What is not finite with any exponent is outside the domain, and no panic.
#[test]
fn what_no_exponent_reaches_is_outside_the_domain() {
    let none = failure(
        "potential = { coordinates = ['x', 'y'], formula = '(1 + exp(exp(x)))/exp(exp(x)) + y^2/2' }\n\
         particle.law = 'newtonian'\ninitial = { x = 30.0, y = 0.1, x_dot = 1.0, y_dot = 0.0 }\n\
         grid = { gamma_f = 8.0, n_gamma = 201 }\nscheme.sbp = 'SBP42'\n",
    );
    assert_eq!(none.status, Status::OutsideDomain, "{none}");
}
