//! The SBP coefficients satisfy their defining identities exactly, and are exact on polynomials up to their order and
//! no further.

use geodesic_ivp::sbp::coefficients::{Rational, SBP21, SBP42, SBP63, SBP84};
use geodesic_ivp::sbp::{Coefficients, RegularisedOperator, SbpName, SbpOperator};
use nalgebra::{ComplexField, DMatrix, DVector};
use num_rational::Ratio;
use proptest::prelude::*;

type Exact = Ratio<i128>;

const OPERATORS: [&Coefficients; 4] = [&SBP21, &SBP42, &SBP63, &SBP84];

fn exact(r: &Rational) -> Exact {
    Exact::new(i128::from(r.numerator), i128::from(r.denominator))
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

fn operator(c: &Coefficients, n: usize, spacing: f64) -> SbpOperator {
    SbpOperator::new(c, n, spacing).unwrap()
}

/// The n × n matrix with these rows.
fn matrix<I: Iterator<Item = (usize, f64)>>(n: usize, row: impl Fn(usize) -> I) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(n, n);
    (0..n).for_each(|k| row(k).for_each(|(column, d)| matrix[(k, column)] += d));
    matrix
}

#[test]
fn the_operator_is_its_table() {
    for c in OPERATORS {
        for n in c.minimum_points..c.minimum_points + 4 {
            let sbp = operator(c, n, 0.25);
            for (k, table) in exact_d(c, n).iter().enumerate() {
                let row: Vec<f64> = (0..n).map(|j| sbp.row(k).filter(|e| e.0 == j).map(|e| e.1).sum()).collect();
                for j in 0..n {
                    let value = *table[j].numer() as f64 / *table[j].denom() as f64 / 0.25;
                    assert!((row[j] - value).abs() < 1e-14, "{} row {k} column {j}", c.name);
                    let mut unit = vec![0.0; n];
                    unit[j] = 1.0;
                    assert_eq!(sbp.derivative(&unit)[k], row[j]);
                }
            }
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
}

#[test]
fn a_deviation_at_the_last_node_reaches_as_many_rows_as_the_closure_has() {
    assert_eq!(operator(&SBP21, 20, 1.0).rows_reaching_last_node(), 2);
    assert_eq!(operator(&SBP42, 20, 1.0).rows_reaching_last_node(), 4);
    assert_eq!(operator(&SBP63, 20, 1.0).rows_reaching_last_node(), 6);
    assert_eq!(operator(&SBP84, 20, 1.0).rows_reaching_last_node(), 8);
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
        let derivative = regularised.derivative(&u);
        for k in 0..n {
            prop_assert!((derivative[k] - image[k]).abs() < 1e-12);
            prop_assert!((transposed[k] - expected[k]).abs() < 1e-12);
        }
    }
}

/// The largest modulus of an eigenvalue of hD.
fn spectral_radius(c: &Coefficients, n: usize) -> f64 {
    let sbp = operator(c, n, 1.0);
    matrix(n, |k| sbp.row(k)).complex_eigenvalues().iter().map(|e| e.modulus()).fold(0.0, f64::max)
}

#[test]
fn closures_are_no_stiffer_than_the_interior() {
    // Largest symbol of the interior stencil, max_φ 2 Σ_m d_m sin mφ.
    for (c, largest) in [(&SBP21, 1.0), (&SBP42, 1.372), (&SBP63, 1.586), (&SBP84, 1.731)] {
        let stencil: Vec<f64> = c.interior.iter().map(|d| d.to_real::<f64>()).collect();
        let symbol = |phi: f64| 2.0 * stencil.iter().zip(1..).map(|(d, m)| d * (f64::from(m) * phi).sin()).sum::<f64>();
        let symbol = (0..3142).map(|k| symbol(f64::from(k) * 1e-3)).fold(0.0, f64::max);
        assert!((symbol - largest).abs() < 1e-3, "{}: {symbol}", c.name);
        assert!(spectral_radius(c, 48) <= largest, "{}: {}", c.name, spectral_radius(c, 48));
    }
}

#[test]
fn names_know_how_exact_the_ends_are() {
    for name in SbpName::STENCILS.into_iter().chain([SbpName::Gll(2), SbpName::Gll(5), SbpName::Gll(9)]) {
        let n = name.fixed_points().unwrap_or(name.minimum_points() + 3);
        let operator: SbpOperator = name.operator(n, 2.0 / (n - 1) as f64).unwrap();
        let off = |degree: i32| {
            let u: Vec<f64> = (0..n).map(|k| operator.node(k).powi(degree)).collect();
            let exact = if degree == 0 { 0.0 } else { f64::from(degree) * operator.node(n - 1).powi(degree - 1) };
            (operator.derivative_at(&u, n - 1) - exact).abs()
        };
        let order = name.boundary_order() as i32;
        assert!((0..=order).all(|degree| off(degree) < 1e-9), "{name}");
        assert!(off(order + 1) > 1e-4, "{name}: {:e}", off(order + 1));
    }
}

#[test]
fn as_a_matrix_an_operator_is_the_same_and_its_penalty_acts_at_the_first_node() {
    for name in SbpName::STENCILS.into_iter().chain([SbpName::Gll(4), SbpName::Gll(9)]) {
        let n = name.fixed_points().unwrap_or(name.minimum_points() + 3);
        let operator: SbpOperator = name.operator(n, 0.3).unwrap();
        let u: Vec<f64> = (0..n).map(|k| (1.3 * k as f64 + 0.2).sin()).collect();
        let mut derivative = vec![0.0; n];
        operator.apply(&u, &mut derivative);
        let by_matrix = matrix(n, |k| operator.row(k)) * DVector::from_column_slice(&u);
        let regularised = RegularisedOperator::new(&operator, 0.7).derivative(&u);
        for k in 0..n {
            assert!((derivative[k] - by_matrix[k]).abs() < 1e-12, "{name}, row {k}");
            let penalty = if k == 0 { (u[0] - 0.7) / operator.weights()[0] } else { 0.0 };
            assert!((regularised[k] - derivative[k] - penalty).abs() < 1e-12, "{name}, row {k}");
        }
    }
}

#[test]
fn the_row_sum_is_by_how_much_rounding_is_amplified() {
    for name in SbpName::STENCILS.into_iter().chain([SbpName::Gll(4), SbpName::Gll(9), SbpName::Gll(24)]) {
        let n = name.fixed_points().unwrap_or(name.minimum_points() + 3);
        let operator: SbpOperator = name.operator(n, 0.3).unwrap();
        assert!((operator.spacing() * (n - 1) as f64 - operator.node(n - 1)).abs() < 1e-13, "{name}");
        let of_row = |k: usize| operator.row(k).map(|(_, d)| (0.3 * d).abs()).sum::<f64>();
        let most = (0..n).map(of_row).fold(4.0, f64::max);
        assert!((operator.row_sum() / most - 1.0).abs() < 1e-13, "{name}: {} for {most}", operator.row_sum());
        assert!((operator.stiffness() / (most / 4.0) - 1.0).abs() < 1e-13, "{name}");
    }
    assert!([SbpName::Sbp21, SbpName::Sbp42].iter().all(|name| name.operator(20, 1.0).unwrap().stiffness() == 1.0));
}
