//! `run --sample-t START:STOP:STEP` and `--sample-gamma START:STOP:STEP`.

use clap::Args;
use geodesic_ivp::sampling::{OutsideRun, Sample, Sampler};
use geodesic_ivp::scalar::Real;
use geodesic_ivp::{CaseError, Solution};

/// More rows than this are a slip of the pen.
const MOST_SAMPLES: f64 = 1e8;

#[derive(Debug, Clone, Args)]
pub(super) struct SampleArgs {
    /// Also write samples.csv at these times, for example 0:10:0.1
    #[arg(long, value_name = "START:STOP:STEP", value_parser = Range::parse, conflicts_with_all = ["sample_gamma", "stdout"], allow_hyphen_values = true)]
    sample_t: Option<Range>,

    /// Also write samples.csv at these values of gamma
    #[arg(long, value_name = "START:STOP:STEP", value_parser = Range::parse, conflicts_with = "stdout", allow_hyphen_values = true)]
    sample_gamma: Option<Range>,
}

/// Decimals, so that a step of 0.1 is one tenth in every precision.
#[derive(Debug, Clone)]
struct Range {
    text: String,
    start: String,
    step: String,
    count: usize,
}

impl Range {
    fn parse(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let numbers: Option<Vec<f64>> =
            parts.iter().map(|part| part.parse().ok().filter(|n: &f64| n.is_finite())).collect();
        let (Some(&[start, stop, step]), &[from, _, by]) = (numbers.as_deref(), parts.as_slice()) else {
            return Err("expected START:STOP:STEP, three numbers, for example 0:10:0.1".to_owned());
        };
        let steps = if step == 0.0 { f64::NAN } else { (stop - start) / step };
        if steps.is_nan() || steps < 0.0 {
            return Err("a STEP that leads from START to STOP is needed".to_owned());
        }
        if steps > MOST_SAMPLES {
            return Err(format!("more than {MOST_SAMPLES:e} samples"));
        }
        // STOP belongs to the range if only rounding keeps the last step from it.
        let count = (steps * (1.0 + 16.0 * f64::EPSILON)).floor() as usize + 1;
        Ok(Self { text: text.to_owned(), start: from.to_owned(), step: by.to_owned(), count })
    }

    fn values<S: Real>(&self) -> impl Iterator<Item = S> + '_ {
        let read = |text: &str| S::from_decimal(text).unwrap_or_else(|| S::from(f64::NAN));
        let (start, step) = (read(&self.start), read(&self.step));
        (0..self.count).map(move |k| start + S::from(k as f64) * step)
    }
}

impl SampleArgs {
    /// Whether samples are asked for.
    pub(super) fn wanted(&self) -> bool {
        self.sample_t.is_some() || self.sample_gamma.is_some()
    }

    /// The samples of `solution`.
    ///
    /// # Errors
    /// [`CaseError`] if one of them lies outside the run.
    pub(super) fn take<S: Real>(&self, solution: &Solution<S>) -> anyhow::Result<Vec<Sample<S>>> {
        let sampler = Sampler::new(solution);
        let refuse = |option: &str, range: &Range, OutsideRun { range: (from, to) }: OutsideRun<S>| {
            let message = format!(
                "--{option} {} goes beyond the run, which covers {} to {}",
                range.text,
                from.to_decimal(solution.digits),
                to.to_decimal(solution.digits)
            );
            anyhow::Error::from(CaseError::without_place("command line", message))
        };
        if let Some(range) = &self.sample_t {
            return range.values().map(|t| sampler.at_time(t).map_err(|end| refuse("sample-t", range, end))).collect();
        }
        let gammas = self.sample_gamma.iter().flat_map(|range| range.values().map(move |gamma| (range, gamma)));
        gammas.map(|(range, gamma)| sampler.at_gamma(gamma).map_err(|end| refuse("sample-gamma", range, end))).collect()
    }
}
