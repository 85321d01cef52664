//! Sums of momenta that are conserved though no single one of them is.
//!
//! If constants c^a make c^a (f_a + F_a) vanish at every point and for every velocity, Σ c^a p_a is conserved, in the
//! continuum and exactly on the grid: the total momentum of V(x1 − x2) is one. The identity is looked for in the values
//! of f_a + F_a at many points, which lie anywhere: a sum that vanishes at all of them vanishes.

use super::Geometry;

/// Constants c^a for which Σ c^a p_a is conserved.
#[derive(Debug, Clone, PartialEq)]
pub struct ConservedSum {
    /// c^a of every coordinate that occurs, with its index.
    pub terms: Vec<(usize, f64)>,
}

impl ConservedSum {
    /// The sum as a formula, for example `p_x1 + p_x2`.
    pub fn formula(&self, names: &[String]) -> String {
        let mut text = String::new();
        for &(a, c) in &self.terms {
            let sign = if c < 0.0 { "-" } else { "+" };
            match (text.is_empty(), c < 0.0) {
                (true, false) => {}
                (true, true) => text.push('-'),
                (false, _) => text.push_str(&format!(" {sign} ")),
            }
            if c.abs() != 1.0 {
                text.push_str(&format!("{}*", c.abs()));
            }
            text.push_str(&format!("p_{}", names[a]));
        }
        text
    }
}

/// Points that are looked at for each active coordinate, and more of them.
const POINTS_PER_COORDINATE: usize = 4;
/// A pivot below this share of the largest entry is zero.
const ZERO: f64 = 1e-9;
/// How far from the given point the others lie, relative to its coordinates and at least 1.
const SPREAD: f64 = 0.1;

impl Geometry<f64> {
    /// The independent conserved sums of momenta of active coordinates, looked for around a point of the scene.
    pub fn conserved_sums(&self, q: &[f64], q_dot: &[f64]) -> Vec<ConservedSum> {
        let active = self.active();
        let m = active.len();
        if m == 0 {
            return Vec::new();
        }
        let mut point = self.point();
        let (mut rows, mut noise): (Vec<Vec<f64>>, _) = (Vec::new(), Noise(0x9e37_79b9_7f4a_7c15));
        for _ in 0..50 * m * POINTS_PER_COORDINATE {
            let q: Vec<f64> = q.iter().map(|q| q + SPREAD * q.abs().max(1.0) * noise.next()).collect();
            let q_dot: Vec<f64> = q_dot.iter().map(|u| u + u.abs().max(1.0) * noise.next()).collect();
            let p = self.momenta(&q, &q_dot);
            if point.evaluate(&q, &p).is_ok() {
                let row: Vec<f64> = (0..m).map(|place| point.p_dot(place)).collect();
                let size = row.iter().fold(0.0, |size: f64, f| size.max(f.abs()));
                if size > 0.0 {
                    rows.push(row.iter().map(|f| f / size).collect());
                }
            }
            if rows.len() == m * POINTS_PER_COORDINATE {
                break;
            }
        }
        null_vectors(rows, m).into_iter().map(|c| sum_of(active, &c)).collect()
    }
}

/// The sum with the coefficients `c` of the active coordinates, scaled so that the first one is 1.
fn sum_of(active: &[usize], c: &[f64]) -> ConservedSum {
    let first = c.iter().copied().find(|c| *c != 0.0).unwrap_or(1.0);
    let tidy = |c: f64| if (c - c.round()).abs() < ZERO { c.round() } else { c };
    let terms = active.iter().zip(c).map(|(&a, c)| (a, tidy(c / first))).filter(|(_, c)| *c != 0.0).collect();
    ConservedSum { terms }
}

/// A basis of the vectors c with rows · c = 0, by Gauss–Jordan elimination with full pivoting.
fn null_vectors(mut rows: Vec<Vec<f64>>, columns: usize) -> Vec<Vec<f64>> {
    let mut pivots: Vec<usize> = Vec::new();
    loop {
        let done = pivots.len();
        let candidates = (done..rows.len()).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let size = |&(row, column): &(usize, usize)| rows[row][column].abs();
        let best = candidates.filter(|(_, column)| !pivots.contains(column)).max_by(|a, b| size(a).total_cmp(&size(b)));
        let Some((row, column)) = best.filter(|best| size(best) > ZERO) else { break };
        rows.swap(done, row);
        let pivot = rows[done][column];
        rows[done].iter_mut().for_each(|entry| *entry /= pivot);
        let pivot_row = rows[done].clone();
        for (_, other) in rows.iter_mut().enumerate().filter(|(row, _)| *row != done) {
            let factor = other[column];
            for (entry, pivot) in other.iter_mut().zip(&pivot_row) {
                *entry -= factor * pivot;
            }
        }
        pivots.push(column);
    }
    let free = (0..columns).filter(|column| !pivots.contains(column));
    free.map(|free| {
        let mut c = vec![0.0; columns];
        c[free] = 1.0;
        for (row, &pivot) in pivots.iter().enumerate() {
            c[pivot] = if rows[row][free].abs() < ZERO { 0.0 } else { -rows[row][free] };
        }
        c
    })
    .collect()
}

/// Numbers in (−1, 1) that look random and are the same in every run (G. Marsaglia's xorshift).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
