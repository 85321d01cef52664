//! The Floquet multipliers of a periodic motion: the eigenvalues of its monodromy matrix.

use nalgebra::{Complex, ComplexField, DMatrix};

use super::chain;
use crate::solve::WorldLine;

/// The multipliers of a periodic motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipliers {
    /// The eigenvalues, the largest first. They come in pairs λ, 1/λ where no force acts; one pair is 1 where the
    /// energy is constant.
    pub values: Vec<Complex<f64>>,
    /// Hénon's stability index (λ + 1/λ)/2 of each pair: it is real and lies between −1 and 1 where the motion is
    /// stable. None where the eigenvalues are no such pairs, as with friction.
    pub indices: Option<Vec<Complex<f64>>>,
    /// M. G. Krein's sign of each of these pairs that lies on the unit circle, and 0 for another one: that of Im Σ q̄_a
    /// p_a of the eigenvector of the multiplier above the real axis, in the momenta that a user sees. It is 1 for an
    /// oscillator of Newton's law. Pairs that meet on the circle can leave it only if their signs differ.
    pub krein_signs: Option<Vec<i8>>,
}

/// A multiplier that is as near to the unit circle, and as far from the real axis, lies on the circle.
const ON_CIRCLE: f64 = 1e-6;

impl Multipliers {
    /// Those of a run which returns; `None` if it has not carried the linearised equations. The time counts nowhere: it
    /// does not return.
    pub(super) fn new(line: &WorldLine) -> Option<Self> {
        let phi = chain::matrix(line)?;
        let (names, active) = (line.geometry().names(), line.geometry().active());
        let m = active.len();
        let kept: Vec<usize> = (0..2 * m).filter(|k| names[active[k % m]] != "t").collect();
        let matrix = DMatrix::from_fn(kept.len(), kept.len(), |i, j| phi[(kept[i], kept[j])]);
        let mut values: Vec<Complex<f64>> = matrix.complex_eigenvalues().iter().copied().collect();
        values.sort_by(|a, b| b.modulus().total_cmp(&a.modulus()).then(b.im.total_cmp(&a.im)));
        let pairs = if line.geometry().has_force() { None } else { Some(pairs(&values)) };
        let momenta = |k: &usize| line.geometry().seen(active[k % m], 1.0);
        let seen: Vec<f64> = kept.iter().map(momenta).collect();
        let krein_signs =
            pairs.as_ref().map(|pairs| pairs.iter().map(|pair| krein_sign(&matrix, &seen, *pair)).collect());
        let indices = pairs.map(|pairs| pairs.into_iter().map(|[one, other]| 0.5 * (one + other)).collect());
        Some(Self { values, indices, krein_signs })
    }
}

/// The sign of a pair of multipliers of a monodromy matrix of positions and then momenta, each of which a user sees
/// with this sign.
fn krein_sign(matrix: &DMatrix<f64>, seen: &[f64], pair: [Complex<f64>; 2]) -> i8 {
    let is_on_circle = |value: &&Complex<f64>| (value.modulus() - 1.0).abs() < ON_CIRCLE && value.im > ON_CIRCLE;
    let Some(&value) = pair.iter().find(is_on_circle) else { return 0 };
    let shifted = matrix.map(Complex::from) - DMatrix::identity(seen.len(), seen.len()) * value;
    let svd = shifted.svd(false, true);
    let Some(v_t) = svd.v_t else { return 0 };
    let last = svd.singular_values.imin();
    let vector: Vec<Complex<f64>> = v_t.row(last).iter().map(Complex::conj).collect();
    let (q, p) = vector.split_at(seen.len() / 2);
    let sum: f64 = q.iter().zip(p).zip(seen).map(|((q, p), seen)| (q.conj() * p).im * seen).sum();
    // Where two pairs meet it has none.
    if sum.abs() > ON_CIRCLE { sum.signum() as i8 } else { 0 }
}

/// Each pair λ and 1/λ, the larger eigenvalue of which has more of its digits.
fn pairs(values: &[Complex<f64>]) -> Vec<[Complex<f64>; 2]> {
    let (mut left, mut pairs) = (values.to_vec(), Vec::new());
    while !left.is_empty() {
        let value = left.remove(0);
        let inverse = value.inv();
        let near = |value: &Complex<f64>| (value - inverse).modulus();
        let other = (0..left.len()).min_by(|&a, &b| near(&left[a]).total_cmp(&near(&left[b])));
        other.map(|other| left.remove(other));
        pairs.push([inverse.inv(), inverse]);
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_belongs_to_a_pair() {
        let on_circle = Complex::new(0.6, 0.8);
        let values = [Complex::from(4.0), on_circle, on_circle.conj(), Complex::from(0.25)];
        let found: Vec<_> = pairs(&values).into_iter().map(|[one, other]| 0.5 * (one + other)).collect();
        assert!(
            found.len() == 2 && (found[0] - 2.125).modulus() < 1e-15 && (found[1] - 0.6).modulus() < 1e-15,
            "{found:?}"
        );
    }

    /// H = ½ (p² + q²) turns one way and has a positive sign, −H the other way and has a negative one; what grows has
    /// none, nor has a momentum that is seen with the other sign the same one.
    #[test]
    fn a_pair_has_the_sign_of_its_energy() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let on_circle = [Complex::new(cos, sin), Complex::new(cos, -sin)];
        for sign in [1.0, -1.0] {
            // q′ = ±p and p′ = ∓q.
            let matrix = DMatrix::from_row_slice(2, 2, &[cos, sign * sin, -sign * sin, cos]);
            assert_eq!(f64::from(krein_sign(&matrix, &[1.0, 1.0], on_circle)), sign);
            assert_eq!(f64::from(krein_sign(&matrix, &[-1.0, -1.0], on_circle)), -sign);
        }
        let growing = DMatrix::from_row_slice(2, 2, &[2.0, 0.0, 0.0, 0.5]);
        assert_eq!(krein_sign(&growing, &[1.0, 1.0], [Complex::from(2.0), Complex::from(0.5)]), 0);
    }
}
