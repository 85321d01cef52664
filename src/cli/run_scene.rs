//! What `run` does with a scene of n coordinates.

use std::io::StdoutLock;
use std::time::Instant;

use geodesic_ivp::case::scene::SceneCase;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::diagnostics::gaps::Gaps;
use geodesic_ivp::diagnostics::scene::SceneMeasures;
use geodesic_ivp::geometry::ConservedSum;
use geodesic_ivp::number::Real;
use geodesic_ivp::output::pictures::scene::{self as pictures, PlotAxes};
use geodesic_ivp::output::{Chart, SceneSummary, Seconds, SolvedScene, write_combined, write_events, write_samples};
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{NoSolution, Setup, WorldLine, solve};
use geodesic_ivp::study::errors::{reference_error, run_error};
use geodesic_ivp::study::verdict::of_world_line;
use geodesic_ivp::trajectory::{Coordinate, Crossing, Sample, Sampler, crossings};

use super::memory;
use super::report::Refusal;
use super::run::{Job, Judged, RunArgs, Tables, doubt_gaps};
use super::scene_readable::{events, readable};

/// The last one only where there are events.
const PICTURES: [&str; 4] = ["orbit.svg", "charges.svg", "mesh.svg", "section.svg"];

/// A scene, in the arithmetic of `S`.
pub(super) struct Scene<'c, S: Real> {
    case: &'c SceneCase,
    args: &'c RunArgs,
    setup: Setup<S>,
}

impl<'c, S: Real> Scene<'c, S> {
    pub(super) fn new(case: &'c SceneCase, args: &'c RunArgs) -> Self {
        Self { case, args, setup: case.setup() }
    }

    /// The index of the coordinate t.
    fn time(&self) -> Option<usize> {
        self.setup.place.geometry.names().iter().position(|name| name == "t")
    }

    fn has_events(&self) -> bool {
        !self.case.events().is_empty()
    }

    fn event_names(&self) -> Vec<&str> {
        self.case.events().iter().map(|event| event.name.as_str()).collect()
    }

    /// The samples that are asked for.
    fn samples(&self, line: &WorldLine<S>) -> anyhow::Result<Vec<Sample<S>>> {
        let Some((coordinate, values)) = self.args.samples.values::<S>() else { return Ok(Vec::new()) };
        let mut sampler = Sampler::new(line);
        let time = self.time().filter(|_| coordinate == Coordinate::Time);
        if time.is_some_and(|t| !sampler.is_monotonic(t)) {
            let message = "t does not grow, or fall, all the way: a time is not one place of the world-line";
            return Err(Refusal::usage(message).help("take samples with --sample-gamma").into());
        }
        let at = |value| match time {
            Some(t) => sampler.at_value(t, value),
            None => sampler.at_gamma(value),
        };
        let found: Result<_, _> = values.into_iter().map(at).collect();
        found.map_err(|outside| self.args.samples.refuse(outside, line.digits).into())
    }
}

/// A world-line with what is measured on it.
pub(super) struct Solved<S: Real> {
    line: WorldLine<S>,
    sums: Vec<ConservedSum>,
    diagnostics: Diagnostics<S, SceneMeasures<S>>,
    samples: Vec<Sample<S>>,
    /// The events of the case, in the order of γ.
    events: Vec<Crossing<S>>,
    /// Seconds in the solver and in the diagnostics.
    seconds: [f64; 2],
}

