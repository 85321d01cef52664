//! `converge` without a case: the slopes of the paper's four base cases (two potentials with two operators each) beside
//! the published ones.

use std::process::ExitCode;

use geodesic_ivp::case::Form;
use geodesic_ivp::output::json_object;
use geodesic_ivp::study::convergence::paper::{BASE_CASES, PUBLISHED_SLOPES, published};
use geodesic_ivp::study::convergence::{Quantity, Slope};

use super::converge::{COMMAND, ConvergeArgs, Swept, grids, sweep_into, two_decimals};
use super::lines::row;
use super::{interrupt, report};

/// Sweeps the base cases, writes the files of each into a folder of its name, and prints one table.
pub(super) fn converge(args: &ConvergeArgs) -> anyhow::Result<ExitCode> {
    if !args.case.quiet {
        report::note("no CASE is given: the paper's base cases are swept, linear and quartic");
    }
    args.output.check_standard_output()?;
    let (mut table, mut written) = (Table::new(args), String::new());
    let mut summaries = Vec::new();
    let mut ending = ExitCode::SUCCESS;
    for name in BASE_CASES {
        let case = args.case.read_built_in(name)?;
        let ranges = ranges(name);
        let swept = sweep_into(args.output.built_in_target(name, COMMAND), &case, args, &ranges, &format!("{name}: "))?;
        let Some(swept) = swept else {
            ending = interrupt::before_any_result();
            break;
        };
        table.add(name, &swept);
        written += &swept.study.written;
        summaries.push((name, swept.study.summary.clone()));
        let this = swept.study.ending(|| swept.code());
        if this != ExitCode::SUCCESS {
            ending = this;
        }
        if swept.study.is_interrupted() {
            break;
        }
    }
    if !summaries.is_empty() {
        args.output.tell(args.case.quiet, &json_object(&summaries), || table.finish() + &written)?;
    }
    Ok(ending)
}

/// The ranges of N over which a case has its published slopes.
fn ranges(case: &str) -> Vec<(usize, usize)> {
    let mut ranges: Vec<_> = PUBLISHED_SLOPES.iter().filter(|one| one.case == case).map(|one| one.n_range).collect();
    ranges.dedup();
    ranges
}

/// The table that is printed.
struct Table<'a> {
    lines: String,
    reference_error: f64,
    /// The largest difference from a slope of the paper, which are fitted against 1/N.
    difference: f64,
    args: &'a ConvergeArgs,
}

impl<'a> Table<'a> {
    fn new(args: &'a ConvergeArgs) -> Self {
        let more = if args.verbose { "  against 1/N  all grids" } else { "" };
        let lines = format!("  potential  operator    error        slope  paper  grids{more}\n");
        Self { lines, reference_error: 0.0, difference: 0.0, args }
    }

    fn add(&mut self, name: &str, swept: &Swept) {
        let is_changed = self.args.case.has_overrides();
        self.reference_error = self.reference_error.max(swept.reference_error);
        for (index, all) in swept.slopes.iter().enumerate() {
            let of = |quantity| published(name, all.sbp, quantity).filter(|_| all.form == Form::Strong);
            // The paper has no slopes in the L2 norm. They are fitted over the grids of ε_x.
            let range = of(Quantity::EPS_X_FINAL).map(|published| published.n_range);
            let place = ranges(name).iter().position(|one| Some(*one) == range);
            let fitted = place.map_or(all, |place| &swept.beside[place][index]);
            let paper = of(all.quantity).filter(|_| !is_changed).map(|published| published.slope);
            let slope = |slope: &Slope| two_decimals(slope.fit.as_ref().map(|fit| fit.slope));
            let inverse = fitted.fit.as_ref().map(|fit| fit.slope_vs_inverse_n);
            if let (Some(paper), Some(inverse)) = (paper, inverse) {
                self.difference = self.difference.max((paper - inverse).abs());
            }
            let more = match self.args.verbose {
                true => format!("  {:>11}  {} ({})", two_decimals(inverse), slope(all), grids(all)),
                false => String::new(),
            };
            let line = format!(
                "  {name:<9}  {:<10}  {:<11}  {:>5}  {:>5}  {:<10}{more}",
                all.scheme(),
                all.name,
                slope(fitted),
                two_decimals(paper),
                grids(fitted)
            );
            self.lines += &format!("{}\n", line.trim_end());
        }
    }

    fn finish(self) -> String {
        let Self { lines, reference_error, difference, args } = self;
        let title = match (args.case.has_overrides(), difference > 0.0) {
            (true, _) => "The paper's base cases, changed by --set".to_owned(),
            (false, true) => format!(
                "The paper's base cases: the slopes against 1/N agree with those of the paper to {difference:.2}"
            ),
            (false, false) => "The paper's base cases".to_owned(),
        };
        let error = format!("against Taylor trajectories, themselves good to {reference_error:.0e}");
        let step = "against the step, 1/(N - 1); those of the paper are against 1/N (--verbose has both)";
        format!("{title}\n{lines}{}{}", row("error", &error), row("slope", step))
    }
}
