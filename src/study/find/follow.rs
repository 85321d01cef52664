//! A family of what a search finds: it is followed in one more number of the case, around folds as well.
//!
//! The unknowns and that number together have one direction in which all residuals stay 0, the tangent of the family. A
//! step goes along it, and Newton's method comes back to the family at right angles to the tangent (H. B. Keller, in
//! Applications of Bifurcation Theory, 1977, p. 359). Where the number that is followed turns back the family has a
//! fold, at which nothing special happens to such steps. Lengths count every unknown relative to its largest value so
//! far, or to 1, and the followed number relative to its range.

use nalgebra::DMatrix;

use super::jacobian::Jacobian;
use super::least_squares::PseudoInverse;
use super::multipliers::Multipliers;
use super::newton::{Converged, search};
use super::problem::{Evaluation, Problem};
use super::{NotFound, norm};
use crate::case::{Case, Find, Goal};
use crate::number::norm::larger;

/// The first step, and the longest and the shortest one.
const FIRST: f64 = 0.02;
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 1e-6;
/// Steps grow where Newton's method needs no more iterations than this, and are halved where it needs more than that.
const FEW: usize = 3;
const MANY: usize = 6;
/// The tangent turns by no more than this, in radians, from a member to the next.
const TURN: f64 = 0.1;
/// A family has at most so many members.
const MOST: usize = 2000;
/// A fold is looked for in so many steps.
const MOST_AT_FOLD: usize = 12;

/// A member of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// The unknowns, and last the number that is followed.
    pub values: Vec<f64>,
    /// By how much each unknown may be off.
    pub errors: Vec<f64>,
    /// The root of the sum of squares of the residuals.
    pub residual: f64,
    /// The rate of the followed number along the family, between −1 and 1; 0 at a fold.
    pub slope: f64,
    /// True at a fold.
    pub is_fold: bool,
    /// The multipliers of a motion that returns.
    pub multipliers: Option<Multipliers>,
}

/// The reason why a family was followed no further.
#[derive(Debug, Clone, PartialEq)]
pub enum Ended {
    /// The followed number has reached the end of its range.
    AtEnd,
    /// It has come back to where it began.
    Back,
    /// Something else.
    Stopped(String),
}

/// A family, from its start on.
#[derive(Debug, Clone, PartialEq)]
pub struct Family {
    /// The members.
    pub members: Vec<Member>,
    /// The reason of its end.
    pub ended: Ended,
}

/// Follows what `wanted` says of `case`, whose last unknown is the number that is followed, from its value in the case
/// until `to`. `tell` hears of every member.
///
/// # Errors
/// [`NotFound`], if there is no first member.
pub fn follow(case: &Case, wanted: &Find, to: f64, tell: &mut dyn FnMut(&Member)) -> Result<Family, NotFound> {
    let mut first = wanted.clone();
    let from = first.unknowns.pop().expect("there is a number to follow").value;
    let Converged { here, errors, .. } = search(&Problem::new(case, &first), &mut |_| {})?;
    let values: Vec<f64> = here.values.into_iter().chain([from]).collect();
    let problem = Problem::followed(case, wanted, &values, (to - from).abs());
    let at_start = |reason: String| NotFound::on_the_way(&reason, "begin elsewhere in the family");
    let here = Point::new(&problem, &values).map_err(at_start)?;
    let here = Point { errors: errors.into_iter().chain([0.0]).collect(), ..here };
    let goal = vec![0.0; values.len() - 1].into_iter().chain([(to - from).signum()]).collect::<Vec<_>>();
    let mut walk = Walk { problem, range: [from, to], tangent: goal, here, members: Vec::new(), has_turned: false };
    walk.tangent = walk.turned(&walk.here).map_err(at_start)?;
    walk.keep(false, tell);
    let ended = walk.finish(tell);
    Ok(Family { members: walk.members, ended })
}

/// A point of a family with the derivatives there.
struct Point {
    here: Evaluation,
    jacobian: Jacobian,
    errors: Vec<f64>,
}

impl Point {
    fn new(problem: &Problem, values: &[f64]) -> Result<Self, String> {
        let here = problem.evaluate(values, true).map_err(|none| none.message)?;
        let jacobian = Jacobian::new(problem, &here).map_err(|none| none.message)?;
        Ok(Self { errors: vec![0.0; values.len()], here, jacobian })
    }
}

