//! `metric.conformal`: what it makes of a start, and what it refuses.

use geodesic_ivp::case::{Case, CaseError};
use geodesic_ivp::geometry::Start;

use super::{KERR, SCHWARZSCHILD, scene};

fn with(text: &str, factor: &str) -> String {
    text.replace("[metric]\n", &format!("[metric]\nconformal = \"{factor}\"\n"))
}

/// Checks what is said of a text that is refused, and of which part of it; returns what to do.
fn refused(text: &str, message: &str, part: &str) -> Option<String> {
    let CaseError { message: found, span, text, help, .. } = Case::parse("case", text, &[]).unwrap_err();
    assert!(found.contains(message), "{found}");
    assert_eq!(&text[span.unwrap()], part, "{found}");
    help
}

#[test]
fn velocities_are_divided_and_momenta_are_not() {
    let (plain, scaled) = (scene(SCHWARZSCHILD), scene(&with(SCHWARZSCHILD, "4/r^2")));
    assert_eq!(scaled.coordinates(), ["t", "r", "phi", "tau"]);
    let (before, after): (Start, Start) = (plain.start(), scaled.start());
    assert_eq!(after.q, [0.0, 10.0, 0.0, 0.0]);
    assert_eq!(before.p, after.p[..3]);
    let tau = 1.058875_f64.sqrt();
    for (found, expected) in after.q_dot.iter().zip(before.q_dot.iter().chain([&tau])) {
        assert!((found - 25.0 * expected).abs() < 1e-14, "{found} {expected}");
    }
    assert!((after.p[3] + tau).abs() < 1e-15);
    let (geometry, q_dot) = (scaled.geometry::<f64>(), &after.q_dot);
    assert!(geometry.norm(&after.q, q_dot).abs() < 1e-13);
    for (found, expected) in geometry.momenta(&after.q, q_dot).iter().zip(&after.p) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }
    // Nothing depends on tau. What the factor depends on is active, and its place has to be given.
    assert_eq!(geometry.active(), [1]);
    let turned = with(SCHWARZSCHILD, "2 + sin(phi)");
    refused(&turned, "missing field `phi`", "[initial]");
    let turned = turned.replace("r = 10.0\n", "r = 10.0\nphi = 0.5\n");
    assert_eq!(scene(&turned).geometry::<f64>().active(), [1, 2]);
}

#[test]
fn the_norm_that_is_given_is_that_without_the_factor() {
    for (norm, tau, sign) in [("\"timelike\"", 1.0, -1.0), ("0.25", 0.5, -1.0), ("-4", 2.0, 1.0)] {
        let text = KERR.replace("norm = \"timelike\"", &format!("norm = {norm}"));
        let start: Start = scene(&with(&text, "1/sigma")).start();
        assert_eq!((start.p[4], start.q_dot[4]), (sign * tau, tau * 64.0), "{norm}");
        assert_eq!(start.p[..4], scene(&text).start::<f64>().p);
    }
    let null = KERR.replace("timelike", "null");
    assert_eq!(scene(&with(&null, "1/sigma")).coordinates(), ["t", "r", "theta", "phi"]);
}

#[test]
fn tau_can_be_used_like_any_coordinate() {
    let text = with(KERR, "1/sigma").replace("until = \"r - 2.1\"", "until = \"tau - 30 + 0*tau_dot\"");
    let text = text.replace("p_theta^2", "0*p_tau + p_theta^2")
        + "[events]\nlater = { when = \"tau - 10\" }\n[plot]\nx = \"tau\"\ny = \"r\"\n\
           [expect]\ntau_final = 30\ntolerance = 1e-10\n";
    let first = scene(&text);
    let (finals, written) = (&first.expect.as_ref().unwrap().finals, first.to_toml());
    assert_eq!(finals[0].0, 4);
    let second = scene(&written);
    assert_eq!(first, second, "{written}");
    assert_eq!(first.start::<f64>(), second.start::<f64>());
    assert!(!written.contains("tau = 0"), "{written}");
    // Neither in the metric, nor in the initial data.
    refused(&with(KERR, "1/(1 + tau)"), "unknown name 'tau'", "t");
    refused(&with(&KERR.replace("r = 8.0", "r = 8.0\ntau = 1"), "1/r"), "unknown field `tau`", "tau");
    // Light has none.
    refused(&text.replace("timelike", "null"), "unknown name 'tau'", "t");
}

#[test]
fn a_name_that_tau_needs_is_refused() {
    let text = with(SCHWARZSCHILD, "1/r");
    let parameter = text.replace("{ m = 1.0 }", "{ m = 1.0, tau = 1.0 }");
    let help = refused(&parameter, "the parameter 'tau' has the name of what conformal adds", "tau");
    assert_eq!(help.as_deref(), Some("choose another name"));
    let definition = text.replace("f = \"1 - 2*m/r\"", "f = \"1 - 2*m/r\", tau_dot = \"r\"");
    refused(&definition, "the definition 'tau_dot' has the name of what conformal adds", "tau_dot");
    let coordinate = text.replace("phi_dot", "tau_dot").replace("\"phi\"", "\"tau\"").replace("phi phi", "tau tau");
    refused(&coordinate, "the coordinate 'tau' has the name of what conformal adds", "\"tau\"");
    // Without a factor, and for light, it is a name like any other.
    scene(&coordinate.replace("conformal = \"1/r\"\n", ""));
    let light = coordinate.replace("t_dot = 1.2\n", "norm = 0\nsolve = { t_dot = \"+\" }\n");
    assert_eq!(scene(&light).coordinates(), ["t", "r", "tau"]);
}

#[test]
fn what_a_factor_cannot_have_is_refused() {
    let force = with(SCHWARZSCHILD, "1/r").replace("[initial]", "force = { r = \"-r_dot\" }\n[initial]");
    let message = "conformal and a force need a null start, K = 0, and these data give K = 1.058";
    assert!(refused(&force, message, "\"1/r\"").is_some_and(|help| help.ends_with("leave out one of the two")));
    scene(&force.replace("t_dot = 1.2\n", "norm = 0\nsolve = { t_dot = \"+\" }\n"));
    refused(&with(SCHWARZSCHILD, "9 - r"), "conformal must be positive at the start, and it is -1", "\"9 - r\"");
    refused(&with(SCHWARZSCHILD, "10 - r"), "the metric is degenerate at the start", "10.0");
    let potential = "potential = { coordinates = [\"x\"], formula = \"x^2\", conformal = \"1 + x^2\" }\n\
                     initial = { x = 1, x_dot = 0.1, t_dot = 1 }\nscheme.sbp = \"GLL8\"\n";
    let help = refused(potential, "conformal needs a null start, K = 0, and these data give K = ", "\"1 + x^2\"");
    assert!(help.is_some_and(|help| help.starts_with("take law = \"newtonian\"")));
    // Numbers that are too large for the arithmetic.
    refused(&with(SCHWARZSCHILD, "1e-320/r"), "a derivative is not finite at the start", "10.0");
    let large = "metric = { coordinates = [\"x\"], components = { \"x x\" = 1e20 }, conformal = 1e-300 }\n\
                 initial = { x_dot = 1 }\nscheme.sbp = \"GLL8\"\n";
    refused(large, "a velocity, a momentum or K is not a finite number at the start", "{ x_dot = 1 }");
}
