//! The linearised equations beside the motion: how small changes of the start grow.

use std::ops::ControlFlow;

use geodesic_ivp::Case;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::engine::{Accuracy, Engine, Growth, Sensitivity};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::output::tables::write_sensitivity;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::run::{Wanted, run as studied};

use crate::common::{distance, line_of, parsed, shipped};

const SENSITIVE: [&str; 2] = ["solver.accuracy=1e-13", "solver.sensitivity=true"];
const LONG: &str = "grid.gamma_f=300";
const OSCILLATOR: &str = r#"
[potential]
coordinates = ["x"]
formula = "x^2/2"
[particle]
law = "newtonian"
[initial]
x = 1.0
x_dot = 0.25
"#;

fn case(name: &str, set: &[&str]) -> Case {
    if name == "oscillator" { parsed(OSCILLATOR, set) } else { shipped(name, set) }
}

fn run(name: &str, set: &[&str]) -> WorldLine {
    line_of(&case(name, set))
}

fn sensitivity(line: &WorldLine) -> &Sensitivity {
    line.sensitivity.as_ref().expect("it was asked for")
}

/// The largest entry of MᵀJM − J, relative to the square of the largest entry of M.
fn defect(matrix: &[f64], n: usize) -> f64 {
    let m = n / 2;
    let product = |a: usize, b: usize| -> f64 {
        let entry = |row: usize, column: usize| matrix[row * n + column];
        (0..m).map(|k| entry(k, a) * entry(m + k, b) - entry(m + k, a) * entry(k, b)).sum()
    };
    let exact = |a: usize, b: usize| f64::from(i8::from(b == a + m)) - f64::from(i8::from(a == b + m));
    let pairs = (0..n * n).map(|at| (at / n, at % n));
    let most = pairs.map(|(a, b)| (product(a, b) - exact(a, b)).abs()).fold(0.0, f64::max);
    most / matrix.iter().fold(1.0, |most: f64, entry| most.max(entry * entry))
}

#[test]
fn matrices_are_symplectic() {
    // Velocities are the unknowns of the first scene, momenta those of the others.
    for (name, length, is_second) in [("henon-heiles", 200, true), ("kerr-inclined", 400, false)] {
        let length = format!("grid.gamma_f={length}");
        let line = run(name, &["solver.tolerance=1e-12", SENSITIVE[1], &length]);
        assert_eq!(line.geometry().is_separable(), is_second, "{name}");
        let most = sensitivity(&line).joints().map(|matrix| defect(matrix, 4)).fold(0.0, f64::max);
        assert!(most < 1e-12, "{name}: {most:e}");
    }
}

/// The matrix of an oscillator is a rotation; inside, its momentum is −dx/dγ.
fn rotation(gamma: f64) -> [f64; 4] {
    let (sin, cos) = gamma.sin_cos();
    [cos, -sin, sin, cos]
}

#[test]
fn matrices_of_an_oscillator_are_rotations() {
    let line = run("oscillator", &[SENSITIVE[0], SENSITIVE[1], "grid.gamma_f=30"]);
    let gammas = std::iter::once(0.0).chain(line.windows.iter().map(|window| window.gamma[1]));
    let joints = sensitivity(&line).joints();
    assert_eq!(joints.len(), line.windows.len() + 1);
    let most = gammas.zip(joints).map(|(gamma, matrix)| distance(matrix, &rotation(gamma))).fold(0.0, f64::max);
    assert!(most < 1e-13, "{most:e}");
}

/// Inside, such a run is that of the reversed motion, which has momenta of the other sign.
#[test]
fn table_of_a_run_backward_is_that_of_the_motion() {
    let line = run("oscillator", &[SENSITIVE[0], SENSITIVE[1], "grid.gamma_f=-2"]);
    let mut table = Vec::new();
    write_sensitivity(&mut table, &[&line]).unwrap();
    let table = String::from_utf8(table).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("gamma,d_x_d_x,d_x_d_p_x,d_p_x_d_x,d_p_x_d_p_x"));
    let last: Vec<f64> = lines.last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert_eq!(last[0], -2.0);
    // A user sees the momentum dx/dγ.
    assert!(distance(&last[1..], &rotation(2.0)) < 1e-13, "{last:?}");
}

