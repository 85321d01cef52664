//! Runs that end at a time, where a formula changes its sign, or outside the domain.

use geodesic_ivp::Status;
use geodesic_ivp::action::Form;
use geodesic_ivp::case::Case;
use geodesic_ivp::geometry::{Direction, GeometryText, Observable, Place, Preset};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{Limit, Setup, System, Until, WorldLine, solve};

use crate::common;

fn plunge<S: Arithmetic>(length: f64, until: Option<&str>) -> Setup<S> {
    let text = GeometryText::Metric(Preset::from_name("schwarzschild-ef").unwrap().text());
    // At rest at r = 10: K = 0.8 v_dot² = 1.
    let v_dot = "1.1180339887498948482045868343656381177203091798057628621354486227";
    let operator = (SbpName::Gll(24), Form::Weak, 24);
    let start: (&[&str], &[&str]) = (&["0", "10", "0"], &[v_dot, "0", "0"]);
    let setup = common::setup(&text, start, length, operator, System::PhysicalLimit);
    let until = until.map(|formula| Until {
        formula: Observable::new(formula, &text, Place::Potential).unwrap(),
        rough: Observable::new(formula, &text, Place::Potential).unwrap(),
        direction: Direction::Both,
        change: None,
    });
    Setup { until: until.into_iter().collect(), ..common::in_windows(setup, 40) }
}

/// Proper time from rest at R = 10 to r, by the cycloid.
fn proper_time(r: f64) -> f64 {
    let eta = (2.0 * r / 10.0 - 1.0).acos();
    (1000.0_f64 / 8.0).sqrt() * (eta + eta.sin())
}

#[test]
fn a_fall_goes_through_the_horizon_and_ends_where_a_formula_changes_its_sign() {
    let line = solve(plunge::<f64>(36.0, Some("r - 2"))).unwrap();
    assert!((line.length - 33.700869851892335).abs() < 1e-11, "{}", line.length);
    assert!((line.end().q[1] - 2.0).abs() < 1e-13, "{}", line.end().q[1]);
    let line = solve(plunge::<f64>(36.0, Some("1 - r"))).unwrap();
    assert!((line.length - proper_time(1.0)).abs() < 1e-10, "{}", line.length);
    // Where the formula keeps its sign the run has its whole length.
    let line = solve(plunge::<f64>(30.0, Some("r - 1"))).unwrap();
    assert_eq!(line.length, 30.0);
}

#[test]
fn a_crossing_is_found_to_all_digits() {
    let line = solve(plunge::<Extended>(36.0, Some("r - 2"))).unwrap();
    assert!((line.end().q[1] - Extended::from(2.0)).abs().to_f64() < 1e-36);
}

#[test]
fn a_run_ends_at_a_time_to_the_last_bit() {
    let text = GeometryText::Metric(Preset::from_name("schwarzschild").unwrap().text());
    let start: (&[&str], &[&str]) = (&["0", "10", "0"], &["1.2", "-0.05", "0.03"]);
    let setup = common::setup::<f64>(&text, start, 0.0, (SbpName::Gll(20), Form::Weak, 20), System::PhysicalLimit);
    for value in [5.0, 20.0, 53.98674477227013] {
        let limit = Limit::Value { coordinate: 0, value };
        let line: WorldLine = solve(&Setup { limit, ..common::in_windows(setup.clone(), 8) }).unwrap();
        assert!((line.end().q[0] - value).abs() <= 2.0 * f64::EPSILON * value, "{} is not {value}", line.end().q[0]);
    }
}

#[test]
fn a_run_that_leaves_the_domain_says_where() {
    let text = GeometryText::Metric(Preset::from_name("schwarzschild").unwrap().text());
    let start: (&[&str], &[&str]) = (&["0", "10", "0"], &["1.2", "-0.05", "0.0"]);
    let setup =
        |sbp, n_gamma| common::setup::<f64>(&text, start, 60.0, (sbp, Form::Strong, n_gamma), System::PhysicalLimit);
    let failure = solve(setup(SbpName::Sbp42, 401)).map(|line| line.length).unwrap_err();
    assert_eq!(failure.status, Status::OutsideDomain, "{failure}");
    assert!(failure.gamma > 20.0 && failure.gamma < 60.0, "{failure}");
    // An explicit rule with a coarse step leaps over the horizon to r < 0, where the metric is regular again.
    for n_gamma in [101, 401, 1601] {
        let failure = solve(setup(SbpName::Sbp21, n_gamma)).map(|line| line.length).unwrap_err();
        assert_eq!(failure.status, Status::OutsideDomain, "{n_gamma}: {failure}");
        assert!(failure.gamma > 20.0 && failure.gamma < 60.0, "{n_gamma}: {failure}");
    }
}

#[test]
fn a_time_before_zero_is_reached() {
    let text = r#"
        potential = { coordinates = ["x"], formula = "x^2/2" }
        particle.c = 2.0
        initial = { t = -5.0, t_dot = 3.0, x = 1.0, x_dot = 0.4 }
        grid = { t_f = -2.0, n_gamma = 201 }
        scheme.sbp = "SBP42"
    "#;
    let case = Case::parse("test", text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let line: WorldLine = solve(case.setup()).unwrap_or_else(|failure| panic!("{failure}"));
    assert!((line.end().q[0] + 2.0).abs() < 1e-13 && line.length > 0.5, "{}", line.end().q[0]);
}

/// With g_tt = 1 + x² and x that flies away, t comes to an end before it is 1002: no γ is long enough.
#[test]
fn a_time_that_is_never_reached_ends_a_run_far_out() {
    let text = r#"
        metric = { coordinates = ["t", "x"], components = { "t t" = "1 + x^2", "x x" = "-1" } }
        initial = { t = 1000.0, t_dot = 100.0, x = 0.0, x_dot = 200.0 }
        grid = { gamma_i = 7.0, t_f = 1002.0 }
        solver.accuracy = 1e-4
    "#;
    let case = Case::parse("test", text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let failure = solve::<f64>(case.setup()).unwrap_err();
    assert_eq!(failure.status, Status::EndTimeNotReached, "{failure}");
    assert!(failure.gamma > 7.0 + 100.0 && failure.point[0].1 > 1e4, "{failure}");
}
