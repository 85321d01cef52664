//! An accuracy asked for is kept, also where V is not smooth, and also for runs that end at a given time. (`cargo bench
//! --bench verdict -- 6000 1 accuracy` does the same with as many random scenes as one likes.)

use geodesic_ivp::solve::{NoSolution, Status, solve_in_parts};
use geodesic_ivp::{Case, solve};

use crate::common::{case, parsed};
use crate::random_scenes::draw::{Drawn, rough, smooth};
use crate::random_scenes::judged::{Found, Judged};
use crate::random_scenes::random::Random;
use crate::random_scenes::several::several;

/// No error is above the accuracy, and at most `most_low` are above the estimate: the bench finds one in some
/// thousands.
fn all_kept(runs: usize, most_low: usize, scene: fn(&mut Random) -> (&'static str, String)) {
    let (mut random, mut unknown, mut low, mut broken) = (Random(13), 0, 0, Vec::new());
    for _ in 0..runs {
        let drawn = Drawn::accurate(&mut random, scene);
        let judged = Judged::of(&drawn.case());
        match judged.found {
            _ if judged.is_broken() => broken.push(drawn.to_string()),
            // Rounding may be more than the accuracy of a long run.
            None | Some(Found::NoReference) => unknown += 1,
            Some(Found::Error { ratio, .. }) => low += usize::from(ratio > 1.0),
        }
    }
    assert!(broken.is_empty(), "{} of {runs} broken:\n{}", broken.len(), broken.join("\n"));
    assert!(low <= most_low, "{low} of {runs} estimates are too low");
    assert!(10 * unknown < runs, "{unknown} of {runs} refused or without a reference");
}

#[test]
fn smooth_potentials_keep_the_promise() {
    all_kept(200, 1, smooth);
}

#[test]
fn cusps_kinks_and_walls_keep_the_promise() {
    all_kept(300, 1, rough);
}

#[test]
fn scenes_of_several_coordinates_keep_the_promise() {
    all_kept(300, 0, several);
}

/// The case of a formula with numbers that follow.
fn formula(expression: &str, c: f64, [x, t_dot, x_dot]: [f64; 3], rest: &str) -> Case {
    let text = format!(
        "potential.formula = {{ expression = \"{expression}\" }}\nparticle.c = {c:?}\n\
         initial = {{ t = 0.0, x = {x:?}, t_dot = {t_dot:?}, x_dot = {x_dot:?} }}\n{rest}"
    );
    parsed(&text, &[])
}

fn refused(case: &Case) -> NoSolution {
    solve::<f64>(case).expect_err("it cannot be done")
}

#[test]
fn work_and_memory_are_bounded_before_they_are_spent() {
    // 3e10 nodes would be kept.
    let failure = refused(&case("grid.gamma_f=1e9 solver.accuracy=1e-8"));
    assert_eq!(failure.status, Status::TooManyNodes, "{failure}");
    assert!(
        failure.needed > 1e10 && failure.to_string().contains("nodes") && failure.advice().contains("--samples-only")
    );
    // Window by window nothing is kept, and evaluations are the limit.
    let failure = solve_in_parts::<f64>(&case("grid.gamma_f=1e15 solver.accuracy=1e-8"), &mut |_| {});
    let failure = failure.expect_err("it takes years");
    assert_eq!(failure.status, Status::EvaluationLimit, "{failure}");
    assert!(failure.needed > 1e12 && failure.to_string().contains("limit of 1e12"), "{failure}");
    // V changes on a scale of 1e-16, and the world-line does not get away from the start.
    let expression = "(0.7*1e3*10+x*exp(x)*-x)/(((x)^(x))^(1e16)*cosh(1.3))";
    let start = std::time::Instant::now();
    let failure = refused(&formula(expression, 1.0, [1.0, 1.0, 0.0], "grid.gamma_f = 1.0\nsolver.accuracy = 1e-12"));
    assert_eq!(failure.status, Status::Stalled, "{failure}");
    assert!(start.elapsed().as_secs() < 10, "{failure}");
}

/// Horizons so steep, or accuracies so high, that errors run away before them, or a step jumps over them.
#[test]
fn a_horizon_is_named_as_the_reason_however_steep() {
    let (mut random, mut wrong) = (Random(4), Vec::new());
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
        if failure.status != Status::OutsideDomain {
            wrong.push(format!("{expression}, x = {x}, x_dot = {x_dot}, {rest}: {failure}"));
        }
    }
    assert!(wrong.is_empty(), "{} of 60 wrong:\n{}", wrong.len(), wrong.join("\n"));
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

/// A barrier narrower than the distance of the nodes is not seen, whatever the accuracy. Windows whose nodes are a
/// fifth of its width apart see it.
#[test]
fn windows_given_by_hand_see_what_is_narrow() {
    let start = [-0.6, 1.0, 0.6];
    let grid = "grid = { gamma_f = 64.0, n_gamma = 16, windows = 256 }\nscheme = { sbp = \"GLL16\", form = \"weak\" }";
    let x = |windows: &str| {
        let case = formula("5*exp(-((x-2)/0.05)^2)", 3.0, start, &grid.replace("256", windows));
        solve::<f64>(&case).unwrap_or_else(|error| panic!("{error}")).end_state().x
    };
    assert!((x("256") + 33.944_080).abs() < 1e-5 && (x("512") - x("1024")).abs() < 1e-9);
}