/// A family on its way.
struct Walk {
    problem: Problem,
    /// The first and the last value of the followed number.
    range: [f64; 2],
    /// The unit tangent, in scaled numbers.
    tangent: Vec<f64>,
    here: Point,
    members: Vec<Member>,
    /// True once the followed number has turned back.
    has_turned: bool,
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

impl Walk {
    /// The tangent at a point, on the same side as the one before.
    fn turned(&self, Point { here, jacobian, .. }: &Point) -> Result<Vec<f64>, String> {
        let (matrix, scales, n) = (&jacobian.matrix, &self.problem.scales, self.problem.scales.len());
        let rows = matrix.nrows().max(n);
        let row_size = |i: usize| (0..n).map(|j| (matrix[(i, j)] * scales[j]).powi(2)).sum::<f64>().sqrt();
        let sizes: Vec<f64> = (0..matrix.nrows()).map(row_size).collect();
        // What is met all along the family, whatever the unknowns are, has a row of errors.
        let least = |i: usize| here.errors[i] * jacobian.most_of_errors;
        let entry = |i: usize, j: usize| match sizes.get(i) {
            Some(size) if *size > least(i) => matrix[(i, j)] * scales[j] / size,
            _ => 0.0,
        };
        let svd = DMatrix::from_fn(rows, n, entry).svd(false, true);
        let v_t = svd.v_t.expect("it was asked for");
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]));
        let most = svd.singular_values.max();
        if n > 1 && svd.singular_values[order[1]] <= larger(jacobian.share, here.noise) * most {
            return Err("what is to be met leaves more than one direction free".to_owned());
        }
        let tangent: Vec<f64> = v_t.row(order[0]).iter().copied().collect();
        let side = dot(&tangent, &self.tangent).signum();
        Ok(tangent.into_iter().map(|part| side * part).collect())
    }

    /// The point of the family in the plane across `normal` through the place `at`, and the number of iterations.
    fn corrected(&self, at: Vec<f64>, normal: &[f64]) -> Result<(Point, usize), String> {
        let (problem, n) = (&self.problem, at.len());
        let mut point = Point::new(problem, &at)?;
        for iteration in 1..=2 * MANY {
            let Point { here, jacobian, .. } = &point;
            let rows = jacobian.matrix.nrows();
            let matrix = DMatrix::from_fn(rows + 1, n, |i, j| {
                if i < rows { jacobian.matrix[(i, j)] } else { normal[j] / problem.scales[j] }
            });
            let inverse = PseudoInverse::new(&matrix, &problem.scales, jacobian.share);
            let away = (0..n).map(|j| normal[j] * (here.values[j] - at[j]) / problem.scales[j]).sum::<f64>();
            let step = inverse.times(&[here.residuals.as_slice(), &[away]].concat());
            let rounded = here.values.iter().map(|value| f64::EPSILON * value.abs());
            let errors = inverse.at_most(&[here.errors.as_slice(), &[0.0]].concat());
            let errors: Vec<f64> = errors.into_iter().zip(rounded).map(|(error, rounded)| error + rounded).collect();
            if step.iter().zip(&errors).all(|(step, error)| step.abs() <= *error) {
                point.errors = errors.iter().zip(&step).map(|(error, step)| error + step.abs()).collect();
                return Ok((point, iteration));
            }
            let values: Vec<f64> = here.values.iter().zip(&step).map(|(value, step)| value - step).collect();
            point = Point::new(problem, &values)?;
        }
        Err("Newton's method does not come back to the family".to_owned())
    }

    /// The place a step along the tangent away.
    fn ahead(&self, step: f64) -> Vec<f64> {
        let Self { problem, tangent, here, .. } = self;
        let each = here.here.values.iter().zip(tangent).zip(&problem.scales);
        each.map(|((value, part), scale)| value + step * part * scale).collect()
    }

    /// Goes on to a point.
    fn go(&mut self, point: Point, tangent: Vec<f64>, is_fold: bool, tell: &mut dyn FnMut(&Member)) {
        (self.here, self.tangent) = (point, tangent);
        self.keep(is_fold, tell);
        // What has become larger counts less, so that steps are a part of it.
        let last = self.problem.scales.len() - 1;
        let values = self.here.here.values[..last].iter();
        let is_larger = values.clone().zip(&self.problem.scales).any(|(value, scale)| value.abs() > *scale);
        self.problem.scales.iter_mut().zip(values).for_each(|(scale, value)| *scale = larger(*scale, value.abs()));
        if is_larger && let Ok(tangent) = self.turned(&self.here) {
            self.tangent = tangent;
        }
    }

    fn keep(&mut self, is_fold: bool, tell: &mut dyn FnMut(&Member)) {
        let Evaluation { values, residuals, run, .. } = &self.here.here;
        let is_periodic = self.problem.find.goal == Goal::Periodic;
        self.members.push(Member {
            values: values.clone(),
            errors: self.here.errors.clone(),
            residual: norm(residuals),
            slope: self.tangent[values.len() - 1],
            is_fold,
            multipliers: if is_periodic { Multipliers::new(&run.line) } else { None },
        });
        tell(&self.members[self.members.len() - 1]);
    }

    fn finish(&mut self, tell: &mut dyn FnMut(&Member)) -> Ended {
        let (mut step, last) = (FIRST, self.tangent.len() - 1);
        while self.members.len() < MOST {
            match self.stepped(step) {
                Ok((point, tangent, iterations)) => {
                    let at = point.here.values[last];
                    if let Some(end) = self.passed(at) {
                        return self.landed(end, tell);
                    }
                    if tangent[last] * self.tangent[last] < 0.0 {
                        self.has_turned = true;
                        if let Some((fold, tangent)) = self.fold(step) {
                            self.go(fold, tangent, true, tell);
                        }
                    }
                    self.go(point, tangent, false, tell);
                    let factor = if iterations <= FEW { 1.5 } else { 1.0 };
                    step = (factor * step).min(LONGEST);
                }
                Err(reason) => {
                    step *= 0.5;
                    if step < SHORTEST {
                        return Ended::Stopped(reason);
                    }
                }
            }
        }
        Ended::Stopped(format!("it has {MOST} members"))
    }

    /// The next point, its tangent and the iterations to it, a step of this length away.
    fn stepped(&self, step: f64) -> Result<(Point, Vec<f64>, usize), String> {
        let (point, iterations) = self.corrected(self.ahead(step), &self.tangent)?;
        if iterations > MANY {
            return Err("Newton's method converges too slowly".to_owned());
        }
        let tangent = self.turned(&point)?;
        // Comparisons that are false for what is not a number.
        let is_near = dot(&tangent, &self.tangent) >= TURN.cos();
        if is_near { Ok((point, tangent, iterations)) } else { Err("the family turns too sharply".to_owned()) }
    }

    /// The end of the range that a value of the followed number is beyond, if it is.
    fn passed(&self, at: f64) -> Option<f64> {
        let [from, to] = self.range;
        let way = (to - from).signum();
        let is_back = self.has_turned && (at - from) * way <= 0.0;
        if (at - to) * way >= 0.0 { Some(to) } else { is_back.then_some(from) }
    }

    /// The member at the end of the range.
    fn landed(&mut self, end: f64, tell: &mut dyn FnMut(&Member)) -> Ended {
        let last = self.tangent.len() - 1;
        let step = (end - self.here.here.values[last]) / (self.problem.scales[last] * self.tangent[last]);
        let mut at = self.ahead(step);
        at[last] = end;
        let across: Vec<f64> = (0..=last).map(|j| if j == last { 1.0 } else { 0.0 }).collect();
        let landed = self.corrected(at, &across).and_then(|(point, _)| Ok((self.turned(&point)?, point)));
        match landed {
            Ok((tangent, point)) => self.go(point, tangent, false, tell),
            Err(reason) => return Ended::Stopped(reason),
        }
        if end == self.range[1] { Ended::AtEnd } else { Ended::Back }
    }

    /// The fold within a step: where the followed number has no rate along the family.
    fn fold(&self, step: f64) -> Option<(Point, Vec<f64>)> {
        let last = self.tangent.len() - 1;
        let (mut low, mut high) = ((0.0, self.tangent[last]), (step, f64::NAN));
        let (point, tangent, _) = self.stepped(step).ok()?;
        high.1 = tangent[last];
        let mut best = (point, tangent);
        for _ in 0..MOST_AT_FOLD {
            let part = (low.1 / (low.1 - high.1)).clamp(0.05, 0.95);
            let at = low.0 + part * (high.0 - low.0);
            // What was found so far stands where no step comes nearer.
            let Ok((point, tangent, _)) = self.stepped(at) else { break };
            let slope = tangent[last];
            if slope.abs() < best.1[last].abs() {
                best = (point, tangent);
            }
            // At a fold the number depends on the place in second order, so this slope makes it good to all digits.
            if slope.abs() <= f64::EPSILON.sqrt() {
                break;
            }
            if slope * low.1 > 0.0 { low = (at, slope) } else { high = (at, slope) }
        }
        // Its place along the family is as uncertain as the slope there.
        let (point, tangent) = &mut best;
        let rate = ((high.1 - low.1) / (high.0 - low.0)).abs();
        let along = (tangent[last].abs() + point.jacobian.share) / rate;
        let parts = tangent.iter().zip(&self.problem.scales).map(|(part, scale)| (part * scale * along).abs());
        point.errors.iter_mut().zip(parts).for_each(|(error, part)| *error += part);
        Some(best)
    }
}
