//! Motions beside which all others run away: what rounding makes of their starts and of their first steps is what they
//! are off by.

use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::proof::prove_run;
use geodesic_ivp::study::run::{NoRun, Wanted, run};

use crate::common::{end, parsed};

/// x and how much it is said to be off at most, of a run that is trusted.
fn trusted(text: &str, name: &str) -> Option<[f64; 2]> {
    let case = parsed(text, &[]);
    let setup = case.setup::<f64>();
    let run = match run(&case, &setup, Wanted::default()).0 {
        Ok(run) => run,
        Err(NoRun::Unsolved(..)) => return None,
        Err(none) => panic!("{none:?}"),
    };
    let judged = run.judged(&setup, false, false);
    let place = run.line.geometry().names().iter().position(|other| other == name).expect("it is a coordinate");
    let is_trusted = judged.verdict.grade == Grade::Trusted;
    is_trusted.then(|| [end(&run.line, name), judged.error.expect("it is known").at_most_at_end()[place]])
}

/// On the way to the top of V = −x²/2 a change grows like eᵗ, by up to 10⁹. Two marches from one start differ there by
/// less than they are both off, as often as not.
#[test]
fn on_the_way_to_a_top_rounding_is_part_of_the_error() {
    let number = |number: f64| <Extended as Real>::from_decimal(&format!("{number:?}")).expect("it is a number");
    let (mut told, mut all) = (0, 0);
    for k in 0..12_u32 {
        let x = [1.4, 0.9, 0.7, 1.3, 2.1, 0.37][k as usize % 6];
        let v = if k < 6 { -x } else { -x + 1e-7 * f64::from(k) };
        for (length, accuracy) in [(20.0, 1e-7), (20.0, 1e-9), (16.0, 1e-11), (11.87, 1e-13), (9.0, 1e-10)] {
            for scheme in [format!("solver.accuracy = {accuracy:e}"), format!("solver.tolerance = {accuracy:e}")] {
                let text = format!(
                    "particle.law = \"newtonian\"\npotential = {{ coordinates = [\"x\"], formula = \"-x^2/2\" }}\n\
                     initial = {{ x = {x:?}, x_dot = {v:?} }}\ngrid.t_f = {length:?}\n{scheme}"
                );
                all += 1;
                let Some([got, most]) = trusted(&text, "x") else { continue };
                told += 1;
                let (half, grown) = (Extended::from(0.5), <Extended as Real>::exp(number(length)));
                let exact = half * (number(x) + number(v)) * grown + half * (number(x) - number(v)) / grown;
                let off = (Extended::from(got) - exact).to_f64().abs();
                assert!(off <= most, "x = {x}, v = {v}, t = {length}, {scheme}: off by {off:e}, said {most:e}");
            }
        }
    }
    assert!(told > all / 4, "{told} of {all} are trusted");
}

/// Near the circular orbit of light r = 3M a change grows by up to 10⁸ here, and the momenta of the start, which its
/// velocities make, are rounded in both marches. A proof takes nothing from them. What is said of the error is an
/// estimate, from one direction of many: it may be too low by a factor, and is none of the accuracy.
#[test]
fn beside_the_orbit_of_light_a_proof_is_no_further_than_what_is_trusted() {
    let (mut told, mut all) = (0, 0);
    for k in 0..5_u32 {
        for accuracy in [1e-5, 1e-7, 1e-9, 1e-11] {
            let (r, length) = (15.3 - 0.7 * f64::from(k), 40.0 + 3.3 * f64::from(k));
            let phi_dot = 27.0_f64.sqrt() / (r * r);
            let text = format!(
                "metric.preset = \"schwarzschild\"\ninitial = {{ r = {r:?}, phi_dot = {phi_dot:?}, norm = \"null\", \
                 t_dot = {:?}, solve = {{ r_dot = \"-\" }} }}\ngrid.gamma_f = {length:?}\n\
                 solver.accuracy = {accuracy:e}",
                1.0 / (1.0 - 2.0 / r)
            );
            let case = parsed(&text, &[]);
            let setup = case.setup::<f64>();
            all += 1;
            let Ok(run) = run(&case, &setup, Wanted::default()).0 else { continue };
            let mut judged = run.judged(&setup, false, false);
            if judged.verdict.grade == Grade::Trusted {
                told += 1;
                let said = judged.error.as_ref().expect("it is known").at_most_at_end();
                prove_run(&case, &run, &mut judged, f64::INFINITY, &mut |_| true);
                for (end, said) in judged.proof.expect("it was asked for").ends.iter().zip(said) {
                    let off = end.run_off_by;
                    assert!(off <= 3.0 * said, "{r} {accuracy:e} {}: {off:e} of {said:e}", end.name);
                }
            }
        }
    }
    assert!(told > all / 4, "{told} of {all} are trusted");
}
