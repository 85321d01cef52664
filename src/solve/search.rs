//! The length of γ of a run that is to end at a given place: a root of a function of whole runs.

use super::newton;
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

/// Why no run was found.
pub(super) enum NotFound<L, E> {
    /// Runs that are long enough have no solution.
    Failed(E),
    /// The excess does not vanish. This run, if any, came closest.
    Missed(Option<L>),
}

/// Looks for the run whose excess is 0, where a longer run has the larger excess: by Newton's method with the slope that
/// comes with it or, where none is known, by secants, kept inside the bracket found so far. A length that has no solution (a horizon on the way) is
/// an upper bound like one that is too long.
pub(super) fn search<S: Real, L, E>(
    Search { guess, limit, digits, digits_of_runs, scale }: Search<S>,
    mut solve_to: impl FnMut(S) -> Result<L, E>,
    mut excess: impl FnMut(&L) -> (S, Option<S>),
) -> Result<L, NotFound<L, E>> {
    let digits = if S::IS_EXTENDED { digits_of_runs } else { digits };
    let [tolerance, loose] = [digits, digits_of_runs - SPARE_DIGITS].map(newton::tolerance::<S>);
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
        let found = |lengths| tried(line, None, None, lengths).0;
        for lengths in [[3.9, 4.0, 9.0], [7.0, 9.0, 4.5]] {
            assert!((found(lengths).unwrap() - 4.0).abs() < 1e-12, "{lengths:?}");
        }
        for lengths in [[2.9, 3.95, 9.0], [1.0, 9.0, 2.0]] {
            assert_eq!(found(lengths), None, "{lengths:?}");
        }
    }

    #[test]
    fn a_step_that_leaves_the_bracket_doubles_or_halves_it() {
        // A slope of the wrong sign points away from the root: until one run is too long lengths double, then halve.
        let (root, runs) = tried(|x| x - 1000.0, Some(|_| -1.0), Some(1.0), [1.0, 1e9, f64::INFINITY]);
        assert!((root.unwrap() - 1000.0).abs() < 1e-11 && runs > 10, "{root:?} after {runs} runs");
    }

    #[test]
    fn a_scale_says_what_misses_count_against() {
        // Of an excess that is known to a millionth only, a root is found on the scale of 1e12, and none on that of 1.
        let coarse = |x: f64| ((x - 2.0) * 1e6).round() / 1e6 + 3e-7;
        let found = |scale| tried(coarse, Some(|_| 1.0), Some(scale), [1.0, 1e9, f64::INFINITY]).0;
        assert!((found(1e12).unwrap() - 2.0).abs() < 1e-5);
        assert!(found(1.0).is_none());
    }
}
