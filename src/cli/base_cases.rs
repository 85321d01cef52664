//! `converge` without a case: the slopes of the paper's four base cases (two potentials with two operators each) beside
//! the published ones.

use std::process::ExitCode;

use geodesic_ivp::case::Form;
use geodesic_ivp::output::json_object;
use geodesic_ivp::study::convergence::paper::{BASE_CASES, PUBLISHED_SLOPES, published};
use geodesic_ivp::study::convergence::{Quantity, Slope};

use super::converge::{COMMAND, ConvergeArgs, Swept, sweep_into};
use super::{interrupt, report};

/// Sweeps the base cases, writes the files of each into a folder of its name, and prints one table.
pub(super) fn converge(args: &ConvergeArgs) -> anyhow::Result<ExitCode> {
    if !args.case.quiet {
        report::note("no CASE is given: the paper's base cases are swept, linear and quartic");
    }
    args.output.check_standard_output()?;
    let (mut table, mut written) = (Table::new(args.case.has_overrides()), String::new());
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
        written += &swept.written;
        summaries.push((name, swept.summary.clone()));
        let this = swept.ending();
        if this != ExitCode::SUCCESS {
            ending = this;
        }
        if swept.interrupted.is_some() {
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
struct Table {
    lines: String,
    reference_error: f64,
    /// Whether overrides have changed the cases, so that they are no longer those of the paper.
    changed: bool,
}

impl Table {
    fn new(changed: bool) -> Self {
        let lines = "  potential  operator    quantity      paper  against 1/N  against Δγ  fitted N    \
                     all grids against Δγ\n";
        Self { lines: lines.to_owned(), reference_error: 0.0, changed }
    }

    fn add(&mut self, name: &str, swept: &Swept) {
        self.reference_error = self.reference_error.max(swept.reference_error);
        for (index, all) in swept.slopes.iter().enumerate() {
            let of = |quantity| published(name, all.sbp, quantity).filter(|_| all.form == Form::Strong);
            // The paper has no slopes in the L2 norm. They are fitted over the grids of ε_x.
            let range = of(Quantity::EPS_X_FINAL).map(|published| published.n_range);
            let place = ranges(name).iter().position(|one| Some(*one) == range);
            let fitted = place.map(|place| &swept.beside[place][index]);
            let paper =
                of(all.quantity).filter(|_| !self.changed).map_or("-".to_owned(), |p| format!("{:.2}", p.slope));
            let slope = |slope: Option<&Slope>, inverse: bool| {
                slope.and_then(|slope| slope.fit.as_ref()).map_or("-".to_owned(), |fit| {
                    format!("{:.3}", if inverse { fit.slope_vs_inverse_n } else { fit.slope })
                })
            };
            let grids = |slope: Option<&Slope>| {
                slope.and_then(|slope| slope.n_range).map_or("-".to_owned(), |(min, max)| format!("{min} … {max}"))
            };
            self.lines += &format!(
                "  {name:<9}  {:<10}  {:<12}  {paper:>5}  {:>11}  {:>10}  {:<10}  {} ({})\n",
                all.scheme(),
                all.name,
                slope(fitted, true),
                slope(fitted, false),
                grids(fitted),
                slope(Some(all), false),
                grids(Some(all)),
            );
        }
    }

    fn finish(self) -> String {
        let Self { lines, reference_error, changed } = self;
        let title = if changed { "The paper's base cases, changed by --set" } else { "The paper's base cases" };
        format!(
            "{title}: slopes of the errors against Taylor trajectories (their estimated error {reference_error:.1e})\n\
             {lines}  The paper fits against 1/N; the step is Δγ = 1/(N - 1).\n"
        )
    }
}
