//! `find CASE`: numbers of a case with which its run meets what `[find]` says.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use geodesic_ivp::Case;
use geodesic_ivp::case::{Find, Goal, Unknown};
use geodesic_ivp::number::Extended;
use geodesic_ivp::output::{
    CASE, OutputSet, SUMMARY, find_summary, not_found_summary, pictures, write_fit, write_iterates,
};
use geodesic_ivp::solve::Setup;
use geodesic_ivp::study::find::{Existence, Fit, Found, Geodesic, Iterate, NotFound, find, norm};
use geodesic_ivp::study::proof::decimal;
use geodesic_ivp::study::run::{self, NoRun, Run, Wanted};

use super::family::follow_family;
use super::find_args::{FindArgs, checked, with_error};
use super::format::FormatArgs;
use super::lines::{listed, row, short, wrapped};
use super::report::{self, Interrupted};
use super::run_tables::{tables, write_table, write_tables};
use super::starts::find_from_each;
use super::told::{Told, number};
use super::{memory, out, study};

const FOUND: &str = "found.toml";
const ITERATES: &str = "find.csv";
const FIT: &str = "fit.csv";
const PICTURE_OF_FIT: &str = "fit.svg";
/// An imaginary part is not shown below this share of a multiplier: rounding splits a double one by about so much.
const UNSEEN: f64 = 1e-6;

/// The result of a search, with the points that it came by.
type Searched = (Result<Found, NotFound>, Vec<Iterate>);

pub(super) fn find_numbers(args: &FindArgs) -> anyhow::Result<ExitCode> {
    if let Some(followed) = &args.follow {
        return follow_family(args, followed);
    }
    if !args.vary.is_empty() {
        return find_from_each(args);
    }
    let case = args.case.read()?;
    let wanted = checked(&case)?;
    case.warnings().iter().for_each(|warning| report::warn(warning));
    memory::check(&case.setup::<f64>(), false, 0)?;
    let target = args.output.target(&args.case, "find")?;
    out::keep_source(&case, &target)?;
    let folder = target.folder.clone();
    let of_run = tables(&case, true, false);
    let own = own_files(&case, &wanted, args.plot);
    let files = OutputSet::open(target, &[&of_run[..], &own, &[ITERATES, FOUND, SUMMARY, CASE]].concat())?;
    files.write_text(CASE, &case.to_toml())?;
    let (result, iterates) = searched(&case, &wanted, args.prove, args.case.quiet)?;
    files.write_table(ITERATES, |out| write_iterates(out, &wanted, &iterates))?;
    let steps = iterates.len().saturating_sub(1);
    let found = match result {
        Ok(found) => found,
        Err(none) => return Err(not_found(args, files, &case, (none, steps))),
    };
    let setup: Setup = found.case.setup();
    let (run, seconds) = run::run(&found.case, &setup, Wanted { sums: true, ..Wanted::default() });
    let run = run.map_err(|none| match none {
        NoRun::Unsolved(failure, _) => anyhow::Error::from(failure),
        NoRun::Unsampled(_) => unreachable!("no sample was asked for"),
    })?;
    let judged = run.judged(&setup, false, false);
    if args.output.json || args.case.quiet {
        judged.suspicions.iter().for_each(|warning| report::warn(warning));
    }
    write_tables(&files, &of_run, &FormatArgs::default(), &|name, out| {
        write_table(name, out, &found.case, (&run, None), 1)
    })?;
    if let Some(fit) = &found.fit {
        files.write_table(FIT, |out| write_fit(out, &wanted, fit))?;
    }
    if args.plot {
        draw(&files, &args.case.headed(case.title.as_deref()), (&found.case, &wanted), (&run, found.fit.as_ref()))?;
    }
    files.write_text(FOUND, &found.case.to_toml())?;
    let json = find_summary(&found.case, &wanted, (&found, steps), (&run, &judged), [seconds, 0.0]);
    files.write_text(SUMMARY, &json)?;
    files.commit(&|_| true)?;
    args.output.tell(args.case.quiet, &json, || {
        let title = args.case.headed(case.title.as_deref());
        let of_run = Told { title: "its run", case: &found.case, run: &run, judged: &judged, solve_seconds: seconds };
        told(&title, &wanted, &found, steps) + &of_run.lines(&folder)
    })?;
    Ok(ExitCode::SUCCESS)
}

