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
}

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
        let indices = if line.geometry().has_force() { None } else { Some(indices(&values)) };
        Some(Self { values, indices })
    }
}

/// The index of each pair, the larger eigenvalue of which has more of its digits.
fn indices(values: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let (mut left, mut indices) = (values.to_vec(), Vec::new());
    while !left.is_empty() {
        let inverse = left.remove(0).inv();
        let near = |value: &Complex<f64>| (value - inverse).modulus();
        let other = (0..left.len()).min_by(|&a, &b| near(&left[a]).total_cmp(&near(&left[b])));
        other.map(|other| left.remove(other));
        indices.push(0.5 * (inverse + inverse.inv()));
    }
    indices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_belongs_to_a_pair() {
        let on_circle = Complex::new(0.6, 0.8);
        let values = [Complex::from(4.0), on_circle, on_circle.conj(), Complex::from(0.25)];
        let found = indices(&values);
        assert!(
            found.len() == 2 && (found[0] - 2.125).modulus() < 1e-15 && (found[1] - 0.6).modulus() < 1e-15,
            "{found:?}"
        );
    }
}
