//! The sizes of unknowns, which errors are relative to, and by what their rates may be off.
//!
//! Sizes come from the motion, window by window: the size of an unknown is the largest distance from the start of a
//! window on its nodes so far, and the largest value at the start of one. Nothing that is known before a window is
//! solved divides its errors, but the sizes that the motion has had. So a force that is 0 at the start, with as many of
//! its derivatives as one likes, is seen when it moves something, and what does not move has one value on all nodes.
//!
//! Units that are scaled by powers of two scale sizes exactly, and change no digit of a run.

use crate::geometry::{Geometry, OutsideGeometry, Source, Start};
use crate::number::norm::max_abs;

/// A rate is off by at most so many units ε of the sum Σ |∂(rate)/∂x_j x_j|: as values are rounded by half a unit, two
/// sweeps differ by one, and each of the few operations on the way to a term rounds once more.
pub(super) const UNITS_OF_RATES: f64 = 16.0;

/// The size of one unknown.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Size {
    /// The value that counts from 0: that at the start of the run for a clock and for an ignorable coordinate.
    pub(super) origin: f64,
    /// 1/size before the window; 0 where it has not moved yet.
    pub(super) before: f64,
    /// 1/size in the window, by which errors become relative; 0 where it has one value on all nodes.
    pub(super) inverse: f64,
    /// What that was before it was taken last.
    last: f64,
    /// The rounding error of its rate, where that may be more than the rate; 0 elsewhere.
    pub(super) noise: f64,
    /// True if it began to move in the window before, or in one before that, and all since were the shortest ones.
    is_young: bool,
}

impl Size {
    /// The size of an unknown that starts with this value, and counts as at least so large.
    pub(super) fn new(start: f64, origin: f64, least: f64) -> Self {
        let before = inverse((start - origin).abs().max(least));
        Self { origin, before, inverse: before, last: before, ..Self::default() }
    }

    /// Takes in by how much the unknown moves in the window.
    #[inline(always)]
    pub(super) fn take(&mut self, distance: f64) {
        self.last = self.inverse;
        // Where nothing is known the product is 0, and no distance is less than that.
        self.inverse = if distance * self.before > 1.0 || self.before == 0.0 { inverse(distance) } else { self.before };
    }

    /// True if it was taken to be more than twice as large before.
    #[inline(always)]
    pub(super) fn has_shrunk(self) -> bool {
        self.inverse > 2.0 * self.last && self.last > 0.0
    }

    /// Goes on from a window, which may be the shortest that there is, to the next one, which starts with this value.
    #[inline(always)]
    pub(super) fn advance(&mut self, start: f64, is_shortest: bool) {
        self.is_young = is_shortest && (self.before == 0.0 || self.is_young);
        let value = (start - self.origin).abs();
        self.before = if value * self.inverse > 1.0 || self.inverse == 0.0 { inverse(value) } else { self.inverse };
        self.inverse = self.before;
    }

    /// True if it begins to move in the window, has done so in the shortest of windows before it, or becomes more than
    /// twice as large as it ever was: its size is not known yet.
    #[inline(always)]
    pub(super) fn grows(self) -> bool {
        self.before == 0.0 || self.is_young || self.before > 2.0 * self.inverse
    }

    /// 1/size for the errors of a window, which may be the shortest that there is. What grows in that one may do so
    /// like a high power of γ, which no window resolves that starts there, however short it is.
    #[inline(always)]
    pub(super) fn counted(self, is_shortest: bool) -> f64 {
        if is_shortest && self.grows() { 0.0 } else { self.inverse }
    }

    /// 1/size for errors that a run adds up, once this part of it is done. In a window in which an unknown grows, its
    /// error may be as large as its way, if that starts like a high power of γ. It counts in the windows behind, and in
    /// the last one.
    pub(super) fn for_sums(self, done: f64) -> f64 {
        if self.grows() && done < 1.0 { 0.0 } else { self.inverse }
    }

    /// The same for the way of an ignorable coordinate, which is expected to go on as it did. The last window knows.
    pub(super) fn of_way(self, done: f64) -> f64 {
        done * self.for_sums(done)
    }
}

/// Numbers below this have lost digits, or are rounded to such as have.
const LEAST: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// 1/size, or 0. What is smaller than numbers with all digits has their size.
pub(super) fn inverse(size: f64) -> f64 {
    if size > 0.0 { 1.0 / size.max(LEAST) } else { 0.0 }
}

