//! The effective case, which reads back as the same scene.

use geodesic_ivp::case::builtin::NAMES;
use geodesic_ivp::geometry::Start;

use super::{KEPLER, KERR, SCHWARZSCHILD, scene};
use crate::common::{parsed, shipped};
use crate::world_lines::bodies::BODIES;

const EVERYTHING: &str = r#"
title = "Everything \"that\" a metric has"

[metric]
coordinates = ["t", "x", "y"]
components = { "t t" = "c^2", "x t" = "w", "x x" = -1, "y y" = "-1" }
definitions = { w = "k*y" }
parameters = { k = 1e-3, c = "sqrt(2)", unused = 0x10 }
one_form = { t = "x", x = 0.10000000000000000000000000000000000000000001 }
force = { y = "-k*y_dot" }

[initial]
t = +1_000.5
x = 0
y = "pi/3"
t_dot = 1
x_dot = "k"
p_y = -0.25

[grid]
gamma_i = -1
t_f = "2000 + pi"
n_gamma = 20
windows = 3
until = "x - y_dot"

[scheme]
sbp = "SBP42"
form = "weak"

[solver]
system = "doubled"
digits = 30
max_iterations = 12

[invariants]
momentum = "p_x + w"

[events]
top = { when = "y_dot", direction = "down" }
end = { when = "x", until = true }

[plot]
x = "x"
y = "y"

[expect]
gamma_final = "pi/3"
t_final = 3.5
y_final = "pi"
tolerance = 1e-11
"#;

#[test]
fn what_is_written_reads_back_as_the_same_scene() {
    let masses = "[potential]\ncoordinates = [\"x\", \"y\"]\nformula = \"x*y\"\nparameters = { k = 3 }\n\
                  one_form = { y = \"k*x\" }\nforce = { x = \"-x_dot\" }\n[particle]\nmasses = { x = 2, y = \"k\" }\n\
                  mass = 1.5\nc = 10\n[initial]\nx = 1\ny = 2\nx_dot = 0.1\ny_dot = 0.2\nt_dot = 1\n[grid]\n\
                  gamma_f = 1\nn_gamma = 20\n[scheme]\nsbp = \"SBP42\"\n";
    let energy = KEPLER.replace("y_dot = \"sqrt(19)\"", "p_t = -0.5\nnorm = 0\nsolve = { y_dot = \"+\" }");
    let newtonian = KEPLER.replace("law = \"newtonian\"", "law = \"newtonian\"\nmasses = { x = 2, y = 2 }");
    let fish_eye = "metric = { preset = \"optics\", definitions = { n = \"2/(1 + x^2 + y^2)\" } }\nscheme.sbp = \
                    \"GLL8\"\ngrid.gamma_f = 1\ninitial = { x = 0.5, y = 0, x_dot = 0, y_dot = 1 }\n";
    let massive = SCHWARZSCHILD.replace("[initial]", "conformal = \"1/r\"\n[initial]");
    for text in [SCHWARZSCHILD, KEPLER, KERR, EVERYTHING, masses, &energy, &newtonian, fish_eye, &massive] {
        let first = scene(text);
        let written = first.to_toml();
        let second = scene(&written);
        assert_eq!(first, second, "{written}");
        assert_eq!(written, second.to_toml());
        assert_eq!(first.start::<f64>(), second.start::<f64>());
    }
    for case in NAMES.iter().map(|name| shipped(name, &[])).chain([parsed(BODIES, &[])]) {
        let written = case.to_toml();
        assert_eq!(case, parsed(&written, &[]), "{written}");
        assert!(!written.contains("[[body]]") || !written.contains("masses"), "{written}");
    }
}

#[test]
fn every_default_is_filled_in() {
    let written = scene(KEPLER).to_toml();
    for line in [
        "mass = 1.0",
        "law = \"newtonian\"",
        "gamma_i = 0",
        "windows = 1",
        "form = \"strong\"",
        "digits = 16",
        "system = \"physical-limit\"",
        "max_iterations = 50",
        "t_dot = 1",
        "s = 0",
    ] {
        assert!(written.lines().any(|other| other == line), "{line} is not in\n{written}");
    }
    assert!(scene(KERR).to_toml().contains("m = 1"));
}

#[test]
fn numbers_keep_their_digits() {
    let scene = scene(EVERYTHING);
    assert!(scene.to_toml().contains("0.10000000000000000000000000000000000000000001"));
    assert_eq!(scene.start::<f64>().q[0], 1000.5);
    assert_eq!(scene.title.as_deref(), Some("Everything \"that\" a metric has"));
    assert_eq!(scene.t_f::<f64>(), Some(2000.0 + std::f64::consts::PI));
    let (events, axes) = (&scene.events, scene.axes.as_ref().unwrap());
    assert!(events[0].direction.as_str() == "down" && events[1].until && axes.x == "x");
    let start: Start = scene.start();
    assert_eq!(parsed(&scene.to_toml(), &[]).start::<f64>(), start);
}
