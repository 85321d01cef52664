//! The engine of few nodes on given windows.

use geodesic_ivp::engine::{Engine, MOST_POINTS};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::{InitialGuess, WorldLine};

use crate::common::{QUARTIC_POTENTIAL, line_of, one, parsed};

/// Scenes whose equations are of first or second order, with one-forms, forces, and a metric that is not diagonal.
pub(super) const SCENES: [(&str, &str); 6] = [
    (
        "kerr",
        "metric.preset = \"kerr\"\nparameters.a = 0.9\n\
         initial = { r = 8.0, theta = \"pi/3\", p_t = 0.95, p_phi = -2.5, p_theta = 1.0, norm = 1, \
         solve = { r_dot = \"+\" } }\ngrid = { gamma_f = 6.0, windows = 3 }\n",
    ),
    (
        "charged schwarzschild",
        "metric.preset = \"schwarzschild\"\nparameters.e = 0.3\n\
         metric.one_form = { t = \"e/r\", phi = \"0.01*r^2\" }\n\
         initial = { r = 10.0, phi = 0.0, t_dot = 1.2, r_dot = -0.05, phi_dot = 0.045 }\n\
         grid = { gamma_f = 9.0, windows = 3 }\n",
    ),
    (
        "henon-heiles",
        "potential = { coordinates = [\"x\", \"y\"], formula = \"(x^2 + y^2)/2 + x^2*y - y^3/3\" }\n\
         particle.law = \"newtonian\"\n\
         initial = { x = 0.1, y = 0.0, x_dot = 0.0, y_dot = 0.5 }\ngrid = { gamma_f = 1.5, windows = 3 }\n",
    ),
    (
        "friction",
        "potential = { coordinates = [\"x\"], formula = \"1 - cos(x)\", force = { x = \"-x_dot/5\" } }\n\
         particle.law = \"newtonian\"\n\
         initial = { x = 1.0, x_dot = 0.3 }\ngrid = { gamma_f = 1.5, windows = 3 }\n",
    ),
    (
        "mixed masses",
        "potential = { coordinates = [\"x\", \"y\"], formula = \"exp(x)*sqrt(1 + y^2)\" }\n\
         particle.masses = { x = 3.0, y = 0.7 }\n\
         initial = { x = 0.2, y = -0.4, t_dot = 1.0, x_dot = 0.2, y_dot = 0.1 }\n\
         grid = { gamma_f = 1.2, windows = 3 }\n",
    ),
    (
        "off the diagonal",
        "metric = { coordinates = [\"u\", \"v\", \"x\"], \
         components = { \"u u\" = \"x^2\", \"u v\" = \"1\", \"x x\" = \"-1 - u^2/9\" } }\n\
         initial = { u = 0.1, v = 0.0, x = 0.5, u_dot = 0.4, v_dot = 1.0, x_dot = 0.2 }\n\
         grid = { gamma_f = 1.2, windows = 3 }\n",
    ),
];

fn line<S: Real>(text: &str, more: &str) -> WorldLine<S> {
    line_of(&parsed(&format!("{text}{more}"), &[]))
}

/// The largest difference of coordinates on all nodes, and of momenta at the ends of windows, relative to sizes.
fn distance(one: &WorldLine, other: &WorldLine<Extended>) -> f64 {
    let n = one.place.start.q.len();
    let momentum = |a: usize| {
        let joints = (0..=one.windows.len()).map(move |index| (one.joint(index).p[a], other.joint(index).p[a]));
        joints.collect::<Vec<_>>()
    };
    let rows = (0..n).map(|a| one.q(a).zip(other.q(a)).collect::<Vec<_>>()).chain((0..n).map(momentum));
    let off = |row: Vec<(f64, Extended)>| {
        let size = row.iter().fold(f64::MIN_POSITIVE, |size, (_, known)| size.max(known.to_f64().abs()));
        row.iter().fold(0.0_f64, |off, &(found, known)| off.max((known - Extended::from(found)).to_f64().abs() / size))
    };
    rows.map(off).fold(0.0, f64::max)
}

