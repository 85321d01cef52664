//! The end of a solved window, and integrals on its nodes.

use pulp::{Simd, WithSimd};

use super::{Pass, Row};
use crate::engine::rule::{Order, Tables};
use crate::formula::Register;
use crate::number::Compensated;
use crate::number::vector::{Lanes, Matrix, Nodes, Twofold, Weights, multiply, two_product};

/// Computes the rows at the end of a window, from which the next one is continued, and by how much ignorable
/// coordinates grow.
pub(in super::super) struct Ends<'w, const N: usize> {
    pub(in super::super) registers: &'w [Nodes<N>],
    pub(in super::super) rows: &'w mut [Row<N>],
    pub(in super::super) passes: &'w [Pass],
    pub(in super::super) order: Order,
    pub(in super::super) tables: &'w Tables<N>,
    /// The registers of the velocities of ignorable coordinates.
    pub(in super::super) ignorable: &'w [Register],
    pub(in super::super) gains: &'w mut [Twofold],
}

impl<const N: usize> WithSimd for Ends<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { registers, rows, passes, order, tables, ignorable, gains } = self;
        let is_exact = tables.collocation_low.is_some();
        for pass in passes {
            for k in 0..pass.slopes.len() {
                let (row, slope) = (&mut rows[pass.first + k], &registers[pass.slopes[k]]);
                row.slopes_before = Lanes::new(s, slope).nodes();
                if is_exact {
                    row.end = plus(row.start, tables.end_weights.dot(s, slope));
                    if order == Order::Second {
                        let (way, low) = two_product::<S>(tables.length, row.velocity.high);
                        row.end = plus(row.end, Twofold::new(way, low + tables.length * row.velocity.low));
                    }
                } else {
                    // What the start lacks is part of the increment.
                    row.end = Compensated::from(row.start.high).plus(row.increment);
                }
                if order == Order::Second {
                    row.velocity_end = plus(row.velocity, sum(s, &tables.weights, slope, is_exact));
                }
            }
        }
        for k in 0..ignorable.len() {
            gains[k] = sum(s, &tables.weights, &registers[ignorable[k]], is_exact);
        }
    }
}

#[inline(always)]
fn sum<S: Simd, const N: usize>(s: S, weights: &Weights<N>, values: &Nodes<N>, is_exact: bool) -> Twofold {
    if is_exact {
        weights.dot(s, values)
    } else {
        Twofold { hi: Lanes::new(s, &weights.high).dot(Lanes::new(s, values)), lo: 0.0 }
    }
}

/// A sum with one more term, of which nothing is lost.
#[inline(always)]
pub(in super::super) fn plus(sum: Compensated<f64>, term: Twofold) -> Compensated<f64> {
    let Twofold { hi: high, lo: low } = Twofold { hi: sum.high, lo: sum.low }.plus_update((term.hi, term.lo));
    Compensated { high, low }
}

/// The integral of a register over the nodes, from a start.
#[inline(always)]
pub(in super::super) fn integrated<S: Simd, const N: usize>(
    s: S,
    matrix: &Matrix<N>,
    length: f64,
    slope: &Nodes<N>,
    start: Compensated<f64>,
) -> Nodes<N> {
    let gains = multiply(s, matrix, slope, [Lanes::splat(s, 0.0); 2]);
    (gains.scale_add(length, Lanes::splat(s, start.low)) + start.high).nodes()
}
