//! The decisions of one march, one by one.

use std::ops::ControlFlow;

use super::{Attempt, CRAWL, Controller, Ended, Judge, ONE_COORDINATE, Pace, Progress, REFINED, ROUNDS, Taken};
use crate::engine::lobatto::force::PolynomialForce;
use crate::engine::lobatto::formula::FormulaForce;
use crate::engine::lobatto::view::WindowView;
use crate::engine::lobatto::walk::{Length, Walk};
use crate::engine::lobatto::{Goal, MarchFailure, State, Statistics, kit};
use crate::geometry::metric::Metric;
use crate::geometry::potential::{Formula, Potential};
use crate::number::vector::Twofold;

fn attempt(metric: &Metric, goal: Goal) -> Attempt<'_> {
    let start = State { t: 2.0.into(), x: 0.0.into(), w: 0.0.into() };
    Attempt { metric, q_t: 1.0, start, goal, accuracy: 1e-6, length: 4.0, first: 1.0, caution: 1.0 }
}

/// A march that has come to `gamma`, t and x.
fn progress<'m>(attempt: &Attempt<'m>, gamma: f64, [t, x]: [f64; 2]) -> Progress<'m> {
    Progress {
        state: State { t: t.into(), x: x.into(), ..attempt.start },
        gamma: Twofold::from(gamma),
        judge: Judge::new(attempt.metric, attempt.q_t, 24, &attempt.start, attempt.first),
        control: Controller::new(ONE_COORDINATE, 24, attempt.accuracy, attempt.first),
        plan: None,
        pace: Pace::new(0),
        idle: 0,
    }
}

/// What is said of a march that has advanced by `advance` in many evaluations, to `gamma` and `t`.
fn stopped(attempt: &Attempt<'_>, [advance, gamma]: [f64; 2], t: f64) -> Result<(), MarchFailure> {
    let mut here = progress(attempt, gamma, [t, 0.0]);
    here.pace.advance(20_000, gamma - advance).unwrap();
    let statistics = Statistics { windows: 5, evaluations: 40_000, unproved: 0 };
    attempt.budget(&mut here, &statistics)
}

#[test]
fn nobody_looks_beyond_the_end_of_a_run() {
    let metric = Metric::new(Potential::free(), 1.0, 1.0);
    let to_length = attempt(&metric, Goal::Gamma(4.0));
    assert_eq!([0.0, 3.0, 3.75].map(|gamma| to_length.ahead(gamma)), [1.0, 1.0, 0.25]);
    assert_eq!(attempt(&metric, Goal::Time(4.0)).ahead(3.75), 1.0);
}

/// From rest at x = 0 it is π/4 to the horizon of g00 = 1 + 2x.
#[test]
fn a_march_that_does_not_move_is_before_a_horizon() {
    let metric = Metric::new(Potential::linear(1.0), 1.0, 1.0);
    let attempt = Attempt { first: 2.0, ..attempt(&metric, Goal::Gamma(8.0)) };
    let crawl = CRAWL * attempt.first;
    let failure = stopped(&attempt, [0.9 * crawl, 3.0], 2.0).unwrap_err();
    let MarchFailure::OutsideDomain { window, gamma, x, .. } = failure else { panic!("{failure}") };
    assert!(window == 5 && (gamma - 3.0 - std::f64::consts::FRAC_PI_4).abs() < 1e-3, "{gamma}");
    assert!((x + 0.5).abs() < 1e-3, "{x}");
    // One that does move is not, and may go on.
    assert_eq!(stopped(&attempt, [1.1 * crawl, 3.0], 2.0), Ok(()));
}

