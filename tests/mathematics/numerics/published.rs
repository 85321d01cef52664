//! Reference trajectories to published digits, in double and in extended precision.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;

use crate::common::parsed;

/// A tolerance, and true if it is one relative to the value.
type Tolerance = (f64, bool);

/// A start, a length, and the digits there of q^a and of −p_a, computed by two other programs or published.
struct Published {
    text: &'static str,
    length: f64,
    q: &'static [(usize, &'static str)],
    p: &'static [(usize, &'static str)],
    double: Tolerance,
    extended: &'static [(u32, Tolerance)],
}

const DIGITS: &[(u32, Tolerance)] = &[(20, (1e-19, false)), (40, (1e-23, false)), (70, (1e-23, false))];

const PUBLISHED: [Published; 4] = [
    Published {
        text: "potential.linear.alpha = 0.25\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }",
        length: 1.0,
        q: &[(0, "0.997129598504376989402741"), (1, "0.976046390793498338329943")],
        p: &[(1, "-0.148570533876599546619321996")],
        double: (1e-14, true),
        extended: DIGITS,
    },
    Published {
        text: "potential.quartic.kappa = 0.5\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }",
        length: 1.0,
        q: &[(0, "1.46863475695573088737134"), (1, "0.15977801888540724822026")],
        p: &[(1, "-1.41682559809315428413482")],
        double: (1e-14, true),
        extended: DIGITS,
    },
    Published {
        text: "metric.preset = 'schwarzschild'\ninitial = { r = 10, t_dot = 1.2, r_dot = -0.05, phi_dot = 0.03 }",
        length: 40.0,
        q: &[(0, "53.98674477227012912899"), (1, "3.694890969288723531810"), (2, "2.512564370210859177403")],
        p: &[],
        double: (1e-13, true),
        extended: &[(24, (3e-21, true)), (40, (3e-21, true))],
    },
    // The last one of the 17 digits of y is off by two.
    Published {
        text: "potential = { coordinates = ['x', 'y'], formula = '(x^2 + y^2)/2 + x^2*y - y^3/3' }\n\
               particle.law = 'newtonian'\ninitial = { x = 0.1, y = 0, x_dot = 0, y_dot = 0.5 }",
        length: 100.0,
        q: &[(0, "100"), (1, "-0.040194237876068815"), (2, "0.67901692177202166")],
        p: &[(1, "0.038450928951859836"), (2, "0.048594831553003641")],
        double: (2e-13, false),
        extended: &[(24, (2e-17, false))],
    },
];

fn check_published<S: Real>(row: &Published, digits: u32, (most, is_relative): Tolerance) {
    let rest = format!("grid.gamma_f = {}\nscheme.sbp = 'GLL12'\nsolver.digits = {digits}", row.length);
    let case = parsed(&format!("{}\n{rest}", row.text), &[]);
    let (geometry, start, length) = (case.geometry::<S>(), case.start::<S>(), S::from(row.length));
    let reference = ReferenceTrajectory::new(&geometry, &start, length, digits).unwrap();
    let end = reference.at(length);
    let q = row.q.iter().map(|&(a, known)| (end.q[a], known));
    for (found, known) in q.chain(row.p.iter().map(|&(a, known)| (-end.p[a], known))) {
        let known = S::from_decimal(known).unwrap();
        let off = (found - known).abs().to_f64() / if is_relative { known.abs().to_f64() } else { 1.0 };
        assert!(off < most, "{}: {found:?} against {known:?}", row.text);
    }
    for a in geometry.ignorable() {
        assert_eq!(end.p[a], start.p[a], "charges");
    }
    // K judges it independently.
    let [k, norm] = [(&end.q, &end.q_dot), (&start.q, &start.q_dot)].map(|(q, q_dot)| geometry.norm(q, q_dot));
    let (unit, estimate) = (10.0_f64.powi(-(digits as i32)), reference.error_estimate());
    let [of_k, of_estimate] = match (S::IS_EXTENDED, row.length) {
        (true, 1.0) => [100.0 * unit, 10.0 * unit],
        (true, 40.0) => [f64::INFINITY, 100.0 * unit],
        (false, 1.0) => [f64::INFINITY, 1e-14],
        (false, 40.0) => [1e-12, 1e-13],
        _ => [f64::INFINITY; 2],
    };
    assert!((k - norm).abs().to_f64() < of_k && estimate < of_estimate, "{}, {digits}: {estimate:e}", row.text);
}

#[test]
fn published_digits_are_met() {
    for row in &PUBLISHED {
        check_published::<f64>(row, 16, row.double);
        row.extended.iter().for_each(|&(digits, most)| check_published::<Extended>(row, digits, most));
    }
}
