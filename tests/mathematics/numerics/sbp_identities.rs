//! The SBP coefficients satisfy their defining identities exactly, and are exact on polynomials up to their order and
//! no further. Gauss–Lobatto–Legendre operators have the same identities in extended precision.

use std::f64::consts::PI;

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::sbp::coefficients::{Rational, SBP21, SBP42, SBP63, SBP84};
use geodesic_ivp::sbp::gll::{LobattoRule, MOST_NODES};
use geodesic_ivp::sbp::symbol::{largest_symbol, symbol};
use geodesic_ivp::sbp::{Coefficients, RegularisedOperator, SbpName, SbpOperator};
use nalgebra::{ComplexField, DMatrix, DVector};
use num_rational::Ratio;
use proptest::prelude::*;

type Exact = Ratio<i128>;

const OPERATORS: [&Coefficients; 4] = [&SBP21, &SBP42, &SBP63, &SBP84];

/// An operator of every name on a few nodes of the spacing, with its name.
fn operators(spacing: f64) -> impl Iterator<Item = (SbpName, SbpOperator)> {
    SbpName::STENCILS.into_iter().chain([2, 4, 5, 9, 24].map(SbpName::Gll)).map(move |name| {
        let n = name.fixed_points().unwrap_or(name.minimum_points() + 3);
        (name, name.operator(n, spacing).unwrap())
    })
}

fn exact(&(numerator, denominator): &Rational) -> Exact {
    Exact::new(i128::from(numerator), i128::from(denominator))
}

fn integer(n: i128) -> Exact {
    Exact::from_integer(n)
}

/// D for unit spacing, straight from the table and independent of `SbpOperator`.
fn exact_d(c: &Coefficients, n: usize) -> Vec<Vec<Exact>> {
    let mut d = vec![vec![integer(0); n]; n];
    let s = c.closure.len();
    for (k, row) in c.closure.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            d[k][j] = exact(value);
            d[n - 1 - k][n - 1 - j] = -exact(value);
        }
    }
    for (k, row) in d.iter_mut().enumerate().take(n - s).skip(s) {
        for (m, value) in c.interior.iter().enumerate() {
            row[k + m + 1] = exact(value);
            row[k - m - 1] = -exact(value);
        }
    }
    d
}

fn exact_h(c: &Coefficients, n: usize) -> Vec<Exact> {
    let mut h = vec![integer(1); n];
    for (k, value) in c.norm.iter().enumerate() {
        h[k] = exact(value);
        h[n - 1 - k] = exact(value);
    }
    h
}

fn summation_by_parts_holds(d: &[Vec<Exact>], h: &[Exact]) -> bool {
    let n = h.len();
    (0..n).all(|i| {
        (0..n).all(|j| {
            let boundary = i128::from(i == n - 1 && j == n - 1) - i128::from(i == 0 && j == 0);
            h[i] * d[i][j] + h[j] * d[j][i] == integer(boundary)
        })
    })
}

#[test]
fn summation_by_parts_is_exact() {
    for c in OPERATORS {
        for n in c.minimum_points..c.minimum_points + 6 {
            assert!(summation_by_parts_holds(&exact_d(c, n), &exact_h(c, n)), "{} with {n} points", c.name);
        }
    }
}

#[test]
fn the_misprint_of_the_paper_breaks_summation_by_parts() {
    let n = 12;
    let mut d = exact_d(&SBP42, n);
    assert_eq!(d[3][2], Exact::new(-59, 98));
    d[3][2] = Exact::new(-59, 86);
    assert!(!summation_by_parts_holds(&d, &exact_h(&SBP42, n)));
    assert_ne!(d[3].iter().sum::<Exact>(), integer(0), "the printed row does not even differentiate a constant");
}

/// Returns true if row k of D is exact on γ^degree (nodes at the integers).
fn exact_on(d: &[Vec<Exact>], k: usize, degree: u32) -> bool {
    let power = |j: usize, p: u32| integer((j as i128).pow(p));
    let applied: Exact = d[k].iter().enumerate().map(|(j, value)| *value * power(j, degree)).sum();
    let expected = if degree == 0 { integer(0) } else { integer(i128::from(degree)) * power(k, degree - 1) };
    applied == expected
}

#[test]
fn rows_are_exact_up_to_their_order_and_no_further() {
    for c in OPERATORS {
        let n = c.minimum_points + 5;
        let d = exact_d(c, n);
        let s = c.closure.len();
        let (inside, boundary) = (c.interior_order as u32, (c.interior_order / 2) as u32);
        for k in 0..n {
            let order = if k < s || k >= n - s { boundary } else { inside };
            assert!((0..=order).all(|p| exact_on(&d, k, p)), "{} row {k} is exact to degree {order}", c.name);
        }
        for k in s..n - s {
            assert!(!exact_on(&d, k, inside + 1), "{} row {k} fails one degree higher", c.name);
        }
        assert!((0..s).any(|k| !exact_on(&d, k, boundary + 1)), "{}: the closure fails one degree higher", c.name);
    }
}

