//! Motions that touch a place where a force jumps, or hardly pass it.

use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::run::{Wanted, run};

use crate::common::parsed;
use crate::random_scenes::random::Random;

/// A throw with a step of the force above a height `c`, where the body falls with g − `j`: x at a time behind.
fn exact([v, g, j, c, t]: [f64; 5]) -> f64 {
    let [v, g, j, c, t] = [v, g, j, c, t].map(Extended::from);
    let (two, square) = (Extended::from(2.0), v * v - Extended::from(2.0) * g * c);
    if square <= Extended::ZERO {
        return (v * t - g * t * t / two).to_f64();
    }
    let u = square.sqrt();
    let above = t - (v - u) / g;
    let behind = above - two * u / (g - j);
    if behind < Extended::ZERO {
        return (c + u * above - (g - j) * above * above / two).to_f64();
    }
    (c - u * behind - g * behind * behind / two).to_f64()
}

/// What turns so near to the step that its error decides whether it passes is not trusted, and all other throws are:
/// also those that pass it by little.
#[test]
fn a_throw_to_next_to_a_step_is_right_or_doubted() {
    let (mut random, mut trusted, mut doubted) = (Random(77), 0, 0);
    for draw in 0..240 {
        let mut drawn = |least: f64, most: f64| random.between(least, most);
        let [v, g] = [drawn(0.5, 2.0), drawn(0.5, 2.0)];
        let j = g * [drawn(-3.0, -0.2), drawn(0.2, 0.8)][draw % 2];
        let (digits, accuracy) = (drawn(1.0, 17.0), drawn(4.0, 12.0));
        let gap = 10.0_f64.powf(-digits) * [1.0, -1.0][draw / 2 % 2];
        let (c, t) = (v * v / (2.0 * g) * (1.0 + gap), 2.6 * v / g);
        let text = format!(
            "potential.coordinates = ['x']\npotential.formula = '0'\n\
             potential.force.x = '{:?} + {j:?}*step(x - {c:?})'\nparticle.law = 'newtonian'\n\
             initial = {{ x = 0.0, x_dot = {v:?} }}\ngrid.t_f = {t:?}\nsolver.accuracy = 1e-{accuracy}",
            -g
        );
        let text = text.replace(&format!("1e-{accuracy}"), &format!("{:e}", 10.0_f64.powf(-accuracy)));
        let case = parsed(&text, &[]);
        let setup = case.setup::<f64>();
        // It may be refused.
        let Ok(found) = run(&case, &setup, Wanted::default()).0 else { continue };
        let judged = found.judged(&setup, false, false);
        let off = (found.line.end().q[1] - exact([v, g, j, c, t])).abs();
        let is_trusted = judged.verdict.grade == Grade::Trusted;
        assert!(!is_trusted || off <= judged.error.as_ref().unwrap().at_most_at_end()[1], "{off:e}: {text}");
        let touches = judged.verdict.reasons.iter().any(|reason| reason.reason.contains("touches a place"));
        assert!(!touches || digits > accuracy - 1.0, "{:?}: {text}", judged.verdict.reasons);
        trusted += usize::from(is_trusted);
        doubted += usize::from(!is_trusted);
    }
    assert!(trusted > 60 && doubted > 60, "{trusted} {doubted}");
}
