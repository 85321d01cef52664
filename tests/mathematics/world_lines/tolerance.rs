//! Chaotic motion to a tolerance: the run ends where it was asked to end, and knows until where it is good.

use geodesic_ivp::engine::GOOD_DIGITS;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::errors::run_error;
use geodesic_ivp::trajectory::crossings;

use crate::common::{line_of, parsed, text_solved};

/// An orbit in the potential of M. Hénon and C. Heiles (Astron. J. 69 (1964) 73) with an energy near 1/8.
const CHAOS: &str = r#"
    potential = { coordinates = ["x", "y"], formula = "(x^2 + y^2)/2 + x^2*y - y^3/3" }
    particle.law = "newtonian"
    initial = { x = 0.0, y = -0.15, x_dot = 0.5, y_dot = 0.0 }
    grid.gamma_f = 1000.0
    solver.tolerance = 1e-12
    events.section = { when = "x", direction = "up" }
"#;

/// A fast oscillation that is 10⁻¹⁰ of the other one costs no windows where it is said to be small.
#[test]
fn below_a_floor_an_accuracy_is_absolute() {
    let solved = |floor: &str| {
        let text = format!(
            "potential = {{ coordinates = [\"x\", \"y\"], formula = \"(x^2 + 400*y^2)/2\" }}\n\
             particle = {{ law = \"newtonian\", masses = {{ x = 1.0, y = 4.0 }} }}\n\
             initial = {{ x = 1.0, y = 1e-10, x_dot = 0.0, y_dot = 0.0 }}\ngrid.t_f = 30.0\n\
             solver = {{ accuracy = 1e-10{floor} }}\n"
        );
        text_solved(&text)
    };
    let [without, with] = ["", ", floor = { y = \"1/2\" }"].map(solved);
    assert!(3 * with.window_count < 2 * without.window_count, "{} {}", with.window_count, without.window_count);
    let [x, y] = [with.end().q[1] - 30.0_f64.cos(), with.end().q[2] - 1e-10 * 300.0_f64.cos()];
    assert!(x.abs() < 1e-10 && y.abs() < 5e-11, "{x:e} {y:e}");
    assert!((without.end().q[2] - 1e-10 * 300.0_f64.cos()).abs() < 1e-20);
}

#[test]
fn a_chaotic_run_knows_until_where_it_is_good() {
    let case = parsed(CHAOS, &[]);
    let line: WorldLine = line_of(&case);
    assert_eq!(line.length, 1000.0);
    // A turn takes 2π or a little more.
    let met = crossings(&line, &mut case.watches()).len();
    assert!((130..160).contains(&met), "{met}");
    assert!(line.good_until.is_sorted_by(|three, six| three > six), "{:?}", line.good_until);

    let exact = case.setup::<Extended>().place;
    let length = Extended::from(line.good_until[0]);
    let reference = ReferenceTrajectory::new(&exact.geometry, &exact.start, length, 40).unwrap();
    let rows: Vec<Vec<f64>> = (0..line.sizes.len()).map(|a| line.q(a).collect()).collect();
    let mut largest = [0.0_f64; GOOD_DIGITS.len()];
    for (k, gamma) in line.gamma().enumerate().filter(|(_, gamma)| *gamma <= line.good_until[0]) {
        let exact = reference.at(Extended::from(gamma)).q;
        let off = |a: usize| (Extended::from(rows[a][k]) - exact[a]).abs().to_f64() / line.sizes[a];
        let off = (0..rows.len()).filter(|&a| line.sizes[a] > 0.0).map(off).fold(0.0, f64::max);
        for (largest, _) in largest.iter_mut().zip(line.good_until).filter(|(_, until)| gamma <= *until) {
            *largest = largest.max(off);
        }
    }
    for (largest, digits) in largest.into_iter().zip(GOOD_DIGITS) {
        let allowed = 10.0_f64.powi(-digits);
        assert!(largest <= allowed && largest > 1e-4 * allowed, "{digits} digits: {largest:e}, {:?}", line.good_until);
    }
}

/// Growth that leaves the range of numbers is growth. The exponents of these are 0.05 and 0.1, and errors are e^1000
/// and e^100 times as large at the end; rounding alone makes no digit good.
#[test]
fn growth_beyond_the_range_of_numbers_leaves_no_digit() {
    let driven = "potential = { coordinates = [\"x\"], formula = \"x^4/4 - 7.5*x*cos(t)\", \
                  force = { x = \"-0.05*x_dot\" } }\nparticle.law = \"newtonian\"\n\
                  initial = { x = 3.0, x_dot = 4.0 }\ngrid.t_f = 1000.0\nsolver.tolerance = 1e-10\n";
    let long = CHAOS.replace("grid.gamma_f = 1000.0", "grid.t_f = 20000.0").replace("1e-12", "1e-10");
    for text in [driven.to_owned(), driven.replace("1000.0", "10000.0"), long] {
        let (case, line) = (parsed(&text, &[]), text_solved(&text));
        let estimate = line.error_estimate.unwrap();
        assert!(estimate > 1.0, "{estimate}: {text}");
        let error = run_error(&case.setup(), &line, &[]).unwrap();
        // t is given.
        let others = &error.at_most()[1..];
        assert!(others.iter().all(|error| *error >= 1e-3 || error.is_nan()), "{error:?}: {text}");
    }
}
