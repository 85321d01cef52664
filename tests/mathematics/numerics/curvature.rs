//! The curvature of a metric at a point, from the derivatives that a geometry has.

use geodesic_ivp::geometry::Geometry;
use nalgebra::DMatrix;

/// g_ab with its inverse and its first and second derivatives, at a point.
pub(crate) struct Curvature {
    n: usize,
    g: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// R_abcd.
    riemann: Vec<f64>,
}

/// The two orders of a pair.
fn orders([a, b]: [usize; 2]) -> [[usize; 2]; 2] {
    [[a, b], [b, a]]
}

impl Curvature {
    pub(crate) fn new(geometry: &Geometry, q: &[f64]) -> Self {
        let n = geometry.dimension();
        let (samples, structure) = (geometry.at(q), geometry.structure());
        let mut g = DMatrix::zeros(n, n);
        let mut first = vec![0.0; n * n * n];
        let mut second = vec![0.0; n * n * n * n];
        for term in &structure.values {
            orders(term.ab).iter().for_each(|&[a, b]| g[(a, b)] = samples.at(term.value, 0));
        }
        for term in &structure.first {
            orders(term.ab).iter().for_each(|&[a, b]| first[(a * n + b) * n + term.by[0]] = samples.at(term.value, 0));
        }
        for term in &structure.second {
            for [a, b] in orders(term.ab) {
                for [c, d] in orders(term.by) {
                    second[((a * n + b) * n + c) * n + d] = samples.at(term.value, 0);
                }
            }
        }
        let inverse = g.clone().try_inverse().unwrap();
        // Γ_abc = ½ (∂_b g_ac + ∂_c g_ab − ∂_a g_bc).
        let d = |a: usize, b: usize, c: usize| first[(a * n + b) * n + c];
        let lower = |a: usize, b: usize, c: usize| 0.5 * (d(a, c, b) + d(a, b, c) - d(b, c, a));
        let dd = |a: usize, b: usize, c: usize, e: usize| second[((a * n + b) * n + c) * n + e];
        let mut riemann = vec![0.0; n * n * n * n];
        for (place, value) in riemann.iter_mut().enumerate() {
            let [a, b, c, e] = indices(place, n);
            *value = 0.5 * (dd(a, e, b, c) + dd(b, c, a, e) - dd(b, e, a, c) - dd(a, c, b, e));
            for i in 0..n {
                for j in 0..n {
                    let products = lower(i, b, c) * lower(j, a, e) - lower(i, b, e) * lower(j, a, c);
                    *value += inverse[(i, j)] * products;
                }
            }
        }
        Self { n, g, inverse, riemann }
    }

    pub(crate) fn metric(&self, a: usize, b: usize) -> f64 {
        self.g[(a, b)]
    }

    /// The largest component of R_bd = g^ac R_abcd in the coordinate basis, relative to the largest sum of its terms'
    /// sizes; of a flat space 0.
    pub(crate) fn ricci(&self) -> f64 {
        let n = self.n;
        let (mut largest, mut size) = (0.0_f64, f64::MIN_POSITIVE);
        for b in 0..n {
            for d in 0..n {
                let terms = (0..n * n).map(|ac| {
                    let (a, c) = (ac / n, ac % n);
                    self.inverse[(a, c)] * self.riemann[((a * n + b) * n + c) * n + d]
                });
                largest = largest.max(terms.clone().sum::<f64>().abs());
                size = size.max(terms.map(f64::abs).sum());
            }
        }
        largest / size
    }

    /// R_abcd R^abcd.
    pub(crate) fn kretschmann(&self) -> f64 {
        let n = self.n;
        let mut raised = self.riemann.clone();
        for slot in 0..4 {
            let stride = n.pow(3 - slot);
            raised = (0..raised.len())
                .map(|place| {
                    let index = place / stride % n;
                    (0..n).map(|i| self.inverse[(index, i)] * raised[place - index * stride + i * stride]).sum()
                })
                .collect();
        }
        raised.iter().zip(&self.riemann).map(|(a, b)| a * b).sum()
    }
}

fn indices(place: usize, n: usize) -> [usize; 4] {
    [place / (n * n * n), place / (n * n) % n, place / n % n, place % n]
}