#[test]
fn the_norm_integrates_up_to_its_order_and_no_further() {
    for c in OPERATORS {
        let n = c.minimum_points + 5;
        let h = exact_h(c, n);
        let integral = |p: u32| -> Exact { h.iter().enumerate().map(|(k, w)| *w * integer((k as i128).pow(p))).sum() };
        let exact_integral = |p: u32| Exact::new((n as i128 - 1).pow(p + 1), i128::from(p) + 1);
        let order = c.interior_order as u32;
        assert!((0..order).all(|p| integral(p) == exact_integral(p)), "{} integrates degree {}", c.name, order - 1);
        assert_ne!(integral(order), exact_integral(order), "{} fails one degree higher", c.name);
    }
}

/// The n × n matrix with these rows.
fn matrix<I: Iterator<Item = (usize, f64)>>(n: usize, row: impl Fn(usize) -> I) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(n, n);
    (0..n).for_each(|k| row(k).for_each(|(column, d)| matrix[(k, column)] += d));
    matrix
}

/// Entry (i, j) of D.
fn entry<S: Real>(sbp: &SbpOperator<S>, i: usize, j: usize) -> S {
    sbp.row(i).filter(|e| e.0 == j).map(|e| e.1).fold(S::ZERO, |sum, d| sum + d)
}

fn operator(c: &Coefficients, n: usize, spacing: f64) -> SbpOperator {
    SbpOperator::new(c, n, spacing).unwrap()
}

#[test]
fn the_operator_is_its_table() {
    for c in OPERATORS {
        for n in c.minimum_points..c.minimum_points + 4 {
            let (sbp, table) = (operator(c, n, 0.25), exact_d(c, n));
            for (k, j) in (0..n * n).map(|kj| (kj / n, kj % n)) {
                let value = *table[k][j].numer() as f64 / *table[k][j].denom() as f64 / 0.25;
                assert!((entry(&sbp, k, j) - value).abs() < 1e-14, "{} row {k} column {j}", c.name);
            }
        }
    }
}

/// As a matrix and as a function an operator is the same, and its penalty acts at the first node.
#[test]
fn an_operator_is_its_rows() {
    for (name, sbp) in operators(0.3).filter(|(name, _)| *name != SbpName::Gll(24)) {
        let n = sbp.points();
        let d = matrix(n, |k| sbp.row(k));
        for (k, j) in (0..n * n).map(|kj| (kj / n, kj % n)) {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            let (found, entry) = (sbp.derivative(&unit)[k], d[(k, j)]);
            // The diagonal of an element is a sum in the one, and what makes its rows add up to zero in the other.
            let most = if name.fixed_points().is_some() { 1e-13 } else { 0.0 };
            assert!((found - entry).abs() <= most, "{name}, row {k}, column {j}: {found} for {entry}");
        }
        let u: Vec<f64> = (0..n).map(|k| (1.3 * k as f64 + 0.2).sin()).collect();
        let mut derivative = vec![0.0; n];
        sbp.apply(&u, &mut derivative);
        let by_matrix = d * DVector::from_column_slice(&u);
        let mut regularised = vec![0.0; n];
        RegularisedOperator::new(&sbp, 0.7).apply(&u, &mut regularised);
        for k in 0..n {
            assert!((derivative[k] - by_matrix[k]).abs() < 1e-12, "{name}, row {k}");
            let penalty = if k == 0 { (u[0] - 0.7) / sbp.weights()[0] } else { 0.0 };
            assert!((regularised[k] - derivative[k] - penalty).abs() < 1e-12, "{name}, row {k}");
        }
    }
}

#[test]
fn too_few_points_are_refused() {
    for c in OPERATORS {
        let error = SbpOperator::new(c, c.minimum_points - 1, 1.0).unwrap_err();
        assert_eq!(error.minimum, c.minimum_points);
        assert!(error.to_string().contains(&format!("at least {} points", c.minimum_points)));
    }
    assert!(SbpName::Gll(16).operator(15, 0.1_f64).is_err());
}

#[test]
fn a_deviation_at_the_last_node_reaches_as_many_rows_as_the_closure_has() {
    for (c, rows) in OPERATORS.into_iter().zip([2, 4, 6, 8]) {
        assert_eq!(operator(c, 20, 1.0).rows_reaching_last_node(), rows, "{}", c.name);
    }
    assert_eq!(SbpOperator::gauss_lobatto(9, 1.0).rows_reaching_last_node(), 9);
}

