//! How the error of a run grows, and what it will be at the end.

/// After this part of a run its error at the end is projected.
const EARLIEST: f64 = 0.05;

/// A march whose error at the end will miss the accuracy by more than this factor is begun again at once.
const MOST_PROJECTED: f64 = 1.2;

/// Not so if that error is no less than this part of that of the attempt before: what is left is rounding, which no
/// smaller share reduces.
const BETTER: f64 = 0.3;

/// Errors grow with a power of γ between these: with the first where they only add up, with the square where the period
/// is off, and faster where paths diverge.
const POWERS: [f64; 2] = [1.0, 2.5];

/// Whether a march with that error at its end is to be begun again at once, as it will miss the `accuracy`. An attempt
/// before would have `missed` it by that error.
pub(super) fn will_miss(projected: f64, accuracy: f64, missed: f64) -> bool {
    projected > MOST_PROJECTED * accuracy && projected < BETTER * missed
}

/// The error of a run at two earlier points. The older one is between a half and a quarter of the way back.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Growth {
    older: (f64, f64),
    newer: (f64, f64),
}

impl Growth {
    /// The error at the end of a run of which this part is `done`, where the error at `gamma` is known; 0 before it can
    /// be said.
    pub(super) fn project(&mut self, gamma: f64, error: f64, done: f64) -> f64 {
        if gamma >= 2.0 * self.newer.0 {
            (self.older, self.newer) = (self.newer, (gamma, error));
        }
        let (before, small) = self.older;
        if done < EARLIEST || before == 0.0 || error == 0.0 {
            return 0.0;
        }
        let power = (error / small).ln() / (gamma / before).ln();
        error * done.recip().powf(power.clamp(POWERS[0], POWERS[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::Growth;

    #[test]
    fn an_error_that_grows_with_a_power_is_foreseen() {
        for power in [1.0, 1.5, 2.0] {
            let (mut growth, mut seen) = (Growth::default(), 0);
            for step in 1..=100 {
                let done = f64::from(step) / 100.0;
                let projected = growth.project(3.0 * done, 1e-9 * done.powf(power), done);
                if projected > 0.0 {
                    assert!((projected / 1e-9 - 1.0).abs() < 1e-9, "{power} {done}: {projected}");
                    seen += 1;
                }
            }
            assert!(seen > 90);
        }
    }

    #[test]
    fn growth_that_no_power_describes_is_limited() {
        let mut growth = Growth::default();
        growth.project(1.0, 1e-30, 0.1);
        growth.project(2.0, 1e-20, 0.2);
        let projected = growth.project(4.0, 1e-9, 0.4);
        assert!((projected / (1e-9 * 2.5_f64.powf(2.5)) - 1.0).abs() < 1e-12);
        assert_eq!(Growth::default().project(1.0, 1e-3, 0.01), 0.0);
    }
}
