//! The set of errors: e = c + Gξ + r for all |ξ_k| ≤ 1 and |r_i| ≤ rest_i, a zonotope and a small box.
//!
//! Columns of G keep the correlations of errors from window to window. What rounds them goes into the box, which the
//! next window takes into its own columns.
//!
//! Of motions from many starts there is a second one, in which their differences are: those of two starts of which no
//! coordinate β_k differs by more than μ lie within μ times it. It begins as what the starts are spread over, nothing
//! is added to it but what comes of itself, and it is how far the flow may be from a linear one.

use super::Spread;
use super::equations::Equations;
use super::matrices::{Matrices, applied};
use super::proved::{Added, Proved};
use super::tables::UP;
use crate::number::ball::{two_product, two_sum};

/// The most columns for each unknown. Then the smaller half of them is covered by a box in a frame of its own. Fewer
/// make windows cheaper, and boxes more frequent. Any number is valid.
const MOST: usize = 200;

/// Generators shorter than this share of the longest are rounding.
const SHORT: f64 = 1e-13;

/// The set at the start of a window.
#[derive(Debug, Clone)]
pub(super) struct Set {
    /// The start of the approximation y, exactly.
    pub(super) start: Vec<f64>,
    /// c, small beside it.
    pub(super) centre: Vec<f64>,
    /// The rest of the errors.
    pub(super) errors: Zonotope,
    /// The differences of motions of a set.
    pub(super) differences: Option<Differences>,
    /// The largest sizes so far, and those of all of a kind.
    largest: Vec<f64>,
    of_kind: Vec<f64>,
}

/// Gξ + r.
#[derive(Debug, Clone)]
pub(super) struct Zonotope {
    /// The rows of G.
    pub(super) columns: Vec<Vec<f64>>,
    /// The first columns are what the window before made of generators of the start. They stay apart.
    pub(super) generators: usize,
    pub(super) rest: Vec<f64>,
}

/// The differences of motions from two starts, as parts of the largest |β_k − β′_k|.
#[derive(Debug, Clone)]
pub(super) struct Differences {
    pub(super) set: Zonotope,
    /// Bounds of them on all of the last window.
    pub(super) within: Vec<f64>,
}

/// Σ |a|.
pub(super) fn sum_of_sizes(a: &[f64]) -> f64 {
    // Eight sums, side by side.
    let mut sums = [0.0; 8];
    let chunks = a.chunks_exact(8);
    let rest: f64 = chunks.remainder().iter().map(|a| a.abs()).sum();
    chunks.for_each(|chunk| (0..8).for_each(|k| sums[k] += chunk[k].abs()));
    (rest + sums.iter().sum::<f64>()) * UP * (1.0 + a.len() as f64 * f64::EPSILON)
}

/// What sums of so many products are off by, relative to Σ |terms|.
fn rounding(terms: usize) -> f64 {
    (terms + 4) as f64 * f64::EPSILON
}