#[test]
fn the_null_space_of_d_is_the_constants_and_the_regularised_one_has_none() {
    for c in OPERATORS {
        let sbp = operator(c, 16, 0.1);
        assert_eq!(matrix(16, |k| sbp.row(k)).rank(1e-10), 15, "{}", c.name);
        // Every eigenvalue of the regularised operator has a positive real part: it is null-space consistent and
        // stable.
        let bar = RegularisedOperator::new(&sbp, 0.7);
        let linear = matrix(16, |k| bar.row(k));
        assert!(linear.complex_eigenvalues().iter().all(|e| e.re > 1e-8), "{}", c.name);
    }
    for nodes in [2, 3, 8, 16, 32] {
        let n = usize::from(nodes);
        let sbp: SbpOperator = SbpName::Gll(nodes).operator(n, 0.1).unwrap();
        let bar = RegularisedOperator::new(&sbp, 0.3);
        assert_eq!(matrix(n, |k| bar.row(k)).rank(1e-10), n);
    }
}

proptest! {
    #[test]
    fn the_rows_and_the_transpose_agree_with_the_operator(
        u in proptest::collection::vec(-3.0..3.0_f64, 17), start in -2.0..2.0_f64, which in 0..4_usize,
    ) {
        let n = u.len();
        let sbp = operator(OPERATORS[which], n, 0.3);
        let regularised = RegularisedOperator::new(&sbp, start);
        let linear = matrix(n, |k| regularised.row(k));
        let mut image = &linear * DVector::from_column_slice(&u);
        image[0] -= start / sbp.weights()[0];
        let expected = linear.transpose() * DVector::from_fn(n, |k, _| sbp.weights()[k] * u[k]);
        let mut transposed = vec![0.0; n];
        regularised.apply_transpose_weighted(&u, &mut transposed);
        let mut derivative = vec![0.0; n];
        regularised.apply(&u, &mut derivative);
        for k in 0..n {
            prop_assert!((derivative[k] - image[k]).abs() < 1e-12);
            prop_assert!((transposed[k] - expected[k]).abs() < 1e-12);
        }
    }
}

/// No eigenvalue of hD is above the largest symbol of the interior stencil, max_θ s(θ). Of second order s = sin θ, of
/// fourth order s = (4/3) sin θ − (1/6) sin 2θ with s' = 0 at cos θ = 1 − √(3/2).
#[test]
fn closures_are_no_stiffer_than_the_interior() {
    let angle = (1.0 - 1.5_f64.sqrt()).acos();
    let fourth = 4.0 / 3.0 * angle.sin() - (2.0 * angle).sin() / 6.0;
    assert!((largest_symbol(&SBP21) - 1.0).abs() < 1e-15 && (largest_symbol(&SBP42) - fourth).abs() < 1e-15);
    for (c, largest) in OPERATORS.into_iter().zip([1.0, 1.372, 1.586, 1.731]) {
        assert!((largest_symbol(c) - largest).abs() < 6e-4, "{}: {}", c.name, largest_symbol(c));
        let s = |angle| symbol(c, angle);
        assert!((s(1e-3) / 1e-3 - 1.0).abs() < 1e-6 && s(PI).abs() < 1e-14, "{}: consistent, blind to (-1)^k", c.name);
        let sbp = operator(c, 48, 1.0);
        let d = matrix(48, |k| sbp.row(k));
        let radius = d.complex_eigenvalues().iter().map(|e| e.modulus()).fold(0.0, f64::max);
        assert!(radius <= largest, "{}: {radius}", c.name);
    }
}

#[test]
fn names_know_how_exact_the_ends_are() {
    for (name, operator) in operators(0.25).filter(|(name, _)| *name != SbpName::Gll(24)) {
        let n = operator.points();
        let scale = 2.0 / operator.node(n - 1);
        let off = |degree: i32| {
            let u: Vec<f64> = (0..n).map(|k| (scale * operator.node(k)).powi(degree)).collect();
            let exact = if degree == 0 { 0.0 } else { f64::from(degree) * 2.0_f64.powi(degree - 1) };
            (operator.derivative_at(&u, n - 1) / scale - exact).abs()
        };
        let order = name.boundary_order() as i32;
        assert!((0..=order).all(|degree| off(degree) < 1e-9), "{name}");
        assert!(off(order + 1) > 1e-4, "{name}: {:e}", off(order + 1));
    }
}

