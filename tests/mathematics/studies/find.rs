//! A search finds what is there, up to the error that it tells: closed forms, laws, published orbits, and fits whose
//! true parameters are known.

use std::f64::consts::PI;

use geodesic_ivp::Case;
use geodesic_ivp::study::find::{Found, Iterate, NotFound, find};

use crate::common::{parsed, shipped};

const OSCILLATOR: &str = r#"
potential = { coordinates = ["x"], formula = "k*x^2/2", parameters = { k = 1.0 } }
particle.law = "newtonian"
initial = { x = 1.0, x_dot = 0.0 }
grid.t_f = 1.0
solver.accuracy = 1e-12
"#;

const PLANE: &str = r#"
potential = { coordinates = ["x", "y"], formula = "0" }
particle.law = "newtonian"
initial = { x = 0.0, y = 0.0, x_dot = 1.0, y_dot = 1.0 }
grid.t_f = 2.0
solver.accuracy = 1e-12
"#;

fn searched(case: &Case) -> (Result<Found, NotFound>, Vec<Iterate>) {
    let mut iterates = Vec::new();
    let found = find(case, case.find.as_ref().unwrap(), false, &mut |iterate| iterates.push(iterate));
    (found, iterates)
}

#[track_caller]
fn found(case: &Case) -> Found {
    searched(case).0.unwrap_or_else(|none| panic!("{none}"))
}

#[track_caller]
fn found_in(text: &str, wanted: &str) -> Found {
    found(&parsed(&format!("{text}\n[find]\n{wanted}"), &[]))
}

/// Every value is the true one to a few of the errors that are told, and these are small.
#[track_caller]
fn assert_found(found: &Found, truth: &[f64], at_most: f64) {
    for ((value, error), truth) in found.values.iter().zip(&found.errors).zip(truth) {
        assert!(*error <= at_most, "an error of {error:e}");
        assert!((value - truth).abs() <= 2.0 * error, "{value} ± {error:e}, and not {truth}");
    }
    assert!(found.is_met, "{:?}", found.residuals);
}

#[test]
fn numbers_of_an_oscillator_are_those_of_the_closed_form() {
    // The amplitude and the time of the first zero, by the linearised equations; the frequency, by differences of runs.
    let amplitude = found_in(OSCILLATOR, "unknowns = [\"initial.x\"]\nmeet = [\"x - 2\"]");
    assert_found(&amplitude, &[2.0 / 1.0_f64.cos()], 1e-11);
    let time = found_in(OSCILLATOR, "unknowns = [\"grid.t_f\"]\nmeet = [\"x\"]");
    assert_found(&time, &[0.5 * PI], 1e-11);
    assert!(amplitude.differenced.is_empty() && time.differenced.is_empty());
    let wanted = "unknowns = [\"parameters.k\"]\nmeet = [\"x - start(x)/2\"]";
    let stiffness = found_in(OSCILLATOR, wanted);
    assert_found(&stiffness, &[(PI / 3.0).powi(2)], 1e-10);
    assert_eq!(stiffness.differenced, ["parameters.k"]);
    // On a given grid all derivatives are differences.
    let grid = OSCILLATOR.replace("solver.accuracy = 1e-12", "scheme = { sbp = \"GLL16\", form = \"weak\" }");
    let on_grid = found_in(&grid, "unknowns = [\"initial.x\", \"grid.t_f\"]\nmeet = [\"x - 0.5\", \"x_dot + 2\"]");
    let amplitude = 4.25_f64.sqrt();
    assert_found(&on_grid, &[amplitude, (0.5 / amplitude).acos()], 1e-11);
    assert_eq!(on_grid.differenced.len(), 2);
}

/// A run backward, and one by γ, whose derivatives come from the linearised equations with other signs.
#[test]
fn signs_of_a_run_backward_are_right() {
    for (end, sign) in [("grid.t_f=-1", -1.0), ("grid.gamma_f=-1", -1.0), ("grid.gamma_f=1", 1.0)] {
        let wanted = "[find]\nunknowns = [\"initial.x_dot\"]\nmeet = [\"x - 2\", ]";
        let case = parsed(&format!("{OSCILLATOR}\n{wanted}"), &[end]);
        let (result, iterates) = searched(&case);
        let (x, v) = (1.0_f64.cos(), sign * 1.0_f64.sin());
        assert_found(&result.unwrap(), &[(2.0 - x) / v], 1e-11);
        assert!(iterates.len() <= 3, "a linear problem takes {} steps", iterates.len() - 1);
    }
}