/// Runs in 40 digits from neighbouring starts, 2e-10 apart, differ so much at their ends.
#[test]
fn matrix_is_the_derivative_of_the_end() {
    let line = run("henon-heiles", &[SENSITIVE[0], SENSITIVE[1], "grid.gamma_f=20"]);
    let end = |at: usize, by: f64| {
        let starts = [("x", 0.1), ("y", 0.0), ("p_x", 0.0), ("p_y", 0.5)].into_iter().enumerate();
        // Inside, momenta have the other sign.
        let by = if at < 2 { by } else { -by };
        let set = |(k, (name, value)): (usize, (&str, f64))| {
            format!("initial.{name}={:.11}", value + if k == at { by } else { 0.0 })
        };
        let mut settings: Vec<String> = starts.map(set).collect();
        settings.extend(["solver.digits=40", "grid.gamma_f=20", "grid.windows=40"].map(str::to_owned));
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let line: WorldLine<Extended> = line_of(&case("henon-heiles", &settings));
        let (end, active) = (line.end(), line.geometry().active().to_vec());
        active.iter().map(|&a| end.q[a]).chain(active.iter().map(|&a| end.p[a])).collect::<Vec<_>>()
    };
    let matrix = sensitivity(&line).joints().last().unwrap();
    for column in 0..4 {
        let [above, below] = [1e-10, -1e-10].map(|by| end(column, by));
        for row in 0..4 {
            let exact = (above[row] - below[row]).to_f64() / 2e-10;
            let off = (matrix[4 * row + column] - exact).abs();
            assert!(off < 1e-12, "{row} {column}: {off:e}, {exact}");
        }
    }
}

/// The Lyapunov exponent and MEGNO of an orbit after this length.
fn growth(settings: &[&str]) -> [f64; 2] {
    let line = run("henon-heiles-megno", settings);
    let found = sensitivity(&line).growth();
    [found.lyapunov, found.megno]
}

/// From heyoka 7: a Taylor integration of the motion and its variational equations to 1e-18, with ∫ ln |δ| as one
/// equation more and the mean of Y by Gauss' rule on 1200 panels.
#[test]
fn growth_is_that_of_other_software() {
    let off = |found: [f64; 2], exact: [f64; 2]| distance(&found, &exact);
    let regular = off(growth(&[LONG]), [0.009_838_034_150_487_13, 1.739_481_898_884_65]);
    assert!(regular < 1e-9, "{regular:e}");
    let chaotic = growth(&[LONG, "parameters.y_i=-0.25"]);
    let chaotic = off(chaotic, [0.053_207_722_960_799_8, 7.859_273_585_024_95]);
    assert!(chaotic < 1e-5, "{chaotic:e}");
}

#[test]
fn megno_tends_to_two_on_a_regular_orbit() {
    let [lyapunov, megno] = growth(&["grid.gamma_f=20000"]);
    assert!((megno - 2.0).abs() < 0.01 && lyapunov < 1e-3, "{lyapunov} {megno}");
}

/// After the first few hundred γ rounding errors choose the orbit: heyoka finds an exponent of 0.044 after 6000, and
/// this program one of 0.049. |δ| would be e^1000 at the end.
#[test]
fn chaos_has_a_positive_exponent_and_overflows_nowhere() {
    let line = run("henon-heiles-megno", &["parameters.y_i=-0.25", "grid.gamma_f=20000"]);
    let found = sensitivity(&line);
    let Growth { lyapunov, megno, .. } = found.growth();
    assert_eq!(found.growths().len(), line.windows.len() + 1);
    assert!(found.growths().iter().all(|growth| growth.lyapunov.is_finite() && growth.megno.is_finite()));
    assert!((0.04..0.06).contains(&lyapunov), "{lyapunov}");
    assert!((0.8..1.25).contains(&(megno / (0.5 * 20_000.0 * lyapunov))), "{megno}");
    let joints = found.joints();
    assert!((line.windows.len() / 2..line.windows.len()).contains(&joints.len()));
    assert!(joints.flatten().all(|entry| entry.is_finite()));
}