/// The files besides those of a run and of every search.
fn own_files(case: &Case, wanted: &Find, plot: bool) -> Vec<&'static str> {
    let of_data: &[&str] = if matches!(wanted.goal, Goal::Data(_)) { &[FIT, PICTURE_OF_FIT] } else { &[] };
    let drawn = if plot { pictures::names_of_run(case) } else { Vec::new() };
    of_data.iter().copied().filter(|name| plot || *name == FIT).chain(drawn).collect()
}

/// Writes what there is of a search that found nothing, and returns the error.
fn not_found(args: &FindArgs, files: OutputSet, case: &Case, (none, steps): (NotFound, usize)) -> anyhow::Error {
    let summary = not_found_summary(case, (&none.message, &none.advice), steps);
    let write = || {
        files.write_text(SUMMARY, &summary)?;
        files.commit(&|name| [ITERATES, SUMMARY, CASE].contains(&name))?;
        args.output.tell(args.case.quiet, &summary, String::new)
    };
    write().err().unwrap_or_else(|| none.into())
}

/// Draws the run that was found, and the data that it fits.
fn draw(
    files: &OutputSet,
    title: &str,
    (case, wanted): (&Case, &Find),
    (run, fit): (&Run, Option<&Fit>),
) -> anyhow::Result<()> {
    let (names, charts) = (pictures::names_of_run(case), pictures::of_run(title, case, run));
    let of_fit = pictures::fit(title, wanted, run, fit).map(|chart| (PICTURE_OF_FIT, chart));
    for (name, chart) in names.into_iter().zip(charts).chain(of_fit) {
        files.write_text(name, &chart.to_svg())?;
    }
    Ok(())
}

/// Searches beside this thread, with a line about the last step if standard error is a terminal.
fn searched(case: &Case, wanted: &Find, proves: bool, is_quiet: bool) -> anyhow::Result<Searched> {
    let bar = study::bar(is_quiet, 0, "{spinner} {msg} ({elapsed})");
    bar.set_message("the first run");
    bar.enable_steady_tick(Duration::from_millis(200));
    let problem = Arc::new((case.clone(), wanted.clone(), proves));
    let (mut iterates, mut result) = (Vec::new(), None);
    enum News {
        Iterate(Iterate),
        End(Box<Result<Found, NotFound>>),
    }
    let interrupted = study::computed(
        &bar,
        &problem,
        |(case, wanted, proves), tell: &(dyn Fn(News) + Sync)| {
            let found = find(case, wanted, *proves, &mut |iterate| tell(News::Iterate(iterate)));
            tell(News::End(Box::new(found)));
        },
        |news| match news {
            News::Iterate(iterate) => {
                let Iterate { iteration, residuals, step, .. } = &iterate;
                bar.set_message(format!("step {}: residual {:.1e}, {step:.1e} to go", iteration + 1, norm(residuals)));
                iterates.push(iterate);
            }
            News::End(found) => result = Some(*found),
        },
    );
    Ok((result.filter(|_| !interrupted).ok_or(Interrupted)?, iterates))
}

