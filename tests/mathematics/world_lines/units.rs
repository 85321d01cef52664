//! Nothing depends on units: lengths, times and masses that are powers of two times as large change exponents only.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::run::{Wanted, run};

use crate::common::parsed;
use crate::random_scenes::random::Random;

/// Units of length, time and mass, as exponents of two.
type Units = [i32; 3];

/// Potentials in X and Y, the positions without units, with positions and velocities: an energy surface with three
/// hills, an ellipse, a well with two bottoms, a rising wave, an oscillator that is driven, and one with friction in a
/// magnetic field.
const POTENTIALS: [(&str, [f64; 2], [f64; 2]); 6] = [
    ("(X^2 + Y^2)/2 + X^2*Y - Y^3/3", [0.1, -0.2], [0.3, 0.1]),
    ("-1/sqrt(X^2 + Y^2)", [0.0, 1.0], [1.1, 0.0]),
    ("X^4/4 - X^2/2 + Y^2", [0.3, 0.0], [0.1, 0.0]),
    ("exp(-X) + Y^2/2", [0.5, 0.1], [0.0, 0.2]),
    ("X^2/2 + Y^2/2 - 0.3*X*cos(2*T)", [0.5, 0.0], [0.0, 0.2]),
    (RUBBING, [0.5, 0.1], [0.0, 0.2]),
];
const RUBBING: &str = "X^2/2 + Y^2";

/// The text that follows `[initial]`, with the length of the run: accuracy, tolerance, and grids of all kinds. One grid
/// is so coarse that K drifts by more than is trusted.
const SCHEMES: [&str; 9] = [
    "grid = { gamma_f = LENGTH, n_gamma = 6 }\nscheme.sbp = \"SBP21\"",
    "grid.t_f = LENGTH\nsolver.accuracy = 1e-9",
    "grid.t_f = LENGTH\nsolver.tolerance = 1e-9",
    "grid = { gamma_f = LENGTH, n_gamma = 48 }\nscheme.sbp = \"SBP21\"",
    "grid = { gamma_f = LENGTH, n_gamma = 48 }\nscheme.sbp = \"SBP42\"",
    "grid = { t_f = LENGTH, n_gamma = 48 }\nscheme = { sbp = \"SBP84\", form = \"weak\" }",
    "grid = { gamma_f = LENGTH, windows = 4 }\nscheme = { sbp = \"GLL12\", form = \"weak\" }",
    "grid = { gamma_f = LENGTH, n_gamma = 20 }\nscheme.sbp = \"SBP42\"\nsolver.system = \"doubled\"",
    "grid = { gamma_f = LENGTH, n_gamma = 24 }\nscheme.sbp = \"SBP63\"\nsolver.digits = 40",
];

/// A number with its unit, as text that is exact in all digits.
fn in_units(number: f64, exponent: i32) -> String {
    format!("\"{number:?}*2^({exponent})\"")
}

/// The case of a particle of mass 0.7 in one of the potentials.
fn newtonian((potential, x, v): (&str, [f64; 2], [f64; 2]), scheme: &str, [a, b, c]: Units) -> String {
    let replaced = |text: &str, name: &str, by: &str, unit: i32| text.replace(name, &format!("({by}*2^({}))", -unit));
    let formula = replaced(&replaced(&replaced(potential, "X", "x", a), "Y", "y", a), "T", "t", b);
    let [x, y] = x.map(|x| in_units(x, a));
    let [u, v] = v.map(|v| in_units(v, a - b));
    let more = format!(
        ", one_form = {{ x = \"0.3*y*2^({})\" }}, force = {{ x = \"-0.2*(x_dot*2^({}) + (y_dot*2^({}))^2)*2^({})\" }}",
        c - b,
        b - a,
        b - a,
        c + a - 2 * b
    );
    let more = if potential == RUBBING { &more } else { "" };
    format!(
        "potential = {{ coordinates = [\"x\", \"y\"], formula = \"({formula})*2^({})\"{more} }}\n\
         particle = {{ law = \"newtonian\", mass = {} }}\n\
         initial = {{ x = {x}, y = {y}, x_dot = {u}, y_dot = {v} }}\n{}\n",
        c + 2 * a - 2 * b,
        in_units(0.7, c),
        scheme.replace("LENGTH", &in_units(2.0, b))
    )
}

