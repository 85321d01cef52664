//! Random potentials of one coordinate, solved to a random accuracy and compared with other integrators.

use std::fmt;
use std::sync::Arc;

use geodesic_ivp::case::{Case, End};
use geodesic_ivp::trajectory::Sampler;
use geodesic_ivp::{Solution, solve};

use super::outcome::Outcome;
use super::random::Random;
use super::rough::{one_coordinate, rough};
use super::truth::Truth;

/// The others are believed if they are apart by no more than this share of the accuracy, and by what rounding may do.
const AGREED: f64 = 0.1;
const ROUNDING: f64 = 1e-13;

/// A case to solve, and how well.
pub(crate) struct Scene {
    pub(crate) kind: &'static str,
    text: String,
    accuracy: f64,
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, accuracy {:e}:\n{}", self.kind, self.accuracy, self.text)
    }
}

/// Smooth potentials, each with x at the start.
const SMOOTH: [(&str, f64); 4] =
    [("x^4/2", 1.0), ("0.1*(1 - cos(x))", 1.0), ("0.3*(1 - exp(-x))^2", 0.8), ("0.1*(x^2 - 1)^2", 0.4)];

impl Scene {
    /// Smooth, to a time.
    pub(crate) fn smooth(random: &mut Random) -> Self {
        let (formula, x) = SMOOTH[random.next() as usize % SMOOTH.len()];
        let (start, t_f) = ([x, 1.0, random.between(-0.2, 0.2)], random.between(0.05, 3.0));
        Self::new("smooth, t_f", one_coordinate(formula, 1.0, start, ("t_f", t_f)), random.scale(1e-12, 1e-6))
    }

    /// With something in it that is no polynomial on a window.
    pub(crate) fn rough(random: &mut Random) -> Self {
        let (kind, text) = rough(random, 1e-4, |random| [1.0, random.scale(0.15, 1.0)]);
        Self::new(kind, text, random.scale(1e-12, 1e-4))
    }

    fn new(kind: &'static str, text: String, accuracy: f64) -> Self {
        Self { kind, text: format!("{text}[solver]\naccuracy = {accuracy:e}\n"), accuracy }
    }

    /// Solves and compares, at the nodes and half way between them.
    pub(crate) fn run(&self) -> Outcome {
        let accuracy = self.accuracy;
        let case = Case::parse(self.kind, &self.text, &[]).unwrap_or_else(|error| panic!("{self}\n{error}"));
        let solved: Result<Solution, _> = solve(&case);
        let length = match (&solved, case.end()) {
            (Ok(solution), _) => solution.length,
            (Err(_), End::Length(length)) => length,
            (Err(failure), End::Duration(_)) => return Outcome::Refused(failure.to_string()),
        };
        let truth = Truth::new(&Arc::new(case.geometry()), &case.start(), length);
        let Some(exact) = truth.filter(|truth| truth.apart <= AGREED * accuracy + ROUNDING) else {
            return Outcome::NoReference;
        };
        let solution = match solved {
            Ok(solution) => solution,
            Err(failure) => return Outcome::Refused(failure.to_string()),
        };
        let mut errors = [0.0_f64; 2];
        let mut see = |gamma: f64, q: [f64; 2]| {
            for (a, (found, exact)) in q.into_iter().zip(exact.at(gamma)).enumerate() {
                errors[a] = errors[a].max((found - exact).abs());
            }
        };
        let gammas: Vec<f64> = solution.gamma().collect();
        let nodes = gammas.iter().zip(solution.t().zip(solution.x()));
        nodes.for_each(|(&gamma, (t, &x))| see(gamma, [t, x]));
        let mut sampler = Sampler::new(&solution);
        for pair in gammas.windows(2) {
            let sample = sampler.at_gamma(0.5 * (pair[0] + pair[1])).expect("inside the run");
            see(sample.gamma, [sample.q[0], sample.q[1]]);
        }
        if let End::Duration(duration) = case.end::<f64>() {
            let end = solution.end_state();
            if end.t.to_bits() != duration.to_bits() {
                return Outcome::Refused(format!("t ends at {}", end.t));
            }
            // x where the exact t is the one asked for.
            let there = exact.at(length);
            let velocity = end.x_dot * solution.geometry().g00(&[0.0, end.x]).unwrap_or(f64::NAN) / end.q_t;
            errors[1] = errors[1].max((end.x - (there[1] + velocity * (duration - there[0]))).abs());
        }
        let [t, x] = [0, 1].map(|a| (errors[a] - exact.uncertain[a]) / solution.sizes[a]);
        let error = t.max(x);
        let estimate = solution.error_estimate.expect("it has one");
        match error {
            error if error > accuracy => Outcome::Broken { error, estimate },
            error if error > estimate => Outcome::TooLow { error, estimate },
            _ => Outcome::Kept { error, estimate },
        }
    }
}
