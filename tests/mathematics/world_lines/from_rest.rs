//! Forces that are 0 at the start, with some of their derivatives or with all: what begins at rest is moved by them.

use std::f64::consts::PI;

use crate::common::{end, line_of, parsed};

/// Schemes that begin with the least that can be known, and one with more digits.
const SCHEMES: [&str; 5] = [
    "solver.accuracy=1e-9",
    "solver.tolerance=1e-11",
    "grid.n_gamma=16 grid.windows=60 scheme.sbp=GLL16 scheme.form=weak",
    "grid.n_gamma=16 grid.windows=60 scheme.sbp=GLL16",
    "grid.n_gamma=16 grid.windows=60 scheme.sbp=GLL16 scheme.form=weak solver.digits=25",
];

/// x at the end of a run of this length from rest at 0, or from next to rest.
fn moved(potential: &str, force: &str, speed: f64, length: f64, scheme: &str) -> f64 {
    let text = format!(
        "potential = {{ coordinates = [\"x\"], formula = \"{potential}\", force = {{ x = \"{force}\" }} }}\n\
         particle.law = \"newtonian\"\ninitial = {{ x = 0.0, x_dot = {speed:e} }}\ngrid.t_f = {length:?}"
    );
    end(&line_of::<f64>(&parsed(&text, &scheme.split(' ').collect::<Vec<_>>())), "x")
}

/// An oscillator under 1 − cos(k t), which begins like t²: x = 1 − cos t − (cos k t − cos t)/(1 − k²).
#[test]
fn an_oscillator_follows_a_force_that_begins_like_a_square() {
    let exact = |k: f64, t: f64| 1.0 - t.cos() - ((k * t).cos() - t.cos()) / (1.0 - k * k);
    for (k, length) in [(3.0, 20.0), (0.3, 12.0), (0.7, -9.0), (0.01, 20.0)] {
        for (speed, scheme) in [0.0, 1e-15, 1e-100].into_iter().flat_map(|speed| SCHEMES.map(|scheme| (speed, scheme)))
        {
            if scheme.contains("digits") && speed != 0.0 {
                continue;
            }
            let x = moved("x^2/2", &format!("1 - cos({k}*t)"), speed, length, scheme);
            assert!((x - exact(k, length)).abs() < 1e-8, "{k} {length} {speed:e} {scheme}: {x}");
        }
    }
}

/// Nothing else moves it: x = t^(n+2)/(n+1)(n+2), whose window looks the same however short it is.
#[test]
fn any_power_of_time_moves_what_is_at_rest() {
    for n in [1, 2, 3, 7, 12, 20, 31, 40] {
        for scheme in &SCHEMES[..3] {
            let x = moved("0", &format!("t^{n}"), 0.0, 1.5, scheme);
            let exact = 1.5_f64.powi(n + 2) / f64::from((n + 1) * (n + 2));
            assert!((x / exact - 1.0).abs() < 1e-8, "{n} {scheme}: {x} {exact}");
        }
    }
}

/// A pulse far ahead, whose force is 0 to the last bit at the start, gives a speed of its area.
#[test]
fn a_pulse_far_ahead_is_met() {
    for (at, width) in [(11.3, 0.1), (7.0, 0.4), (13.1, 2e-3)] {
        for scheme in &SCHEMES[..2] {
            let x = moved("0", &format!("5*exp(-((t - {at})/{width})^2)"), 0.0, 20.0, scheme);
            let exact = 5.0 * width * PI.sqrt() * (20.0 - at);
            assert!((x / exact - 1.0).abs() < 1e-8, "{at} {width} {scheme}: {x} {exact}");
        }
    }
}

/// Of two coordinates one moves from the start, and the other one by a force of it.
#[test]
fn a_second_coordinate_is_moved_by_the_first() {
    let text = "potential = { coordinates = [\"x\", \"y\"], formula = \"y^2/2\", \
                force = { y = \"2*(1 - cos(3*x))\" } }\n\
                particle = { law = \"newtonian\", masses = { x = 1.0, y = 2.0 } }\n\
                initial = { x = 0.0, y = 0.0, x_dot = 1.0, y_dot = 0.0 }\ngrid.t_f = 20.0";
    // ÿ = −w² y + 1 − cos 3t.
    let (square, w) = (0.5, 0.5_f64.sqrt());
    let exact = (1.0 - (20.0 * w).cos()) / square - ((60.0_f64).cos() - (20.0 * w).cos()) / (square - 9.0);
    for scheme in SCHEMES {
        let y = end(&line_of::<f64>(&parsed(text, &scheme.split(' ').collect::<Vec<_>>())), "y");
        assert!((y - exact).abs() < 1e-8, "{scheme}: {y} {exact}");
    }
}

/// The far end of a chain moves like a high power of time, by its neighbours, also where all masses differ.
#[test]
fn a_wave_reaches_the_end_of_a_chain() {
    for masses in ["", "particle.masses = { a = 1.0, b = 1.3, c = 0.7, d = 1.9, e = 0.4, f = 1.1, g = 2.3, h = 0.6 }\n"]
    {
        let names = ["a", "b", "c", "d", "e", "f", "g", "h"];
        let springs: Vec<String> = names.windows(2).map(|pair| format!("({} - {})^2/2", pair[0], pair[1])).collect();
        let rest: Vec<String> = names[1..].iter().map(|name| format!("{name} = 0.0, {name}_dot = 0.0")).collect();
        let text = format!(
            "potential = {{ coordinates = {names:?}, formula = \"{}\" }}\nparticle.law = \"newtonian\"\n{masses}\
             initial = {{ a = 1.0, a_dot = 0.0, {} }}\ngrid.t_f = 6.0",
            springs.join(" + "),
            rest.join(", ")
        );
        let finer =
            end(&line_of::<f64>(&parsed(&text, &["grid.n_gamma=20", "grid.windows=40", "scheme.sbp=GLL20"])), "h");
        for scheme in &SCHEMES[..3] {
            let h = end(&line_of::<f64>(&parsed(&text, &scheme.split(' ').collect::<Vec<_>>())), "h");
            assert!((h - finer).abs() < 1e-8, "{masses}{scheme}: {h} {finer}");
        }
    }
}