#[test]
fn a_march_that_crawls_says_what_it_would_need() {
    let metric = Metric::new(Potential::free(), 1.0, 1.0);
    // A part of 2⁻³⁰ is done.
    let (part, needed) = (0.5_f64.powi(30), 40_000.0 * 2.0_f64.powi(30));
    for (goal, gamma, t) in [(Goal::Gamma(4.0), 4.0 * part, 2.0), (Goal::Time(4.0), 1e-9, 2.0 + 4.0 * part)] {
        let expected = MarchFailure::EvaluationLimit { gamma, x: 0.0, evaluations: 40_000, needed };
        assert_eq!(stopped(&attempt(&metric, goal), [0.0, gamma], t), Err(expected));
    }
}

/// A window counts for as long as windows are on average, and for a part of the first one at least.
#[test]
fn the_time_scale_is_that_of_windows() {
    let metric = Metric::new(Potential::free(), 1.0, 1.0);
    let attempt = attempt(&metric, Goal::Gamma(4.0));
    assert_eq!(attempt.scale(2.0, 100.0, 10), 10.0);
    assert_eq!(attempt.scale(20.0, 100.0, 10), 20.0);
    assert_eq!(attempt.scale(1e-3, 0.0, 0), 1.0 / 16.0);
}

/// The iteration of a window ends at a tolerance for its motion, relative to x.
#[test]
fn the_tolerance_of_a_window_is_relative_to_x() {
    let metric = Metric::new(Potential::free(), 1.0, 1.0);
    let attempt = attempt(&metric, Goal::Gamma(4.0));
    let tolerance =
        |x: f64| attempt.plan(&progress(&attempt, 0.0, [2.0, x]), &Statistics::default()).precision.tolerance;
    assert!(tolerance(0.5) > 0.0 && tolerance(0.5) == tolerance(1.0));
    assert_eq!(tolerance(1.0), 8.0 * tolerance(-8.0));
}

/// The estimate of a march holds what rounding adds to a window that is summed in plain or in twofold precision.
#[test]
fn rounding_is_counted_as_windows_are_summed() {
    let metric = Metric::new(Potential::quartic(1.0), 1.0, 1.0);
    let start = State { t: 0.0.into(), x: 1.0.into(), w: 0.5.into() };
    let attempt = Attempt { q_t: 2.0, start, first: 0.25, ..attempt(&metric, Goal::Gamma(4.0)) };
    for (refine, rounds) in [(false, ROUNDS), (true, REFINED)] {
        let force = PolynomialForce::new(&metric, 2.0, &[0.0, 0.0, 0.0, 0.0, 1.0]);
        let mut walk = Walk::new(kit::fine(), force, None, false);
        let (mut here, mut statistics) = (progress(&attempt, 0.0, [0.0, 1.0]), Statistics::default());
        here.state = start;
        let mut task = attempt.next(&mut here, &statistics);
        task.precision.refine = refine;
        let taken = attempt.solve(&mut walk, &mut here, task, &mut statistics).expect("a short window");
        let mut judge = progress(&attempt, 0.0, [0.0, 1.0]).judge;
        judge.see(&taken.solved, taken.end, task.length.h.hi, task.scale, rounds);
        let mut go_on = |_: &WindowView<'_>| ControlFlow::Continue(());
        let accepted = attempt.accept(&mut walk, &mut here, task, &taken, &mut statistics, &mut go_on);
        assert!(matches!(accepted, Ok(false)));
        assert_eq!(here.judge.so_far(), judge.so_far());
    }
}

