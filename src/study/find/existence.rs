//! A proof that there is what a search has found: near its numbers there are some with which a motion meets all
//! conditions, not nearly but exactly; and no others.
//!
//! The unknowns are ū + r β with |β_k| ≤ 1, where ū are those that were found. One proof holds for the motions of all
//! these starts together, and says of the residuals R(β) = R̂ + L β ± E. With C ≈ L⁻¹ the map β − C R(β) is continuous,
//! and leads no further than
//!
//! ```text
//! t = |C R̂| + Σ_k |I − C L| + |C| E.
//! ```
//!
//! If that is below 1 it maps the cube into itself, and by Brouwer's theorem there is a β that it leaves where it is.
//! There R = 0, as C is regular where the second term is below 1 (R. Krawczyk, Computing 4 (1969) 187).
//!
//! Of two motions the proof says R(β) − R(β′) = L (β − β′) ± S max |β_k − β′_k|. Where
//!
//! ```text
//! Σ_k |I − C L| + |C| S < 1,
//! ```
//!
//! C (R(β) − R(β′)) is 0 for β = β′ alone, and the cube has only one such β.
//!
//! Starts and lengths have to be linear in the unknowns, as their formulas show.

use std::time::Instant;

use nalgebra::DMatrix;

use super::problem::Problem;
use crate::case::{Condition, Goal};
use crate::geometry::Jet;
use crate::number::ball::{Ball, OFF};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::proof::{Generator, Spread, prove};
use crate::study::proof::Starts;

/// The first cube is so many times the errors of what was found, and each further one so many times that one.
const ROOM: f64 = 8.0;
const LARGER: f64 = 32.0;
/// A smaller cube reaches so many times as far as what is proved.
const CLOSER: f64 = 1.5;
/// So many cubes are tried.
const MOST: usize = 6;
/// More than the roundings of a sum of few terms.
const UP: f64 = 1.0 + 1e-12;

/// What is proved: such numbers exist.
#[derive(Debug, Clone, PartialEq)]
pub struct Existence {
    /// Each unknown, with a bound of its distance from the true one.
    pub values: Vec<(Extended, f64)>,
    /// How far each unknown may be from the number that was found before there can be others, if that is proved.
    pub alone_within: Option<Vec<f64>>,
    /// The number of windows of the proof of the motions.
    pub windows: usize,
    /// The seconds that it took.
    pub seconds: f64,
}

/// Proves that near these values, which may be off by `errors`, there are some with which all conditions are met.
///
/// # Errors
/// The reason why there is no proof.
pub(super) fn exists(problem: &Problem, values: &[f64], errors: &[f64]) -> Result<Existence, String> {
    let begun = Instant::now();
    // Those that were found are the decimals of the case.
    let decimal = |value: &f64| Extended::from_decimal(&format!("{value:?}"));
    let middles = values.iter().map(|value| decimal(value).unwrap_or_else(|| Extended::from(*value)));
    let set = Set::new(problem, middles.collect())?;
    let least = |(value, error): (&f64, &f64)| ROOM * larger(*error, f64::EPSILON * value.abs());
    let mut radii: Vec<f64> = values.iter().zip(errors).map(least).collect();
    let mut reason = "the errors of what was found are not known".to_owned();
    for _ in 0..MOST {
        if !radii.iter().all(|radius| radius.is_finite() && *radius > 0.0) {
            break;
        }
        match set.proved(&radii) {
            Ok(existence) => {
                let existence = closer(problem, &existence).unwrap_or(existence);
                return Ok(Existence { seconds: begun.elapsed().as_secs_f64(), ..existence });
            }
            Err(none) if none.is_final => return Err(none.reason),
            Err(none) => reason = none.reason,
        }
        radii.iter_mut().for_each(|radius| *radius *= LARGER);
    }
    Err(reason)
}

