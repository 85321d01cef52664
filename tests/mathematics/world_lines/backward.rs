//! Runs back in time.

use geodesic_ivp::Case;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::trajectory::{Sampler, crossings};

use crate::common::{line_of, parsed};

const SCHEMES: [&str; 4] = [
    "solver.accuracy = 1e-12",
    "grid.windows = 40\nscheme = { sbp = \"GLL16\", form = \"weak\" }",
    "grid.windows = 40\nscheme.sbp = \"GLL16\"",
    "grid.windows = 40\nscheme = { sbp = \"GLL12\", form = \"weak\" }\nsolver.digits = 30",
];

fn case(physics: &str, start: &str, end: &str, scheme: &str) -> Case {
    parsed(&format!("{physics}\ninitial = {{ {start} }}\n{end}\n{scheme}\n"), &[])
}

/// Physics with a start, and where the run there ends.
const MOTIONS: [(&str, &str, &str, &str); 4] = [
    (
        "potential = { formula = \"x^2/2 - x*cos(2*t)/9\", force = { x = \"-0.2*x_dot - 0.1*x_dot^2\" } }\n\
         particle.law = \"newtonian\"",
        "t = 0.5, x = 1.0, x_dot = 0.3",
        "grid.t_f = 4.5",
        "grid.t_f = 0.5",
    ),
    (
        "potential = { formula = \"x^2/2\", force = { x = \"-0.1*x_dot\" }, one_form = { x = \"x/9\" } }\n\
         particle.c = 3.0",
        "t = 0.0, x = 0.5, t_dot = 1.1, x_dot = 0.3",
        "grid.gamma_i = 1.0\ngrid.gamma_f = 4.0",
        "grid.gamma_i = 4.0\ngrid.gamma_f = 1.0",
    ),
    (
        "metric = { coordinates = [\"t\", \"x\", \"y\"], components = { \"t t\" = \"4\", \"x x\" = \"-1\", \"y y\" = \
         \"-1\" }, one_form = { t = \"x^2/3\", y = \"x/2\" }, force = { x = \"-0.1*x_dot\", y = \"-0.1*y_dot^2\" } }",
        "t = 0.0, x = 0.5, y = 0.1, t_dot = 1.0, x_dot = 0.3, y_dot = 0.2",
        "grid.gamma_f = 3.0",
        "grid.gamma_i = 3.0\ngrid.gamma_f = 0.0",
    ),
    ("potential.quartic.kappa = 0.5", "t = 0.0, x = 1.0, t_dot = 1.0, x_dot = 0.1", "grid.t_f = 3.0", "grid.t_f = 0.0"),
];

#[test]
fn there_and_back_is_where_it_began() {
    for (physics, start, there, back) in MOTIONS {
        for scheme in &SCHEMES[..3] {
            let case_there = case(physics, start, there, scheme);
            let line: WorldLine = line_of(&case_there);
            assert!(!line.is_backward);
            let (begin, end) = (case_there.start::<f64>(), line.end());
            let names = case_there.coordinates();
            let state = names
                .iter()
                .enumerate()
                .filter(|(_, name)| *name != "s")
                .map(|(a, name)| format!("{name} = {:?}, {name}_dot = {:?}", end.q[a], end.q_dot[a]));
            let state: Vec<String> = state.collect();
            let case_back = case(physics, &state.join(", "), back, scheme);
            let line: WorldLine = line_of(&case_back);
            assert!(line.is_backward && line.gamma_f() < line.gamma_i);
            let back = line.end();
            for a in (0..names.len()).filter(|&a| names[a] != "s") {
                let off = (back.q[a] - begin.q[a]).abs().max((back.q_dot[a] - begin.q_dot[a]).abs());
                assert!(off < 2e-10, "{physics} {scheme} {}: {off:e}", names[a]);
            }
        }
    }
}

/// Every number of a run backward is that of the user: γ and t fall, and velocities and momenta are those of the
/// motion.
#[test]
fn numbers_are_those_of_the_motion() {
    let physics = "potential.formula = \"x^2/2\"\nparticle.law = \"newtonian\"\nevents.top.when = \"x_dot\"";
    for scheme in SCHEMES {
        let case = case(physics, "x = 1.0, x_dot = 0.0", "grid.t_f = -5.0", scheme);
        let line: WorldLine = line_of(&case);
        let end = line.end();
        let off = |found: f64, expected: f64| (found - expected).abs() < 1e-10;
        assert!(off(end.q[1], 5.0_f64.cos()) && off(end.q_dot[1], 5.0_f64.sin()) && off(end.q_dot[0], 1.0), "{end:?}");
        assert!(off(end.p[1], -(5.0_f64.sin())) && off(end.p[2], 1.0), "{scheme}: {end:?}");
        let gamma: Vec<f64> = line.gamma().collect();
        assert!(gamma[0] == 0.0 && gamma.is_sorted_by(|a, b| a >= b) && off(gamma[gamma.len() - 1], -5.0));
        let sample = Sampler::new(&line).at_gamma(-2.0).unwrap();
        assert!(off(sample.q[0], -2.0) && off(sample.q[1], 2.0_f64.cos()) && off(sample.q_dot[1], 2.0_f64.sin()));
        let met = crossings(&line, &mut case.watches());
        assert!(met.len() == 1 && off(met[0].sample.gamma, -std::f64::consts::PI), "{scheme}: {met:?}");
        // It may end where a formula says.
        let until = parsed(&case.to_toml(), &["grid.until=x_dot - 0.5"]);
        assert!((line_of::<f64>(&until).gamma_f() + std::f64::consts::FRAC_PI_6).abs() < 1e-9, "{scheme}");
    }
}
