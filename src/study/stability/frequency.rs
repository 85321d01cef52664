//! The local frequencies of a scene: eigenvalues of the linearised equations of motion.

use nalgebra::{DMatrix, Schur};

use crate::geometry::{Geometry, Start};

/// The largest number of points at which eigenvalues are computed.
const MOST_POINTS: usize = 5_000;
/// A part of an eigenvalue below this share of the largest eigenvalue is rounding: two equal eigenvalues are known to
/// the root of ε.
const ROUNDING: f64 = 1e-6;
/// Iterations allowed for the eigenvalues of a point. A point whose eigenvalues need more is left out.
const MOST_ITERATIONS: usize = 1_000;

/// The largest |Im λ| and the largest |Re λ| of the eigenvalues λ of ∂(q̇, ṗ)/∂(q, p) of the active coordinates and
/// their momenta, at these points; 0 where all are rounding. In one coordinate λ² = dẍ/dx.
pub(super) fn rates(geometry: &Geometry, points: &[Start]) -> [f64; 2] {
    let every = points.len().div_ceil(MOST_POINTS).max(1);
    let (mut at, size) = (geometry.point(), 2 * geometry.active().len());
    let (mut largest, mut all) = ([0.0_f64; 2], 0.0_f64);
    for point in points.iter().step_by(every) {
        let mut jacobian = DMatrix::zeros(size, size);
        at.jacobian(&point.q, &point.p, |row, column, value| jacobian[(row, column)] = value);
        for [re, im] in eigenvalues(jacobian) {
            largest = [largest[0].max(im.abs()), largest[1].max(re.abs())];
            all = all.max(re.hypot(im));
        }
    }
    largest.map(|rate| if rate > ROUNDING * all { rate } else { 0.0 })
}

/// Real and imaginary parts of the eigenvalues of ((A, B), (C, D)); none if a number is not finite.
fn eigenvalues(mut matrix: DMatrix<f64>) -> Vec<[f64; 2]> {
    let half = matrix.nrows() / 2;
    let size = |row: usize, column: usize| matrix.view((row, column), (half, half)).amax();
    let [b, c] = [size(0, half), size(half, 0)];
    // B and C have units that are the inverse of each other, of any size. A similarity makes them equally large.
    if b > 0.0 && c > 0.0 {
        let (b, c) = (b.sqrt(), c.sqrt());
        let (to_b, to_c) = (c / b, b / c);
        matrix.view_mut((0, half), (half, half)).scale_mut(to_b);
        matrix.view_mut((half, 0), (half, half)).scale_mut(to_c);
    }
    let unit = matrix.amax();
    if unit == 0.0 || !matrix.iter().all(|value| value.is_finite()) {
        return Vec::new();
    }
    let Some(schur) = Schur::try_new(matrix / unit, f64::EPSILON, MOST_ITERATIONS) else { return Vec::new() };
    schur.complex_eigenvalues().iter().map(|value| [value.re * unit, value.im * unit]).collect()
}