/// The same from a smaller cube around what is proved, in which the motion is more nearly linear. Both cubes have one
/// solution each, and that of the larger one lies in the smaller one.
fn closer(problem: &Problem, found: &Existence) -> Option<Existence> {
    let (middles, radii): (Vec<Extended>, Vec<f64>) =
        found.values.iter().map(|(value, radius)| (*value, radius * CLOSER)).unzip();
    found.alone_within.as_ref()?;
    let next = Set::new(problem, middles).ok()?.proved(&radii).ok()?;
    next.alone_within.as_ref()?;
    let is_closer = next.values.iter().zip(&found.values).all(|(next, found)| next.1 < found.1);
    is_closer.then(|| Existence {
        alone_within: found.alone_within.clone(),
        windows: found.windows + next.windows,
        ..next
    })
}

/// Why a cube does not do.
struct None {
    reason: String,
    /// True if none does.
    is_final: bool,
}

/// The case with the numbers that were found.
struct Set<'p> {
    starts: Starts,
    conditions: &'p [Condition],
}

impl<'p> Set<'p> {
    fn new(problem: &'p Problem, middles: Vec<Extended>) -> Result<Self, String> {
        let Goal::Meet(conditions) = &problem.find.goal else {
            return Err(
                "a proof needs find.meet, with as many conditions as unknowns; x returns where x - start(x) is 0"
                    .to_owned(),
            );
        };
        let (many, unknowns) = (conditions.len(), &problem.find.unknowns);
        if many != unknowns.len() {
            return Err(format!("it needs as many conditions as unknowns: there are {many} for {}", unknowns.len()));
        }
        for unknown in unknowns {
            if unknown.is_in_equations && !unknown.key.starts_with("parameters.") {
                return Err(format!("{} is in the equations of motion, and no parameter", unknown.key));
            }
        }
        if conditions.iter().any(|condition| condition.uses("norm")) {
            return Err("norm depends on the start".to_owned());
        }
        let keys = unknowns.iter().map(|unknown| unknown.key.clone());
        let starts = Starts::new(problem.text.clone(), keys.collect(), middles)?;
        if starts.may_meet_events() {
            return Err("an event may end the run, or acts".to_owned());
        }
        Ok(Self { starts, conditions })
    }

    /// What is proved, but for its time, if the cube with these radii has a solution.
    fn proved(&self, radii: &[f64]) -> Result<Existence, None> {
        let starts = &self.starts;
        let generators = starts.generators(radii).map_err(|reason| None { reason, is_final: true })?;
        let geometry = starts.geometry(&generators).map_err(|reason| None { reason, is_final: true })?;
        let motion = starts.motion(&geometry, &generators);
        let proof = prove(&motion, &mut |_| true);
        if let Err(reason) = proof.end {
            return Err(None { reason: reason.to_string(), is_final: true });
        }
        let residuals = self.residuals(&proof.state, &generators);
        let none = |reason: &str| None { reason: reason.to_owned(), is_final: false };
        let too_large = || none("the errors of the motion are too large");
        let Solution { beta, is_alone } = Solution::new(&residuals, radii.len()).ok_or_else(too_large)?;
        let unknown = |j: usize| {
            let value = starts.middles[j] + Extended::from(radii[j]) * Extended::from(beta[j].0);
            (value, (radii[j] * beta[j].1 + OFF * value.abs().to_f64()) * UP)
        };
        Ok(Existence {
            values: (0..radii.len()).map(unknown).collect(),
            alone_within: is_alone.then(|| radii.to_vec()),
            windows: proof.windows,
            seconds: 0.0,
        })
    }