/// The paper's oscillator, whose γ is measured in the unit of t.
fn relativistic(scheme: &str, [a, b, c]: Units) -> String {
    format!(
        "potential.formula = \"(x*2^({}))^4/2*2^({})\"\nparticle = {{ mass = {}, c = {} }}\n\
         initial = {{ x = {}, t_dot = 1.0, x_dot = {} }}\n{}\n",
        -a,
        c + 2 * a - 2 * b,
        in_units(1.0, c),
        in_units(10.0, a - b),
        in_units(1.0, a),
        in_units(0.1, a - b),
        scheme.replace("LENGTH", &in_units(1.0, b))
    )
}

/// A bound orbit around a black hole, where lengths and times have one unit.
fn black_hole(scheme: &str, [a, ..]: Units) -> String {
    format!(
        "metric = {{ preset = \"schwarzschild\", parameters = {{ m = {} }} }}\n\
         initial = {{ r = {}, phi = 0.1, t_dot = 1.25, r_dot = 0.0, phi_dot = {} }}\n{}\n",
        in_units(1.0, a),
        in_units(9.0, a),
        in_units(0.04, -a),
        scheme.replace("t_f", "gamma_f").replace("LENGTH", &in_units(20.0, a))
    )
}

/// The part of a number that no unit changes.
fn mantissa(number: f64) -> f64 {
    let exponent = f64::from_bits(number.abs().to_bits() & 0x7ff0_0000_0000_0000);
    if number == 0.0 || !number.is_finite() { number } else { number / exponent }
}

/// Everything that a run tells, without units.
fn told<S: Real>(text: &str) -> Vec<(String, Vec<f64>)> {
    let case = parsed(text, &[]);
    let setup = case.setup::<S>();
    let wanted = Wanted { sums: true, ..Wanted::default() };
    let (found, _) = run(&case, &setup, wanted);
    let found = found.unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    let judged = found.judged(&setup, false, true);
    let mut told = Vec::new();
    let mut tell = |name: &str, numbers: Vec<f64>| told.push((name.to_owned(), numbers));
    for a in 0..setup.rough.geometry.dimension() {
        tell(&format!("q{a}"), found.line.q(a).map(|q| q.to_f64()).collect());
    }
    tell("p", found.line.end().p.iter().map(|p| p.to_f64()).collect());
    for charge in found.diagnostics.charges.iter().chain(&found.diagnostics.sums) {
        tell("charge", vec![charge.max_interior.to_f64(), charge.max_ends.to_f64()]);
    }
    let error = judged.error.expect("the run was compared");
    tell("error", [error.end, error.largest, error.own].concat());
    let verdict = judged.verdict;
    tell("error of the verdict", verdict.error.into_iter().collect());
    tell(&format!("{:?}, {:?}, {} reasons", verdict.grade, verdict.digits, verdict.reasons.len()), Vec::new());
    for (_, numbers) in &mut told {
        numbers.iter_mut().for_each(|number| *number = mantissa(*number));
    }
    told
}

/// Compares what is told in a few units, which are not 1: a factor 1 would be left out of a formula, and rounding with
/// it.
fn assert_nothing_depends_on_units(text: impl Fn(Units) -> String) {
    let of = |units: Units| {
        let text = text(units);
        if text.contains("digits = 40") { told::<Extended>(&text) } else { told::<f64>(&text) }
    };
    let (known, mut random) = (of([4, 8, -12]), Random(7));
    for _ in 0..3 {
        let units = [(); 3].map(|()| 4 * random.between(-20.0, 20.0) as i32);
        for (known, (name, found)) in known.iter().zip(of(units)) {
            assert_eq!(*known, (name, found), "{units:?} in\n{}", text(units));
        }
    }
}

#[test]
fn newtonian_motions_do_not_depend_on_units() {
    for potential in POTENTIALS {
        for scheme in SCHEMES {
            assert_nothing_depends_on_units(|units| newtonian(potential, scheme, units));
        }
    }
}

#[test]
fn the_papers_oscillator_does_not_depend_on_units() {
    for scheme in SCHEMES {
        assert_nothing_depends_on_units(|units| relativistic(scheme, units));
    }
}

#[test]
fn orbits_around_a_black_hole_do_not_depend_on_units() {
    for scheme in SCHEMES {
        assert_nothing_depends_on_units(|units| black_hole(scheme, units));
    }
}
