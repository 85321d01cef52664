//! Rest, circular orbits and small oscillations: the motion is smaller than the rounding of the place.

use crate::common::{parsed, solved};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::study::run::{Wanted, run};

/// Schemes on a given grid, of both forms and of both systems.
const SCHEMES: [&str; 8] = [
    "grid.n_gamma=101 scheme.sbp=SBP21",
    "grid.n_gamma=101 scheme.sbp=SBP21 scheme.form=weak",
    "grid.n_gamma=101 scheme.sbp=SBP42",
    "grid.n_gamma=101 scheme.sbp=SBP84 scheme.form=weak",
    "grid.n_gamma=20 grid.windows=10 scheme.sbp=GLL20 scheme.form=strong",
    "grid.n_gamma=20 grid.windows=10 scheme.sbp=GLL20 scheme.form=weak",
    "grid.n_gamma=101 scheme.sbp=SBP42 solver.system=doubled",
    "grid.n_gamma=101 scheme.sbp=SBP42 scheme.form=weak solver.system=doubled",
];

/// A potential with its minimum, which is no number of the machine, and the frequency there over c.
const WELLS: [(&str, f64, f64, f64); 2] = [
    // (x² − 2)² at the root of two: V″ = 16.
    ("(x^2-2)^2", std::f64::consts::SQRT_2, 100.0, 4.0),
    // The radial motion on a circular orbit of Kepler's: V″ = 3 L²/r⁴ − 2/r³ = 1/27.
    ("-1/x+1.5/x^2", 3.0, 10.0, 0.192_450_089_729_875_25),
];

fn ended(well: (&str, f64, f64, f64), amplitude: f64, scheme: &str) -> f64 {
    let (formula, x, c, omega) = well;
    let potential = format!("potential={{formula={{expression=\"{formula}\"}}}} particle.c={c:?}");
    let initial = format!("initial={{t=0.0,x={:?},t_dot=1.0,x_dot=0.0}}", x + amplitude);
    let length = 2.0 * std::f64::consts::TAU / omega;
    let solution = solved(&format!("{potential} {initial} grid.gamma_f={length:?} {scheme}"));
    let most = solution.x().iter().fold(0.0, |most: f64, at| most.max((at - x).abs()));
    assert!(most < 1.3 * amplitude + 1e-13, "{formula} {amplitude:e} {scheme}: {most:e}");
    // What rounding leaves is no sawtooth.
    if amplitude < 1e-13 {
        let warnings = Diagnostics::new(&solution).warnings(&solution);
        assert!(!warnings.iter().any(|warning| warning.contains("sawtooth")), "{scheme}: {warnings:?}");
    }
    solution.gradient_norm
}

#[test]
fn what_hardly_moves_has_a_critical_point() {
    for well in WELLS {
        for scheme in SCHEMES {
            for amplitude in [0.0, 1e-16, 1e-15, 1e-14, 1e-12, 1e-10, 1e-7, 1e-5, 1e-3] {
                ended(well, amplitude, scheme);
            }
        }
    }
}

/// A well of two coupled coordinates and a round one, with the places of their minima. What starts there stays there to
/// the last bit, and nobody doubts it.
#[test]
fn what_starts_at_rest_stays_and_is_trusted() {
    for (formula, x, y) in [("(x-3)^2+(y+1)^2+(x-3)*(y+1)/2", 3.0, -1.0), ("(x^2+y^2)/2", 0.0, 0.0)] {
        for scheme in SCHEMES.into_iter().chain(["solver.accuracy=1e-8 grid.gamma_f=1000.0"]) {
            let text = format!(
                "potential = {{ coordinates = [\"x\", \"y\"], formula = \"{formula}\" }}\n\
                 particle.law = \"newtonian\"\n\
                 initial = {{ x = {x:?}, y = {y:?}, x_dot = 0.0, y_dot = 0.0 }}\ngrid.gamma_f = 10.0\n"
            );
            let case = parsed(&text, &scheme.split(' ').collect::<Vec<_>>());
            let setup = case.setup();
            let run = run(&case, &setup, Wanted::default()).0.unwrap_or_else(|error| panic!("{scheme}: {error:?}"));
            for (a, place) in [(1, x), (2, y)] {
                assert!(run.line.q(a).all(|q: f64| q == place), "{formula} {scheme}");
            }
            let verdict = run.judged(&setup, false, true).verdict;
            assert_eq!(verdict.grade, Grade::Trusted, "{formula} {scheme}: {:?}", verdict.reasons);
        }
    }
}

/// The verdict on a run, and by how much it is off from this end in these coordinates.
fn verdict(text: &str, accuracy: &str, exact: &[(usize, f64)]) -> (Grade, f64) {
    let case = parsed(text, &[&format!("solver.accuracy={accuracy}")]);
    let setup = case.setup::<f64>();
    let Ok(found) = run(&case, &setup, Wanted::default()).0 else { panic!("{text} {accuracy}") };
    let end = found.line.end();
    let off = exact.iter().map(|&(a, value)| (end.q[a] - value).abs());
    (found.judged(&setup, false, false).verdict.grade, off.fold(0.0, f64::max))
}

/// s of Newton's law has the rate v²/2 − V, which is 0 on a circle around a spring: only rounding moves it.
#[test]
fn a_circle_around_a_spring_is_trusted_though_s_rests() {
    let scene = "potential={coordinates=['x', 'y'], formula='(x^2 + y^2)/2'}\nparticle.law='newtonian'\n\
                 initial={x=0.0, y=1.0, x_dot=1.0, y_dot=0.0}\ngrid.t_f=10.0\nsolver.accuracy=1e-6";
    for accuracy in ["1e-4", "1e-6", "1e-9", "1e-12"] {
        let (grade, off) = verdict(scene, accuracy, &[(1, 10.0_f64.sin()), (2, 10.0_f64.cos())]);
        assert!(grade == Grade::Trusted && off < accuracy.parse().unwrap(), "{accuracy}: {grade:?} {off:e}");
    }
}

/// An orbit in the equator stays there, and a particle at rest beside one that moves does, too: the error of the others
/// is none of theirs.
#[test]
fn what_rests_beside_what_moves_is_trusted() {
    let kerr = "metric={preset='kerr', parameters={a=0.7}}\ngrid.gamma_f=500.0\nsolver.accuracy=1e-4\n\
                initial={r=10.0, theta='pi/2', r_dot=0.0, theta_dot=0.0, phi_dot=0.04, norm='timelike', \
                solve={t_dot='+'}}";
    let pair = "potential={coordinates=['x', 'y'], formula='x^2/2 + y^2'}\ngrid.t_f=10.0\nsolver.accuracy=1e-4\n\
                particle={law='newtonian', masses={x='1', y='2'}}\ninitial={x=1.0, y=0.0, x_dot=0.0, y_dot=0.0}";
    for accuracy in ["1e-4", "1e-6"] {
        let (grade, off) = verdict(kerr, accuracy, &[(2, std::f64::consts::FRAC_PI_2)]);
        assert!(grade == Grade::Trusted && off < 1e-14, "{accuracy}: {grade:?} {off:e}");
        let (grade, off) = verdict(pair, accuracy, &[(1, 10.0_f64.cos()), (2, 0.0)]);
        assert!(grade == Grade::Trusted && off < 1e-4, "{accuracy}: {grade:?} {off:e}");
    }
}