impl<S: Arithmetic> Job for Scene<'_, S> {
    type Solved = Solved<S>;
    type Numbers = SolvedScene;

    fn check_options(&self) -> anyhow::Result<()> {
        let samples = &self.args.samples;
        if samples.only() {
            let help = "leave --samples-only out: samples.csv is written beside the other tables";
            return Err(Refusal::usage("the run of a scene is kept as a whole").help(help).into());
        }
        let by_time = matches!(samples.values::<f64>(), Some((Coordinate::Time, _)));
        if by_time && self.time().is_none() {
            let help = "take samples with --sample-gamma";
            return Err(Refusal::usage("--sample-t needs a coordinate t, and the scene has none").help(help).into());
        }
        Ok(())
    }

    fn check_memory(&self) -> anyhow::Result<()> {
        memory::check(&self.setup, Some(&self.args.samples))
    }

    fn solve(&self) -> (anyhow::Result<Solved<S>>, f64) {
        let start = Instant::now();
        let result = solve(&self.setup);
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
        let diagnostics = Diagnostics::of_scene(&line, &terms, &mut self.case.observables(), self.case.is_lifted());
        let events = crossings(&line, &mut self.case.watches());
        let samples = self.samples(&line);
        let seconds = [solve_seconds, start.elapsed().as_secs_f64()];
        let solved = samples.map(|samples| Solved { line, sums, diagnostics, samples, events, seconds });
        (solved, solve_seconds)
    }

    fn failed(&self, failure: &NoSolution, seconds: f64) -> SceneSummary {
        SceneSummary::new(self.case, &self.setup.place.geometry, Err(failure), seconds)
    }

    fn suspicions(&self, solved: &Solved<S>) -> Vec<String> {
        solved.diagnostics.warnings(&solved.line)
    }

    fn write_combined(&self, solved: Solved<S>, out: StdoutLock<'static>) -> csv::Result<()> {
        write_combined(out, &solved.line, &solved.diagnostics)
    }

    fn judge(&self, solved: &Solved<S>) -> Judged<SolvedScene> {
        let Solved { line, sums, diagnostics, events, seconds, .. } = solved;
        let mut summary = SceneSummary::new(self.case, line.geometry(), Ok((line, diagnostics, sums)), seconds[0]);
        let wanted = self.args.reference;
        let reference = if wanted { reference_error(&self.setup, line, &[]) } else { None };
        let estimate =
            if line.error_estimate.is_some() || reference.is_none() { run_error(&self.setup, line, &[]) } else { None };
        let contradiction = reference.as_ref().filter(|_| estimate.is_some());
        let verdict = of_world_line(line, diagnostics, estimate.as_ref().or(reference.as_ref()), contradiction);
        let error = reference.or(estimate);
        let looks_between = self.args.enclose && line.accuracy.is_none();
        let gaps = looks_between.then(|| Gaps::new(line, &self.setup.rough.geometry, verdict.error));
        summary.set_error(error.as_ref(), verdict);
        let mut suspicions = self.suspicions(solved);
        if let Some(gaps) = &gaps {
            doubt_gaps(&mut summary, gaps, &mut suspicions);
        }
        summary.seconds = Some(Seconds { diagnostics: seconds[1], write: 0.0 });
        if let Some(numbers) = summary.solved_mut() {
            numbers.gaps = gaps;
            for (index, event) in self.case.events().iter().enumerate() {
                let count = events.iter().filter(|crossing| crossing.watch == index).count();
                numbers.events.insert(event.name.clone(), count);
            }
        }
        Judged { summary, error, suspicions }
    }

    fn write_tables(&self, solved: &Solved<S>, tables: &Tables<'_>) -> anyhow::Result<()> {
        let Solved { line, diagnostics, samples, events, .. } = solved;
        let names = line.geometry().names();
        if self.args.samples.wanted() {
            tables.samples(|out| write_samples(out, names, samples, line.digits))?;
        }
        if self.has_events() {
            tables.events(|out| write_events(out, names, &self.event_names(), events, line.digits))?;
        }
        tables.nodes(line, diagnostics)
    }

    fn picture_names(&self) -> &'static [&'static str] {
        if self.has_events() { &PICTURES } else { &PICTURES[..PICTURES.len() - 1] }
    }

    fn pictures(&self, title: &str, solved: &Solved<S>) -> Vec<Chart> {
        let Solved { line, sums, diagnostics, events, .. } = solved;
        let (formulas, labels) = self.case.plot_axes(line.geometry());
        let axes = PlotAxes { formulas, labels };
        let mut pictures = vec![
            pictures::orbit(title, line, &axes),
            pictures::charges(title, line, diagnostics, sums),
            pictures::mesh(title, line),
        ];
        if self.has_events() {
            pictures.push(pictures::section(title, line, &axes, &self.event_names(), events));
        }
        pictures
    }

    fn readable(&self, title: &str, solved: &Solved<S>, judged: &Judged<SolvedScene>) -> String {
        let Solved { line, sums, diagnostics, .. } = solved;
        let events = events(&self.event_names(), &solved.events, line.digits);
        let gaps = judged.summary.solved().and_then(|solved| solved.gaps.as_ref());
        readable(title, line, diagnostics, sums, judged.error.as_ref(), gaps, events)
    }
}
