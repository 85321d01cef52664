//! Scenes that go on where an exponential overflows on the way to finite forces.

use geodesic_ivp::Status;
use geodesic_ivp::case::Case;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::geometry::Geometry;
use geodesic_ivp::methods::{Output, PEERS, Problem, Setting, Step};
use geodesic_ivp::number::Extended;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{WorldLine, solve};
use geodesic_ivp::study::errors::reference_error;

/// Three smooth discs on the unit circle.
fn disks(height: &str, width: &str, start: [&str; 4], length: &str, rest: &str) -> Case {
    let centres = [("- 0.995004", "- 0.099833"), ("+ 0.583960", "- 0.811782"), ("+ 0.411044", "+ 0.911616")];
    let discs = centres.map(|(a, b)| format!("h/(1 + exp((sqrt((x {a})^2 + (y {b})^2) - 0.4)/w))")).join(" + ");
    let [x, y, x_dot, y_dot] = start;
    let text = format!(
        "[potential]\ncoordinates = [\"x\", \"y\"]\nformula = \"{discs}\"\n\
         parameters = {{ h = {height}, w = {width} }}\n[particle]\nlaw = \"newtonian\"\n\
         [initial]\nx = {x}\ny = {y}\nx_dot = {x_dot}\ny_dot = {y_dot}\n[grid]\ngamma_f = {length}\n{rest}"
    );
    Case::parse("disks", &text, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn first(rest: &str) -> Case {
    let start = ["0.0691458", "0.0200234", "0.492534", "0.805463"];
    disks("2.843", "0.0088026", start, "5.90825", rest)
}

const END: [f64; 2] = [2.97915981, 4.77890017];
const ACCURACY: &str = "[solver]\naccuracy = 1e-10\n";

/// x and y are those `expected`, to their eight digits, and so are the measures of the run numbers.
fn check<S: Arithmetic>(case: &Case, expected: [f64; 2]) {
    let line: WorldLine<S> = solve(case.setup::<S>()).unwrap_or_else(|none| panic!("{none}"));
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
    check::<f64>(&first(ACCURACY), END);
    let start = ["0.0330365", "0.0152144", "-0.472044", "0.775422"];
    check::<f64>(&disks("4.94777", "0.0052314", start, "3.6856", ACCURACY), [-1.00445048, -0.63859572]);
}

#[test]
fn discs_end_where_they_should_on_every_grid() {
    let windows = "n_gamma = 16\nwindows = 40\n[scheme]\nsbp = \"GLL16\"\n";
    let weak = "n_gamma = 16\nwindows = 40\n[scheme]\nsbp = \"GLL16\"\nform = \"weak\"\n";
    let strong = "n_gamma = 401\n[scheme]\nsbp = \"SBP42\"\n";
    for scheme in [windows, weak, strong] {
        check::<f64>(&first(scheme), END);
    }
    check::<f64>(&first(&format!("{strong}[solver]\nsystem = \"doubled\"\n")), END);
    check::<Extended>(&first(&format!("{weak}[solver]\ndigits = 40\n")), END);
}

/// Far outside there is no force, whatever the exponent.
#[test]
fn a_particle_goes_on_for_ever() {
    for (length, end) in [("60.0", [29.6205, 48.4309]), ("2000.0", [983.97, 1610.27])] {
        let case = disks("2.843", "0.0088026", ["0.0691458", "0.0200234", "0.492534", "0.805463"], length, ACCURACY);
        let line: WorldLine<f64> = solve(case.setup::<f64>()).unwrap_or_else(|none| panic!("{none}"));
        let q = line.end().q;
        assert!(q[1..3].iter().zip(end).all(|(q, end)| (q / end - 1.0).abs() < 2e-2), "{q:?}");
    }
}

#[test]
fn other_methods_go_on() {
    let case = first(ACCURACY);
    let geometry: Geometry = case.geometry();
    let start = case.start_in(&geometry);
    let problem = Problem { space: geometry.into(), start, length: 5.90825, g00: None };
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
    let text = "[potential]\ncoordinates = [\"x\", \"y\"]\nformula = \"(1 + exp(exp(x)))/exp(exp(x)) + y^2/2\"\n\
                [particle]\nlaw = \"newtonian\"\n[initial]\nx = 30.0\ny = 0.1\nx_dot = 1.0\ny_dot = 0.0\n\
                [grid]\ngamma_f = 8.0\nn_gamma = 201\n[scheme]\nsbp = \"SBP42\"\n";
    let case = Case::parse("far", text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let none = solve(case.setup::<f64>()).expect_err("it leaves the domain");
    assert_eq!(none.status, Status::OutsideDomain, "{none}");
}