/// Newton's method solves the same equations in more digits.
#[test]
fn given_windows_are_critical_points_to_rounding() {
    for (name, text) in SCENES {
        for points in 2..=MOST_POINTS {
            let scheme = format!("scheme = {{ sbp = \"GLL{points}\", form = \"weak\" }}\n");
            let found = line::<f64>(text, &scheme);
            assert_eq!(found.iterations.initial_guess, InitialGuess::Extrapolation, "{name}, {points}: not the engine");
            let known = line::<Extended>(text, &format!("{scheme}solver.digits = 20\n"));
            let off = distance(&found, &known);
            assert!(off < 1e-14, "{name}, {points} nodes: {off:e}");
        }
    }
}

/// Beyond a turning point, about which the motion would be even and the order one higher.
const HENON_HEILES: &str = "potential = { coordinates = [\"x\", \"y\"], formula = \"(x^2 + y^2)/2 + x^2*y - y^3/3\" }
particle.law = \"newtonian\"
initial = { x = 0.1, y = 0.2, x_dot = 0.3, y_dot = 0.4 }
";
const QUARTIC: &str = "potential = { coordinates = [\"x\"], formula = \"x^4/2\" }
initial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }
";

/// The geometry of a scene around its start, and the start.
pub(super) fn scene(text: &str) -> (Geometry, Start) {
    let case = parsed(&format!("{text}grid.gamma_f = 1.0\nsolver.accuracy = 1e-6\n"), &[]);
    (case.geometry(), case.start())
}

/// Where windows of one length end. The velocities are those of the start.
fn end(geometry: &Geometry, start: &Start, length: f64, [windows, points]: [usize; 2]) -> Start {
    end_of(Engine::equal(geometry, start, length, windows, points).unwrap(), geometry, start)
}

fn end_of(mut engine: Engine<'_>, geometry: &Geometry, start: &Start) -> Start {
    while engine.next().unwrap().is_some() {}
    let (window, mut found) = (engine.window(), start.clone());
    let end = window.end();
    found.q = end.positions();
    geometry.active().iter().zip(end.momenta()).for_each(|(&a, p)| found.p[a] = p);
    found
}

/// The largest difference of active coordinates and momenta.
fn difference(geometry: &Geometry, one: &Start, other: &Start) -> f64 {
    let off = |&a: &usize| (one.q[a] - other.q[a]).abs().max((one.p[a] - other.p[a]).abs());
    geometry.active().iter().map(off).fold(0.0, f64::max)
}

/// With all momenta turned round the motion goes back to where it came from, by Gauss' method too.
#[test]
fn motion_is_reversible() {
    let (geometry, start) = scene(HENON_HEILES);
    for points in [8, 16, 24, 4] {
        let turned = |mut start: Start| {
            geometry.active().iter().for_each(|&a| start.p[a] = -start.p[a]);
            start
        };
        let end = |start: &Start| match points {
            4 => end_of(Engine::gauss(&geometry, start, 50.0, 150, 4, 0.0).unwrap(), &geometry, start),
            _ => end(&geometry, start, 50.0, [100, points]),
        };
        let back = turned(end(&turned(end(&start))));
        let off = difference(&geometry, &back, &start);
        assert!(off < 2e-13, "{points}: {off:e}");
    }
}

/// Rounding errors of K are a random walk: γ = 1e6 of the quartic, where 4e6 windows of 20 nodes follow each other.
#[test]
#[ignore = "long: ten seconds and more"]
fn k_walks_at_random_over_a_million_units() {
    let change = change_of_k(1e6, [4_000_000, 20]);
    assert!(change < 2e-13, "{change:e}");
}

/// With weights or nodes of 16 digits it would drift by ten times as much.
#[test]
fn k_walks_at_random_over_twenty_thousand_units() {
    for points in [12, 16, 20, 24] {
        let change = change_of_k(2e4, [80_000, points]);
        assert!(change < 3e-14, "{points}: {change:e}");
    }
}

