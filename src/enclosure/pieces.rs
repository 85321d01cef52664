//! Which pairs of nodes hide something, where the nodes are given.
//!
//! An enclosure on the box between two nodes is wider than what formulas do on the way from one to the other: it does
//! not know that variables change together. So the way is cut into pieces where its box is not enough. What formulas do
//! on the way is the union of what they do on the pieces, and that is judged as the box is.

use super::lanes::BOXES;
use super::path::Path;
use super::{Enclosed, Enclosure, is_gentle};

/// Into so many pieces a way is cut, one number after the other. Each is a multiple of the number of boxes.
const PIECES: [usize; 2] = [8, 64];

/// Pairs of nodes that are looked at together first.
const TOGETHER: usize = 3 * BOXES;

impl Enclosed {
    /// Encloses every value on the way from node `pair` to the next by the union of its intervals on `count` pieces of
    /// that way, in all boxes.
    fn run_in_pieces(&mut self, path: &Path, pair: usize, count: usize) {
        let mut hulls = vec![[f64::INFINITY, -f64::INFINITY]; self.registers.len()];
        for first in (0..count).step_by(BOXES) {
            for (row, &variable) in path.variables.iter().enumerate() {
                for k in 0..BOXES {
                    let part = [first + k, first + k + 1].map(|end| end as f64 / count as f64);
                    self.set(variable, k, path.piece(row, pair, part));
                }
            }
            self.run();
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
    /// The pairs of neighbouring nodes of [`Self::path`], each named by its first node, between which something may
    /// hide. Changes of what drives the motion by `tolerances` do nothing.
    pub(crate) fn unexplained(&mut self, tolerances: impl FnOnce() -> Vec<f64>) -> Vec<usize> {
        let pairs = self.path.points - 1;
        let some = (0..pairs).step_by(TOGETHER).map(|first| first..(first + TOGETHER).min(pairs));
        let steep: Vec<usize> = some.flat_map(|some| self.steep(some)).collect();
        if steep.is_empty() {
            return steep;
        }
        let tolerances = tolerances();
        let Self { path, drive, influence, .. } = self;
        influence.see_nodes(path, drive);
        let mut left = Vec::new();
        for some in steep.chunks(BOXES) {
            Self::place(path, drive, some);
            drive.run();
            let flags = influence.are_negligible(drive, some, &tolerances);
            left.extend(some.iter().zip(flags).filter(|look| !look.1).map(|look| *look.0));
        }
        left.retain(|&pair| !PIECES.iter().any(|&count| self.is_explained(pair, count, &tolerances)));
        left
    }

    /// Whether nothing hides between two nodes, by the pieces of the way from one to the other.
    fn is_explained(&mut self, pair: usize, count: usize, tolerances: &[f64]) -> bool {
        let Self { path, kinds, arguments, drive, influence, .. } = self;
        arguments.run_in_pieces(path, pair, count);
        let is_gentle = |(output, &kind)| {
            let (lo, hi) = arguments.output(output);
            is_gentle(kind, lo[0], hi[0])
        };
        if kinds.iter().enumerate().all(is_gentle) {
            return true;
        }
        drive.run_in_pieces(path, pair, count);
        influence.are_negligible(drive, &[pair], tolerances)[0]
    }
}
