//! A conformal factor of a metric: the path, the charges and tau are those of the metric without it.

use geodesic_ivp::case::Case;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;

use crate::common::{line_of, parsed, shipped};

const SCHWARZSCHILD: &str = "metric.preset = \"schwarzschild\"\n\
                             initial = { r = 10.0, phi = 0.0, t_dot = 1.2, r_dot = -0.05, phi_dot = 0.045 }\n";
const SPACELIKE: &str = "metric.preset = \"schwarzschild\"\n\
                         initial = { r = 10.0, phi = 0.0, t_dot = 0.5, phi_dot = 0.1, norm = -1, \
                         solve = { r_dot = \"+\" } }\n";
const KERR: &str = "metric.preset = \"kerr\"\nparameters.a = 0.9\n\
                    initial = { r = 8.0, theta = \"pi/3\", p_t = 0.95, p_phi = -2.5, p_theta = 1.0, norm = 1, \
                    solve = { r_dot = \"+\" } }\n";
const CHARGED: &str = "metric.preset = \"schwarzschild\"\nparameters.e = 0.3\n\
                       metric.one_form = { t = \"e/r\", phi = \"0.01*r^2\" }\n\
                       initial = { r = 10.0, phi = 0.0, t_dot = 1.2, r_dot = -0.05, phi_dot = 0.045 }\n";

fn case(text: &str, more: &str) -> Case {
    parsed(&format!("{text}{more}"), &[])
}

/// The largest difference of coordinates, relative to max(1, |q|).
fn distance<S: Real>(one: &[S], other: &[S]) -> f64 {
    let off = |(&a, &b): (&S, &S)| ((a - b).abs() / S::ONE.max(a.abs())).to_f64();
    one.iter().zip(other).map(off).fold(0.0, f64::max)
}

/// √|K| of the metric without the factor.
fn rate(case: &Case) -> f64 {
    let (geometry, start) = (case.geometry::<f64>(), case.start::<f64>());
    geometry.norm(&start.q, &start.q_dot).abs().sqrt()
}

/// Compares the end of `text` after `length` with that in a metric with the factor, at the same tau.
fn agree(text: &str, factor: &str, length: f64) {
    const ACCURACY: &str = "solver.accuracy = 1e-12\n";
    let plain = case(text, &format!("{ACCURACY}grid.gamma_f = {length:?}\n"));
    let tau = rate(&plain) * length;
    let scaled =
        format!("{ACCURACY}metric.conformal = \"{factor}\"\ngrid.gamma_f = 1e9\ngrid.until = \"tau - {tau:?}\"\n");
    let scaled = case(text, &scaled);
    let (before, after) = (plain.start::<f64>(), scaled.start::<f64>());
    let n = before.q.len();
    assert_eq!(scaled.coordinates()[n], "tau");
    assert_eq!(before.p, after.p[..n], "{factor}: momenta at the start");
    let (one, other) = (line_of::<f64>(&plain), line_of::<f64>(&scaled));
    let off = distance(&one.end().q, &other.end().q[..n]);
    assert!(off < 1e-11, "{factor}: {off:e}");
    let off = distance(&one.end().p, &other.end().p[..n]);
    assert!(off < 1e-11, "{factor}: {off:e} in the momenta");
    assert!((other.end().q[n] - tau).abs() <= 1e-12 * tau && other.end().p[n].abs() == tau / length);
}

/// A one-form is not multiplied.
#[test]
fn the_path_at_the_same_tau_is_that_without_a_factor() {
    for (text, length, factors) in [
        (SCHWARZSCHILD, 200.0, &["1/r^2", "r", "2 + sin(phi)"][..]),
        (SPACELIKE, 4.0, &["1/r^2", "r", "2 + sin(phi)"]),
        (KERR, 150.0, &["1/sigma", "sigma", "m/r"]),
        (CHARGED, 100.0, &["1/r^2", "r^2"]),
    ] {
        factors.iter().for_each(|factor| agree(text, factor, length));
    }
}

