//! An accuracy asked for is kept, also where V is not smooth, and also for runs that end at a given time. (`cargo bench
//! --bench promises` does the same with as many random scenes as one likes.)

use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::engine::lobatto::{Adaptive, Goal, MOST_EVALUATIONS, MarchFailure, State};
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::Potential;
use geodesic_ivp::solve::{NoSolution, Status, solve_window_by_window};
use geodesic_ivp::{Case, Solution, solve};

use crate::common::{case, solved};
use crate::random_scenes::outcome::Outcome;
use crate::random_scenes::random::Random;
use crate::random_scenes::scenes::Scene;

fn all_kept(runs: usize, draw: impl Fn(&mut Random) -> Scene) {
    let mut random = Random(13);
    let mut unknown = 0;
    for _ in 0..runs {
        let scene = draw(&mut random);
        match scene.run() {
            Outcome::Kept { .. } => {}
            Outcome::NoReference => unknown += 1,
            outcome => panic!("{}: {outcome}: {scene}", scene.kind),
        }
    }
    assert!(10 * unknown < runs, "{unknown} of {runs} without a reference");
}

#[test]
fn random_end_times_are_hit_to_the_last_bit() {
    all_kept(300, Scene::smooth);
}

#[test]
fn cusps_kinks_and_walls_keep_the_promise() {
    all_kept(300, Scene::rough);
}

