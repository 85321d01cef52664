//! `--set` on scenes.

use geodesic_ivp::case::{Case, CaseError};

use super::{KEPLER, KERR, SCHWARZSCHILD};

fn with(text: &str, overrides: &[&str]) -> Result<Case, CaseError> {
    Case::parse("case", text, &overrides.iter().map(|setting| (*setting).to_owned()).collect::<Vec<_>>())
}

#[test]
fn numbers_formulas_and_names() {
    let scene = with(
        SCHWARZSCHILD,
        &["parameters.m=2", "metric.components.\"r r\"=-1/f", "initial.phi=pi/3", "grid.t_f=12", "scheme.sbp=GLL16"],
    )
    .unwrap();
    let start = scene.start::<f64>();
    assert!((start.p[0] - 0.6 * 1.2).abs() < 1e-15 && start.q[2] == std::f64::consts::PI / 3.0);
    assert_eq!((scene.settings.n_gamma, scene.t_f()), (16, Some(12.0)));
    let scene = with(KEPLER, &["grid.gamma_f=3", "solver.digits=30", "potential.formula=-2/sqrt(x^2+y^2)"]).unwrap();
    assert!(scene.settings.is_extended() && scene.t_f::<f64>().is_none());
}

#[test]
fn a_rate_takes_the_place_of_the_other() {
    let scene = with(SCHWARZSCHILD, &["initial.p_r=0.1"]).unwrap();
    assert_eq!(scene.start::<f64>().p[1], 0.1);
    let scene = with(KERR, &["initial.theta_dot=0.02"]).unwrap();
    assert_eq!(scene.start::<f64>().q_dot[2], 0.02);
    let error = with(SCHWARZSCHILD, &["initial.p_r=0.1", "initial.r_dot=1"]).unwrap_err();
    assert!(error.message.contains("both"), "{error}");
}

/// A rate that is to follow from K takes the place of what was given, and the other way round.
#[test]
fn what_follows_from_k_takes_the_place_of_what_is_given() {
    let timelike = "initial.norm=timelike";
    for solve in ["initial.solve={t_dot=\"+\"}", "initial.solve.t_dot=+"] {
        let scene = with(SCHWARZSCHILD, &["initial.r_dot=0", timelike, solve]).unwrap();
        let start = scene.start::<f64>();
        assert!((scene.geometry::<f64>().norm(&start.q, &start.q_dot) - 1.0).abs() < 1e-14);
        let back = with(&scene.to_toml(), &["initial.p_t=0.97"]).unwrap();
        assert_eq!(back.start::<f64>().p[0], 0.97);
    }
}

#[test]
fn a_preset_takes_the_place_of_components() {
    let scene = with(SCHWARZSCHILD, &["metric.preset=kerr-equatorial", "metric.definitions={}", "parameters.a=0.5"]);
    assert_eq!(scene.unwrap().preset, Some("kerr-equatorial"));
}

#[test]
fn errors_refer_to_the_changed_text() {
    let error = with(SCHWARZSCHILD, &["metric.definitions.f=1-2*M/r"]).unwrap_err();
    let span = error.span.clone().unwrap();
    assert_eq!(&error.text[span], "M");
    assert!(error.source_name.contains("--set"));
}
