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
    assert!((narrow.gamma - half).abs() < 1e-3 && narrow.share < 1e-5 && refused.gamma > 2.0 * half, "{refused}");
    assert!(refused.to_string().contains("the accuracy 1e-9 is not reached: at gamma = 3.3"), "{refused}");
    assert!(refused.advice().contains("conformal"));
    let line = run(PAST_A_MASS, &["potential.conformal=\"1/sqrt(x^2 + y^2)\""]).unwrap();
    assert!(line.error_estimate.unwrap() <= 1e-9);
}

/// A larger accuracy is kept, and a tolerance goes to the end; so a refusal says nothing that does not help.
#[test]
fn a_larger_accuracy_and_a_tolerance_help() {
    assert!(run(PAST_A_MASS, &["solver.accuracy=3e-6"]).unwrap().error_estimate.unwrap() <= 3e-6);
    assert!(run(&PAST_A_MASS.replace("accuracy", "tolerance"), &[]).is_ok());
}

/// An accuracy that is looser than what windows are made for may be used up by rounding.
#[test]
fn rounding_may_use_up_all_of_a_loose_accuracy() {
    let slow = ["initial.y_dot=2e-3", "solver.accuracy=1e-3"];
    let estimate = run(PAST_A_MASS, &slow).unwrap().error_estimate.unwrap();
    assert!(estimate > 1e-4 && estimate <= 1e-3, "{estimate:e}");
}