/// The case of a formula with numbers that follow.
fn formula(expression: &str, c: f64, [x, t_dot, x_dot]: [f64; 3], rest: &str) -> Case {
    let text = format!(
        "potential.formula = {{ expression = \"{expression}\" }}\nparticle.c = {c:?}\n\
         initial = {{ t = 0.0, x = {x:?}, t_dot = {t_dot:?}, x_dot = {x_dot:?} }}\n{rest}"
    );
    Case::parse("test", &text, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The true error was 9.6e-5, the estimate 5.4e-6, while K was off by 3.5e-3.
#[test]
fn an_estimate_that_k_contradicts_is_not_believed() {
    let start = [-0.884378, 4.0, -0.02371412];
    let rest = "grid.gamma_f = 4.703152\nsolver.accuracy = ";
    let cusp = |accuracy: &str| -> Solution {
        let case = formula("0.806348*sqrt(x^2 + 0.00231836^2)", 3.0, start, &format!("{rest}{accuracy}"));
        solve(&case).unwrap_or_else(|error| panic!("{error}"))
    };
    let (loose, tight) = (cusp("1e-5"), cusp("1e-11"));
    let error = (loose.end_state().x - tight.end_state().x)
        .abs()
        .max((loose.end_state().t - tight.end_state().t).abs() / tight.end_state().t);
    let estimate = loose.error_estimate.expect("it has one");
    println!("error {error:.1e}, estimate {estimate:.1e}");
    assert!(error <= estimate && estimate <= 1e-5, "{error:e} {estimate:e}");
}

#[test]
fn the_last_row_is_at_the_end_time() {
    let mut random = Random(2);
    for _ in 0..100 {
        let (t_i, t_f) = (random.between(-5.0, 5.0), random.between(5.5, 9.0));
        let accuracy = random.scale(1e-12, 1e-6);
        let solution = solved(&format!("initial.t={t_i:?} grid.t_f={t_f:?} solver.accuracy={accuracy:e}"));
        let last = solution.t().last().expect("it has nodes");
        assert_eq!([solution.end_state().t.to_bits(), last.to_bits()], [t_f.to_bits(); 2], "{t_i} {t_f} {accuracy:e}");
    }
}

fn refused(case: &Case) -> NoSolution {
    solve::<f64, _>(case).expect_err("it cannot be done")
}

#[test]
fn work_and_memory_are_bounded_before_they_are_spent() {
    // 5e10 nodes would be kept.
    let failure = refused(&case("grid.gamma_f=1e9 solver.accuracy=1e-12"));
    assert_eq!(failure.status, Status::TooManyNodes, "{failure}");
    assert!(
        failure.needed > 1e10 && failure.to_string().contains("nodes") && failure.advice().contains("--samples-only")
    );
    // Window by window nothing is kept, and evaluations are the limit.
    let failure = solve_window_by_window::<f64>(&case("grid.gamma_f=1e15 solver.accuracy=1e-8"), &mut |_| {});
    let failure = failure.expect_err("it takes years");
    assert_eq!(failure.status, Status::EvaluationLimit, "{failure}");
    assert!(failure.needed > MOST_EVALUATIONS && failure.to_string().contains("limit of 1e12"), "{failure}");
    // V changes on a scale of 1e-16, and the world-line does not get away from the start.
    let expression = "(0.7*1e3*10+x*exp(x)*-x)/(((x)^(x))^(1e16)*cosh(1.3))";
    let start = std::time::Instant::now();
    let failure = refused(&formula(expression, 1.0, [1.0, 1.0, 0.0], "grid.gamma_f = 1.0\nsolver.accuracy = 1e-12"));
    assert_eq!(failure.status, Status::TooManyNodes, "{failure}");
    assert!(start.elapsed().as_secs() < 10, "{failure}");
}

/// Horizons so steep, or accuracies so high, that errors run away before them, or a step jumps over them.
#[test]
fn a_horizon_is_named_as_the_reason_however_steep() {
    let mut random = Random(4);
    for k in 0..60 {
        let (s, d) = (random.scale(4.0, 1e8), random.between(0.6, 4.0));
        let expression = match k % 6 {
            0 => format!("-{d}*exp({s}*(x-1))"),
            1 => format!("-{d}*(1+tanh({s}*(x-1)))/2"),
            2 => format!("-{d}*abs(x)^{}", 2 + random.next() % 40),
            3 => format!("{d}*ln(abs(x-1))"),
            4 => format!("{d}-{d}/abs(x-1)^{}", 1 + random.next() % 6),
            _ => format!("-{d}*exp(-({}*(x-1))^2)", random.scale(3.0, 20.0)),
        };
        let (x, x_dot) = (random.between(-0.2, -0.05), random.between(0.5, 0.9));
        let accuracy = random.scale(1e-12, 1e-4);
        let rest = format!("grid.gamma_f = 20.0\nsolver.accuracy = {accuracy:e}");
        let failure = refused(&formula(&expression, 1.0, [x, 1.5, x_dot], &rest));
        assert_eq!(failure.status, Status::OutsideDomain, "{expression}, x = {x}, x_dot = {x_dot}, {rest}: {failure}");
    }
}

#[test]
fn advice_to_an_accuracy_speaks_of_no_nodes() {
    let failure = NoSolution { residual: 1e-9, ..refused(&case("grid.gamma_f=1e9 solver.accuracy=1e-12")) };
    let all = [
        Status::MaxIterations,
        Status::Stalled,
        Status::Singular,
        Status::OutsideDomain,
        Status::PrecisionNotReached,
        Status::AccuracyNotReached,
        Status::EndTimeNotReached,
        Status::EvaluationLimit,
        Status::TooManyNodes,
    ];
    for status in all {
        let failure = NoSolution { status, ..failure.clone() };
        let text = format!("{failure}; {}", failure.advice());
        assert!(!failure.advice().is_empty() && !text.contains("n_gamma") && !text.contains("inf"), "{text}");
    }
    let horizon = refused(&formula("-2*exp(x)", 1.0, [-3.0, 1.0, 0.9], "grid.gamma_f = 20.0\nsolver.accuracy = 1e-6"));
    assert!(horizon.status == Status::OutsideDomain && !horizon.advice().contains("n_gamma"), "{}", horizon.advice());
}

#[test]
fn a_time_that_cannot_be_printed_is_warned_of() {
    let warnings = |overrides: &str| {
        let solution = solved(overrides);
        Diagnostics::new(&solution).measures.warnings(&solution).join("; ")
    };
    assert!(warnings("initial.t=1e10 solver.accuracy=1e-12").contains("t is near 1.0e10"));
    assert!(
        warnings("grid.gamma_i=1e10 grid.gamma_f=10000000001.0 solver.accuracy=1e-12").contains("gamma is near 1.0e10")
    );
    assert!(!warnings("initial.t=1e3 solver.accuracy=1e-6").contains("near"));
    assert!(!warnings("solver.accuracy=1e-12").contains("near"));
}

/// A barrier narrower than the distance of the nodes is not seen, whatever the accuracy. Windows whose nodes are a
/// fifth of its width apart see it.
#[test]
fn windows_given_by_hand_see_what_is_narrow() {
    let start = [-0.6, 1.0, 0.6];
    let grid = "grid = { gamma_f = 64.0, n_gamma = 16, windows = 256 }\nscheme = { sbp = \"GLL16\", form = \"weak\" }";
    let x = |windows: &str| {
        let case = formula("5*exp(-((x-2)/0.05)^2)", 3.0, start, &grid.replace("256", windows));
        solve::<f64, _>(&case).unwrap_or_else(|error| panic!("{error}")).end_state().x
    };
    assert!((x("256") + 33.944_080).abs() < 1e-5 && (x("512") - x("1024")).abs() < 1e-9);
}

/// A time is reached from a window that also reaches a horizon beyond it.
#[test]
fn an_end_time_just_before_a_horizon_is_reached() {
    let metric = Metric::new(Potential::linear(1.0), 1.0, 1.0);
    let start = State { t: 0.0.into(), x: 0.0.into(), w: 0.0.into() };
    let march = |t: f64| {
        Adaptive::new(&metric, 1.0).run(start, Goal::Time(t), 1e-8, &mut |_| std::ops::ControlFlow::Continue(()))
    };
    // The cycloid of section 1: t runs to π/2 at the horizon.
    for t in [0.3, 1.0, 1.5, 1.57] {
        let end = march(t).unwrap_or_else(|failure| panic!("{t}: {failure}")).end;
        assert_eq!(end.t.hi, t);
        assert!((end.x.hi - 0.5 * (t.cos().powi(2) - 1.0)).abs() < 1e-8, "{t}: {}", end.x.hi);
    }
    assert!(matches!(march(1.6), Err(MarchFailure::OutsideDomain { .. } | MarchFailure::TimeNotReached { .. })));
}
