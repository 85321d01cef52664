//! Windows of the weak form on spectral elements, marched by the fixed-point iteration of [`crate::lobatto`].
//!
//! It is the same collocation system that Newton's method solves window by window, and every window is certified on the
//! same action; the iteration is just some fifty times faster. Where it does not converge, because a window is too long
//! for it, Newton's method takes over.

use std::ops::ControlFlow;

use super::failure::{At, NoSolution};
use super::run::{Observer, Place, Run};
use super::setup::{Scene, Settings, Setup};
use super::solution::Solution;
use super::status::{InitialGuess, Status};
use crate::geodesic::InitialData;
use crate::lobatto::{Certified, March, MarchFailure, State, Twofold, WeakRule, WindowView};

/// The windows of the run of `setup` on γ − γ_i ∈ [0, `length`], which are elements in the weak form; none if the
/// iteration does not converge. The operator on the elements is not made here: it is a matter of diagnostics.
pub(super) fn march(
    setup: &Setup,
    length: f64,
    observer: Option<Observer<'_, f64>>,
) -> Result<Option<Solution>, NoSolution> {
    let Settings { n_gamma: points, windows, form, sbp: sbp_name, digits, .. } = setup.settings;
    let Scene { metric, initial, gamma_i, .. } = &setup.scene;
    let initial = InitialData { t: 0.0, ..*initial };
    let rule = WeakRule::shared(points);
    let window_length = Twofold::from(length) / Twofold::from(windows as f64);
    // The tables hold the square of the length, and half as many digits of it again.
    let rounded_length = length / windows as f64;
    let square = rounded_length * rounded_length;
    if !(square.is_finite() && square > f64::MIN_POSITIVE / f64::EPSILON / f64::EPSILON) {
        return Ok(None);
    }
    let kept = if observer.is_some() { 1 } else { windows };
    let mut run = Run::new(&setup.scene, (form, sbp_name), digits, kept * points, observer);
    run.reserve(kept);
    run.solution.length = length;
    // The length that `SbpName::operator` gives an element, to the last bit.
    let intervals = (points - 1) as f64;
    let operator = run.solution.operators.element(points, rounded_length / intervals * intervals);
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

/// Collects marched windows, each with the certificate that it is a critical point of its action.
pub(super) struct CertifiedRun<'o> {
    pub(super) run: Run<'o, f64>,
    failure: Option<NoSolution>,
}

impl<'o> CertifiedRun<'o> {
    /// For windows that are added to `run`, on elements.
    pub(super) fn new(mut run: Run<'o, f64>) -> Self {
        run.solution.iterations.initial_guess = InitialGuess::Extrapolation;
        Self { run, failure: None }
    }

    /// Adds a window with this operator of the run that ends at γ − γ_i = `end`.
    pub(super) fn append(&mut self, view: &WindowView<'_>, end: f64, operator: usize) -> ControlFlow<()> {
        let Certified { elapsed, gradient_norm } = view.certified().expect("the march is certified");
        let (start, last) = (view.start, view.end);
        let place = Place { gamma: [view.gamma.hi, end], time: [start.t.hi, last.t.hi] };
        // Numbers that are not finite are not a result: an overflow anywhere makes the gradient or the action infinite.
        if !(gradient_norm.is_finite() && place.has_finite_action(self.run.solution.end.q_t, last.w.hi)) {
            let solution = &self.run.solution;
            let g00 = solution.metric.g00(last.x.hi);
            let at = At::overflow(solution.gamma_i + view.gamma.hi, last.x.hi, g00);
            let failure = NoSolution::marched(Status::OutsideDomain, at);
            self.failure = Some(NoSolution { residual: gradient_norm, ..failure });
            return ControlFlow::Break(());
        }
        self.run.begin_window(operator, &place, [[start.x.hi, start.w.hi], [last.x.hi, last.w.hi]], None);
        let solution = &mut self.run.solution;
        solution.gradient_norm = solution.gradient_norm.max(gradient_norm);
        solution.elapsed.extend_from_slice(elapsed);
        solution.x.extend_from_slice(view.x());
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
            None => Ok(self.run.solution),
        }
    }
}