fn norm(a: &[f64]) -> f64 {
    a.iter().map(|a| a * a).sum::<f64>().sqrt()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Set {
    /// That of the start of a run, with the rows of its generators.
    pub(super) fn new(equations: &Equations<'_>, columns: Vec<Vec<f64>>) -> Self {
        let [start, centre, rest] = equations.split_start();
        // They are rounded themselves.
        let rounded: Vec<f64> = columns.iter().map(|row| f64::EPSILON * sum_of_sizes(row) * UP).collect();
        let rest = rest.iter().zip(&rounded).map(|(rest, rounded)| (rest + rounded) * UP).collect();
        let largest: Vec<f64> = start.iter().map(|z| z.abs()).collect();
        let of_kind = equations.shared(&largest);
        let generators = columns.first().map_or(0, Vec::len);
        let differences = (generators > 0).then(|| {
            let set = Zonotope { columns: columns.clone(), generators, rest: rounded };
            Differences { within: set.radii(), set }
        });
        Self { errors: Zonotope { columns, generators, rest }, differences, start, centre, largest, of_kind }
    }

    /// The same with what is known of every unknown behind an event.
    pub(super) fn behind<'s>(mut self, known: impl Iterator<Item = Option<&'s Spread>>) -> Self {
        for (k, known) in known.enumerate() {
            let Some(known) = known else { continue };
            let rounded = f64::EPSILON * sum_of_sizes(&known.columns);
            self.errors.columns[k].clone_from(&known.columns);
            self.errors.rest[k] = (self.errors.rest[k] + known.radius + rounded) * UP;
        }
        let most = self.errors.columns.iter().map(Vec::len).max().unwrap_or(0);
        self.errors.columns.iter_mut().for_each(|row| row.resize(most, 0.0));
        self
    }

    /// Radii of the unknowns around start + c.
    pub(super) fn radii(&self) -> Vec<f64> {
        self.errors.radii()
    }

    /// Bounds of |e|.
    pub(super) fn sizes(&self) -> Vec<f64> {
        self.radii().iter().zip(&self.centre).map(|(radius, c)| (radius + c.abs()) * UP).collect()
    }

    /// The largest size of an unknown so far, also that in the window at hand.
    pub(super) fn size(&self, i: usize, here: f64) -> f64 {
        self.largest[i].max(here)
    }

    /// The largest size of all unknowns of that unit.
    pub(super) fn size_of_kind(&self, i: usize) -> f64 {
        self.of_kind[i]
    }

    /// Goes to the end of a window. `None` if the older columns find no frame.
    pub(super) fn advance(&mut self, equations: &Equations<'_>, proved: &Proved) -> Option<()> {
        let d = self.start.len();
        let shift: Vec<f64> = self.centre.iter().zip(&proved.gain).map(|(c, g)| c + g).collect();
        let centre: Vec<f64> = (0..d).map(|i| dot(&proved.matrices.a_end[i * d..][..d], &shift)).collect();
        self.errors.advance(&proved.matrices, &shift, &proved.added);
        for (k, centre) in centre.into_iter().enumerate() {
            // y at the end is start + h times the first coefficient, exactly; c takes up what the next start leaves.
            let (product, error) = two_product(proved.h, proved.modes[k][0]);
            let (high, low) = two_sum(self.start[k], product);
            let small = low + error + centre;
            let rest = &mut self.errors.rest[k];
            *rest = (*rest + f64::EPSILON * (low.abs() + error.abs() + centre.abs()) + 1e-290) * UP;
            (self.start[k], self.centre[k]) = two_sum(high, small);
            self.largest[k] = self.largest[k].max(proved.sizes[k]).max(high.abs());
        }
        self.of_kind = equations.shared(&self.largest);
        if let (Some(differences), Some(apart)) = (&mut self.differences, &proved.apart) {
            differences.set.advance(&proved.matrices, &vec![0.0; d], apart);
            differences.within.clone_from(&apart.epsilon);
            differences.set.reduce_if_many()?;
        }
        self.errors.reduce_if_many()
    }
}

impl Zonotope {
    /// Bounds of |Gξ + r|.
    pub(super) fn radii(&self) -> Vec<f64> {
        self.columns.iter().zip(&self.rest).map(|(row, rest)| (sum_of_sizes(row) + rest) * UP).collect()
    }

    /// Goes to the end of a window, to A (s + Gξ + r ± δ) ± |I − A B| ε without A s.
    fn advance(&mut self, matrices: &Matrices, shift: &[f64], added: &Added) {
        let d = shift.len();
        let a = &matrices.a_end;
        let size_of_a: Vec<f64> = a.iter().map(|a| a.abs()).collect();
        let own: Vec<f64> = added.delta.iter().zip(&self.rest).map(|(delta, rest)| (delta + rest) * UP).collect();
        // |s| and radii with what the window adds are multiplied by A, and rounded.
        let radii: Vec<f64> = self.columns.iter().map(|row| sum_of_sizes(row)).collect();
        let moved: Vec<f64> = (0..d).map(|i| 2.0 * shift[i].abs() + (radii[i] + own[i]) * UP).collect();
        let of_miss = applied(&matrices.miss, &added.epsilon);
        let rounded = applied(&size_of_a, &moved);
        self.rest = (0..d).map(|i| (of_miss[i] + rounding(d) * rounded[i]) * UP).collect();
        self.columns = (0..d).map(|i| self.moved_row(&a[i * d..][..d], &own)).collect();
    }

    /// Covers the smaller columns once there are many. `None` if they find no frame.
    fn reduce_if_many(&mut self) -> Option<()> {
        let d = self.columns.len();
        if self.columns[0].len() - self.generators > MOST * d { self.reduce() } else { Some(()) }
    }

    /// Row i of A G, and then of A times the new columns.
    fn moved_row(&self, a: &[f64], own: &[f64]) -> Vec<f64> {
        let mut row = vec![0.0; self.columns[0].len()];
        for (factor, column) in a.iter().zip(&self.columns).filter(|(factor, _)| **factor != 0.0) {
            row.iter_mut().zip(column).for_each(|(to, g)| *to += factor * g);
        }
        row.extend(a.iter().zip(own).map(|(a, own)| a * own));
        row
    }

