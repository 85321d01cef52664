//! Sums of momenta that are conserved though no single one of them is.
//!
//! If constants c^a make c^a (f_a + F_a) vanish at every point and for every velocity, Σ c^a p_a is conserved, in the
//! continuum and exactly on the grid: the total momentum of V(x1 − x2) is one. The identity is looked for in the values
//! of f_a + F_a at many points, which lie anywhere: a sum that vanishes at all of them vanishes.

use std::cmp::Ordering;

use super::{Geometry, Start};
use crate::number::norm::max_abs;
use crate::number::{Extended, Noise, Real};

/// Constants c^a for which Σ c^a p_a is conserved, with momenta as a user sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct ConservedSum {
    /// c^a of every coordinate that occurs, with its index.
    pub terms: Vec<(usize, f64)>,
}

impl ConservedSum {
    /// The sum as a formula, for example `p_x1 + p_x2`.
    pub fn formula(&self, names: &[String]) -> String {
        let term = |&(a, c): &(usize, f64)| match c {
            1.0 => format!("p_{}", names[a]),
            -1.0 => format!("-p_{}", names[a]),
            _ => format!("{c}*p_{}", names[a]),
        };
        self.terms.iter().map(term).collect::<Vec<_>>().join(" + ").replace("+ -", "- ")
    }
}

/// Points that are looked at for each active coordinate, and so many more than coordinates at most: as many values as
/// coordinates tell of every sum.
const POINTS_PER_COORDINATE: usize = 4;
const MORE_POINTS: usize = 64;
/// The same in extended precision, of twice as many as there are coordinates.
const MORE_EXACT: usize = 16;
/// A pivot below this share of the largest entry of its column is zero: in `f64`, and in extended precision.
const ZERO: [f64; 2] = [1e-9, 1e-40];
/// The distance of the points from the start, relative to the sizes of coordinates.
const SPREAD: f64 = 0.1;
/// A size that the start does not tell is drawn as a power of two up to this one, or its inverse.
const LARGEST_EXPONENT: f64 = 60.0;

/// A point with velocities.
type Place = (Vec<f64>, Vec<f64>);

impl Geometry<f64> {
    /// The independent conserved sums of momenta of active coordinates, looked for around the start of a motion.
    ///
    /// Forces on a light body are rounding errors of those on a heavy one, so that the coefficients of sums that seem
    /// to be conserved come from `exact`, the same geometry in extended precision.
    pub fn conserved_sums(&self, start: &Start, exact: impl FnOnce() -> Geometry<Extended>) -> Vec<ConservedSum> {
        let active = self.active();
        let places = self.places_around(start);
        if active.is_empty() || null_vectors(self.rows(&places), ZERO[0]).is_empty() {
            return Vec::new();
        }
        let few = &places[..places.len().min(2 * active.len()).min(active.len() + MORE_EXACT)];
        let exact = exact();
        null_vectors(exact.rows(few), ZERO[1]).into_iter().map(|c| exact.sum_of(&c)).collect()
    }

    /// Returns true if a sum does not change at a place: its terms cancel there but for rounding.
    pub fn conserves(&self, sum: &ConservedSum, q: &[f64], q_dot: &[f64]) -> bool {
        let forces = self.forces(q, q_dot);
        let terms = || sum.terms.iter().map(|&(a, c)| c * self.seen(a, forces[a]));
        terms().sum::<f64>().abs() <= ZERO[0] * terms().map(f64::abs).sum::<f64>()
    }

    /// Places inside the domain that lie anywhere around the start, by the sizes that it has.
    fn places_around(&self, start: &Start) -> Vec<Place> {
        let active = self.active().len();
        let count = (POINTS_PER_COORDINATE * active).min(active + MORE_POINTS);
        let mut noise = Noise::default();
        let sizes = [&start.q, &start.q_dot].map(|values| {
            let own: Vec<f64> = values.iter().map(|value| value.abs()).collect();
            self.shared(&start.q, &own)
        });
        let mut around = |values: &[f64], sizes: &[f64], spread: f64| -> Vec<f64> {
            let drawn = (LARGEST_EXPONENT * noise.next()).exp2();
            let size = |size: f64| if size > 0.0 { size } else { drawn };
            values.iter().zip(sizes).map(|(value, &own)| value + spread * size(own) * noise.next()).collect()
        };
        let places =
            (0..50 * count).map(|_| (around(&start.q, &sizes[0], SPREAD), around(&start.q_dot, &sizes[1], 1.0)));
        places.filter(|place| self.forces_at(place).is_some()).take(count).collect()
    }
}