    /// The residuals over the cube.
    fn residuals(&self, end: &[Option<Spread>], generators: &[Generator]) -> Vec<Residual> {
        let Starts { case, setup, start, .. } = &self.starts;
        let (n, all) = (setup.place.start.q.len(), start.q.len());
        let own = |a: usize, values: &[Extended], of: fn(&Generator) -> &Vec<f64>| {
            let columns: Vec<f64> = generators.iter().map(|generator| of(generator)[a]).collect();
            let radius = f64::EPSILON * columns.iter().map(|column| column.abs()).sum::<f64>() * UP;
            Some(Spread { value: values[a], columns, radius, slack: radius })
        };
        let of_start = (0..n).map(|a| own(a, &start.q, |of| &of.q)).chain((0..n).map(|a| own(a, &start.p, |of| &of.p)));
        let parameters = (n..all).map(|a| own(a, &start.q, |of| &of.q));
        let is_known = |spread: &Spread| spread.columns.iter().all(|column| !column.is_nan());
        let end = [0, all].into_iter().flat_map(|first| end[first..first + n].iter().cloned());
        let states = end.chain(of_start).chain(parameters).map(|spread| spread.filter(is_known));
        let mut states: Vec<Option<Spread>> = states.collect();
        for first in [0, 2 * n] {
            for (a, spread) in states[first..first + n].iter_mut().enumerate() {
                spread.iter_mut().for_each(|spread| spread.value += setup.origin_of(a));
            }
        }
        let norm = setup.place.geometry.norm(&start.q, &start.q_dot);
        let jets = case.jets(self.conditions, norm);
        let ball = |spread: &Option<Spread>, with: fn(&Spread) -> f64| {
            spread.as_ref().map_or(Ball::UNKNOWN, |spread| Ball::of(spread.value, OFF).widened(with(spread)))
        };
        let centres: Vec<Ball> = states.iter().map(|spread| ball(spread, |_| 0.0)).collect();
        let boxes: Vec<Ball> = states.iter().map(|spread| ball(spread, Spread::reach)).collect();
        let all = jets.at(&centres).into_iter().zip(jets.at(&boxes));
        all.map(|(centre, over)| Residual::new(centre.value, &over, &states, generators.len())).collect()
    }
}

/// A residual over the cube: value + Σ β columns ± radius, and for two motions a difference that is off by slack.
struct Residual {
    value: f64,
    columns: Vec<f64>,
    radius: f64,
    slack: f64,
}

impl Residual {
    /// By the mean value: from the value in the middle, with gradients over the whole.
    fn new(value: Ball, over: &Jet, states: &[Option<Spread>], many: usize) -> Self {
        let (mut columns, mut radius) = (vec![0.0; many], value.lo.abs() + value.rad);
        let (mut size, mut slack, mut of_columns) = (value.hi.abs(), 0.0, 0.0);
        // Where it may jump, derivatives tell nothing of it, and it has no value over the whole.
        radius += if over.value.rad.is_finite() { 0.0 } else { f64::INFINITY };
        for (slope, spread) in over.gradient.iter().zip(states) {
            // It does not depend on this number.
            if slope.hi == 0.0 && slope.lo == 0.0 && slope.rad == 0.0 {
                continue;
            }
            let Some(spread) = spread else {
                (radius, slack) = (f64::INFINITY, f64::INFINITY);
                continue;
            };
            columns.iter_mut().zip(&spread.columns).for_each(|(sum, column)| *sum += slope.hi * column);
            radius += (slope.rad + slope.lo.abs()) * spread.reach() + slope.hi.abs() * spread.radius;
            size += slope.hi.abs() * spread.reach();
            let of_all: f64 = spread.columns.iter().map(|column| column.abs()).sum();
            slack += (slope.rad + slope.lo.abs()) * (of_all + spread.slack) * UP + slope.hi.abs() * spread.slack;
            of_columns += slope.hi.abs() * of_all;
        }
        slack += if radius.is_finite() { 0.0 } else { f64::INFINITY };
        // Sums of so many products.
        let rounding = (states.len() + 4) as f64 * f64::EPSILON;
        let slack = (slack + rounding * of_columns) * UP;
        Self { value: value.hi, columns, radius: (radius + rounding * size) * UP, slack }
    }
}

