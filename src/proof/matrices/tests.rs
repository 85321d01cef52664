//! Each term of the bounds of matrices by itself. Beside each test stands the part of the bound that its example
//! reaches.

use super::super::lemmas::with_window;
use super::super::tests::{lagrange_at_end, of_nodes_there, with_one_coordinate};
use super::*;
use crate::number::ball::Disc;
use crate::number::{Extended, Real};

/// B = 1 and W = 0 for `d` unknowns, with nothing that is off.
fn polynomials(d: usize) -> Polynomials {
    let (unit, zero): (Vec<f64>, Vec<f64>) = ((0..d * d).map(|at| one(at, d)).collect(), vec![0.0; d * d]);
    Polynomials {
        b: unit.iter().map(|b| [*b; LANES]).collect(),
        w: vec![[0.0; LANES]; d * d],
        slack: zero.clone(),
        w_slack: zero.clone(),
        b_most: unit.clone(),
        w_most: zero.clone(),
        b_there: unit.clone(),
        w_there: zero,
        b_end: unit,
    }
}

fn no_bounds(entries: usize) -> Bounds {
    let [defect, slope, reach, sides] = [(); 4].map(|()| Vec::new());
    Bounds { defect, slope, jacobian: vec![0.0; entries], spread: vec![0.0; entries], reach, sides }
}

/// The bound of |W_00 + B_01 J_10| after a change of what is known, with J = 0 before it.
fn defect_of_adjoint(change: impl FnOnce(&mut Polynomials, &mut Discs, &mut f64)) -> f64 {
    with_one_coordinate(|equations| {
        let (mut of, mut jacobian, mut bounds) = (polynomials(2), vec![Discs::of(Disc::default()); 2], no_bounds(2));
        // The second entry is J_10.
        change(&mut of, &mut jacobian[1], &mut bounds.jacobian[1]);
        adjoint_defect(equations, &of, &jacobian, &bounds)[0]
    })
}

/// Asserts that a bound holds, and that at least this part of it is met.
#[track_caller]
fn is_met(value: f64, bound: f64, part: f64) {
    assert!(value <= bound && value >= part * bound, "{value:e} of {bound:e}: {}", value / bound);
}

/// The terms of Λ in Ē: E has at the nodes the signs of ℓ_j(1), by W itself, by what W or B is off by, or by the radius
/// of J. Parts 0.9.
#[test]
fn a_defect_at_the_nodes_is_larger_between_them() {
    let at_end = lagrange_at_end();
    let most = at_end.iter().map(|l| l.abs()).sum();
    is_met(most, defect_of_adjoint(|of, _, _| of.w[0] = at_end.map(f64::signum)), 0.9);
    is_met(most, defect_of_adjoint(|of, _, _| of.w_slack[0] = 1.0), 0.9);
    is_met(most, defect_of_adjoint(|of, jacobian, _| (of.slack[1], jacobian.re) = (1.0, [1.0; LANES])), 0.9);
    is_met(most, defect_of_adjoint(|of, jacobian, _| (of.b[1], jacobian.rad) = ([1.0; LANES], [1.0; LANES])), 0.9);
}

/// The terms of interpolation in Ē: W is P_32, which is 0 at all nodes, or B is, and J = 1. Parts 0.2.
#[test]
fn a_defect_that_the_nodes_do_not_see_is_bounded() {
    let there = of_nodes_there();
    is_met(1.0, defect_of_adjoint(|of, _, _| of.w_there[0] = there), 0.2);
    let of_b = defect_of_adjoint(|of, jacobian, most| {
        (of.b_there[1], jacobian.re, *most) = (there, [1.0; LANES], 1.0);
    });
    is_met(1.0, of_b, 0.2);
}

/// The rounding of E at the nodes: a product, and then what it is rounded to with the other sign. It is one rounding of
/// twelve, for each of two terms, and times Λ. Part 1e-3.
#[test]
fn rounding_of_the_defect_is_bounded() {
    with_window(0.0, |prover, _, _| {
        let equations = &prover.equations;
        let place =
            |row: usize| equations.entries.iter().position(|entry| (entry.row, entry.column) == (row, 0)).unwrap();
        let (first, second) = (place(2), place(3));
        assert!(first < second);
        let (mut of, bounds) = (polynomials(4), no_bounds(equations.entries.len()));
        let mut jacobian = vec![Discs::of(Disc::default()); equations.entries.len()];
        let (b, j) = (1.0 + 2.0_f64.powi(-30), 1.0 + 2.0_f64.powi(-23) + 2.0_f64.powi(-50));
        (of.b[2], of.b[3]) = ([b; LANES], [-1.0; LANES]);
        (jacobian[first].re, jacobian[second].re) = ([j; LANES], [b * j; LANES]);
        let exact = Extended::from(b) * Extended::from(j) - Extended::from(b * j);
        is_met(exact.abs().to_f64(), adjoint_defect(equations, &of, &jacobian, &bounds)[0], 1e-3);
    });
}

