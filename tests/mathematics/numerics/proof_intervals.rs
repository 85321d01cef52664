//! Starts and parameters between two numbers: the proved hull has the ends of all motions from there, and not much
//! more.

use geodesic_ivp::study::proof::{Hull, hull};

use crate::common::parsed;

const OSCILLATOR: &str = r#"
potential = { coordinates = ["x"], formula = "x^2/2" }
particle.law = "newtonian"
initial = { x = [0.9, 1.1], x_dot = ["-1/10", 0.2] }
grid.t_f = 1.0
solver.accuracy = 1e-10
"#;

fn found(text: &str, set: &[&str]) -> Result<Hull, String> {
    let hull = hull(&parsed(text, set), &mut |_| true);
    hull.ends.clone().map(|_| hull)
}

fn ends_of(hull: &Hull, name: &str) -> [f64; 2] {
    hull.ends.as_ref().unwrap().iter().find(|(own, _)| own == name).unwrap().1
}

/// x = x₀ cos t + ẋ₀ sin t is linear, so that the hull is that of its corners, but for what a window is not exact by: a
/// part in 1e6 of the set at most.
#[test]
fn the_hull_of_an_oscillator_is_that_of_its_corners() {
    let hull = found(OSCILLATOR, &[]).unwrap();
    let (cos, sin) = (1.0_f64.cos(), 1.0_f64.sin());
    let wanted = [0.9 * cos - 0.1 * sin, 1.1 * cos + 0.2 * sin];
    let [low, high] = ends_of(&hull, "x");
    assert!(low <= wanted[0] && wanted[0] - low < 1e-8, "{low} {}", wanted[0]);
    assert!(high >= wanted[1] && high - wanted[1] < 1e-8, "{high} {}", wanted[1]);
    assert_eq!(ends_of(&hull, "t"), [1.0_f64.next_down().next_down(), 1.0_f64.next_up().next_up()]);
}

/// Free motion: what was a constant is none, and a place that nothing depends on moves with its start.
#[test]
fn conserved_momenta_may_be_intervals() {
    let stone = r#"
        potential = { coordinates = ["x", "y"], formula = "9.81*y" }
        particle.law = "newtonian"
        initial = { x = [0.0, 0.5], y = 1.0, x_dot = [1.0, 2.0], y_dot = 0.0 }
        grid.t_f = 2.0
        solver.accuracy = 1e-10
    "#;
    let [low, high] = ends_of(&found(stone, &[]).unwrap(), "x");
    assert!((low - 2.0).abs() < 1e-8 && low <= 2.0 && (high - 4.5).abs() < 1e-8 && high >= 4.5, "{low} {high}");
}

/// A velocity times t_dot, both of which are intervals, is no linear start; and what nothing acts on has a hull, too.
#[test]
fn products_of_intervals_have_no_hull_and_free_motions_have_one() {
    let relativistic = r#"
        potential = { coordinates = ["x"], formula = "x^2/2" }
        particle.c = 2.0
        initial = { t = 0.0, x = 0.3, t_dot = [0.995, 1.005], velocity = [0.295, 0.305] }
        grid.gamma_f = 0.3
        solver.accuracy = 1e-8
    "#;
    let reason = found(relativistic, &[]).unwrap_err();
    assert!(reason.contains("not linear"), "{reason}");
    let free = OSCILLATOR.replace("x^2/2", "0");
    let [low, high] = ends_of(&found(&free, &[]).unwrap(), "x");
    assert!((0.8 - 1e-12..=0.8).contains(&low) && (1.3..1.3 + 1e-12).contains(&high), "{low} {high}");
}

/// The pendulum is not linear: every corner and points inside end within, and the hull is not much larger.
#[test]
fn motions_from_inside_end_within() {
    let pendulum = OSCILLATOR.replace("x^2/2", "1 - cos(x)");
    let [low, high] = ends_of(&found(&pendulum, &[]).unwrap(), "x");
    let end = |x: &str, x_dot: &str| {
        let set = [format!("initial.x=[{x}, {x} + 1e-12]"), format!("initial.x_dot=[{x_dot}, {x_dot} + 1e-12]")];
        let set = set.map(|text| text.replace("[", "[\"").replace(", ", "\", \"").replace("]", "\"]"));
        ends_of(&found(&pendulum, &set.each_ref().map(String::as_str)).unwrap(), "x")[0]
    };
    let corners = [("0.9", "-0.1"), ("0.9", "0.2"), ("1.1", "-0.1"), ("1.1", "0.2"), ("1.0", "0.05")];
    let ends = corners.map(|(x, x_dot)| end(x, x_dot));
    let least = ends.into_iter().fold(f64::INFINITY, f64::min);
    let most = ends.into_iter().fold(f64::NEG_INFINITY, f64::max);
    assert!(low <= least + 1e-11 && most <= high + 1e-11, "{low} {least} {most} {high}");
    assert!(high - low < 1.5 * (most - least), "{low} {least} {most} {high}");
}

/// A start may be linear at every place that is looked at, and leap or swell between them: formulas tell.
#[test]
fn starts_that_are_linear_at_some_places_alone_have_no_hull() {
    let of = |x: &str, grid: &str| {
        let text = format!(
            "parameters.k = [0.0, 1.0]\npotential.formula = \"x^2/2\"\nparticle.law = \"newtonian\"\n\
             initial = {{ x = \"{x}\", x_dot = 0.3 }}\ngrid = {{ {grid} }}\nsolver.accuracy = 1e-10"
        );
        found(&text, &[]).map(|_| ())
    };
    let end = "t_f = 1.0";
    for (x, grid) in [
        ("k + exp(-(1e4*(k - 0.3))^2)", end),
        ("k + step(abs(k - 0.3) - 0.01)", end),
        ("k + (k - 0.5)*(k - 1)*k*(k - 1/8)", end),
        ("k", "gamma_i = \"k\", gamma_f = 3.0"),
        ("k", "t_f = \"1 + exp(-(1e4*(k - 0.3))^2)\""),
    ] {
        let reason = of(x, grid).unwrap_err();
        assert!(reason.contains("linear in parameters.k"), "{x}, {grid}: {reason}");
    }
    assert!(of("2*(k/3 - 1)", end).is_ok() && of("k/5", "t_f = \"1 + k/10\"").is_ok());
}

#[test]
fn what_is_no_set_of_linear_starts_is_said() {
    let bent = OSCILLATOR.replace("x_dot = [\"-1/10\", 0.2]", "x_dot = 0.1, t_dot = 1.0, norm = 0.5");
    assert!(geodesic_ivp::Case::parse("bent", &bent, &[]).is_err() || found(&bent, &[]).is_err());
    // All of the starts are on one side of what ends the run, or there is no hull.
    let event = |when: &str| format!("{OSCILLATOR}\n[events.zero]\nwhen = \"{when}\"\nuntil = true\n");
    assert!(found(&event("x - 1"), &[]).unwrap_err().contains("side of an event"));
    assert!(found(&event("x - 7"), &[]).is_ok());
    for (wrong, message) in [("[1.0]", "two ends"), ("[2.0, 1.0]", "no inside"), ("[\"k\", 1.0]", "no inside")] {
        let error = geodesic_ivp::Case::parse("wrong", OSCILLATOR, &[format!("initial.x={wrong}")]).unwrap_err();
        assert!(error.to_string().contains(message) || error.to_string().contains("k"), "{error}");
    }
}