/// In the strong form up to the last node, and there with its multiplier.
#[test]
fn the_charge_of_tau_and_all_others_are_exact_on_coarse_grids() {
    let grids = [
        ("SBP42', form = 'weak", "n_gamma = 24, windows = 2"),
        ("SBP21', form = 'weak", "n_gamma = 24"),
        ("GLL8', form = 'weak", "windows = 4"),
        ("SBP42', form = 'strong", "n_gamma = 40"),
    ];
    for (text, sign, length) in [(SCHWARZSCHILD, -1.0, 0.6), (KERR, -1.0, 0.6), (SPACELIKE, 1.0, 0.05)] {
        for (scheme, grid) in grids {
            let grid = format!("grid = {{ gamma_f = {length}, {grid} }}\nmetric.conformal = '1/r^2'\n");
            let case = case(text, &format!("scheme = {{ sbp = '{scheme}' }}\n{grid}"));
            let line: WorldLine = line_of(&case);
            let diagnostics = Diagnostics::of(&line, &[], &mut [], false);
            let tau = line.geometry().dimension() - 1;
            assert!(diagnostics.charges.iter().any(|charge| charge.terms == [(tau, 1.0)]));
            let most = if scheme.ends_with("strong") { 1e-12 } else { 2e-13 };
            for charge in &diagnostics.charges {
                let off = charge.max_interior.max(charge.max_corrected);
                assert!(off < most, "{scheme}: {:?} {off:e}", charge.terms);
            }
            let expected = case.initial.norm.as_ref().map_or(0.946375_f64.sqrt(), |_| 1.0);
            assert!((line.end().p[tau] - sign * expected).abs() < 1e-15, "{}", line.end().p[tau]);
        }
    }
}

#[test]
fn forty_digits() {
    let more = "solver.digits = 40\nscheme = { sbp = \"GLL40\", form = \"weak\" }\n";
    let plain = case(SCHWARZSCHILD, &format!("{more}grid = {{ gamma_f = 4.0, windows = 2 }}\n"));
    let end = "grid = { gamma_f = 1.0, windows = 20, until = \"tau - 4*sqrt(0.946375)\" }\n";
    let scaled = case(SCHWARZSCHILD, &format!("{more}{end}metric.conformal = \"1/r^2\"\n"));
    let (one, other) = (line_of::<Extended>(&plain), line_of::<Extended>(&scaled));
    let tau = Extended::from_decimal("0.946375").unwrap().sqrt();
    let start = scaled.start::<Extended>();
    assert!((start.p[3] + tau).abs().to_f64() < 1e-60 && plain.start::<Extended>().p == start.p[..3]);
    let off = distance(&one.end().q, &other.end().q[..3]);
    assert!(off < 1e-45, "{off:e}");
    for charge in Diagnostics::of(&other, &[], &mut [], false).charges {
        assert!(charge.max_interior.to_f64() < 1e-50, "{:?} {:e}", charge.terms, charge.max_interior.to_f64());
    }
}

/// Light has no tau, and is where it was without the factor.
#[test]
fn light_that_starts_with_velocities_keeps_its_charges() {
    let photon = |set: &[&str]| shipped("kerr-photon", set);
    let plain = photon(&["solver.accuracy=1e-12", "grid.until=phi + 3.5"]);
    for factor in ["1/r^2", "r"] {
        let conformal = format!("metric.conformal={factor}");
        let scaled = photon(&["solver.accuracy=1e-12", "grid.until=phi + 3.5", "grid.gamma_f=1e9", &conformal]);
        assert_eq!(scaled.coordinates(), plain.coordinates());
        let (before, after) = (plain.start::<f64>(), scaled.start::<f64>());
        assert_eq!(before.p, after.p);
        let omega = if factor == "r" { 50.0 } else { 1.0 / 2500.0 };
        assert!(distance(&before.q_dot, &after.q_dot.iter().map(|u| u * omega).collect::<Vec<_>>()) < 1e-15);
        let off = distance(&line_of::<f64>(&plain).end().q, &line_of::<f64>(&scaled).end().q);
        assert!(off < 1e-11, "{factor}: {off:e}");
    }
}
