//! The length of γ of a run that is to end at a given place: a root of a function of whole runs.

use super::refinement;
use crate::number::Real;

/// Solves allowed for the search; Newton's method needs about five.
const MOST_SOLVES: usize = 60;
/// Where rounding ends the search first, this many digits fewer than requested are enough.
const SPARE_DIGITS: u32 = 4;
/// The first step of a secant, as a share of the length.
const FIRST_STEP: f64 = 1e-6;

/// The end that is looked for.
pub(super) struct Search<S> {
    /// The length that is tried first.
    pub(super) guess: S,
    /// The longest that is allowed.
    pub(super) limit: S,
    /// The share that counts as none is 10 to minus this.
    pub(super) digits: u32,
    /// Significant digits of the runs.
    pub(super) digits_of_runs: u32,
    /// The number that an excess is a share of. Without it, the share is that of the correction in the length.
    pub(super) scale: Option<S>,
}

/// The place of a run that was tried relative to the end that is looked for.
pub(super) struct Excess<S> {
    /// Negative if the run is too short.
    pub(super) value: S,
    /// Its derivative by the length, where it is known.
    pub(super) slope: Option<S>,
}

/// Why no run was found.
pub(super) enum NotFound<L, E> {
    /// Runs that are long enough have no solution.
    Failed(E),
    /// The excess does not vanish. This run, if any, came closest.
    Missed(Option<L>),
}

/// Looks for the run whose excess is 0, where a longer run has the larger excess: by Newton's method or, where no slope
/// is known, by secants, kept inside the bracket found so far. A length that has no solution (a horizon on the way) is
/// an upper bound like one that is too long.
pub(super) fn search<S: Real, L, E>(
    Search { guess, limit, digits, digits_of_runs, scale }: Search<S>,
    mut solve_to: impl FnMut(S) -> Result<L, E>,
    mut excess: impl FnMut(&L) -> Excess<S>,
) -> Result<L, NotFound<L, E>> {
    let [tolerance, loose] = [digits, digits_of_runs - SPARE_DIGITS].map(refinement::tolerance::<S>);
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
        if length > limit {
            length = limit;
        }
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
        let Excess { value, slope } = excess(&run);
        if value < S::ZERO {
            below = length
        } else {
            above = length
        }
        let step = step(length, Excess { value, slope }, last);
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

/// By how much `length` is too long: by the slope, or by a secant through the `last` length and its excess.
fn step<S: Real>(length: S, Excess { value, slope }: Excess<S>, last: Option<[S; 2]>) -> S {
    match (slope, last) {
        (Some(slope), _) => value / slope,
        (None, Some([before, was])) if was != value => value * (length - before) / (value - was),
        (None, Some(_)) => S::ZERO,
        // Without two points the step is a small part of the length.
        (None, None) if value < S::ZERO => -S::from(FIRST_STEP) * length,
        (None, None) => S::from(FIRST_STEP) * length,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs are their lengths here; none is longer than `longest`.
    fn found(
        f: impl Fn(f64) -> f64,
        has_slope: bool,
        guess: f64,
        limit: f64,
        longest: f64,
    ) -> Result<f64, &'static str> {
        let asked = Search { guess, limit, digits: 15, digits_of_runs: 16, scale: None };
        let slope = |at: f64| has_slope.then(|| (f(at * 1.000001) - f(at)) / (1e-6 * at));
        let solve_to = |length| if length > longest { Err("a horizon") } else { Ok(length) };
        search(asked, solve_to, |&at| Excess { value: f(at), slope: slope(at) }).map_err(|error| match error {
            NotFound::Failed(error) => error,
            NotFound::Missed(_) => "missed",
        })
    }

    #[test]
    fn roots_are_found_with_and_without_a_slope() {
        let root = 2.0_f64.sqrt();
        for has_slope in [true, false] {
            for (guess, longest) in [(0.1, f64::INFINITY), (40.0, f64::INFINITY), (3.0, 1.5)] {
                let found = found(|x| x * x - 2.0, has_slope, guess, f64::INFINITY, longest).unwrap();
                assert!((found - root).abs() < 1e-14, "{found} from {guess}");
            }
        }
    }

    #[test]
    fn a_root_at_the_limit_is_found_and_none_beyond_it() {
        assert_eq!(found(|x| x - 3.0, false, 2.9, 3.0, 9.0), Ok(3.0));
        assert_eq!(found(|x| x - 3.0, false, 2.9, 2.95, 9.0), Err("missed"));
        assert_eq!(found(|x| x - 3.0, false, 1.0, 9.0, 2.0), Err("a horizon"));
    }

    /// The most runs that are tried until the root is found.
    fn tried(f: impl Fn(f64) -> f64, slope: Option<f64>, scale: Option<f64>, guess: f64) -> (f64, usize) {
        let mut runs = 0;
        let solve_to = |length| {
            runs += 1;
            Ok::<f64, ()>(length)
        };
        let asked = Search { guess, limit: 1e9, digits: 15, digits_of_runs: 16, scale };
        let root = search(asked, solve_to, |&at| Excess { value: f(at), slope });
        (root.unwrap_or(f64::NAN), runs)
    }

    #[test]
    fn what_is_linear_is_found_at_once() {
        // With the slope the second run is at the root. Secants need one more to know the slope, from either side.
        for guess in [1.0, 7.0] {
            let (root, runs) = tried(|x| 3.0 * (x - 4.0), Some(3.0), None, guess);
            assert!((root - 4.0).abs() < 1e-14 && runs <= 2, "{root} after {runs} runs from {guess}");
            let (root, runs) = tried(|x| 3.0 * (x - 4.0), None, None, guess);
            assert!((root - 4.0).abs() < 1e-12 && runs <= 5, "{root} after {runs} runs from {guess}");
        }
    }

    #[test]
    fn a_step_that_leaves_the_bracket_doubles_or_halves_it() {
        // A slope of the wrong sign points away from the root: until one run is too long lengths double, then halve.
        let (root, runs) = tried(|x| x - 1000.0, Some(-1.0), Some(1.0), 1.0);
        assert!((root - 1000.0).abs() < 1e-11 && runs > 10, "{root} after {runs} runs");
    }

    #[test]
    fn a_scale_says_what_misses_count_against() {
        // Of an excess that is known to a millionth only, a root is found on the scale of 1e12, and none on that of 1.
        let coarse = |x: f64| ((x - 2.0) * 1e6).round() / 1e6 + 3e-7;
        assert!((tried(coarse, Some(1.0), Some(1e12), 1.0).0 - 2.0).abs() < 1e-5);
        assert!(tried(coarse, Some(1.0), Some(1.0), 1.0).0.is_nan());
    }
}
