//! What `run` does with a case of one coordinate in a potential.

use std::io::StdoutLock;
use std::time::Instant;

use geodesic_ivp::diagnostics::gaps::Gaps;
use geodesic_ivp::diagnostics::{Diagnostics, Measures};
use geodesic_ivp::number::Real;
use geodesic_ivp::output::pictures::{self, Run};
use geodesic_ivp::output::{self, Chart, Seconds, Summary, write_combined, write_samples};
use geodesic_ivp::reference::{ReferenceTrajectory, time_parametrised};
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{NoSolution, Setup, solve_window_by_window};
use geodesic_ivp::study::errors::{reference_error, run_error};
use geodesic_ivp::study::verdict::of_solution;
use geodesic_ivp::trajectory::Sample;
use geodesic_ivp::{Case, Solution, solve};

use super::memory;
use super::readable::readable;
use super::report::Refusal;
use super::run::{Job, Judged, RunArgs, Tables, doubt_gaps};

const PICTURES: [&str; 5] = ["world_line.svg", "t_dot.svg", "trajectory.svg", "delta_q_t.svg", "delta_g.svg"];

/// A case of one coordinate, in the arithmetic of `S`.
pub(super) struct OneCoordinate<'c, S: Real> {
    case: &'c Case,
    args: &'c RunArgs,
    setup: Setup<S>,
}

impl<'c, S: Arithmetic> OneCoordinate<'c, S> {
    pub(super) fn new(case: &'c Case, args: &'c RunArgs) -> Self {
        Self { case, args, setup: Setup::from(case) }
    }

    /// Whether to look between the nodes. With an accuracy the solver has.
    fn looks_between(&self) -> bool {
        self.args.enclose && self.case.solver.accuracy.is_none()
    }
}

/// The result of a solve.
pub(super) struct Solved<S: Real> {
    /// The whole run, or only its last window with `--samples-only`.
    solution: Solution<S>,
    /// `None` with `--samples-only`.
    diagnostics: Option<Diagnostics<S>>,
    measures: Measures<S>,
    samples: Vec<Sample<S>>,
    /// Seconds in the solver and in the diagnostics.
    seconds: [f64; 2],
}