/// The time scale of a motion at its start, and what is known of sizes before it begins.
#[derive(Debug, Clone, Default)]
pub(super) struct Scales {
    /// T, the time in which a small error changes much, as the period of an oscillator over 2π, or the length of the
    /// run if that is shorter.
    pub(super) time: f64,
    /// The least sizes of active coordinates and of their momenta or velocities, and of ignorable coordinates.
    pub(super) least: Vec<f64>,
    pub(super) least_ways: Vec<f64>,
    /// What the motion is about to make of active coordinates, and of their momenta or velocities, within T: units for
    /// small changes, 0 where that is nothing.
    pub(super) units: Vec<f64>,
    /// Clocks among the active coordinates: their rate depends on nothing that varies, and their size is what elapses.
    pub(super) clocks: Vec<bool>,
    /// Unknowns that share their size: coordinates with one metric coefficient, and their momenta. Of two coordinates
    /// with one unit one may be 0 but for rounding.
    pub(super) shared: Vec<Vec<usize>>,
}

impl Scales {
    /// Measures the motion that begins at `start` and lasts for `length`.
    ///
    /// The rate is the fourth root of ½ Σ |S_ij S_ji|, S = J², J the Jacobian of the equations of motion, and
    /// T = min(1/rate, length).
    ///
    /// # Errors
    /// If the start is outside the domain.
    pub(super) fn new(geometry: &Geometry, start: &Start, length: f64) -> Result<Self, OutsideGeometry> {
        let (m, ignorable) = (geometry.active().len(), geometry.ignorable().count());
        let mut point = geometry.point();
        point.evaluate(&start.q, &start.p)?;
        let mut jacobian = vec![0.0; 4 * m * m];
        point.jacobian(&start.q, &start.p, |row, column, value| jacobian[row * 2 * m + column] = value);
        let (rate, length) = (rate(&jacobian, 2 * m), length.abs());
        let time = if rate * length > 1.0 { 1.0 / rate } else { length };
        let slopes: Vec<f64> =
            (geometry.active().iter().map(|&a| point.q_dot(a))).chain((0..m).map(|place| point.p_dot(place))).collect();
        Ok(Self {
            time,
            units: units(geometry, start, &slopes, &jacobian, time),
            least: vec![0.0; 2 * m],
            least_ways: vec![0.0; ignorable],
            clocks: (0..m).map(|place| geometry.is_clock(place)).collect(),
            shared: shared(geometry),
        })
    }

    /// Raises the sizes of coordinates to these at least, by their index, and those of their momenta to what changes
    /// them by that within T.
    pub(super) fn raise(&mut self, geometry: &Geometry, start: &Start, floors: &[(usize, f64)]) {
        let m = geometry.active().len();
        for &(a, least) in floors {
            match geometry.active().binary_search(&a) {
                Ok(place) => {
                    let mut by = 0.0_f64;
                    geometry.point().jacobian(&start.q, &start.p, |row, column, value| {
                        by = if row == place && column >= m { by.max(value.abs()) } else { by };
                    });
                    let speed = least / self.time;
                    let other = if geometry.is_separable() { speed } else { speed / by };
                    self.least[place] = self.least[place].max(least);
                    if other.is_finite() {
                        self.least[m + place] = self.least[m + place].max(other);
                    }
                }
                Err(before) => self.least_ways[a - before] = self.least_ways[a - before].max(least),
            }
        }
    }
}

/// A position q has the unit max(|q|, |q̇| T), the largest one of those with the same g^aa, and a momentum that of what
/// changes its position by this within T.
fn units(geometry: &Geometry, start: &Start, slopes: &[f64], jacobian: &[f64], time: f64) -> Vec<f64> {
    let (active, m) = (geometry.active(), geometry.active().len());
    let by = |k: usize, j: usize| jacobian[k * 2 * m + m + j];
    let is_same = |k: usize, j: usize| by(k, k) == by(j, j);
    let own = |k: usize| start.q[active[k]].abs().max(slopes[k].abs() * time);
    let position = |k: usize| (0..m).filter(|&j| is_same(k, j)).map(own).fold(0.0, f64::max);
    let positions: Vec<f64> = (0..m).map(position).collect();
    let other = |k: usize| {
        let now = if geometry.is_separable() { slopes[k].abs() } else { start.p[active[k]].abs() };
        let largest = if by(k, k) == 0.0 { (0..m).map(|j| by(k, j).abs()).fold(0.0, f64::max) } else { by(k, k).abs() };
        let size = positions[k] / time / if geometry.is_separable() { 1.0 } else { largest };
        if size.is_finite() { size.max(now) } else { now }
    };
    let others: Vec<f64> = (0..m).map(other).collect();
    [positions, others].concat()
}