#[test]
fn matrices_begin_again_with_the_run() {
    let case = case("henon-heiles-megno", &["parameters.y_i=-0.25"]);
    let setup = case.setup::<f64>();
    let (geometry, start) = (&setup.place.geometry, &setup.place.start);
    let mut engine = Engine::accurate(geometry, start, 300.0, Accuracy::Promised(1e-8)).unwrap();
    let mut found = Sensitivity::new(2, true);
    let (mut begun, mut windows) = (0, 0);
    engine
        .run(|mut window| {
            begun += usize::from(window.index == 0);
            windows = window.index + 1;
            window.carry(&mut found);
            ControlFlow::Continue(())
        })
        .unwrap();
    assert!(begun > 1, "{begun}");
    assert_eq!(found.joints().len(), windows + 1);
}

/// Linearised equations pass a jump of the force as if it were none: where neighbours meet it at other times,
/// derivatives of the end are wrong, and the run says so. All meet a jump in time together, and a kink is no jump.
#[test]
fn a_jump_that_neighbours_meet_at_other_times_is_a_doubt() {
    for (force, is_doubted) in [("-0.1*sign(x)", true), ("step(t - 3)", false), ("-0.1*abs(x)", false)] {
        let scene = OSCILLATOR.replace("[particle]", &format!("force = {{ x = \"{force}\" }}\n[particle]"));
        let case = parsed(&scene, &["grid.t_f=10", "solver.accuracy=1e-6", SENSITIVE[1]]);
        let setup = case.setup::<f64>();
        let Ok(found) = studied(&case, &setup, Wanted::default()).0 else { panic!("{force}") };
        let verdict = found.judged(&setup, false, false).verdict;
        assert_eq!(verdict.grade == Grade::Doubtful, is_doubted, "{force}: {:?}", verdict.reasons);
        assert!(!is_doubted || verdict.reasons.iter().any(|reason| reason.reason.contains("jumps")), "{force}");
    }
}

/// The exponent of a damped oscillator is −k/2, however long the run is and whatever law moves it: what the force takes
/// from the motion shows in no time and no energy. MEGNO is half of ln |δ|.
#[test]
fn damping_has_a_negative_exponent() {
    for (law, k, length) in [("newtonian", 0.2, 300.0), ("newtonian", 0.2, 6000.0), ("newtonian", 1.0, 300.0)] {
        let text = format!(
            "potential = {{ coordinates = [\"x\"], formula = \"x^2/2\", force = {{ x = \"-k*x_dot\" }}, \
             parameters = {{ k = {k} }} }}\nparticle.law = \"{law}\"\ninitial = {{ x = 1.0, x_dot = 0.0 }}\n\
             grid.t_f = {length:?}\nsolver = {{ tolerance = 1e-10, sensitivity = true }}\n"
        );
        let line: WorldLine = line_of(&parsed(&text, &[]));
        let Growth { lyapunov, megno, .. } = sensitivity(&line).growth();
        assert!((lyapunov / (-0.5 * k) - 1.0).abs() < 0.01, "{law} {k} {length}: {lyapunov}");
        assert!((megno / (-0.25 * k * length) - 1.0).abs() < 0.02, "{law} {k} {length}: {megno}");
    }
}

/// On its cycle a driven oscillator forgets how it began, and the exponent converges: the sum of all exponents of
/// x'' = −0.3 x' + … is −0.3, so that the larger one of two that are a pair is −0.15.
#[test]
fn a_cycle_has_a_negative_exponent_that_converges() {
    let text = "potential = { coordinates = [\"x\"], formula = \"x^2/2 + x^4/4 - 0.3*x*cos(1.2*t)\", \
                force = { x = \"-0.3*x_dot\" } }\nparticle.law = \"newtonian\"\n\
                initial = { x = 0.5, x_dot = 0.0 }\ngrid.t_f = 600.0\n\
                solver = { tolerance = 1e-10, sensitivity = true }\n";
    let line: WorldLine = line_of(&parsed(text, &[]));
    let growths = sensitivity(&line).growths();
    let late = |from: f64| growths.iter().filter(move |growth| growth.gamma > from);
    assert!((growths.last().unwrap().lyapunov + 0.15).abs() < 2e-3, "{:?}", growths.last());
    let off = |from: f64| late(from).map(|growth| (growth.lyapunov + 0.15).abs()).fold(0.0, f64::max);
    assert!(off(300.0) < 0.3 * off(30.0), "{} {}", off(30.0), off(300.0));
}
