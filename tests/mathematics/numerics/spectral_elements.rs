//! Gauss–Lobatto–Legendre operators: the same identities as the others, in extended precision.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::sbp::gll::{LobattoRule, MOST_NODES};
use geodesic_ivp::sbp::{RegularisedOperator, SbpName, SbpOperator};
use nalgebra::DMatrix;

const SIZES: [usize; 9] = [2, 3, 4, 5, 8, 16, 21, 32, MOST_NODES];

fn whole(k: usize) -> Extended {
    Extended::from(k as f64)
}

fn power(x: Extended, exponent: usize) -> Extended {
    (0..exponent).fold(Extended::ONE, |product, _| product * x)
}

/// Entry (i, j) of D.
fn entry(sbp: &SbpOperator<Extended>, i: usize, j: usize) -> Extended {
    sbp.row(i).filter(|e| e.0 == j).map(|e| e.1).fold(Extended::ZERO, |sum, d| sum + d)
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

#[test]
fn only_constants_have_no_derivative_and_the_regularised_operator_loses_nothing() {
    for nodes in [2, 3, 8, 16, 32] {
        let n = usize::from(nodes);
        let sbp: SbpOperator = SbpName::Gll(nodes).operator(n, 0.1).unwrap();
        let mut linear = DMatrix::<f64>::zeros(n, n);
        let bar = RegularisedOperator::new(&sbp, 0.3);
        (0..n).for_each(|k| bar.row(k).for_each(|(column, d)| linear[(k, column)] += d));
        assert_eq!(linear.rank(1e-10), n);
    }
    assert!(SbpName::Gll(16).operator(15, 0.1_f64).is_err());
}
