//! Runs that end where a coordinate reaches a value or a formula changes its sign: the length of γ at which the last
//! node is there.

use super::failure::{NoSolution, Unfinished};
use super::newton::tolerance;
use super::run::Observer;
use super::setup::{Limit, Setup};
use super::signs::Watched;
use super::solve_to;
use super::status::{Iterations, Status};
use super::sweeps;
use super::world_line::{Joint, WorldLine};
use crate::engine::Accuracy;
use crate::number::Real;

/// The share of the whole way that counts as none has this many digits in `f64`.
const DIGITS_OF_WAY: u32 = 14;
/// The same of the length of γ.
const DIGITS_OF_LENGTH: u32 = 15;
/// Solves allowed for the search; Newton's method needs about five.
const MOST_SOLVES: usize = 60;
/// Where rounding ends the search first, this many digits fewer than requested are enough.
const SPARE_DIGITS: u32 = 4;
/// The first step of a secant, as a share of the length.
const FIRST_STEP: f64 = 1e-6;
/// The accuracy of the windows that tell roughly where a formula changes its sign.
const NEAR: f64 = 1e-9;

/// The run of `setup`, with what it ended by, where its length is to be searched for: all of its windows, or the last
/// one.
pub(super) fn solve<S: Real>(setup: &Setup<S>, is_kept: bool) -> Result<WorldLine<S>, Box<Unfinished<S>>> {
    let mut ignore = |_: &WorldLine<S>| ();
    let mut solve_to = |length: S| {
        let observer: Option<Observer<'_, S>> = if is_kept { None } else { Some(&mut ignore) };
        solve_to(setup, length, observer)
    };
    let (coordinate, value) = match setup.limit {
        Limit::Length(length) => return until(setup, length, &mut solve_to),
        Limit::Value { coordinate, value } => (coordinate, value),
    };
    let mut line = at_value(setup, coordinate, value, &mut solve_to)?;
    if !setup.until.is_empty() {
        line = until(setup, line.length, &mut solve_to)?;
    }
    // A search meets the value but for rounding. Rows that count from an origin are rounded once more when they are
    // shown, at the end as anywhere else.
    if line.ended_by.is_none() && !setup.counts_from_origin(coordinate) {
        line.ended_at = Some((coordinate, line.last_joint().q[coordinate]));
    }
    Ok(line)
}

/// Solves a setup up to a length.
type SolveTo<'s, S> = &'s mut dyn FnMut(S) -> Result<WorldLine<S>, Box<Unfinished<S>>>;

/// The length of the same run in `f64`, where most of a search is cheapest, or what is known without it.
fn first_guess<S: Real>(known: S, setup: impl FnOnce() -> Setup<S>) -> Result<S, Box<Unfinished<S>>> {
    if !S::IS_EXTENDED {
        return Ok(known);
    }
    let found = solve(&setup().in_f64(), false).map_err(|unfinished| unfinished.failure)?;
    Ok(S::from(found.length))
}

/// The world-line that ends where `coordinate` is `value`, by Newton's method on γ_f with the velocity at the end of
/// each solution: the coordinate grows, or falls, with γ_f. A share of the whole way counts as none of what counts from
/// an origin, or else one of the length of γ.
fn at_value<S: Real>(
    setup: &Setup<S>,
    coordinate: usize,
    value: S,
    solve_to: SolveTo<'_, S>,
) -> Result<WorldLine<S>, Box<Unfinished<S>>> {
    let (start, is_of_way) = (&setup.place.start, setup.counts_from_origin(coordinate));
    let value = value - setup.origin_of(coordinate);
    let way = value - start.q[coordinate];
    let asked = Search {
        // The length that would do at constant speed.
        guess: first_guess(way / start.q_dot[coordinate], || Setup { until: Vec::new(), ..setup.clone() })?,
        limit: S::from(f64::INFINITY),
        digits: if is_of_way { DIGITS_OF_WAY } else { DIGITS_OF_LENGTH },
        digits_of_runs: setup.settings.digits,
        scale: is_of_way.then(|| way.abs()),
    };
    let excess = |line: &WorldLine<S>| {
        let end = line.last_joint();
        let [excess, slope] = [end.q[coordinate] - value, line.velocities(end)[coordinate]];
        (excess * way.signum(), Some(slope * way.signum()))
    };
    search(asked, solve_to, excess).map_err(|error| not_reached(error, setup))
}

