//! The look between nodes that are given.
//!
//! An enclosure on the box between two nodes is wider than what formulas do on the way from one to the other: it does
//! not know that variables change together. So the way is cut into pieces where its box is not enough. What formulas do
//! on the way is the union of what they do on the pieces, and that is judged as the box is.
//!
//! Nodes that are given are allowed one thing more, the tail of an exponential: exp and all its derivatives are
//! monotone, so that no value of them is unseen where the exponent stays between its values at the nodes.

use super::{BOXES, Enclosed, Enclosure, Hidden, Path, middle};
use crate::formula::{Kind, Step, Watched};

/// Into so many pieces a way is cut, one number after the other. Each is a multiple of the number of boxes.
const PIECES: [usize; 2] = [8, 64];

/// The change of an exponent between two nodes that show its least and its largest value, and by how much it may pass
/// these on the way.
const TAIL: f64 = 6.0;
const PASSED: f64 = 0.5;

impl Enclosed {
    /// Encloses what these steps compute on the way from node `pair` to the next by the union of its intervals on
    /// `count` pieces of that way, in all boxes.
    fn run_in_pieces(&mut self, steps: &[Step], path: &Path, pair: usize, count: usize) {
        let mut hulls = vec![[f64::INFINITY, -f64::INFINITY]; self.registers.len()];
        for first in (0..count).step_by(BOXES) {
            let part = |k: usize| [first + k, first + k + 1].map(|end| end as f64 / count as f64);
            self.place(path, |row, k| path.piece(row, pair, part(k)));
            self.run(steps);
            for (hull, register) in hulls.iter_mut().zip(&self.registers) {
                let (lo, hi) = register.0.split_at(BOXES);
                *hull = lo.iter().zip(hi).fold(*hull, |hull, (&lo, &hi)| [hull[0].min(lo), hull[1].max(hi)]);
            }
        }
        for (register, [lo, hi]) in self.registers.iter_mut().zip(hulls) {
            register.0[..BOXES].fill(lo);
            register.0[BOXES..].fill(hi);
        }
    }
}

impl Enclosure {
    /// Finds what may hide between neighbouring nodes of [`Self::path`], in units of `tolerances`. Pairs that hide
    /// nothing are left out, and what is below `least` is not looked at more closely.
    pub(crate) fn hidden(&mut self, tolerances: impl FnOnce() -> Vec<f64>, least: f64) -> Vec<Hidden> {
        let pairs: Vec<usize> = (0..self.path.points() - 1).collect();
        let steep: Vec<usize> = pairs.chunks(BOXES).flat_map(|some| self.steep(some)).collect();
        if steep.is_empty() {
            return Vec::new();
        }
        self.see_nodes();
        let tolerances = tolerances();
        let mut hidden = self.changes(&steep, &tolerances);
        for found in &mut hidden {
            for count in PIECES {
                if found.change > least {
                    found.change = found.change.min(self.change_on_pieces(found.pair, count, &tolerances));
                }
            }
        }
        hidden.retain(|found| found.change > 0.0);
        hidden
    }

    /// The largest change between two nodes, by the pieces of the way from one to the other.
    fn change_on_pieces(&mut self, pair: usize, count: usize, tolerances: &[f64]) -> f64 {
        self.enclosed.run_in_pieces(&self.arguments, &self.path, pair, count);
        let mut steep = self.steep_between(pair, 0);
        for ((is_steep, look), seen) in steep.iter_mut().zip(&self.watched).zip(&self.seen) {
            let Watched { register, kind: Kind::Exponent, .. } = *look else { continue };
            let ([lo, hi], ends) =
                (self.enclosed.interval(register, 0), [pair, pair + 1].map(|node| middle(seen[node])));
            let [least, most] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let is_between = lo >= least - PASSED && hi <= most + PASSED;
            *is_steep &= !(is_between && most - least <= TAIL);
        }
        if !steep.contains(&true) {
            return 0.0;
        }
        self.enclosed.run_in_pieces(&self.drive, &self.path, pair, count);
        self.influence.largest(&self.enclosed, &[steep], tolerances)[0]
    }
}