/// With V = ¼ (1 − sign x), at each value of γ where a node of the window crosses x = 0, t jumps.
#[test]
fn a_time_that_is_jumped_over_is_told_of_where_it_is() {
    let formula = Formula::new("0.25*(1 - tanh(1e300*x))", &Default::default()).unwrap();
    let metric = Metric::new(Potential::Formula(formula), 1.0, 1.0);
    let Potential::Formula(formula) = metric.potential() else { panic!("a formula") };
    let start = State { t: 2.0.into(), x: (-1.0).into(), w: 1.0.into() };
    let attempt = Attempt { start, ..attempt(&metric, Goal::Time(1.0)) };
    let kit = kit::fine();
    let mut walk = Walk::new(kit, FormulaForce::<24>::new(&metric, 1.0, formula.program(), 24), None, false);
    let (mut here, mut statistics) = (progress(&attempt, 3.0, [2.0, -1.0]), Statistics::default());
    here.state = start;
    // The first node behind the middle crosses at this length, where half of the window or a little more has u = ½.
    let length = 1.0 / kit.rule.nodes()[12].hi;
    let mut jump = 0.5 * length;
    jump += 0.5 * length * kit.rule.weights()[12..].iter().map(|weight| weight.hi).sum::<f64>();
    jump -= 0.25 * length * kit.rule.weights()[12].hi;
    let mut task = attempt.next(&mut here, &statistics);
    task.length = Length::exactly(2.5.into(), 1.0);
    let solved = walk.solve(task.length, &start, task.precision, &mut statistics).unwrap();
    let mut taken = Taken { solved, end: here.judge.joint(&solved.end), excess: 0.0 };
    let looked = attempt.look_at_time(&mut walk, &mut here, (&mut task, &mut taken), &mut statistics, jump);
    let MarchFailure::TimeNotReached { gamma, elapsed } = looked.unwrap_err() else { panic!("t jumps over it") };
    assert!((gamma - 3.0 - length).abs() < 1e-12, "{gamma}, {length}");
    assert!((elapsed - jump).abs() < 0.1 && elapsed != jump, "{elapsed}, {jump}");
}

/// Where no share is small enough, the reason is given with its place.
#[test]
fn what_keeps_a_march_from_its_accuracy_is_said() {
    let failure = |metric: &Metric, goal: Goal, [gamma, t, x]: [f64; 3]| {
        let attempt = Attempt { accuracy: 1e-17, ..attempt(metric, goal) };
        let here = progress(&attempt, gamma, [t, x]);
        let start = here.state;
        match attempt.check(&here, &start, 7, 0.0) {
            Err(Ended::Failed(failure)) => failure,
            _ => panic!("no error is as small"),
        }
    };
    // From rest at x = 0 it is π/4 to the horizon of g00 = 1 + 2x.
    let falling = Metric::new(Potential::linear(1.0), 1.0, 1.0);
    let MarchFailure::OutsideDomain { window, gamma, .. } = failure(&falling, Goal::Gamma(8.0), [3.0, 5.0, 0.0]) else {
        panic!("a horizon is near")
    };
    assert!(window == 7 && (gamma - 3.0 - std::f64::consts::FRAC_PI_4).abs() < 1e-3, "{gamma}");
    // g00 = 1 + x²: at x = 999 t grows by 1e-6 a unit of γ, and at x = 9 by 1e-2.
    let metric = Metric::new(Potential::polynomial(vec![0.0, 0.0, 0.5]), 1.0, 1.0);
    let stopped = MarchFailure::TimeNotReached { gamma: 400.0, elapsed: 0.75 };
    assert_eq!(failure(&metric, Goal::Time(1.0), [400.0, 2.75, 999.0]), stopped);
    // With a charge of a hundredth it grows by as much less.
    let slow = Attempt { q_t: 0.01, ..attempt(&metric, Goal::Time(1.0)) };
    let [near, far] = [9.0, 99.0].map(|x: f64| State { t: 2.75.into(), x: x.into(), w: 0.0.into() });
    assert!(slow.is_out_of_reach(1.0, [&far; 2], 1.0) && !slow.is_out_of_reach(1.0, [&near; 2], 100.0));
    for (goal, at) in [
        (Goal::Gamma(1e9), [400.0, 2.75, 999.0]),
        (Goal::Time(1.0), [400.0, 2.75, 9.0]),
        // Almost there, or almost at the start.
        (Goal::Time(0.76), [400.0, 2.75, 999.0]),
        (Goal::Time(1.0), [400.0, 2.01, 999.0]),
    ] {
        let failure = failure(&metric, goal, at);
        assert!(matches!(failure, MarchFailure::AccuracyNotReached { gamma: 400.0, .. }), "{failure}");
    }
}