#[test]
fn systems_of_any_shape_have_the_nearest_solution() {
    let meet =
        |meet: &str| found_in(PLANE, &format!("unknowns = [\"initial.x_dot\", \"initial.y_dot\"]\nmeet = {meet}"));
    // On the line x + 2y = 10 at t = 2 the velocity nearest to (1, 1) is (1.4, 1.8).
    let under = meet("[\"x + 2*y - 10\"]");
    assert_found(&under, &[1.4, 1.8], 1e-11);
    assert_eq!(under.rank, 1);
    // Three places cannot all be met: nearest is their centre, and that is said.
    let over = meet("[\"x - 1\", \"x - 2\", \"x - 6\", \"y\"]");
    assert!(!over.is_met && (over.values[0] - 1.5).abs() < 1e-9 && over.values[1].abs() < 1e-9, "{:?}", over.values);
}

/// Lagrange's equation √μ Δt = a^(3/2) (2πN + (α − sin α) − (β − sin β)), sin²(α/2) = s/(2a), sin²(β/2) = (s − c)/(2a),
/// where the other branch has 2π − α and the longer way −β.
#[test]
fn lambert_s_problem_meets_lagrange_s_equation() {
    let far = ["grid.t_f=20", "initial.x_dot=0", "initial.y_dot=1.1"];
    for (set, time, turns) in [(&[][..], 13.0, 1.0), (&far, 20.0, 2.0)] {
        let all = found(&shipped("lambert", set));
        assert!(all.is_met && all.errors.iter().all(|error| *error < 1e-10), "{:?}", all.errors);
        assert!(all.differenced.is_empty());
        let off = times_of_lagrange(&all.values, turns).map(|of_law| (of_law - time).abs());
        assert!(off.into_iter().fold(f64::INFINITY, f64::min) < 1e-9, "{turns}: {off:?}");
    }
}

/// The times of both branches for a start from (1, 0) with this velocity to (0, 1.5).
fn times_of_lagrange(velocity: &[f64], turns: f64) -> [f64; 2] {
    let (r1, r2, c) = (1.0, 1.5, f64::hypot(1.0, 1.5));
    let square: f64 = velocity.iter().map(|v| v * v).sum();
    let a = 1.0 / (2.0 / r1 - square);
    let s = 0.5 * (r1 + r2 + c);
    let angle = |square: f64| 2.0 * square.sqrt().asin();
    let (alpha, beta) = (angle(s / (2.0 * a)), angle((s - c) / (2.0 * a)));
    let swept = |angle: f64| angle - angle.sin();
    [alpha, 2.0 * PI - alpha].map(|alpha| a.powf(1.5) * (2.0 * PI * turns + swept(alpha) - swept(beta)))
}

#[test]
fn a_great_circle_has_the_length_and_the_direction_of_spherical_trigonometry() {
    let [a, b, l] = [47.38_f64, 35.68, 139.69 - 8.54].map(f64::to_radians);
    let length = (a.sin() * b.sin() + a.cos() * b.cos() * l.cos()).acos();
    let north = f64::atan2(l.sin() * b.cos(), a.cos() * b.sin() - a.sin() * b.cos() * l.cos());
    assert_found(&found(&shipped("great-circle", &[])), &[north, length], 1e-9);
}

#[test]
fn the_figure_eight_is_found_from_a_rough_start() {
    let all = found(&shipped("figure-eight", &[]));
    for (value, published) in all.values.iter().zip([0.466203685, 0.43236573, 6.32591398]) {
        assert!((value - published).abs() < 2e-8, "{:?}", all.values);
    }
    // The indices that are not trivial are cos(2πν) with the ν of C. Simó (Contemporary Mathematics 292 (2002) 209),
    // which have eight digits.
    let multipliers = all.multipliers.unwrap();
    assert_eq!(multipliers.values.len(), 12);
    for published in [0.008_422_72_f64, 0.298_092_53] {
        let index = (2.0 * PI * published).cos();
        let is_near = multipliers.indices.as_ref().unwrap().iter().any(|z| (z.re - index).abs() < 1e-7);
        assert!(is_near, "{index} is not in {multipliers:?}");
    }
}

#[test]
fn arenstorf_s_orbit_has_its_published_digits() {
    let text = r#"
        initial = { x = 0.994, y = 0.0, x_dot = 0.0, y_dot = -2.0016 }
        grid.t_f = 17.06
        particle.law = "newtonian"
        solver.accuracy = 1e-11
        [potential]
        coordinates = ["x", "y"]
        formula = "-(1 - mu)/sqrt((x + mu)^2 + y^2) - mu/sqrt((x - 1 + mu)^2 + y^2) - (x^2 + y^2)/2"
        one_form = { x = "-y", y = "x" }
        parameters = { mu = 0.012277471 }
    "#;
    let all = found_in(text, "unknowns = [\"initial.y_dot\", \"grid.t_f\"]\nperiodic = true");
    assert_found(&all, &[-2.001_585_106_379_082_5, 17.065_216_560_157_964], 1e-6);
}

