//! The linear theory of stability, computed from the coefficients of the operators.
//!
//! On an infinite grid hD turns the wave e^{ikθ} into i s(θ) e^{ikθ} with the *symbol* s(θ) = 2 Σ_m d_m sin mθ. An
//! oscillation of frequency ω needs an angle with s(θ) = hω. If hω is above the largest symbol, there is no such angle,
//! and the recursion has growing solutions instead. If it is below, there are two angles. The second one is near θ = π,
//! where s(π) = 0; it belongs to the computational mode, the sawtooth (−1)^k.
//!
//! A *window* maps its initial value to its last node: dy/dγ = λy becomes y_N = R(λ) y_0. An oscillation does not grow
//! as long as |R(iω)| ≤ 1. In the weak form
//!
//! ```text
//! ( D + H⁻¹E_0 − λ ) y = H⁻¹e_1 y_0
//! ```
//!
//! holds, and R is that of an A- and L-stable Runge–Kutta method; for Gauss–Lobatto nodes that is Lobatto IIIC. In the
//! strong form (Dy)_k = λ y_k holds at all nodes but the last, and y_1 = y_0.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, DVector};

use super::coefficients::quotient;
use super::{Coefficients, SbpOperator};

/// Number of angles at which the maximum of the symbol is searched for.
const ANGLES: usize = 1000;

/// The symbol s(θ) of hD in the interior, at the given `angle` θ.
pub fn symbol(coefficients: &Coefficients, angle: f64) -> f64 {
    let terms = coefficients.interior.iter().zip(1..);
    terms.map(|(d, m)| 2.0 * quotient::<f64>(d) * (f64::from(m) * angle).sin()).sum()
}

/// The largest s(θ). No oscillation with a larger hω is a solution in the interior.
pub fn largest_symbol(coefficients: &Coefficients) -> f64 {
    let angle = |k: usize| PI * k as f64 / ANGLES as f64;
    let at = |k: &usize| symbol(coefficients, angle(*k));
    let best = (1..ANGLES).max_by(|a, b| at(a).total_cmp(&at(b))).unwrap_or(ANGLES / 2);
    // There is a single maximum between the neighbours; every step of the search removes a third of the interval.
    let (mut low, mut high) = (angle(best - 1), angle(best + 1));
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if symbol(coefficients, low + third) < symbol(coefficients, high - third) {
            low += third;
        } else {
            high -= third;
        }
    }
    symbol(coefficients, 0.5 * (low + high))
}

/// R(λ) of a window, in the operator's own units of 1/γ; infinite where the system is singular. In the weak form the
/// initial value enters by the penalty H⁻¹E_0, and otherwise as the value of the first node.
pub fn amplification(sbp: &SbpOperator, is_weak: bool, lambda: Complex<f64>) -> Complex<f64> {
    let n = sbp.points();
    // The unknowns are the nodes from `first` on, and there is one equation for each.
    let first = usize::from(!is_weak);
    let mut matrix = DMatrix::<Complex<f64>>::zeros(n - first, n - first);
    let mut right = DVector::<Complex<f64>>::zeros(n - first);
    for row in 0..n - first {
        let diagonal = std::iter::once((row, -lambda));
        for (column, value) in sbp.row(row).map(|(column, d)| (column, d.into())).chain(diagonal) {
            if column < first {
                right[row] -= value;
            } else {
                matrix[(row, column - first)] += value;
            }
        }
    }
    if is_weak {
        let penalty = 1.0 / sbp.weights()[0];
        matrix[(0, 0)] += penalty;
        right[0] += penalty;
    }
    match matrix.lu().solve(&right) {
        Some(y) => y[n - first - 1],
        None => Complex::new(f64::INFINITY, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::ComplexField;

    use super::*;
    use crate::sbp::SbpName;

    #[test]
    fn weak_windows_are_a_stable_and_l_stable() {
        let operators = [
            SbpName::Sbp21.operator(21, 1.0),
            SbpName::Sbp42.operator(9, 1.0),
            SbpName::Sbp84.operator(20, 1.0),
            SbpName::Gll(2).operator(2, 1.0),
            SbpName::Gll(5).operator(5, 0.25),
            SbpName::Gll(16).operator(16, 1.0),
        ];
        for sbp in operators.map(Result::unwrap) {
            for k in -40..=40 {
                let omega = 10_f64.powf(0.1 * f64::from(k));
                for damping in [0.0, 0.3, 20.0] {
                    let r = amplification(&sbp, true, Complex::new(-damping, omega)).modulus();
                    assert!(r <= 1.0 + 1e-11, "{} nodes, omega = {omega}, -{damping}: {r}", sbp.points());
                }
            }
            assert!(amplification(&sbp, true, Complex::new(-1e9, 0.0)).modulus() < 1e-6);
        }
    }

    #[test]
    fn gauss_lobatto_windows_are_lobatto_iiic() {
        // Two nodes: R(z) = 1/(1 − z + z²/2), the (0, 2) Padé approximant of e^z; n nodes: the (n − 2, n) one.
        for z in [Complex::new(0.0, 0.7), Complex::new(-0.4, 1.9)] {
            let two = amplification(&SbpOperator::gauss_lobatto(2, 1.0), true, z);
            assert!((two - (Complex::new(1.0, 0.0) - z + z * z * 0.5).inv()).modulus() < 1e-14);
            let three = amplification(&SbpOperator::gauss_lobatto(3, 1.0), true, z);
            let denominator = Complex::new(1.0, 0.0) - z * 0.75 + z * z * 0.25 - z * z * z / 24.0;
            assert!((three - (Complex::new(1.0, 0.0) + z * 0.25) / denominator).modulus() < 1e-14);
        }
    }

    #[test]
    fn strong_windows_begin_with_an_euler_step_and_grow() {
        let sbp = SbpName::Sbp21.operator(3, 1.0).unwrap();
        // y_2 = (1 + z) y_1, y_3 = y_1 + 2 z y_2.
        let z = Complex::new(0.0, 0.1);
        let r = amplification(&sbp, false, z);
        assert!((r - (Complex::new(1.0, 0.0) + z * 2.0 * (Complex::new(1.0, 0.0) + z))).modulus() < 1e-15);
        let window = SbpName::Sbp21.operator(21, 1.0).unwrap();
        assert!(amplification(&window, false, z).modulus() > 1.0 + 1e-3);
    }
}
