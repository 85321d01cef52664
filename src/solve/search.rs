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
    /// In `f64` the share that counts as none is 10 to minus this. With more digits, all those of the runs must agree.
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
    let digits = if S::IS_EXTENDED { digits_of_runs } else { digits };
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

    const ENDLESS: f64 = f64::INFINITY;

    /// The length that is found, and the number of runs that are tried. Runs are their lengths here; none is longer
    /// than `longest`. The slope is what is given, if anything.
    fn tried(
        f: impl Fn(f64) -> f64,
        slope: Option<&dyn Fn(f64) -> f64>,
        scale: Option<f64>,
        [guess, limit, longest]: [f64; 3],
    ) -> (Result<f64, &'static str>, usize) {
        let mut runs = 0;
        let solve_to = |length| {
            runs += 1;
            if length > longest { Err("a horizon") } else { Ok(length) }
        };
        let asked = Search { guess, limit, digits: 15, digits_of_runs: 16, scale };
        let excess = |&at: &f64| Excess { value: f(at), slope: slope.map(|slope| slope(at)) };
        let found = search(asked, solve_to, excess).map_err(|error| match error {
            NotFound::Failed(error) => error,
            NotFound::Missed(_) => "missed",
        });
        (found, runs)
    }

    #[test]
    fn roots_are_found_with_and_without_a_slope() {
        let slope: &dyn Fn(f64) -> f64 = &|x| 2.0 * x;
        for slope in [Some(slope), None] {
            for (guess, longest) in [(0.1, ENDLESS), (40.0, ENDLESS), (3.0, 1.5)] {
                let found = tried(|x| x * x - 2.0, slope, None, [guess, ENDLESS, longest]).0.unwrap();
                assert!((found - 2.0_f64.sqrt()).abs() < 1e-14, "{found} from {guess}");
            }
        }
    }

    #[test]
    fn a_root_at_the_limit_is_found_and_none_beyond_it() {
        for (lengths, found) in
            [([2.9, 3.0, 9.0], Ok(3.0)), ([2.9, 2.95, 9.0], Err("missed")), ([1.0, 9.0, 2.0], Err("a horizon"))]
        {
            assert_eq!(tried(|x| x - 3.0, None, None, lengths).0, found);
        }
    }

    #[test]
    fn what_is_linear_is_found_at_once() {
        // With the slope the second run is at the root. Secants need one more to know the slope, from either side.
        let slope: &dyn Fn(f64) -> f64 = &|_| 3.0;
        for (guess, (slope, error, most)) in [1.0, 7.0]
            .into_iter()
            .flat_map(|guess| [(Some(slope), 1e-14, 2), (None, 1e-12, 5)].map(|expected| (guess, expected)))
        {
            let (root, runs) = tried(|x| 3.0 * (x - 4.0), slope, None, [guess, 1e9, ENDLESS]);
            assert!((root.unwrap() - 4.0).abs() < error && runs <= most, "{root:?} after {runs} runs from {guess}");
        }
    }

    #[test]
    fn a_step_that_leaves_the_bracket_doubles_or_halves_it() {
        // A slope of the wrong sign points away from the root: until one run is too long lengths double, then halve.
        let (root, runs) = tried(|x| x - 1000.0, Some(&|_| -1.0), Some(1.0), [1.0, 1e9, ENDLESS]);
        assert!((root.unwrap() - 1000.0).abs() < 1e-11 && runs > 10, "{root:?} after {runs} runs");
    }

    #[test]
    fn a_scale_says_what_misses_count_against() {
        // Of an excess that is known to a millionth only, a root is found on the scale of 1e12, and none on that of 1.
        let coarse = |x: f64| ((x - 2.0) * 1e6).round() / 1e6 + 3e-7;
        let found = |scale| tried(coarse, Some(&|_| 1.0), Some(scale), [1.0, 1e9, ENDLESS]).0;
        assert!((found(1e12).unwrap() - 2.0).abs() < 1e-5);
        assert!(found(1.0).is_err());
    }
}
