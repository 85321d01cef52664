//! The inverse of the metric as expressions: block by block, by minors.
//!
//! Coordinates that off-diagonal components couple form a block. A block is inverted by its adjugate, which needs no
//! pivots: in an ergosphere g_tt is 0, and a null coordinate has g_vv = 0. Minors are expanded by rows, so that those
//! of the same last rows are shared; a block of k coordinates takes k 2^(k−1) products.

use std::collections::HashMap;

use super::parts::Parts;
use super::text::GeometryError;
use crate::formula::{Graph, NodeId};
use crate::number::Real;

/// The largest block that is inverted. Eight take two seconds to compile, and each one more takes that twice.
pub const MOST_COUPLED: usize = 8;

/// A block of coordinates with its determinant.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// The coordinates, in order.
    pub(super) coordinates: Vec<usize>,
    pub(super) determinant: NodeId,
}

/// The inverse metric.
pub(super) struct Inverse {
    /// g^ab for a ≤ b, where it is not zero.
    pub(super) entries: HashMap<[usize; 2], NodeId>,
    pub(super) blocks: Vec<Block>,
}

impl Inverse {
    pub(super) fn new<S: Real>(parts: &mut Parts<S>) -> Result<Self, GeometryError> {
        let mut inverse = Self { entries: HashMap::new(), blocks: Vec::new() };
        for coordinates in blocks(parts) {
            inverse.add_block(parts, coordinates)?;
        }
        Ok(inverse)
    }

    /// g^ab in either order.
    pub(super) fn get(&self, a: usize, b: usize) -> Option<NodeId> {
        self.entries.get(&[a.min(b), a.max(b)]).copied()
    }

    fn add_block<S: Real>(&mut self, parts: &mut Parts<S>, block: Vec<usize>) -> Result<(), GeometryError> {
        let order = block.len();
        if order > MOST_COUPLED {
            let many = format!("{order} coordinates are coupled by off-diagonal components");
            let help = "their block is inverted as formulas, by minors, which double in number with each coordinate: \
                        choose coordinates that couple fewer";
            let message = format!("{many}, at most {MOST_COUPLED} may be");
            return Err(GeometryError::Metric(message, Some(help.to_owned())));
        }
        let rows: Vec<Vec<Option<NodeId>>> =
            block.iter().map(|&a| block.iter().map(|&b| parts.component(a, b)).collect()).collect();
        if let Some(empty) = rows.iter().position(|row| row.iter().all(Option::is_none)) {
            let name = &parts.names[block[empty]];
            let help = format!("give a component \"{name} {name}\", or leave out the coordinate");
            let message = format!("no component with '{name}' is given, so the metric has no inverse");
            return Err(GeometryError::Metric(message, Some(help)));
        }
        let list = block.iter().map(|&a| parts.names[a].as_str()).collect::<Vec<_>>().join(", ");
        let message = format!("the determinant of the metric is zero everywhere (coordinates {list})");
        let degenerate = GeometryError::Metric(message, None);
        let graph = &mut parts.graph;
        let mut minors = Minors { rows: &rows, graph, known: HashMap::new() };
        let all = (1 << order) - 1;
        let Some(determinant) = minors.of(all, all) else { return Err(degenerate) };
        for i in 0..order {
            for j in i..order {
                let Some(minor) = minors.of(all & !(1 << i), all & !(1 << j)) else { continue };
                let cofactor = if (i + j) % 2 == 0 { minor } else { minors.graph.negate(minor) };
                let entry = minors.graph.divide(cofactor, determinant);
                self.entries.insert([block[i], block[j]], entry);
            }
        }
        if graph.is(determinant, 0.0) {
            return Err(degenerate);
        }
        self.blocks.push(Block { coordinates: block, determinant });
        Ok(())
    }
}

/// The connected sets of coordinates.
fn blocks<S: Real>(parts: &Parts<S>) -> Vec<Vec<usize>> {
    let n = parts.dimension();
    let mut block_of: Vec<usize> = (0..n).collect();
    for &[a, b] in parts.metric.keys() {
        let (from, to) = (block_of[a].max(block_of[b]), block_of[a].min(block_of[b]));
        block_of.iter_mut().filter(|block| **block == from).for_each(|block| *block = to);
    }
    let members = |block: usize| -> Vec<usize> { (0..n).filter(|&a| block_of[a] == block).collect() };
    (0..n).map(members).filter(|members| !members.is_empty()).collect()
}

/// Determinants of parts of a symmetric matrix.
struct Minors<'m, S> {
    rows: &'m [Vec<Option<NodeId>>],
    graph: &'m mut Graph<S>,
    known: HashMap<[u32; 2], Option<NodeId>>,
}

impl<S: Real> Minors<'_, S> {
    /// The determinant of these rows and columns, a bit each; `None` if it is zero.
    fn of(&mut self, rows: u32, columns: u32) -> Option<NodeId> {
        if rows == 0 {
            return Some(self.graph.whole(1));
        }
        if let Some(&known) = self.known.get(&[rows, columns]) {
            return known;
        }
        let (row, mut sum) = (rows.trailing_zeros() as usize, None);
        for (place, column) in (0..MOST_COUPLED).filter(|&column| columns >> column & 1 == 1).enumerate() {
            let Some(entry) = self.rows[row][column] else { continue };
            let Some(minor) = self.of(rows & (rows - 1), columns & !(1 << column)) else { continue };
            let product = self.graph.multiply(entry, minor);
            sum = Some(match (sum, place % 2) {
                (None, 0) => product,
                (None, _) => self.graph.negate(product),
                (Some(sum), 0) => self.graph.add(sum, product),
                (Some(sum), _) => self.graph.subtract(sum, product),
            });
        }
        self.known.insert([rows, columns], sum);
        sum
    }
}