/// The world-line that ends where one of the formulas of the setup first changes its sign in its direction, or after
/// the length `whole`.
fn until<S: Real>(setup: &Setup<S>, whole: S, solve_to: SolveTo<'_, S>) -> Result<WorldLine<S>, Box<Unfinished<S>>> {
    let Near { change, watched } = near(setup, whole);
    let Some((index, gamma, to_positive)) = change else { return Ok(WorldLine { watched, ..solve_to(whole)? }) };
    let start = &setup.place.start;
    let k = setup.place.geometry.norm(&start.q, &start.q_dot);
    let mut formula = setup.until[index].formula.clone();
    let asked = Search {
        guess: first_guess(gamma, || Setup { limit: Limit::Length(whole), ..setup.clone() })?,
        limit: whole,
        digits: DIGITS_OF_LENGTH,
        digits_of_runs: setup.settings.digits,
        scale: None,
    };
    let excess = |line: &WorldLine<S>| {
        let end = line.end_inside();
        let value = formula.at(&end.q, &end.q_dot, &end.p, k);
        (if to_positive { value } else { -value }, None)
    };
    let line = search(asked, solve_to, excess).map_err(|error| not_reached(error, setup))?;
    Ok(WorldLine { ended_by: Some(index), watched, ..line })
}

/// What the engine finds within a length.
#[derive(Default)]
struct Near<S> {
    /// The first change of sign, if there is one: the place of the formula among those that end the run, γ − γ_i
    /// roughly, and true if the formula is positive after it.
    change: Option<(usize, S, bool)>,
    watched: Watched,
}

/// Looks for the first change of sign within the length `whole`.
fn near<S: Real>(setup: &Setup<S>, whole: S) -> Near<S> {
    let rough = Setup { limit: Limit::Length(whole.to_f64()), ..setup.in_f64() };
    let found = sweeps::to_accuracy(&rough, Accuracy::Local(NEAR), Some(&mut |_| ()), None);
    found.map_or_else(|_| Near::default(), |line| Near { change: change(&rough, &line), watched: line.watched })
}

/// The change of sign that ended a run.
fn change<S: Real>(rough: &Setup, line: &WorldLine) -> Option<(usize, S, bool)> {
    let (index, view, start) = (line.ended_by?, line.views().last()?, &rough.place.start);
    // The node before the change.
    let node = view.window.points() - 2;
    let q: Vec<f64> = (0..start.q.len()).filter_map(|a| view.absolute(a, &line.q[a]).nth(node)).collect();
    let mut p = view.start.p.to_vec();
    line.geometry().active().iter().zip(&line.p).for_each(|(&a, row)| p[a] = row[view.window.nodes()][node]);
    let q_dot = line.velocities(Joint { q: &q, p: &p });
    let k = line.geometry().norm(&start.q, &start.q_dot);
    let before = rough.until[index].formula.clone().at(&q, &q_dot, &p, k);
    Some((index, S::from(line.length), before < 0.0))
}

/// The failure of a search for the end of the run of `setup`.
fn not_reached<S: Real>(error: NotFound<WorldLine<S>, Box<Unfinished<S>>>, setup: &Setup<S>) -> Box<Unfinished<S>> {
    let (geometry, status) = (&setup.place.geometry, Status::EndTimeNotReached);
    match error {
        NotFound::Failed(failure) => failure,
        NotFound::Missed(None) => {
            NoSolution::new(status, geometry, setup.gamma_i.to_f64(), &setup.place.start.q).into()
        }
        NotFound::Missed(Some(closest)) => {
            let failure = NoSolution::new(status, geometry, closest.gamma_f().to_f64(), closest.last_joint().q);
            let Iterations { initial_guess, history, .. } = closest.iterations;
            NoSolution { residual: closest.gradient_norm.to_f64(), ..failure.after(initial_guess, history) }.into()
        }
    }
}

/// The end that is looked for.
struct Search<S> {
    /// The length that is tried first.
    guess: S,
    /// The longest that is allowed.
    limit: S,
    /// In `f64` the share that counts as none is 10 to minus this. With more digits, all those of the runs must agree.
    digits: u32,
    /// Significant digits of the runs.
    digits_of_runs: u32,
    /// The number that an excess is a share of. Without it, the share is that of the correction in the length.
    scale: Option<S>,
}

/// Why no run was found.
enum NotFound<L, E> {
    /// Runs that are long enough have no solution.
    Failed(E),
    /// The excess does not vanish. This run, if any, came closest.
    Missed(Option<L>),
}

