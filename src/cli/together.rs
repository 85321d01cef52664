//! `run --plot --together`: the curves of several runs in one picture.

use std::path::Path;
use std::vec::IntoIter;

use geodesic_ivp::Case;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::output::pictures::{MOST_TOGETHER, are_apart, names_of_run, names_of_together, of_run, together};
use geodesic_ivp::output::{Chart, Origin, OutputSet};
use geodesic_ivp::study::many::ManyRuns;
use geodesic_ivp::study::run::{Wanted, run};

use super::lines::row;
use super::out::{self, OutArgs};
use super::report::{self, refused};

/// The name of these pictures in records, and of their folder without `--out`.
const COMMAND: &str = "together";

/// The pictures that a sweep has of its rows: it draws the events of all rows by itself.
const OF_EVENTS: &str = "section.svg";

/// Pictures that runs have in common.
pub(super) struct Curves {
    /// Their names.
    pub(super) names: Vec<&'static str>,
    /// The runs so far: their names, and their pictures in that order.
    runs: Vec<(String, Vec<Chart>)>,
}

impl Curves {
    /// Those of the runs of these cases, which have names.
    ///
    /// # Errors
    /// A refusal if such runs are not drawn in one picture.
    fn new(named: &[(String, &Case)]) -> anyhow::Result<Self> {
        if named.len() > MOST_TOGETHER {
            let message = format!("--together draws {MOST_TOGETHER} runs at most, and these are {}", named.len());
            return Err(refused(message, "choose some of them: more colours cannot be told apart"));
        }
        let (first, others) = named.split_first().expect("there is a case");
        for other in others {
            if let Some(reason) = are_apart(first.1, other.1) {
                let message = format!("{} and {} {reason}: they are not drawn --together", first.0, other.0);
                return Err(refused(message, "leave --together out, or give them the same coordinates and [plot]"));
            }
        }
        let cases: Vec<&Case> = named.iter().map(|(_, case)| *case).collect();
        Ok(Self { names: names_of_together(&cases), runs: Vec::new() })
    }

    /// Adds a run, with all its pictures.
    fn add(&mut self, name: &str, case: &Case, charts: Vec<Chart>) {
        let own = names_of_run(case).into_iter().zip(charts);
        let common = own.filter(|(name, _)| self.names.contains(name)).map(|(_, chart)| chart);
        self.runs.push((name.to_owned(), common.collect()));
    }

    /// Writes the pictures.
    fn write(self, files: &OutputSet, title: &str) -> anyhow::Result<()> {
        if self.runs.len() < 2 {
            report::warn(&format!("--together has {} of the runs to draw: the others failed", self.runs.len()));
        }
        let mut of_runs: Vec<_> = self.runs.into_iter().map(|(name, charts)| (name, charts.into_iter())).collect();
        for name in &self.names {
            let one = |(name, charts): &mut (String, IntoIter<Chart>)| Some((name.clone(), charts.next()?));
            files.write_text(name, &together(title, of_runs.iter_mut().filter_map(one).collect()).to_svg())?;
        }
        Ok(())
    }
}

/// The pictures of several cases, in a folder of their own.
pub(super) struct Together {
    curves: Curves,
    files: OutputSet,
}

impl Together {
    /// Opens the pictures of these cases.
    pub(super) fn open(output: &OutArgs, named: &[(String, &Case)]) -> anyhow::Result<Self> {
        let curves = Curves::new(named)?;
        let folder = output.out.clone().unwrap_or_else(|| Path::new("results").join(COMMAND));
        // Pictures of other cases are replaced as those of the same ones are.
        let origin = Origin { command: COMMAND.to_owned(), case: "<several>".to_owned() };
        let files = OutputSet::open(output.target_in(folder, origin)?, &curves.names)?;
        Ok(Self { curves, files })
    }

    /// Adds a run, with all its pictures.
    pub(super) fn add(&mut self, name: &str, case: &Case, charts: Vec<Chart>) {
        self.curves.add(name, case, charts);
    }

    /// Puts the pictures in place, and says so.
    pub(super) fn finish(self, is_quiet: bool) -> anyhow::Result<()> {
        let title = self.curves.runs.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        self.curves.write(&self.files, &title)?;
        let folder = self.files.folder().display().to_string();
        let names = self.files.commit(&|_| true)?;
        if is_quiet {
            return Ok(());
        }
        out::write(&(format!("Together: {title}\n") + &row("written", &format!("{folder}: {}", names.join(", ")))))
    }
}

/// The pictures of the rows of a sweep together: their names, and what is drawn of each row when it is solved again.
pub(super) fn of_rows(runs: &ManyRuns) -> anyhow::Result<Curves> {
    if runs.len() == 1 {
        let help = "let --vary give a key several values, or leave --together out";
        return Err(refused("--together draws several runs in one picture, and this is one", help));
    }
    if runs.len() > MOST_TOGETHER {
        let message = format!("--together draws {MOST_TOGETHER} runs at most, and these are {}", runs.len());
        return Err(refused(message, "give --vary fewer values: more colours cannot be told apart"));
    }
    let cases: Vec<(String, Case)> = valid(runs).collect();
    let named: Vec<(String, &Case)> = cases.iter().map(|(name, case)| (name.clone(), case)).collect();
    let mut curves = Curves::new(&named)?;
    curves.names.retain(|name| *name != OF_EVENTS);
    Ok(curves)
}

/// The rows that are valid cases, with their values.
fn valid(runs: &ManyRuns) -> impl Iterator<Item = (String, Case)> {
    (0..runs.len()).filter_map(|run| {
        let values = runs.axes.iter().zip(runs.values(run)).map(|(axis, value)| format!("{} = {value}", axis.key));
        Some((values.collect::<Vec<_>>().join(", "), runs.case(run).ok()?))
    })
}

/// Draws the rows of a sweep. A table keeps only their ends, so each is solved once more.
pub(super) fn draw_rows(mut curves: Curves, files: &OutputSet, runs: &ManyRuns, title: &str) -> anyhow::Result<()> {
    for (name, case) in valid(runs) {
        let charts = if case.settings.is_extended() { charts::<Extended>(&case) } else { charts::<f64>(&case) };
        charts.into_iter().for_each(|charts| curves.add(&name, &case, charts));
    }
    curves.write(files, title)
}

/// The pictures of a case, if it has a solution.
fn charts<S: Real>(case: &Case) -> Option<Vec<Chart>> {
    let run = run(case, &case.setup::<S>(), Wanted::default()).0.ok()?;
    Some(of_run("", case, &run))
}