impl<S: Real> Geometry<S> {
    /// A row for each place where there are forces.
    fn rows(&self, places: &[Place]) -> Vec<Vec<S>> {
        places.iter().filter_map(|place| self.forces_at(place)).collect()
    }

    /// f_a + F_a of the active coordinates at a place, if they are finite and not all 0.
    fn forces_at(&self, (q, q_dot): &Place) -> Option<Vec<S>> {
        let [q, q_dot] = [q, q_dot].map(|values| values.iter().map(|&value| S::from(value)).collect::<Vec<S>>());
        let all = self.forces(&q, &q_dot);
        let forces: Vec<S> = self.active().iter().map(|&a| all[a]).collect();
        let size = max_abs(&forces);
        (size > S::ZERO && size.is_finite()).then_some(forces)
    }
}

impl Geometry<Extended> {
    /// The sum with the coefficients `c` of the active coordinates, scaled so that the first one is 1.
    fn sum_of(&self, c: &[Extended]) -> ConservedSum {
        let terms = self.active().iter().zip(c).map(|(&a, &c)| (a, self.seen(a, c)));
        let terms: Vec<_> = terms.filter(|(_, c)| *c != Extended::ZERO).collect();
        let first = terms.first().map_or(Extended::ONE, |(_, c)| *c);
        ConservedSum { terms: terms.into_iter().map(|(a, c)| (a, (c / first).to_f64())).collect() }
    }
}

/// A basis of the vectors c with rows · c = 0, by Gauss–Jordan elimination with full pivoting. Rows and columns are
/// scaled first, so that neither units nor masses decide what is 0.
fn null_vectors<S: Real>(mut rows: Vec<Vec<S>>, zero: f64) -> Vec<Vec<S>> {
    let Some(columns) = rows.first().map(Vec::len) else { return Vec::new() };
    for row in &mut rows {
        let size = max_abs(row);
        row.iter_mut().for_each(|entry| *entry = *entry / size);
    }
    let scales: Vec<S> =
        (0..columns).map(|column| max_abs(&rows.iter().map(|row| row[column]).collect::<Vec<S>>())).collect();
    let scaled = |value: S, scale: S| if scale > S::ZERO { value / scale } else { value };
    for row in &mut rows {
        row.iter_mut().zip(&scales).for_each(|(entry, &scale)| *entry = scaled(*entry, scale));
    }
    let zero = S::from(zero);
    let (mut pivots, mut is_pivot) = (Vec::new(), vec![false; columns]);
    loop {
        let done = pivots.len();
        let candidates = (done..rows.len()).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let size = |&(row, column): &(usize, usize)| rows[row][column].abs();
        let best = candidates.filter(|(_, column)| !is_pivot[*column]);
        let best = best.max_by(|a, b| size(a).partial_cmp(&size(b)).unwrap_or(Ordering::Equal));
        let Some((row, column)) = best.filter(|best| size(best) > zero) else { break };
        rows.swap(done, row);
        let pivot = rows[done][column];
        rows[done].iter_mut().for_each(|entry| *entry = *entry / pivot);
        let pivot_row = rows[done].clone();
        for (_, other) in rows.iter_mut().enumerate().filter(|(row, _)| *row != done) {
            let factor = other[column];
            for (entry, pivot) in other.iter_mut().zip(&pivot_row) {
                *entry -= factor * *pivot;
            }
        }
        pivots.push(column);
        is_pivot[column] = true;
    }
    let free = (0..columns).filter(|column| !is_pivot[*column]);
    let vector = |free: usize| {
        let mut c = vec![S::ZERO; columns];
        c[free] = S::ONE;
        for (row, &pivot) in pivots.iter().enumerate().filter(|(row, _)| rows[*row][free].abs() > zero) {
            c[pivot] = -rows[row][free];
        }
        c.iter().zip(&scales).map(|(&c, &scale)| scaled(c, scale)).collect()
    };
    free.map(vector).collect()
}
