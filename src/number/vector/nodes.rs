//! The values on the nodes of a window, as vectors take them.

/// Nodal values, padded to P.
#[repr(align(64))]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nodes<const P: usize>(pub(crate) [f64; P]);

impl<const P: usize> AsRef<[f64]> for Nodes<P> {
    #[inline]
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

impl<const P: usize> AsMut<[f64]> for Nodes<P> {
    #[inline]
    fn as_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl<const P: usize> Nodes<P> {
    pub(crate) const ZERO: Self = Self([0.0; P]);

    /// Σ b_j v_j, in eight sums that do not wait for each other.
    pub(crate) fn dot(&self, weights: &[f64; P]) -> f64 {
        let mut sums = [0.0; 8];
        for (v, b) in self.0.as_chunks::<8>().0.iter().zip(weights.as_chunks::<8>().0) {
            (0..8).for_each(|k| sums[k] += v[k] * b[k]);
        }
        sums.iter().sum()
    }
}
