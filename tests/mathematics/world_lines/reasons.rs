//! The printed reason is the reason, and what is advised helps.

use geodesic_ivp::solve::{NoSolution, WorldLine, solve};

use crate::common::parsed;

/// A fall past a mass at a distance of 5e-5, over two turns.
const PAST_A_MASS: &str = "potential = { coordinates = [\"x\", \"y\"], formula = \"-1/sqrt(x^2 + y^2)\" }\n\
                           particle.law = \"newtonian\"\n\
                           initial = { x = 1.0, y = 0.0, x_dot = 0.0, y_dot = 1e-2 }\n\
                           grid.t_f = 20.0\nsolver.accuracy = 1e-9\n";

fn run(text: &str, set: &[&str]) -> Result<WorldLine, NoSolution> {
    solve(&parsed(text, set))
}

/// A refusal long after a close encounter names the encounter, and a conformal factor that grows there as the force
/// does keeps the accuracy.
#[test]
fn a_close_encounter_is_named_and_a_conformal_factor_helps() {
    let refused = run(PAST_A_MASS, &[]).unwrap_err();
    let narrow = refused.reasons.narrow.clone().unwrap();
    // The first passage of the mass is after half a period of a fall from rest.
    let half = std::f64::consts::PI / 8.0_f64.sqrt();
    assert!((narrow.gamma - half).abs() < 1e-3 && narrow.share < 1e-5 && refused.gamma > 1.4 * half, "{refused}");
    assert!(refused.to_string().contains("the accuracy 1e-9 is not reached: from gamma = "), "{refused}");
    assert!(refused.advice().contains("conformal"));
    let line = run(PAST_A_MASS, &["potential.conformal=\"1/sqrt(x^2 + y^2)\""]).unwrap();
    assert!(line.error_estimate.unwrap() <= 1e-9);
}

/// A larger accuracy is kept, and a tolerance goes to the end; so a refusal says nothing that does not help.
#[test]
fn a_larger_accuracy_and_a_tolerance_help() {
    assert!(run(PAST_A_MASS, &["solver.accuracy=1e-4"]).unwrap().error_estimate.unwrap() <= 1e-4);
    assert!(run(&PAST_A_MASS.replace("accuracy", "tolerance"), &[]).is_ok());
}

/// A force of time that is known from 0 to 10, or as its tangent beyond.
fn of_a_table(outside: &str) -> String {
    let points =
        |of: &dyn Fn(f64) -> f64| (0..=100).map(|k| format!("{:?}", of(f64::from(k) / 10.0))).collect::<Vec<_>>();
    let (x, y) = (points(&|t| t).join(", "), points(&|t| (3.0 * t).sin()).join(", "));
    format!(
        "potential = {{ coordinates = [\"x\"], formula = \"x^2/2\", force = {{ x = \"F(t)\" }} }}\n\
         particle.law = \"newtonian\"\ninitial = {{ x = 0.0, x_dot = 0.0 }}\n\
         tables.F = {{ x = [{x}], y = [{y}]{outside} }}\ngrid.t_f = 10.0\nsolver.accuracy = 1e-8\n"
    )
}

/// The exact motion is (3 sin t − sin 3t)/8 but for the spline.
#[test]
fn a_run_may_end_where_a_table_ends() {
    let exact = |t: f64| (3.0 * t.sin() - (3.0 * t).sin()) / 8.0;
    let grids = ["solver.accuracy=1e-8", "solver.tolerance=1e-9", "grid={ gamma_f = 10.0 }"];
    for set in grids {
        let line = run(&of_a_table(""), &[set]).unwrap_or_else(|none| panic!("{set}: {none}"));
        let end = line.end();
        assert_eq!(end.q[0], 10.0, "{set}");
        assert!((end.q[1] - exact(10.0)).abs() < 1e-3, "{set}: {}", end.q[1]);
        assert_eq!(line.windows_unproved, Some(0), "{set}");
    }
    let longer = run(&of_a_table(", outside = \"linear\""), &[]).unwrap().end().q[1];
    assert!((run(&of_a_table(""), &[]).unwrap().end().q[1] - longer).abs() < 1e-9);
}