/// Also in between.
#[test]
fn k_stays_over_a_thousand_units() {
    let (geometry, start) = scene(QUARTIC);
    for (windows, points, most) in [(2000, 16, 1e-13), (4000, 20, 4e-15)] {
        let mut engine = Engine::equal(&geometry, &start, 1000.0, windows, points).unwrap();
        let mut worst = 0.0_f64;
        while let Some(window) = engine.next().unwrap() {
            let ([x, w], of) = ([window.end().positions()[1], window.end().momenta()[0]], Extended::from);
            let square = of(x) * of(x);
            let k = of(4.0) / (square * square + Extended::ONE) - of(w) * of(w);
            worst = worst.max((k - (of(2.0) - of(0.1) * of(0.1))).to_f64().abs());
        }
        assert!(worst < most, "{points}: {worst:e}");
    }
}

fn change_of_k(length: f64, grid: [usize; 2]) -> f64 {
    let (geometry, start) = scene(QUARTIC);
    let end = end(&geometry, &start, length, grid);
    let q_dot = geometry.velocities(&end.q, &end.p).unwrap();
    (geometry.norm(&end.q, &q_dot) - geometry.norm(&start.q, &start.q_dot)).abs()
}

/// t(1), x(1) and dx/dγ(1) of the quartic base case, from its continuum solution with 24 digits.
const QUARTIC_END: [f64; 3] = [1.468_634_756_955_731, 0.159_778_018_885_407_25, -1.416_825_598_093_154_3];

/// Formulas have every kind of instruction: arithmetic, negation, powers, functions.
#[test]
fn a_polynomial_is_solved_to_the_last_digits_and_so_are_formulas_of_it() {
    let formulas = [
        "x^4/2",
        "x^2*(x^2 + 1)/2 - x*x/2",
        "-(0 - x^4)/2",
        "1/(2*x^(-4))",
        "x*x*x/(2/x)",
        "exp(ln(x^2)*2)/2",
        "abs(x)^4.0/2",
        "sqrt(x^8)/2",
    ];
    let formulas = formulas.into_iter().map(|text| (text, 1e-14));
    for (potential, most) in [(QUARTIC_POTENTIAL, 4e-15)].into_iter().chain(formulas) {
        let (geometry, start) = one(potential, 1.0, [1.0, 1.0, 0.1]);
        for grid in [[16, 8], [2, 16], [1, 24]] {
            let end = end(&geometry, &start, 1.0, grid);
            for (found, exact) in [end.q[0], end.q[1], -end.p[1]].into_iter().zip(QUARTIC_END) {
                assert!((found - exact).abs() < most, "{most:e} {grid:?}: {found} {exact}");
            }
        }
    }
}

/// Programs have as many values as they need: nine bodies in space have some seven hundred.
#[test]
fn nine_bodies_move_in_space() {
    let body = |k: usize| {
        let position = [0, 1, 2].map(|axis| ((5 * k + 7 * axis) as f64).sin() * 9.0);
        format!("[[body]]\nname = 'b{k}'\nmass = {k}.0\nposition = {position:?}\nvelocity = [0.0, 0.0, 0.0]\n")
    };
    let bodies: String = (1..=9).map(body).collect();
    let scheme = "grid = { gamma_f = 0.1, windows = 4 }\nscheme = { sbp = 'GLL12', form = 'weak' }\n";
    let line = line::<f64>(&format!("pair.formula = '-m_1*m_2/r'\n{scheme}{bodies}"), "");
    assert_eq!(line.iterations.initial_guess, InitialGuess::Extrapolation);
    for axis in 0..3 {
        let momentum: f64 = (0..9).map(|body| line.end().p[1 + 3 * body + axis]).sum();
        assert!(momentum.abs() < 1e-13, "{axis}: {momentum:e}");
    }
}