#[test]
fn the_row_sum_is_by_how_much_rounding_is_amplified() {
    for (name, operator) in operators(0.3) {
        let n = operator.points();
        assert!((operator.spacing() * (n - 1) as f64 - operator.node(n - 1)).abs() < 1e-13, "{name}");
        let of_row = |k: usize| operator.row(k).map(|(_, d)| (0.3 * d).abs()).sum::<f64>();
        let most = (0..n).map(of_row).fold(4.0, f64::max);
        assert!((operator.row_sum() / most - 1.0).abs() < 1e-13, "{name}: {} for {most}", operator.row_sum());
        assert!((operator.stiffness() / (most / 4.0) - 1.0).abs() < 1e-13, "{name}");
    }
    assert!([SbpName::Sbp21, SbpName::Sbp42].iter().all(|name| name.operator(20, 1.0).unwrap().stiffness() == 1.0));
}

/// Numbers of nodes of elements.
const SIZES: [usize; 9] = [2, 3, 4, 5, 8, 16, 21, 32, MOST_NODES];

fn whole(k: usize) -> Extended {
    Extended::from(k as f64)
}

fn power(x: Extended, exponent: usize) -> Extended {
    (0..exponent).fold(Extended::ONE, |product, _| product * x)
}

#[test]
fn summation_by_parts_holds_to_the_last_digits() {
    for n in SIZES {
        let sbp = SbpOperator::gauss_lobatto(n, Extended::ONE);
        let h = sbp.weights();
        for i in 0..n {
            for j in 0..n {
                let boundary = f64::from(i == n - 1 && j == n - 1) - f64::from(i == 0 && j == 0);
                let q = h[i] * entry(&sbp, i, j) + h[j] * entry(&sbp, j, i);
                let off = (q - Extended::from(boundary)).abs().to_f64();
                assert!(off < 1e-67 * n as f64, "n = {n}, ({i}, {j}): {off:e}");
            }
        }
    }
}

#[test]
fn derivative_and_quadrature_are_exact_to_their_degree_and_no_further() {
    for n in SIZES {
        let sbp = SbpOperator::gauss_lobatto(n, Extended::ONE + Extended::ONE);
        let nodes: Vec<Extended> = (0..n).map(|k| sbp.node(k) - Extended::ONE).collect();
        let values = |degree: usize| nodes.iter().map(|&x| power(x, degree)).collect::<Vec<_>>();
        let error = |degree: usize| {
            let derivative = sbp.derivative(&values(degree));
            let exact = |x: Extended| if degree == 0 { Extended::ZERO } else { whole(degree) * power(x, degree - 1) };
            derivative.iter().zip(&nodes).map(|(&d, &x)| (d - exact(x)).abs().to_f64()).fold(0.0, f64::max)
        };
        for degree in [0, 1, n / 2, n - 1] {
            assert!(error(degree) < 1e-65 * (n * n) as f64, "n = {n}, degree {degree}: {:e}", error(degree));
        }
        assert!(error(n) > 1e-20, "n = {n} fails at degree {n}");
        let defect = |degree: usize| {
            let exact = if degree.is_multiple_of(2) { whole(2) / whole(degree + 1) } else { Extended::ZERO };
            (sbp.integrate(&values(degree)) - exact).abs().to_f64()
        };
        for degree in [0, 1, n - 1, 2 * n - 3] {
            assert!(defect(degree) < 1e-68, "n = {n}, degree {degree}: {:e}", defect(degree));
        }
        assert!(defect(2 * n - 2) > 1e-40, "n = {n} fails at degree {}", 2 * n - 2);
    }
}

#[test]
fn nodes_weights_and_derivative_are_symmetric_and_rounded_once() {
    for n in SIZES {
        let (double, extended) = (LobattoRule::<f64>::new(n), LobattoRule::<Extended>::new(n));
        for k in 0..n {
            assert_eq!(double.nodes[k], extended.nodes[k].to_f64());
            assert_eq!(double.weights[k], extended.weights[k].to_f64());
            assert_eq!(double.nodes[k], -double.nodes[n - 1 - k]);
            assert!((extended.weights[k] - extended.weights[n - 1 - k]).abs().to_f64() < 1e-70);
        }
        assert!(extended.nodes.windows(2).all(|pair| pair[0] < pair[1]));
    }
    // Five nodes are ±1, ±√(3/7), 0 with the weights 1/10, 49/90, 32/45.
    let rule = LobattoRule::<Extended>::new(5);
    let close = |a: Extended, b: Extended| (a - b).abs().to_f64() < 1e-70;
    assert!(close(rule.nodes[3], (whole(3) / whole(7)).sqrt()) && rule.nodes[2] == Extended::ZERO);
    for (weight, (top, bottom)) in rule.weights.iter().zip([(1, 10), (49, 90), (32, 45)]) {
        assert!(close(*weight, whole(top) / whole(bottom)));
    }
}
