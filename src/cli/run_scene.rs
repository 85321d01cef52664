//! What `run` does with a scene of n coordinates.

use std::io::StdoutLock;
use std::time::Instant;

use geodesic_ivp::case::scene::SceneCase;
use geodesic_ivp::diagnostics::scene::SceneDiagnostics;
use geodesic_ivp::geometry::ConservedSum;
use geodesic_ivp::output::{Chart, SceneSummary, write_combined};
use geodesic_ivp::scalar::Real;
use geodesic_ivp::solve::System;
use geodesic_ivp::solve::scene::{SceneSetup, WorldLine, solve_scene};
use geodesic_ivp::study::scene_error::{SceneError, scene_error};

use super::memory;
use super::run::{Job, RunArgs, Tables};
use super::scene_readable::readable;

/// A scene, in the arithmetic of `S`.
pub(super) struct Scene<'c, S> {
    case: &'c SceneCase,
    args: &'c RunArgs,
    setup: SceneSetup<S>,
}

impl<'c, S: Real> Scene<'c, S> {
    pub(super) fn new(case: &'c SceneCase, args: &'c RunArgs) -> Self {
        Self { case, args, setup: case.setup() }
    }
}

/// A world-line with what is measured on it.
pub(super) struct Solved<S> {
    line: WorldLine<S>,
    sums: Vec<ConservedSum>,
    diagnostics: SceneDiagnostics<S>,
    /// Seconds in the solver and in the diagnostics.
    seconds: [f64; 2],
}

/// The summary, and the error of the run.
pub(super) struct Judged {
    summary: SceneSummary,
    error: Option<SceneError>,
}

impl<S: Real> Job for Scene<'_, S> {
    type Solved = Solved<S>;
    type Judged = Judged;

    fn warnings(&self) -> Vec<String> {
        self.case.warnings()
    }

    fn check_memory(&self) -> anyhow::Result<()> {
        memory::check_scene(&self.setup)
    }

    fn is_doubled(&self) -> bool {
        self.case.system() == System::Doubled
    }

    fn effective(&self) -> String {
        match self.args.case.has_overrides() {
            // The expectations hold for the case as it is in its file.
            true => self.case.without_expectations().to_toml(),
            false => self.case.to_toml(),
        }
    }

    fn progress(&self) -> String {
        format!("solving for {} nodes", self.setup.n_gamma * self.setup.windows)
    }

    fn solve(&self) -> (anyhow::Result<Solved<S>>, f64) {
        let start = Instant::now();
        let result = solve_scene(&self.setup);
        let solve_seconds = start.elapsed().as_secs_f64();
        let line = match result {
            Ok(line) => line,
            Err(failure) => return (Err(failure.into()), solve_seconds),
        };
        let start = Instant::now();
        let rough = &self.setup.rough;
        let sums = rough.geometry.conserved_sums(&rough.start.q, &rough.start.q_dot);
        let terms: Vec<Vec<(usize, S)>> =
            sums.iter().map(|sum| sum.terms.iter().map(|&(a, c)| (a, S::from(c))).collect()).collect();
        let diagnostics = SceneDiagnostics::new(&line, &terms, &mut self.case.observables(), self.case.is_lifted());
        let seconds = [solve_seconds, start.elapsed().as_secs_f64()];
        (Ok(Solved { line, sums, diagnostics, seconds }), solve_seconds)
    }

    fn failed(&self, error: &anyhow::Error, seconds: f64) -> Option<String> {
        let geometry = &self.setup.place.geometry;
        let summary = |failure| SceneSummary::new(self.case, geometry, Err(failure), seconds).to_json();
        error.downcast_ref().map(summary)
    }

    fn suspicions(&self, solved: &Solved<S>) -> Vec<String> {
        solved.diagnostics.warnings(&solved.line)
    }

    fn write_combined(&self, solved: Solved<S>, out: StdoutLock<'static>) -> csv::Result<()> {
        write_combined(out, &solved.line, &solved.diagnostics)
    }

    fn judge(&self, solved: &Solved<S>) -> (Judged, Vec<String>) {
        let Solved { line, sums, diagnostics, seconds } = solved;
        let mut summary = SceneSummary::new(self.case, line.geometry(), Ok((line, diagnostics, sums)), seconds[0]);
        let error = scene_error(line);
        if let Some(solved) = &mut summary.solved {
            solved.diagnostics_seconds = seconds[1];
            error.iter().for_each(|error| solved.set_error(line.geometry().names(), error));
        }
        (Judged { summary, error }, self.suspicions(solved))
    }

    fn write_tables(&self, solved: &Solved<S>, tables: &Tables<'_>) -> anyhow::Result<()> {
        tables.nodes(&solved.line, &solved.diagnostics, solved.line.is_doubled())
    }

    fn summary(&self, judged: &mut Judged, write_seconds: f64) -> String {
        if let Some(solved) = &mut judged.summary.solved {
            solved.write_seconds = write_seconds;
        }
        judged.summary.to_json()
    }

    fn pictures(&self, _: &Solved<S>, _: &Judged) -> Vec<Chart> {
        Vec::new()
    }

    fn readable(&self, solved: &Solved<S>, judged: &Judged) -> String {
        let title =
            self.case.title().map_or_else(|| self.args.case.stem().to_string_lossy().into_owned(), str::to_owned);
        readable(&title, &solved.line, &solved.diagnostics, &solved.sums, judged.error.as_ref())
    }
}