/// A fixed point of Krawczyk's map in the cube of starts, at which the conditions are met.
struct Solution {
    /// β with bounds of what it is off by.
    beta: Vec<(f64, f64)>,
    /// True if no other motion of the cube meets the conditions.
    is_alone: bool,
}

impl Solution {
    /// `None` if it is not known that the map leads into the cube.
    fn new(residuals: &[Residual], many: usize) -> Option<Self> {
        let l = DMatrix::from_fn(many, many, |i, j| residuals[i].columns[j]);
        let c = l.clone().try_inverse()?;
        let rows: Vec<Row> = (0..many).map(|i| Row::new(i, (&c, &l), residuals)).collect();
        let reaches: Vec<f64> =
            rows.iter().map(|row| (row.step.abs() + row.radius + row.left.iter().sum::<f64>()) * UP).collect();
        // Comparisons that are false for what is not a number.
        let is_inside = reaches.iter().all(|reach| *reach < 1.0);
        let is_alone = rows.iter().all(|row| (row.slack + row.left.iter().sum::<f64>()) * UP < 1.0);
        let bound = |row: &Row| {
            let of_others: f64 = row.left.iter().zip(&reaches).map(|(left, reach)| left * reach).sum();
            (row.step, (row.radius + of_others) * UP)
        };
        is_inside.then(|| Self { beta: rows.iter().map(bound).collect(), is_alone })
    }
}

/// A row of the map β − C R(β).
struct Row {
    /// −C R̂, and what that and the errors of R are off by.
    step: f64,
    radius: f64,
    /// |C| S.
    slack: f64,
    /// |I − C L|.
    left: Vec<f64>,
}

impl Row {
    fn new(i: usize, (c, l): (&DMatrix<f64>, &DMatrix<f64>), residuals: &[Residual]) -> Self {
        let many = residuals.len();
        let rounding = (2 * many + 4) as f64 * f64::EPSILON;
        let (mut step, mut size, mut of_errors, mut slack) = (0.0, 0.0, 0.0, 0.0);
        for (j, residual) in residuals.iter().enumerate() {
            step -= c[(i, j)] * residual.value;
            size += (c[(i, j)] * residual.value).abs();
            of_errors += c[(i, j)].abs() * residual.radius;
            slack += c[(i, j)].abs() * residual.slack;
        }
        let left = |k: usize| {
            let sum: f64 = (0..many).map(|j| c[(i, j)] * l[(j, k)]).sum();
            let room: f64 = (0..many).map(|j| (c[(i, j)] * l[(j, k)]).abs()).sum();
            (if i == k { 1.0 } else { 0.0 } - sum).abs() + rounding * (1.0 + room)
        };
        let radius = (of_errors + rounding * size) * UP;
        Self { step, radius, slack: slack * UP, left: (0..many).map(left).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::{Residual, Solution};

    fn residual(value: f64, column: f64, radius: f64, slack: f64) -> Residual {
        Residual { value, columns: vec![column], radius, slack }
    }

    /// R = R̂ + l β ± E leads into the cube up to |R̂| + E = l.
    #[test]
    fn a_solution_exists_as_far_as_the_map_leads_into_the_cube() {
        let exists = |radius: f64| Solution::new(&[residual(0.5, 2.0, radius, 0.0)], 1);
        let found = exists(1.499).unwrap();
        assert!(found.beta[0].0 == -0.25 && (0.7495..0.7496).contains(&found.beta[0].1), "{:?}", found.beta);
        assert!(exists(1.5).is_none() && exists(f64::INFINITY).is_none() && exists(f64::NAN).is_none());
    }

    /// Two zeros are as far apart as slack lets them be, where it is as large as l.
    #[test]
    fn a_solution_is_alone_as_far_as_differences_have_a_sign() {
        let is_alone = |slack: f64| Solution::new(&[residual(0.0, 2.0, 0.0, slack)], 1).unwrap().is_alone;
        assert!(is_alone(1.999) && !is_alone(2.0) && !is_alone(f64::INFINITY) && !is_alone(f64::NAN));
    }
}
