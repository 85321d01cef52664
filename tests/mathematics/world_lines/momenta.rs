//! With Newton's law a user reads and writes the momenta of mechanics, p = m v + A.

use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::geometry::Start;
use geodesic_ivp::study::run::{Run, Wanted, run};

use crate::common::{distance, parsed};

/// Two coordinates with masses of their own, and a one-form.
const TURNING: &str = r#"
particle = { law = "newtonian", masses = { x = 2.0, y = 3.0 } }
grid.t_f = 5.0
solver.accuracy = 1e-11
[potential]
coordinates = ["x", "y"]
formula = "x^2/2 + y^2 + x*y/3"
one_form = { x = "-y/2", y = "x/4" }
"#;
const BY_VELOCITIES: &str = "initial={ x = 1.0, y = 0.5, x_dot = 0.5, y_dot = -0.25 }";

/// Two bodies that pull at each other, and a third coordinate that nothing acts on.
const FREE: &str = r#"
particle = { law = "newtonian", masses = { x = 2.0, y = 3.0, z = 4.0 } }
initial = { x = 1.0, y = 0.5, z = 0.0, x_dot = 0.5, y_dot = 0.25, z_dot = 1.5 }
grid.t_f = 5.0
solver.accuracy = 1e-11
[potential]
coordinates = ["x", "y", "z"]
formula = "(x - y)^2/2"
"#;

fn start(text: &str, set: &[&str]) -> Start {
    parsed(text, set).start()
}

fn solved(text: &str, set: &[&str]) -> Run {
    let case = parsed(text, set);
    let setup = case.setup();
    let all = Wanted { sums: true, ..Wanted::default() };
    run(&case, &setup, all).0.unwrap_or_else(|error| panic!("{error:?}"))
}

#[test]
fn a_momentum_at_the_start_is_that_of_mechanics() {
    let velocities = start(TURNING, &[BY_VELOCITIES]);
    for momenta in ["x_dot = 0.5, p_y = \"3*(-0.25) + 1.0/4\"", "p_x = \"2*0.5 - 0.5/2\", p_y = -0.5"] {
        let found = start(TURNING, &[&format!("initial={{ x = 1.0, y = 0.5, {momenta} }}")]);
        assert!(distance(&found.q_dot, &velocities.q_dot) < 1e-15, "{momenta}: {found:?}");
    }
    // A momentum from the energy: its larger root moves to the right.
    let energy = velocities.p[0];
    let solve =
        format!("initial={{ x = 1.0, y = 0.5, y_dot = -0.25, p_t = {energy:?}, norm = 0, solve = {{ p_x = \"+\" }} }}");
    assert!(distance(&start(TURNING, &[&solve]).q_dot, &velocities.q_dot) < 1e-12);
}

#[test]
fn formulas_have_the_momenta_of_mechanics() {
    let zero = "invariants={ x = \"p_x - 2*x_dot + y/2\", y = \"p_y - 3*y_dot - x/4\" }";
    let run = solved(TURNING, &[BY_VELOCITIES, zero]);
    for (name, found) in &run.diagnostics.invariants {
        assert!(found.value.abs() < 1e-15 && found.max_interior < 1e-14, "{name}: {found:?}");
    }
}

#[test]
fn charges_and_sums_are_those_of_mechanics() {
    let run = solved(FREE, &[]);
    let names = run.line.geometry().names().to_vec();
    let charge = |name: &str| {
        let found = run.diagnostics.charges.iter().find(|charge| names[charge.terms[0].0] == name);
        found.unwrap_or_else(|| panic!("{name} has no charge")).value
    };
    let energy = (2.0 * 0.25 + 3.0 * 0.0625 + 4.0 * 2.25) / 2.0 + 0.125;
    assert!((charge("z") - 6.0).abs() < 1e-15 && (charge("t") - energy).abs() < 1e-14 && charge("s") == 1.0);
    let [sum] = &run.sums[..] else { panic!("{:?}", run.sums) };
    assert_eq!(sum.formula(&names), "p_x + p_y");
    assert!((run.diagnostics.sums[0].value - 1.75).abs() < 1e-14, "{:?}", run.diagnostics.sums[0]);
}

/// What moves with a wall at the speed u keeps p_x u − E: the sign of the momentum shows.
#[test]
fn a_sum_with_the_energy_has_the_momentum_of_mechanics() {
    let text = "particle = { law = \"newtonian\", mass = 2.0 }\n\
                potential = { coordinates = [\"x\"], formula = \"(x - t/2)^2\" }\n\
                initial = { x = 1.0, x_dot = 0.5 }\ngrid.t_f = 5.0\nsolver.accuracy = 1e-11\n";
    let run = solved(text, &[]);
    let names = run.line.geometry().names().to_vec();
    let [sum] = &run.sums[..] else { panic!("{:?}", run.sums) };
    assert_eq!(sum.formula(&names), "p_t - 0.5*p_x");
    assert!((run.diagnostics.sums[0].value - (0.25 + 1.0 - 0.5)).abs() < 1e-14);
}

/// In the relativistic law, as in the paper, they are those of the metric.
#[test]
fn momenta_of_the_relativistic_law_are_those_of_the_metric() {
    let text = "potential = { coordinates = [\"x\"], formula = \"0*x\" }\n\
                initial = { x = 0.0, t_dot = 1.0, x_dot = 0.5 }\ngrid.gamma_f = 1.0\nsolver.accuracy = 1e-11\n";
    let run = solved(text, &[]);
    assert_eq!(Diagnostics::new(&run.line).charges.iter().map(|charge| charge.value).collect::<Vec<_>>(), [1.0, -0.5]);
}

/// A run on a given grid that ends where a force sets in: its last slope has all of the force, and its last momentum is
/// off by far more than its place is.
#[test]
fn the_error_of_a_momentum_is_found_where_a_run_ends_at_a_jump() {
    let text = "potential = { formula = \"x^2/2\", force = { x = \"0.5*step(t - 2)\" } }\n\
                particle.law = \"newtonian\"\n\
                initial = { x = 1.0, x_dot = 0.0 }\ngrid = { t_f = 2.0, n_gamma = 16, windows = 8 }\n\
                scheme = { sbp = \"GLL16\", form = \"weak\" }\n";
    let case = parsed(text, &[]);
    let setup = case.setup();
    let run: Run = run(&case, &setup, Wanted::default()).0.unwrap();
    let (end, left): (Start, _) = (run.line.end(), run.judged(&setup, false, false).left.unwrap());
    let off = [(end.q[1] - 2.0_f64.cos()).abs(), (end.p[1].abs() - 2.0_f64.sin()).abs()];
    assert!(off[1] > 1e-5 && off[1] > 10.0 * off[0], "{off:?}");
    assert!(left.p[1].abs() >= off[1] - 1e-12 && left.p[1].abs() < 3.0 * off[1], "{off:?} {left:?}");
}