/// What is off the end of a table is called so, and what is advised helps.
#[test]
fn a_table_that_ends_is_named() {
    let given = ["scheme={ sbp = \"SBP42\", form = \"weak\" }", "grid={ gamma_f = 10.5, n_gamma = 400 }"];
    for set in [&["grid.t_f=10.5"][..], &["grid={ gamma_f = 10.5 }"], &given] {
        let of_a_table = |outside: &str| {
            let text = of_a_table(outside);
            if set == given { text.replace("solver.accuracy = 1e-8\n", "") } else { text }
        };
        let refused = run(&of_a_table(""), set).unwrap_err();
        let message = refused.to_string();
        assert!(message.contains("the table 'F' goes from 0 to 10"), "{message}");
        assert!(refused.advice().contains("outside = \"linear\""), "{}", refused.advice());
        assert!(run(&of_a_table(", outside = \"linear\""), set).is_ok());
    }
}

/// A body that stands at rest is at no encounter and at no pole, whatever windows do there.
#[test]
fn rest_is_no_encounter() {
    let arm = "grid.t_f = 5.0\nsolver.accuracy = 1e-8\n\
               initial = { t_dot = 1.0, a = \"pi/2\", b = 0.0, a_dot = 0.0, b_dot = 0.0, norm = \"null\", \
               solve = { s_dot = \"+\" } }\n[metric]\ncoordinates = [\"t\", \"a\", \"b\", \"s\"]\n\
               components = { \"t t\" = \"-2*V\", \"t s\" = \"1\", \"a a\" = \"M\", \"a b\" = \"N\", \
               \"b b\" = \"0.1725\" }\n\
               [metric.definitions]\nM = \"0.595 + 0.25*cos(b)\"\nN = \"0.1725 + 0.125*cos(b)\"\n\
               V = \"9.81*(0.75*sin(a) + 0.25*sin(a + b))\"\n";
    if let Err(refused) = run(arm, &[]) {
        assert!(refused.reasons.narrow.is_none(), "{refused}");
    }
}

/// The sign of a root is of no matter where there is only one.
#[test]
fn one_root_has_either_sign() {
    for sign in ["+", "-"] {
        let text = format!(
            "grid.t_f = 1.0\nsolver.accuracy = 1e-8\ninitial = {{ t_dot = 1.0, x = 1.0, x_dot = 0.0, norm = \"null\", \
             solve = {{ s_dot = \"{sign}\" }} }}\n[metric]\ncoordinates = [\"t\", \"x\", \"s\"]\n\
             components = {{ \"t t\" = \"x^2\", \"t s\" = \"1\", \"x x\" = \"-1\" }}\n"
        );
        assert!((run(&text, &[]).unwrap().end().q[1] - 1.0_f64.cos()).abs() < 1e-8);
    }
}

/// A robot arm of two links that stands upright at rest: the small angle has nothing but rounding to begin with, and
/// grows by exp(7.8 t).
fn upright(a: &str, settings: &[&str]) -> Result<WorldLine, NoSolution> {
    let text = format!(
        "initial = {{ t_dot = 1.0, a = {a}, b = 0.0, a_dot = 0.0, b_dot = 0.0, norm = \"null\", \
         solve = {{ s_dot = \"+\" }} }}\ngrid.t_f = 3.0\nsolver.accuracy = 1e-6\n[metric]\n\
         coordinates = [\"t\", \"a\", \"b\", \"s\"]\n\
         components = {{ \"t t\" = \"-2*V\", \"t s\" = \"1\", \"a a\" = \"M11\", \"a b\" = \"M12\", \
         \"b b\" = \"I + a2^2\" }}\n\
         parameters = {{ I = 0.11, a1 = 0.25, a2 = 0.25, l = 0.5, g = 9.81 }}\n[metric.definitions]\n\
         M11 = \"a1^2 + I + a2^2 + l^2 + 2*a2*l*cos(b) + I\"\nM12 = \"I + a2^2 + a2*l*cos(b)\"\n\
         V = \"g*(a1*sin(a) + l*sin(a) + a2*sin(a + b))\"\n"
    );
    solve(&parsed(&text, settings))
}

/// What only rounding moves is named; beside that start the motion follows from it, and before it grows nothing is
/// wrong with rest.
#[test]
fn an_unstable_rest_is_named_and_a_start_beside_it_helps() {
    let failure = upright("\"pi/2\"", &["solver.accuracy=1e-8"]).unwrap_err();
    assert_eq!(failure.reasons.of_rounding.last().map(String::as_str), Some("b"), "{failure}");
    let advice = failure.advice();
    assert!(failure.to_string().contains("rounding alone moves") && advice.contains("solver.floor"), "{failure}");
    let beside = upright("1.5707963", &[]).unwrap();
    assert!((beside.end().q[1] - 1.516_936_100_854_8).abs() < 1e-5, "{:?}", beside.end());
    assert!(upright("\"pi/2\"", &["grid.t_f=0.5", "solver.floor={a=1e-3,b=1e-3}"]).is_ok());
}
