//! Windows of the weak form on spectral elements, solved by the fixed-point iterations of [`crate::engine`].
//!
//! It is the same collocation system that Newton's method solves window by window, and every window is certified on the
//! same action; the iteration is just some fifty times faster. Where it does not converge, because a window is too long
//! for it, Newton's method takes over.

use std::ops::ControlFlow;

use super::accuracy::{JointOf, append};
use super::failure::{At, NoSolution};
use super::places::Places;
use super::run::{Observer, Run};
use super::setup::{Settings, Setup};
use super::solution::Solution;
use super::space::Space;
use super::status::{InitialGuess, Status};
use super::world_line::{Joint, Place, WorldLine};
use crate::engine::lobatto::{Certified, March, MarchFailure, State, Twofold, WeakRule, WindowView};
use crate::engine::{Engine, MOST_POINTS};
use crate::geometry::Geometry;
use crate::geometry::metric::Metric;

/// The windows of the run of `setup` on γ − γ_i ∈ [0, `length`], which are elements in the weak form; none if the
/// iteration does not converge. The operator on the elements is not made here: it is a matter of diagnostics.
pub(super) fn march(
    setup: &Setup<f64, Metric>,
    length: f64,
    observer: Option<Observer<'_, f64, Metric>>,
) -> Result<Option<Solution>, NoSolution> {
    let Settings { n_gamma: points, windows, .. } = setup.settings;
    let (metric, initial, gamma_i) = (setup.metric(), setup.initial(), setup.gamma_i);
    let rule = WeakRule::shared(points);
    let window_length = Twofold::from(length) / Twofold::from(windows as f64);
    // The tables hold the square of the length, and half as many digits of it again.
    let rounded_length = length / windows as f64;
    let square = rounded_length * rounded_length;
    if !(square.is_finite() && square > f64::MIN_POSITIVE / f64::EPSILON / f64::EPSILON) {
        return Ok(None);
    }
    let mut run = Run::new(setup, &setup.settings, observer);
    run.expect(windows, points);
    run.reserve();
    run.line.length = length;
    // The length that `SbpName::operator` gives an element, to the last bit.
    let intervals = (points - 1) as f64;
    let operator = run.line.operators.element(points, rounded_length / intervals * intervals);
    let mut certified = CertifiedRun::new(run);
    let march = March::new(metric, initial.invariants(metric).q_t, rule, window_length).certified();
    let marched = march.run(State::from(initial), windows, &mut |view| {
        let end = if view.index + 1 == windows { length } else { (view.gamma + view.length).hi };
        certified.append(view, end, operator)
    });
    let mut run = certified.finish()?;
    match marched {
        Ok(marched) => {
            run.iterations.count = marched.statistics.evaluations;
            Ok(Some(run))
        }
        Err(MarchFailure::OutsideDomain { gamma, x, g00, .. }) => {
            Err(NoSolution::marched(Status::OutsideDomain, At::x(gamma_i + gamma, x, g00)))
        }
        Err(_) => Ok(None),
    }
}

/// The windows of the run of a scene on γ − γ_i ∈ [0, `length`], which are elements in the weak form; none if the
/// engine has no rule of so many nodes, or if it does not get to the end: Newton's method takes over there, and knows
/// why.
pub(super) fn windows(
    setup: &Setup<f64>,
    length: f64,
    observer: Option<Observer<'_, f64, Geometry>>,
) -> Result<Option<WorldLine>, NoSolution> {
    let Settings { n_gamma: points, windows, .. } = setup.settings;
    let Place { geometry, start, .. } = &setup.place;
    if points > MOST_POINTS {
        return Ok(None);
    }
    let Ok(mut engine) = Engine::equal(geometry, start, length, windows, points) else { return Ok(None) };
    let mut run = Run::new(setup, &setup.settings, observer);
    run.expect(windows, points);
    run.reserve();
    run.line.length = length;
    run.line.iterations.initial_guess = InitialGuess::Extrapolation;
    let window_length = length / windows as f64;
    let operator = run.line.operators.element(points, window_length);
    let mut joint = JointOf::new(start);
    for index in 1..=windows {
        let Ok(Some(mut window)) = engine.next() else { return Ok(None) };
        let gamma = if index == windows { length } else { index as f64 * window_length };
        run.line.iterations.count += window.sweeps;
        if append(&mut run, &mut window, &mut joint, (geometry, operator), gamma).is_err() {
            return Ok(None);
        }
    }
    Ok(Some(run.line))
}

/// Collects marched windows, each with the certificate that it is a critical point of its action.
pub(super) struct CertifiedRun<'o> {
    pub(super) run: Run<'o, f64, Metric>,
    failure: Option<NoSolution>,
}

impl<'o> CertifiedRun<'o> {
    /// For windows that are added to `run`, on elements.
    pub(super) fn new(mut run: Run<'o, f64, Metric>) -> Self {
        run.line.iterations.initial_guess = InitialGuess::Extrapolation;
        Self { run, failure: None }
    }

    /// Adds a window with this operator of the run that ends at γ − γ_i = `end`.
    pub(super) fn append(&mut self, view: &WindowView<'_>, end: f64, operator: usize) -> ControlFlow<()> {
        let Certified { elapsed, gradient_norm } = view.certified().expect("the march is certified");
        let (last, line) = (view.end, &self.run.line);
        let (q, p) = ([last.t.hi, last.x.hi], [line.place.start.p[0], -last.w.hi]);
        let joint = Joint { q: &q, p: &p };
        // Numbers that are not finite are not a result: an overflow anywhere makes the gradient or the action infinite.
        if !(gradient_norm.is_finite() && line.geometry().has_finite_action(joint, end - view.gamma.hi)) {
            let at = line.geometry().place_of_overflow(line.gamma_i + view.gamma.hi, &q);
            let failure = NoSolution::marched(Status::OutsideDomain, at);
            self.failure = Some(NoSolution { residual: gradient_norm, ..failure });
            return ControlFlow::Break(());
        }
        self.run.begin_window(operator, end, joint, Vec::new());
        let line = &mut self.run.line;
        line.gradient_norm = line.gradient_norm.max(gradient_norm);
        line.q[0].extend_from_slice(elapsed);
        line.q[1].extend_from_slice(view.x());
        self.run.end_window();
        ControlFlow::Continue(())
    }

    /// The run.
    ///
    /// # Errors
    /// Why a window could not be added.
    pub(super) fn finish(self) -> Result<Solution, NoSolution> {
        match self.failure {
            Some(failure) => Err(failure),
            None => Ok(self.run.line),
        }
    }
}