/// Looks for the run whose excess is 0, where a longer run has the larger excess: by Newton's method with the slope
/// that comes with it or, where none is known, by secants, kept inside the bracket found so far. A length that has no
/// solution (a horizon on the way) is an upper bound like one that is too long.
fn search<S: Real, L, E>(
    Search { guess, limit, digits, digits_of_runs, scale }: Search<S>,
    mut solve_to: impl FnMut(S) -> Result<L, E>,
    mut excess: impl FnMut(&L) -> (S, Option<S>),
) -> Result<L, NotFound<L, E>> {
    let digits = if S::IS_EXTENDED { digits_of_runs } else { digits };
    let [tolerance, loose] = [digits, digits_of_runs - SPARE_DIGITS].map(tolerance::<S>);
    let infinite = S::from(f64::INFINITY);
    let (mut length, mut below, mut above) = (guess, S::ZERO, infinite);
    // The run that is closest: by how much it misses, what that is a share of, and the run.
    let mut best: Option<(S, S, L)> = None;
    let mut failure = None;
    // The last length and excess, for secants.
    let mut last: Option<[S; 2]> = None;
    for _ in 0..MOST_SOLVES {
        if !(length > below && length < above) {
            // No upper bound yet: the run is longer than any tried.
            length = if above.is_finite() { (below + above).half() } else { below + below };
        }
        length = if length > limit { limit } else { length };
        if length <= below || length >= above || !length.is_finite() {
            break;
        }
        let run = match solve_to(length) {
            Ok(run) => run,
            Err(error) => {
                above = length;
                failure = Some(error);
                length = below;
                continue;
            }
        };
        let (value, slope) = excess(&run);
        *(if value < S::ZERO { &mut below } else { &mut above }) = length;
        let step = match (slope, last) {
            (Some(slope), _) => value / slope,
            (None, Some([before, was])) if was != value => value * (length - before) / (value - was),
            (None, Some(_)) => S::ZERO,
            // Without two points the step is a small part of the length.
            (None, None) => S::from(FIRST_STEP) * length * if value < S::ZERO { -S::ONE } else { S::ONE },
        };
        last = Some([length, value]);
        let (miss, whole) = scale.map_or((step.abs(), length), |scale| (value.abs(), scale));
        let improved = best.as_ref().is_none_or(|(least, ..)| miss < *least);
        if improved {
            best = Some((miss, whole, run));
        }
        let least = best.as_ref().map_or(infinite, |(least, ..)| *least);
        if least <= tolerance * whole || (!improved && least <= loose * whole) {
            break;
        }
        length -= step;
    }
    match (best, failure) {
        (Some((miss, whole, run)), _) if miss <= loose * whole => Ok(run),
        (_, Some(failure)) => Err(NotFound::Failed(failure)),
        (best, None) => Err(NotFound::Missed(best.map(|(.., run)| run))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The length that is found, and the number of runs that are tried. Runs are their lengths here; none is longer
    /// than `longest`. The slope is what is given, if anything.
    fn tried(
        f: impl Fn(f64) -> f64,
        slope: Option<fn(f64) -> f64>,
        scale: Option<f64>,
        [guess, limit, longest]: [f64; 3],
    ) -> (Option<f64>, usize) {
        let mut runs = 0;
        let solve_to = |length| {
            runs += 1;
            if length > longest { Err("a horizon") } else { Ok(length) }
        };
        let asked = Search { guess, limit, digits: 15, digits_of_runs: 16, scale };
        (search(asked, solve_to, |&at: &f64| (f(at), slope.map(|slope| slope(at)))).ok(), runs)
    }

    /// With the slope of a line the second run is at its root. Secants need one more to know the slope, from either
    /// side, and a length without a solution only bounds them.
    #[test]
    fn roots_are_found_with_and_without_a_slope_and_inside_of_limits() {
        let line = |x: f64| 3.0 * (x - 4.0);
        for guess in [1.0, 7.0] {
            for (slope, error, most) in [(Some((|_| 3.0) as fn(f64) -> f64), 1e-14, 2), (None, 1e-12, 5)] {
                let (root, runs) = tried(line, slope, None, [guess, 1e9, f64::INFINITY]);
                assert!((root.unwrap() - 4.0).abs() < error && runs <= most, "{root:?} after {runs} runs from {guess}");
            }
        }
        let found = |lengths| tried(line, None, None, lengths).0.unwrap_or(0.0);
        for (lengths, root) in
            [([3.9, 4.0, 9.0], 4.0), ([7.0, 9.0, 4.5], 4.0), ([2.9, 3.95, 9.0], 0.0), ([1.0, 9.0, 2.0], 0.0)]
        {
            assert!((found(lengths) - root).abs() < 1e-12, "{lengths:?}");
        }
        // A slope of the wrong sign points away from the root: until one run is too long lengths double, then halve.
        let (root, runs) = tried(|x| x - 1000.0, Some(|_| -1.0), Some(1.0), [1.0, 1e9, f64::INFINITY]);
        assert!((root.unwrap() - 1000.0).abs() < 1e-11 && runs > 10, "{root:?} after {runs} runs");
        // Of an excess that is known to a millionth only, a root is found on the scale of 1e12, and none on that of 1.
        let coarse = |x: f64| ((x - 2.0) * 1e6).round() / 1e6 + 3e-7;
        let found = |scale| tried(coarse, Some(|_| 1.0), Some(scale), [1.0, 1e9, f64::INFINITY]).0;
        assert!((found(1e12).unwrap() - 2.0).abs() < 1e-5 && found(1.0).is_none());
    }
}
