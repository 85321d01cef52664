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
}