    /// The smaller columns g = F (F⁻¹ g) become columns of F times bounds of Σ |F⁻¹ g|. Coordinates are scaled by
    /// powers of two.
    ///
    /// A set that is covered becomes larger. Columns of a box are larger than those that they cover, so that they are
    /// covered again only when there are many such: as often as the logarithm of the number of windows says, and all
    /// growth together is a power of that number.
    fn reduce(&mut self) -> Option<()> {
        let d = self.columns.len();
        let scales: Vec<f64> = self.columns.iter().map(|row| power_of_two(sum_of_sizes(row))).collect();
        let count = self.columns[0].len();
        let scaled = |k: usize| -> Vec<f64> { (0..d).map(|i| self.columns[i][k] / scales[i]).collect() };
        let mut all: Vec<(usize, Vec<f64>)> = (self.generators..count).map(|k| (k, scaled(k))).collect();
        all.sort_by(|(_, one), (_, other)| norm(one).total_cmp(&norm(other)));
        let larger = all.split_off(count - self.generators - MOST * d / 2);
        let smaller: Vec<Vec<f64>> = all.into_iter().map(|(_, column)| column).collect();
        let frame = frame(&smaller, d);
        let total = reach_in(&frame, &smaller)?;
        for i in 0..d {
            let covering: Vec<f64> = (0..d).map(|k| frame[k][i] * total[k] * scales[i]).collect();
            let rounded = sum_of_sizes(&covering);
            self.rest[i] = (self.rest[i] + 2.0 * f64::EPSILON * rounded) * UP;
            let row = &self.columns[i];
            let larger = larger.iter().map(|(k, _)| row[*k]);
            self.columns[i] = row[..self.generators].iter().copied().chain(larger).chain(covering).collect();
        }
        Some(())
    }
}

/// The power of two below a size that is normal, or 1.
fn power_of_two(size: f64) -> f64 {
    let exponent_alone = f64::from_bits(size.to_bits() & f64::INFINITY.to_bits());
    if exponent_alone.is_normal() { exponent_alone } else { 1.0 }
}

/// Bounds of Σ |F⁻¹ g| over vectors g, where the columns of F, one after another, are nearly orthonormal: with N = FᵀF
/// − I, F⁻¹ = (I + N)⁻¹ Fᵀ, and t ≥ Σ |Fᵀg| + |N| t bounds it. `None` if none is found.
fn reach_in(frame: &[Vec<f64>], vectors: &[Vec<f64>]) -> Option<Vec<f64>> {
    let d = frame.len();
    let mut radius = vec![0.0; d];
    for g in vectors {
        for (radius, direction) in radius.iter_mut().zip(frame) {
            let room: f64 = direction.iter().zip(g).map(|(f, g)| (f * g).abs()).sum();
            *radius += dot(direction, g).abs() + rounding(d) * room;
        }
    }
    let of_sums = UP * (1.0 + vectors.len() as f64 * f64::EPSILON);
    let radius: Vec<f64> = radius.iter().map(|radius| radius * of_sums + 1e-290).collect();
    let near = |at: usize| {
        let (one, other) = (&frame[at / d], &frame[at % d]);
        let ideal = if at / d == at % d { 1.0 } else { 0.0 };
        (dot(one, other) - ideal).abs() + rounding(d)
    };
    let near: Vec<f64> = (0..d * d).map(near).collect();
    let first = applied(&near, &radius);
    let total: Vec<f64> = radius.iter().zip(&first).map(|(radius, more)| radius * 1.001 + 2.0 * more).collect();
    let needed = applied(&near, &total);
    (0..d).all(|i| (radius[i] + needed[i]) * UP <= total[i]).then_some(total)
}

/// d nearly orthonormal directions, of the longest vectors first (Gram and Schmidt with pivots).
fn frame(vectors: &[Vec<f64>], d: usize) -> Vec<Vec<f64>> {
    let mut left = vectors.to_vec();
    let longest = vectors.iter().map(|g| norm(g)).fold(0.0, f64::max);
    let mut frame: Vec<Vec<f64>> = Vec::new();
    while frame.len() < d {
        let next = left.iter().max_by(|a, b| norm(a).total_cmp(&norm(b)));
        let mut direction = match next {
            Some(next) if norm(next) > SHORT * longest => next.clone(),
            _ => {
                // The axis that is furthest from the others.
                let within = |k: &usize| frame.iter().map(|f| f[*k] * f[*k]).sum::<f64>();
                let axis = (0..d).min_by(|a, b| within(a).total_cmp(&within(b))).unwrap_or(0);
                (0..d).map(|i| if i == axis { 1.0 } else { 0.0 }).collect()
            }
        };
        for _ in 0..3 {
            for other in &frame {
                let part = dot(&direction, other);
                direction.iter_mut().zip(other).for_each(|(to, other)| *to -= part * other);
            }
            let size = norm(&direction);
            direction.iter_mut().for_each(|to| *to /= size);
        }
        for g in &mut left {
            let part = dot(&direction, g);
            g.iter_mut().zip(&direction).for_each(|(g, direction)| *g -= part * direction);
        }
        frame.push(direction);
    }
    frame
}

#[cfg(test)]
mod tests;