/// The lines about what was found.
fn told(title: &str, wanted: &Find, found: &Found, steps: usize) -> String {
    let many = if steps == 1 { "one step".to_owned() } else { format!("{steps} steps") };
    let head = match (&found.fit, found.is_met) {
        (Some(_), _) => format!("{title}: fitted to the data in {many}"),
        (None, true) => format!("{title}: found in {many}"),
        (None, false) => format!("{title}: not all of it can be met; nearest, in least squares, after {many}"),
    };
    let errors = found.fit.as_ref().map_or_else(|| found.errors.clone(), |fit| fit.standard_errors());
    let one = |(unknown, (value, error)): (&Unknown, (&f64, &f64))| {
        format!("{} = {}, from {}", unknown.key, with_error(*value, *error), short(unknown.value))
    };
    let mut text = wrapped(&head, 2);
    for (k, all) in wanted.unknowns.iter().zip(found.values.iter().zip(&errors)).enumerate() {
        text += &row(if k == 0 { "found" } else { "" }, &one(all));
    }
    if !found.residuals.is_empty() {
        let one = |(name, residual, error): &(String, f64, f64)| format!("{name} = {residual:.1e} ± {error:.0e}");
        text += &row("residual", &listed(found.residuals.iter().map(one)));
    }
    if let Some(fit) = &found.fit {
        let own = found.errors.iter().map(|error| format!("{error:.0e}")).collect::<Vec<_>>().join(", ");
        let sigmas = if fit.has_sigmas { "" } else { ", by the scatter of the residuals" };
        let chi = if fit.has_sigmas { "chi^2" } else { "sum of squares" };
        let chi = format!("{chi} {} with {} degrees of freedom", short(fit.chi_squared), fit.degrees_of_freedom);
        text += &row("fit", &format!("{chi}; the errors are standard errors{sigmas}, and the run's own are {own}"));
    }
    let unknowns = wanted.unknowns.len();
    let mut system = format!("condition {:.0e}", found.condition);
    if found.rank < unknowns {
        system +=
            &format!("; {} of {unknowns} directions are determined, and no step went along the others", found.rank);
    }
    if !found.differenced.is_empty() {
        system += &format!("; differences of runs for {}", found.differenced.join(", "));
    }
    text += &row("system", &system);
    if let Some(geodesic) = &found.geodesic {
        text += &row("geodesic", &of_geodesic(geodesic));
    }
    match &found.existence {
        Some(Ok(existence)) => text += &row("proved", &exists(wanted, existence)),
        Some(Err(reason)) => text += &row("no proof", reason),
        None => {}
    }
    if wanted.goal == Goal::Periodic {
        text += &row("returns", &multipliers(found));
    }
    text
}

/// The length of a geodesic, and the points conjugate to its start.
fn of_geodesic(Geodesic { length, conjugate }: &Geodesic) -> String {
    let points = match conjugate.as_deref() {
        None => "; neighbours of it have no end".to_owned(),
        Some([]) => ", with no conjugate point on it".to_owned(),
        Some([one]) => format!(", with a conjugate point at gamma = {one:.6}"),
        Some(many) => {
            format!(", with {} conjugate points, at gamma = {}", many.len(), listed(many.iter().map(|at| short(*at))))
        }
    };
    format!("length {}{points}", number(*length, None, 16))
}

/// The numbers of which it is proved that they exist.
fn exists(wanted: &Find, existence: &Existence) -> String {
    let one = |(unknown, &(value, radius)): (&Unknown, &(Extended, f64))| {
        let (value, radius) = decimal(value, radius);
        format!("{} = {value} ± {radius:.1e}", unknown.key)
    };
    let numbers = listed(wanted.unknowns.iter().zip(&existence.values).map(one));
    let alone = existence.alone_within.as_ref().map_or_else(String::new, |radii| {
        format!(
            ", and no other is within {} of what was found",
            listed(radii.iter().map(|radius| rounded_down(*radius)))
        )
    });
    let (windows, seconds) = (existence.windows, 1e3 * existence.seconds);
    format!("with {numbers} a motion meets all of it exactly{alone} ({windows} steps, {seconds:.1} ms)")
}

/// A positive number in two digits, at most as large.
fn rounded_down(number: f64) -> String {
    let text = format!("{number:.1e}");
    if text.parse::<f64>().is_ok_and(|rounded| rounded <= number) { text } else { format!("{:.1e}", 0.95 * number) }
}

/// The multipliers in words.
fn multipliers(found: &Found) -> String {
    let Some(multipliers) = &found.multipliers else {
        return "its multipliers need solver.accuracy or solver.tolerance, and no event that acts".to_owned();
    };
    let complex = |re: f64, im: f64| match im {
        _ if im.abs() <= UNSEEN * f64::hypot(re, im) => short(re),
        _ if im < 0.0 => format!("{} - {}i", short(re), short(-im)),
        _ => format!("{} + {}i", short(re), short(im)),
    };
    let list = |values: &[_]| -> String {
        let values: &[nalgebra::Complex<f64>] = values;
        listed(values.iter().map(|z| complex(z.re, z.im)))
    };
    let indices = multipliers.indices.as_ref().map(|indices| format!("; stability indices {}", list(indices)));
    format!("multipliers {}{}", list(&multipliers.values), indices.unwrap_or_default())
}
