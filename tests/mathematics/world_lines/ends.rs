//! Runs that end at a time, where a formula changes its sign, or outside the domain.

use geodesic_ivp::Status;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;

use crate::common::{failure, line_of, shipped, solved, solved_in, text_solved};

/// Proper time of a fall from rest at R = 10 to r, by the cycloid.
fn proper_time(r: f64) -> f64 {
    let eta = (2.0 * r / 10.0 - 1.0).acos();
    (1000.0_f64 / 8.0).sqrt() * (eta + eta.sin())
}

/// On a grid, to all digits, and with windows for an accuracy: r = 0.01 is just before the singularity.
#[test]
fn a_fall_goes_through_the_horizon_and_ends_where_a_formula_changes_its_sign() {
    fn fall<S: Real>(length: f64, until: &str, scheme: &[&str]) -> WorldLine<S> {
        let end = [format!("grid.gamma_f={length:?}"), format!("grid.until={until}")];
        let set: Vec<&str> = end.iter().map(String::as_str).chain(scheme.iter().copied()).collect();
        line_of(&shipped("schwarzschild-plunge", &set))
    }
    let grid = ["grid.windows=40", "scheme.sbp=GLL24"];
    for (until, r, scheme, most) in [
        ("r - 2", 2.0, &grid[..], 1e-11),
        ("1 - r", 1.0, &grid, 1e-10),
        ("r - 2", 2.0, &["solver.accuracy=1e-11"], 3e-9),
        ("r - 0.01", 0.01, &["solver.accuracy=1e-11"], 3e-9),
    ] {
        let line = fall::<f64>(35.2, until, scheme);
        assert!((line.length - proper_time(r)).abs() < most, "{until} {scheme:?}: {}", line.length);
        assert!((line.end().q[1] - r).abs() < most.max(1e-13), "{until} {scheme:?}: {}", line.end().q[1]);
    }
    // Where the formula keeps its sign the run has its whole length.
    assert_eq!(fall::<f64>(30.0, "r - 1", &grid).length, 30.0);
    let line = fall::<Extended>(35.0, "r - 2", &[&grid[..], &["solver.digits=40"]].concat());
    assert!((line.end().q[1] - Extended::from(2.0)).abs().to_f64() < 1e-36, "to all digits");
}

/// A run on a grid ends at a time to this error, in whatever form, system and precision, and wherever γ starts.
#[test]
fn a_run_can_end_at_a_physical_time() {
    for scheme in [
        "scheme.sbp=SBP21",
        "scheme.sbp=SBP42",
        "scheme.sbp=SBP21 solver.system=doubled",
        "scheme.sbp=SBP42 solver.system=doubled",
        "scheme.sbp=SBP21 scheme.form=weak",
        "scheme.sbp=SBP42 scheme.form=weak",
        "scheme.sbp=SBP21 scheme.form=weak solver.system=doubled",
        "scheme.sbp=SBP42 scheme.form=weak solver.system=doubled",
    ] {
        let solution = solved(&format!("grid={{t_f=5.0,n_gamma=128}} initial.t=0.5 {scheme}"));
        assert!((solution.end_state().t - 5.0).abs() < 1e-11, "{scheme}: {}", solution.end_state().t);
        let by_gamma = format!("grid={{gamma_f={:?},n_gamma=128}} initial.t=0.5 {scheme}", solution.gamma_f());
        assert!((solved(&by_gamma).end_state().x - solution.end_state().x).abs() < 1e-10, "{scheme}");
    }
    for (t_f, rest, error) in [
        (5.0, "gamma_i=1e6,n_gamma=128} scheme.sbp=SBP21", 1e-12),
        (5.0, "gamma_i=1e8,n_gamma=128} scheme.sbp=SBP21", 1e-12),
        (1e-6, "n_gamma=401} scheme.sbp=SBP42", 1e-19),
        (1.0, "n_gamma=401} scheme.sbp=SBP42", 1e-13),
        (30.0, "n_gamma=401} scheme.sbp=SBP42", 3e-12),
        (4.5, "n_gamma=40,windows=8} scheme.sbp=SBP42", 1e-12),
        (4.5, "n_gamma=16,windows=8} scheme.sbp=GLL16", 1e-12),
        (4.5, "n_gamma=16,windows=8} scheme.sbp=GLL16 scheme.form=weak", 1e-12),
    ] {
        let off = solved(&format!("grid={{t_f={t_f:?},{rest}")).end_state().t - t_f;
        assert!(off.abs() < error, "{t_f} {rest}: {off:e}");
    }
    for (digits, system) in [20, 40, 60].iter().flat_map(|digits| ["physical-limit", "doubled"].map(|s| (digits, s))) {
        let run = format!("grid={{t_f=5.0,n_gamma=64}} scheme.sbp=SBP42 solver.system={system} solver.digits={digits}");
        let off = (solved_in::<Extended>(&run).end_state().t - Extended::from(5.0)).abs();
        assert!(off <= Extended::from_decimal(&format!("1e-{}", digits - 1)).unwrap(), "{run}: {off:?}");
    }
    for t_f in [5.0, 20.0, 53.98674477227013] {
        let line = text_solved(&format!(
            "metric.preset = 'schwarzschild'\ngrid = {{ t_f = {t_f:?}, windows = 8 }}\n\
             initial = {{ r = 10, t_dot = 1.2, r_dot = -0.05, phi_dot = 0.03 }}\n\
             scheme = {{ sbp = 'GLL20', form = 'weak' }}\n"
        ));
        assert!((line.end().q[0] - t_f).abs() <= 2.0 * f64::EPSILON * t_f, "{} is not {t_f}", line.end().q[0]);
    }
    let early = text_solved(
        "potential = { coordinates = ['x'], formula = 'x^2/2' }\nparticle.c = 2.0\nscheme.sbp = 'SBP42'\n\
         initial = { t = -5.0, t_dot = 3.0, x = 1.0, x_dot = 0.4 }\ngrid = { t_f = -2.0, n_gamma = 201 }\n",
    );
    assert!((early.end().q[0] + 2.0).abs() < 1e-13 && early.length > 0.5, "{}", early.end().q[0]);
}

/// An explicit rule with a coarse step leaps over the horizon to r < 0, where the metric is regular again.
#[test]
fn a_run_that_leaves_the_domain_says_where() {
    for (sbp, n_gamma) in [("SBP42", 401), ("SBP21", 101), ("SBP21", 401), ("SBP21", 1601)] {
        let failure = failure(&format!(
            "metric.preset = 'schwarzschild'\ngrid = {{ gamma_f = 60.0, n_gamma = {n_gamma} }}\n\
             initial = {{ r = 10, t_dot = 1.2, r_dot = -0.05, phi_dot = 0 }}\nscheme.sbp = '{sbp}'\n"
        ));
        assert_eq!(failure.status, Status::OutsideDomain, "{sbp} {n_gamma}: {failure}");
        assert!(failure.gamma > 20.0 && failure.gamma < 60.0, "{sbp} {n_gamma}: {failure}");
    }
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
    let failure = failure(text);
    assert_eq!(failure.status, Status::EndTimeNotReached, "{failure}");
    assert!(failure.gamma > 7.0 + 100.0 && failure.point[0].1 > 1e4, "{failure}");
}