/// Multipliers of a planar orbit: λ and 1/λ, and 1 twice. λ is that of differences of runs, too.
#[test]
fn multipliers_are_those_of_the_monodromy_matrix() {
    let text = r#"
        potential = { coordinates = ["x", "y"], formula = "(x^2 + y^2)/2 + x^2*y - y^3/3" }
        particle.law = "newtonian"
        initial = { x = 0.0, y = 0.2, x_dot = 0.4, y_dot = 0.0 }
        grid.t_f = 6.0
        solver.accuracy = 1e-12
    "#;
    let all = found_in(text, "unknowns = [\"initial.y\", \"initial.x_dot\", \"grid.t_f\"]\nperiodic = true");
    assert!(all.is_met && all.errors.iter().all(|error| *error < 1e-7), "{:?} {:?}", all.values, all.errors);
    let of_orbit = all.multipliers.as_ref().unwrap();
    let product = of_orbit.values.iter().fold((1.0, 0.0), |(re, im), z| (re * z.re - im * z.im, re * z.im + im * z.re));
    assert!((product.0 - 1.0).abs() < 1e-9 && product.1.abs() < 1e-9, "{product:?}");
    let sum: f64 = of_orbit.values.iter().map(|z| z.re).sum();
    // The trace, from runs that begin beside the orbit.
    let end = |key: &str, change: f64| {
        let at = |k: usize| format!("{:?}", all.values[k]);
        let start = [("x", "0.0".to_owned()), ("y", at(0)), ("x_dot", at(1)), ("y_dot", "0.0".to_owned())];
        let set: Vec<String> = start
            .iter()
            .map(|(name, value)| {
                let moved = value.parse::<f64>().unwrap() + if *name == key { change } else { 0.0 };
                format!("initial.{name}={moved:?}")
            })
            .chain([format!("grid.t_f={}", at(2))])
            .collect();
        let case = parsed(text, &set.iter().map(String::as_str).collect::<Vec<_>>());
        let end = crate::common::line_of::<f64>(&case).end();
        [end.q[1], end.q[2], end.q_dot[1], end.q_dot[2]]
    };
    let h = 1e-5;
    let keys = ["x", "y", "x_dot", "y_dot"];
    let trace: f64 = keys.iter().enumerate().map(|(k, key)| (end(key, h)[k] - end(key, -h)[k]) / (2.0 * h)).sum();
    assert!((sum - trace).abs() < 1e-7, "{sum} and {trace}");
    let indices = of_orbit.indices.as_ref().unwrap();
    assert!(indices.iter().any(|index| (index.re - 1.0).abs() < 1e-6), "{indices:?}");
}

#[test]
fn a_lyapunov_orbit_crosses_the_axis_at_a_right_angle_after_half_its_period() {
    let all = found(&shipped("lyapunov-orbit", &[]));
    assert!(all.is_met && all.errors.iter().all(|error| *error < 1e-7), "{:?}", all.errors);
    let half = parsed(&all.case.text_of_run(), &[&format!("grid.t_f={:?}", 0.5 * all.values[1])]);
    let end = crate::common::line_of::<f64>(&half).end();
    assert!(end.q[2].abs() < 1e-7 && end.q_dot[1].abs() < 1e-7, "{end:?}");
    let values = all.multipliers.unwrap().values;
    assert!(values[0].re > 100.0 && (values[0].re * values[3].re - 1.0).abs() < 1e-3, "{values:?}");
}

#[test]
fn nothing_is_found_where_there_is_nothing() {
    for (set, wanted, message) in [
        ("grid.t_f=1.0", "unknowns = [\"grid.t_f\"]\nmeet = [\"x - 5\"]", "step"),
        ("grid.gamma_i=0.0", "unknowns = [\"initial.x\"]\nmeet = [\"x_dot - x_dot\"]", "does not depend on initial.x"),
        ("initial.t=0.0", "unknowns = [\"initial.t\"]\nmeet = [\"start(x) - 2\"]", "does not depend on initial.t"),
    ] {
        let (result, _) = searched(&parsed(&format!("{OSCILLATOR}\n[find]\n{wanted}"), &[set]));
        let none = result.expect_err(wanted);
        assert!(none.message.contains(message), "{none}");
    }
}

/// Uniform numbers between 0 and 1 (D. H. Lehmer's generator with the multiplier of S. K. Park and K. W. Miller), and
/// from them normal ones (G. E. P. Box and M. E. Muller).
struct Draws(u64);

impl Draws {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        self.0 as f64 / 2_147_483_647.0
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (2.0 * PI * self.uniform()).cos()
    }
}