/// Groups of unknowns whose coordinates have the same g^aa everywhere.
fn shared(geometry: &Geometry) -> Vec<Vec<usize>> {
    let m = geometry.active().len();
    let equations = geometry.hamiltonian.linearised();
    let coefficient = |place: usize| match geometry.separable() {
        Some(inverse) => Some(Err(inverse[place * (m + 1)])),
        None => equations.entries.iter().find(|entry| (entry.row, entry.column) == (place, m + place)).map(|entry| {
            match entry.value {
                Source::Row(output) => Ok(equations.jacobian.output(output)),
                Source::Constant(value) => Err(value),
            }
        }),
    };
    let coefficients: Vec<_> = (0..m).map(coefficient).collect();
    let is_first = |place: &usize| !coefficients[..*place].contains(&coefficients[*place]);
    let of_kind = |first: usize| (first..m).filter(|&other| coefficients[other] == coefficients[first]).collect();
    let kinds = (0..m).filter(|place| coefficients[*place].is_some() && is_first(place)).map(of_kind);
    let groups = kinds.filter(|kind: &Vec<usize>| kind.len() > 1);
    groups.flat_map(|kind| [kind.iter().map(|place| m + place).collect(), kind]).collect()
}

fn rate(jacobian: &[f64], n: usize) -> f64 {
    // Most entries are 0 where many bodies move.
    let mut square = vec![0.0; n * n];
    for (row, of) in square.chunks_exact_mut(n.max(1)).zip(jacobian.chunks_exact(n.max(1))) {
        for (k, &entry) in of.iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
            row.iter_mut().zip(&jacobian[k * n..][..n]).for_each(|(sum, other)| *sum += entry * other);
        }
    }
    // The fourth power of a rate may be out of the range of numbers where the rate is not.
    let rates = (0..n * n).map(|at| square[at].abs().sqrt() * square[at % n * n + at / n].abs().sqrt());
    let rates: Vec<f64> = rates.collect();
    let largest = max_abs(&rates);
    if largest == 0.0 {
        return 0.0;
    }
    let sum: f64 = rates.iter().map(|rate| (rate / largest).powi(2)).sum();
    (largest * (0.5 * sum).sqrt()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{Scales, Size};
    use crate::engine::tests::{kerr, lifted, schwarzschild};

    /// A size is 0 until something moves, never falls, and leaves out the value that it counts from.
    #[test]
    fn sizes_come_from_distances() {
        let mut size = Size::new(0.0, 0.0, 0.0);
        assert_eq!(size.inverse, 0.0);
        size.take(0.0);
        assert_eq!(size.inverse, 0.0);
        size.take(0.25);
        assert_eq!((size.inverse, size.before, size.for_sums(0.5), size.for_sums(1.0)), (4.0, 0.0, 0.0, 4.0));
        // The window is solved again, shorter: its size is its own.
        size.take(0.0625);
        assert!(size.has_shrunk() && size.inverse == 16.0 && size.counted(true) == 0.0);
        size.advance(-0.5, false);
        assert_eq!((size.before, size.inverse), (2.0, 2.0));
        size.take(0.1);
        size.advance(0.1, false);
        assert_eq!((size.inverse, size.for_sums(0.5), size.of_way(0.5)), (2.0, 2.0, 1.0));
        // In a tail that grows more than twofold in a window nothing is added up before the last one.
        size.take(1.5);
        assert_eq!((size.for_sums(0.5), size.for_sums(1.0)), (0.0, 1.0 / 1.5));
        size.advance(0.1, false);
        // A size that began in the shortest of windows is young until a longer one is behind.
        let mut young = Size::default();
        young.take(1e-30);
        young.advance(1e-30, true);
        young.take(1.5e-30);
        assert!(young.grows() && young.for_sums(0.5) == 0.0);
        young.advance(2.5e-30, true);
        young.take(0.5);
        young.advance(0.5, false);
        young.take(0.6);
        assert!(!young.grows() && young.for_sums(0.5) > 0.0);
        let mut clock = Size::new(2_450_000.5, 2_450_000.5, 0.0);
        clock.take(0.5);
        clock.advance(2_450_001.5, false);
        assert_eq!(clock.inverse, 1.0);
        assert_eq!(Size::new(0.0, 0.0, 0.5).inverse, 2.0);
        // A denormal size has no inverse, and is still one.
        size = Size::default();
        size.take(f64::MIN_POSITIVE / 4.0);
        assert!(size.inverse > 0.0 && size.inverse.is_finite());
    }

    /// Coordinates share a size where g^aa is one expression, and not where it has one value by chance.
    #[test]
    fn coordinates_with_one_coefficient_share_their_size() {
        let of = |(geometry, start): (crate::geometry::Geometry, crate::geometry::Start)| {
            Scales::new(&geometry, &start, 10.0).unwrap().shared
        };
        let plane = lifted("-1/sqrt(x^2 + y^2 + z^2)", &["x", "y", "z"], &[1.0, 0.0, 0.0], &[0.0, 1.0, 0.0]);
        assert_eq!(of(plane), [vec![3, 4, 5], vec![0, 1, 2]]);
        assert!(of(kerr()).is_empty() && of(schwarzschild()).is_empty());
    }
}