/// The terms |Δ| of X, and X Ā of Ā: B = 1 − 0.95 (1 + x)/2 is 0.05 at the end, and larger at the last node by more
/// than the fiftieth that the search adds. Part 0.5.
#[test]
fn an_inverse_is_larger_between_the_nodes() {
    let mut of = polynomials(1);
    of.b[0] = TABLES.legendre[1].hi.map(|x| 1.0 - 0.475 * (1.0 + x));
    of.w_most[0] = 0.95;
    is_met(20.0, inverse_bound(1, 1.0, &of).unwrap()[0], 0.5);
}

/// The term |I − A B| of X: B is 1, and off by a tenth. Part 0.95.
#[test]
fn an_inverse_is_larger_where_the_matrix_is_off() {
    let mut of = polynomials(1);
    of.slack[0] = 0.1;
    is_met(1.0 / 0.9, inverse_bound(1, 1.0, &of).unwrap()[0], 0.95);
}

/// The three terms of |I − A B|. Parts 1 of what it is and of what B is off by, and 0.02 of rounding, of which there is
/// one for eighteen.
#[test]
fn what_an_inverse_misses_is_bounded() {
    is_met(0.5, missed(&[1.0], &[0.5], &[0.0], 1)[0], 0.999);
    is_met(0.3, missed(&[1.0], &[1.0], &[0.3], 1)[0], 0.999);
    let mut largest = 0.0_f64;
    for i in 1..200 {
        let b = 1.0 + f64::from(i) / 200.0;
        let a = 1.0 / b;
        let exact = (Extended::ONE - Extended::from(a) * Extended::from(b)).abs().to_f64();
        let most = missed(&[a], &[b], &[0.0], 1)[0];
        assert!(exact <= most, "{b}: {exact:e} {most:e}");
        largest = largest.max(exact / most);
    }
    assert!(largest > 0.02, "{largest}");
}

/// Bounds hold of the rounding of B and W at the nodes, and of their sizes: on the window, where W is 1 + … + 1 at its
/// end, and where the ellipse meets the real axis. Parts 0.003 of roundings, 1 of W, and 0.1 on the ellipse.
#[test]
fn matrix_polynomials_are_bounded_with_their_rounding() {
    let (h, exact) = (0.7, Extended::from);
    let mut largest = [0.0_f64; 2];
    for draw in 0..50 {
        let coefficients: FewRow = std::array::from_fn(|k| ((7 * k + 13 * draw) as f64).sin().abs());
        let of = Polynomials::new(1, h, &[coefficients]);
        for i in 0..LANES {
            let sum = |table: &[super::super::tables::Pairs]| {
                let terms = coefficients.iter().zip(table);
                terms.fold(Extended::ZERO, |sum, (c, row)| sum + exact(*c) * (exact(row.hi[i]) + exact(row.lo[i])))
            };
            let b = Extended::ONE + exact(0.5 * h) * sum(&TABLES.integral);
            let off_b = (b - exact(of.b[0][i])).abs().to_f64() / of.slack[0];
            let off_w = (sum(&TABLES.legendre) - exact(of.w[0][i])).abs().to_f64() / of.w_slack[0];
            assert!(off_b <= 1.0 && off_w <= 1.0, "{off_b} {off_w}");
            largest = [largest[0].max(off_b), largest[1].max(off_w)];
        }
        is_met(coefficients.iter().sum(), of.w_most[0], 0.999);
        let (x, mut p) = (5.0 / 3.0, vec![1.0, 5.0 / 3.0]);
        (1..=FEW_MODES).for_each(|k| p.push(((2 * k + 1) as f64 * x * p[k] - k as f64 * p[k - 1]) / (k + 1) as f64));
        let integral = |k: usize| if k == 0 { 1.0 + x } else { (p[k + 1] - p[k - 1]) / (2 * k + 1) as f64 };
        let terms = coefficients.iter().enumerate();
        is_met(terms.clone().map(|(k, c)| c * p[k]).sum(), of.w_there[0], 0.1);
        is_met(1.0 + 0.5 * h * terms.map(|(k, c)| c * integral(k)).sum::<f64>(), of.b_there[0], 0.1);
    }
    assert!(largest.iter().all(|used| *used > 3e-3), "{largest:?}");
}

/// The degree of W and one more.
const FEW_MODES: usize = super::super::tables::FEW;