/// The number of draws of data with errors that have the true stiffness and amplitude in their ellipse of 95 %, and the
/// mean of χ² over degrees of freedom.
fn coverage(draws: usize) -> (usize, f64) {
    const QUANTILE: f64 = 5.991_464_547;
    let (k, amplitude, sigma) = (2.0_f64, 1.0, 0.02);
    let (mut normal, mut inside, mut sum) = (Draws(20_261_130), 0, 0.0);
    for _ in 0..draws {
        let times: Vec<f64> = (1..=20).map(|i| 0.4 * f64::from(i)).collect();
        let values: Vec<f64> =
            times.iter().map(|t| amplitude * (k.sqrt() * t).cos() + sigma * normal.normal()).collect();
        let sigmas = vec![sigma; times.len()];
        let data = format!("data = {{ t = {times:?}, x = {values:?}, sigma_x = {sigmas:?} }}");
        let wanted = format!("unknowns = [\"parameters.k\", \"initial.x\"]\n{data}");
        let case = parsed(&format!("{OSCILLATOR}\n[find]\n{wanted}"), &["grid.t_f=8.0", "parameters.k=1.8"]);
        let all = found(&case);
        let fit = all.fit.as_ref().unwrap();
        let [[a, b], [_, d]] = [0, 1].map(|j| [fit.covariance[j][0], fit.covariance[j][1]]);
        let (u, v) = (all.values[0] - k, all.values[1] - amplitude);
        inside += usize::from((d * u * u - 2.0 * b * u * v + a * v * v) / (a * d - b * b) <= QUANTILE);
        sum += fit.chi_squared / fit.degrees_of_freedom as f64;
    }
    (inside, sum / draws as f64)
}

#[test]
fn true_parameters_lie_in_the_covariance_of_a_fit() {
    // Fewer than 34 of 40 would be seen once in 300 times.
    let (inside, chi) = coverage(40);
    assert!(inside >= 34 && (chi - 1.0).abs() < 0.2, "{inside} of 40, {chi}");
}

/// `cargo test --profile tests --test mathematics -- --ignored coverage --nocapture` prints the share of 200 draws.
#[test]
#[ignore = "long: two hundred fits"]
fn coverage_of_two_hundred_draws() {
    let (inside, chi) = coverage(200);
    println!("{inside} of 200 draws have the true parameters in their ellipse of 95 %; chi^2 is {chi:.3} on average");
    assert!((180..=198).contains(&inside), "{inside} of 200");
}

/// A straight line through data is the one of linear regression, with its covariance by the scatter of residuals.
#[test]
fn a_fit_of_a_straight_line_is_linear_regression() {
    let (times, values) = ([0.5, 1.0, 1.5, 2.0], [1.1, 1.9, 3.2, 3.9]);
    let data = format!("data = {{ t = {times:?}, x = {values:?} }}");
    let all = found_in(PLANE, &format!("unknowns = [\"initial.x\", \"initial.x_dot\"]\n{data}"));
    let n = times.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let (t, x) = (mean(&times), mean(&values));
    let square: f64 = times.iter().map(|time| (time - t).powi(2)).sum();
    let slope = times.iter().zip(&values).map(|(time, value)| (time - t) * (value - x)).sum::<f64>() / square;
    let residual: f64 = times.iter().zip(&values).map(|(time, value)| (value - x - slope * (time - t)).powi(2)).sum();
    let variance = residual / (n - 2.0);
    assert!((all.values[1] - slope).abs() < 1e-8 && (all.values[0] - (x - slope * t)).abs() < 1e-8, "{:?}", all.values);
    let errors = all.fit.as_ref().unwrap().standard_errors();
    assert!((errors[1] - (variance / square).sqrt()).abs() < 1e-6, "{errors:?}");
    assert!((errors[0] - (variance * (1.0 / n + t * t / square)).sqrt()).abs() < 1e-6, "{errors:?}");
}

/// Orbits of the restricted problem of three bodies, from rough starts: K. C. Howell (1984) and R. F. Arenstorf (1963,
/// with the digits of E. Hairer, S. P. Nørsett and G. Wanner).
#[test]
fn published_orbits_are_found_from_rough_starts() {
    let halo = found(&shipped("halo", &[]));
    for (value, published) in halo.values.iter().zip([0.723_268, 0.198_019, 1.300_177]) {
        assert!((value - published).abs() < 6e-7, "{value} {published}");
    }
    let set = ["parameters.mu=0.012277471", "initial.x=0.994", "initial.y_dot=-2.001", "grid.t_f=17.065"];
    // No run past the earth is accurate to 1e-12.
    let wanted = ["find.unknowns=[\"initial.y_dot\", \"grid.t_f\"]", "solver.accuracy=1e-10"];
    let arenstorf = found(&shipped("lyapunov-orbit", &[&set[..], &wanted].concat()));
    assert_found(&arenstorf, &[-2.001_585_106_379_082, 17.065_216_560_157_96], 1e-6);
}
