//! The tables of a run.

use std::fs::File;
use std::thread::{Builder, scope};

use geodesic_ivp::Case;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::tables::{
    branches, residuals, trajectory, write_events, write_growth, write_nodes, write_samples, write_sensitivity,
};
use geodesic_ivp::output::{OutputSet, write_hull};
use geodesic_ivp::solve::System;
use geodesic_ivp::study::run::{Judged, Run};

use super::format::FormatArgs;

const TRAJECTORY: &str = "trajectory.csv";
const RESIDUALS: &str = "residuals.csv";
const BRANCHES: &str = "branches.csv";
const SAMPLES: &str = "samples.csv";
const SENSITIVITY: &str = "sensitivity.csv";
const GROWTH: &str = "growth.csv";
pub(super) const HULL: &str = "hull.csv";
pub(super) const EVENTS: &str = "events.csv";

/// The tables of a run, which keeps its nodes or not, and takes samples or not.
pub(super) fn tables(case: &Case, has_nodes: bool, has_samples: bool) -> Vec<&'static str> {
    let settings = &case.settings;
    let all = [
        (TRAJECTORY, has_nodes),
        (RESIDUALS, has_nodes),
        (BRANCHES, has_nodes && settings.system == System::Doubled),
        (SAMPLES, has_samples),
        (SENSITIVITY, has_nodes && settings.sensitivity),
        (GROWTH, has_nodes && settings.sensitivity),
        (EVENTS, !case.events.is_empty()),
    ];
    all.into_iter().filter(|(_, is_wanted)| *is_wanted).map(|(name, _)| name).collect()
}

/// Writes one of these tables.
pub(super) fn write_table<S: Real>(
    name: &str,
    out: &File,
    case: &Case,
    (run, judged): (&Run<S>, Option<&Judged>),
    every: usize,
) -> csv::Result<()> {
    let (line, names) = (&run.line, run.line.geometry().names());
    let pieces = || run.parts().into_iter().map(|(line, _)| line).collect::<Vec<_>>();
    let proof = judged.and_then(|judged| judged.proof.as_ref());
    match name {
        TRAJECTORY => write_nodes(out, &run.parts(), every, trajectory),
        RESIDUALS => write_nodes(out, &run.parts(), every, residuals),
        BRANCHES => write_nodes(out, &run.parts(), every, branches),
        SAMPLES => {
            let radii = proof.map_or(&[][..], |proof| &proof.samples);
            write_samples(out, names, (&run.samples, radii), line.digits)
        }
        SENSITIVITY => write_sensitivity(out, &pieces()),
        GROWTH => write_growth(out, &pieces()),
        HULL => {
            let hull = judged.and_then(|judged| judged.hull.as_ref());
            write_hull(out, &names[..line.geometry().results()], hull.map_or(&[], |hull| &hull.way))
        }
        _ => {
            let format = (line.digits, case.settings.is_judged_on_its_way());
            let radii = proof.map_or(&[][..], |proof| &proof.events);
            write_events(out, names, &case.event_names(), (&run.events, radii), format)
        }
    }
}

/// Writes the tables, and their arrays if these are wanted, in parallel: at a million nodes that is most of the work
/// that is left after the solve.
pub(super) fn write_tables(
    files: &OutputSet,
    tables: &[&str],
    format: &FormatArgs,
    write: &(dyn Fn(&str, &File) -> csv::Result<()> + Sync),
) -> anyhow::Result<()> {
    let write = |name: &str| {
        files.write_table(name, |out| write(name, out))?;
        format.write_array(files, name)
    };
    let Some((first, others)) = tables.split_first() else { return Ok(()) };
    scope(|scope| {
        let spawned = |table| (table, Builder::new().spawn_scoped(scope, move || write(table)));
        let others: Vec<_> = others.iter().copied().map(spawned).collect();
        let first = write(first);
        others.into_iter().fold(first, |before, (table, thread)| match thread {
            Ok(thread) => before.and(thread.join().expect("writing a table does not panic")),
            // Where there is no room for a thread, one table follows the other.
            Err(_) => before.and(write(table)),
        })
    })
}