impl<S: Arithmetic> Job for OneCoordinate<'_, S> {
    type Solved = Solved<S>;
    type Numbers = output::Solved;

    fn check_options(&self) -> anyhow::Result<()> {
        if self.looks_between() && self.args.samples.only() {
            let help = "leave one of them out, or ask for solver.accuracy, which looks between the nodes on the way";
            return Err(Refusal::usage("--samples-only keeps no nodes that --enclose could look between")
                .help(help)
                .into());
        }
        Ok(())
    }

    fn check_memory(&self) -> anyhow::Result<()> {
        memory::check(&self.setup, Some(&self.args.samples))
    }

    fn solve(&self) -> (anyhow::Result<Solved<S>>, f64) {
        let start = Instant::now();
        let samples = &self.args.samples;
        let mut stream = samples.stream(self.case);
        let mut measures: Option<Measures<S>> = None;
        let result = if samples.only() {
            solve_window_by_window(&self.setup, &mut |window: &Solution<S>| {
                let here = Diagnostics::new(window).measures;
                let before = measures.take().filter(|_| window.window_count > 1);
                measures = Some(before.map_or(here, |before| before.followed_by(here)));
                stream.iter_mut().for_each(|stream| stream.see(window));
            })
        } else {
            solve(&self.setup)
        };
        let solve_seconds = start.elapsed().as_secs_f64();
        let solution = match result {
            Ok(solution) => solution,
            Err(failure) => return (Err(failure.into()), solve_seconds),
        };
        let start = Instant::now();
        let (diagnostics, measures) = match measures {
            Some(measures) => (None, measures),
            None => {
                let diagnostics = Diagnostics::new(&solution);
                stream.iter_mut().for_each(|stream| stream.see(&solution));
                let measures = diagnostics.measures;
                (Some(diagnostics), measures)
            }
        };
        let seconds = [solve_seconds, start.elapsed().as_secs_f64()];
        let found = stream.map_or(Ok(Vec::new()), |stream| stream.finish(&solution));
        let found = found.map_err(|outside| samples.refuse(outside, solution.digits).into());
        (found.map(|samples| Solved { solution, diagnostics, measures, samples, seconds }), solve_seconds)
    }

    fn failed(&self, failure: &NoSolution, seconds: f64) -> Summary {
        Summary::new::<S>(self.case, Err(failure), seconds)
    }

    fn suspicions(&self, solved: &Solved<S>) -> Vec<String> {
        let warnings = solved.measures.warnings(&solved.solution);
        warnings.into_iter().chain(solved.measures.newtonian_warning()).collect()
    }

    fn write_combined(&self, solved: Solved<S>, out: StdoutLock<'static>) -> csv::Result<()> {
        let Solved { solution, diagnostics, samples, .. } = solved;
        match diagnostics {
            Some(diagnostics) => write_combined(out, &solution, &diagnostics),
            None => write_samples(out, solution.geometry().names(), &samples, solution.digits),
        }
    }

    fn judge(&self, Solved { solution, measures, samples, seconds, .. }: &Solved<S>) -> Judged<output::Solved> {
        let mut summary = Summary::new(self.case, Ok((solution, measures)), seconds[0]);
        // The nodes before the last window may be gone; what is written is compared all the same.
        let samples = if self.args.samples.only() { samples.as_slice() } else { &[] };
        let wanted = self.args.reference;
        let reference = if wanted { reference_error(&self.setup, solution, samples) } else { None };
        let error = reference.or_else(|| run_error(&self.setup, solution, samples));
        let verdict = of_solution(solution, measures, error.as_ref());
        let mut suspicions = measures.warnings(solution);
        let gaps = self.looks_between().then(|| Gaps::new(solution, &self.setup.rough.geometry, verdict.error));
        summary.set_error(error.as_ref(), verdict);
        if let Some(gaps) = gaps {
            doubt_gaps(&mut summary, &gaps, &mut suspicions);
            if let Some(numbers) = summary.solved_mut() {
                numbers.gaps = Some(gaps);
            }
        }
        suspicions.extend(measures.newtonian_warning());
        summary.seconds = Some(Seconds { diagnostics: seconds[1], write: 0.0 });
        Judged { summary, error, suspicions }
    }

    fn write_tables(&self, solved: &Solved<S>, tables: &Tables<'_>) -> anyhow::Result<()> {
        let Solved { solution, diagnostics, samples, .. } = solved;
        if self.args.samples.wanted() {
            tables.samples(|out| write_samples(out, solution.geometry().names(), samples, solution.digits))?;
        }
        match diagnostics {
            Some(diagnostics) => tables.nodes(solution, diagnostics),
            None => Ok(()),
        }
    }

    fn picture_names(&self) -> &'static [&'static str] {
        &PICTURES
    }

    fn pictures(&self, title: &str, solved: &Solved<S>) -> Vec<Chart> {
        let Some(diagnostics) = &solved.diagnostics else { return Vec::new() };
        pictures(title, self.case, &solved.solution, diagnostics).to_vec()
    }

    fn readable(&self, title: &str, solved: &Solved<S>, judged: &Judged<output::Solved>) -> String {
        readable(title, &solved.solution, &solved.measures, &judged.summary, judged.error.as_ref())
    }
}

/// One chart for each picture of a run, in the order of their names.
fn pictures<S: Real>(title: &str, case: &Case, solution: &Solution<S>, diagnostics: &Diagnostics<S>) -> [Chart; 5] {
    let runs = [Run { label: "", solution, diagnostics }];
    // If the reference does not reach the end, the picture is drawn without it. For a line f64 is precise enough.
    let (geometry, start) = (case.geometry(), case.start());
    let reference = ReferenceTrajectory::new(&geometry, &start, solution.length.to_f64(), f64::MOST_DIGITS).ok();
    let duration = (solution.end_state().t - solution.t_i()).to_f64();
    let in_time = time_parametrised(&geometry, &start, duration, 400);
    [
        pictures::world_line(title, solution),
        pictures::time_mesh(title, &runs),
        pictures::trajectory(title, &runs, reference.as_ref(), &in_time),
        pictures::noether_charge(title, &runs),
        pictures::geodesic_residuals(title, &runs),
    ]
}
