//! The tables of windows of one length, rounded to `f64` so that nothing drifts.

use crate::number::vector::Twofold;
use crate::sbp::collocation::{Collocation, legendre_values};

/// A matrix by columns, padded to P × P.
pub(super) type Matrix<const P: usize> = [[f64; P]; P];

/// What a window of one rule and length needs; zeros beyond the n nodes, so that every loop has a constant length.
#[repr(C, align(64))]
#[derive(Debug, Clone)]
pub(super) struct Tables<const P: usize> {
    /// h² A², rounded so that its rows sum right, see [`round_row`]; and what that rounding left over.
    pub(super) force: Matrix<P>,
    pub(super) force_lo: Matrix<P>,
    /// h² A² E, E the extrapolation of a from a window of the same rule and length before this one.
    pub(super) guess: Matrix<P>,
    /// h b, to add up w and t.
    pub(super) weights: [f64; P],
    pub(super) weights_lo: [f64; P],
    /// h² b (1 − c), to add up x.
    pub(super) position_weights: [f64; P],
    pub(super) position_weights_lo: [f64; P],
    /// h c.
    pub(super) line: [f64; P],
    pub(super) line_lo: [f64; P],
    /// h² c²/2, for the parabola.
    pub(super) parabola: [f64; P],
    /// A power of two above h, at most 2h: products with h times the weights stay below its products.
    pub(super) length_unit: f64,
    pub(super) length: Twofold,
    pub(super) points: usize,
    /// n rounded up to a multiple of 4.
    pub(super) columns: usize,
}

/// The highest Legendre degree that is continued from one window to the next, where it is larger by up to 6^degree:
/// with 8 to 24 nodes on windows of a third to a radian or two, the iteration is shortest with this one.
pub(super) const EXTRAPOLATED: usize = 7;

/// What the tables of all lengths have in common.
#[derive(Debug, Clone)]
pub(super) struct LengthFree {
    /// The columns of every row of A² by falling size of their entries.
    order: Vec<u8>,
    /// A² E by columns, E the extrapolation of nodal values from one window to the next by the whole polynomial, and by
    /// its low degrees.
    guesses: [Vec<f64>; 2],
}

impl LengthFree {
    pub(super) fn new(operators: &Collocation) -> Self {
        let n = operators.points();
        let order = operators.a_squared().chunks_exact(n).flat_map(|row| {
            let mut order: Vec<u8> = (0..n as u8).collect();
            order.sort_by(|&i, &j| row[j as usize].hi.abs().total_cmp(&row[i as usize].hi.abs()));
            order
        });
        let guesses = [n - 1, (n - 1).min(EXTRAPOLATED)].map(|degree| {
            let e = evaluation_matrix::<{ Collocation::MOST }>(operators, degree, |i| 1.0 + operators.nodes()[i].hi, n);
            let entry = |i: usize, j: usize| (0..n).map(|k| operators.a_squared()[i * n + k].hi * e[j][k]).sum();
            (0..n * n).map(|place| entry(place % n, place / n)).collect()
        });
        Self { order: order.collect(), guesses }
    }
}

/// Rounds a row to `f64`, in the `order` of its entries from large to small, each rounding error passed on to the next
/// smaller entry: the sum of the row is right to half a unit of its smallest entry. Rounded one by one, the sums (the
/// answer to a constant force) are off by 1e-17 with the same sign in every window, a drift of 4e-20 a window in K.
pub(super) fn round_row(row: &[Twofold], order: &[u8], rounded: &mut [f64]) {
    let mut carry = Twofold::ZERO;
    for &i in order {
        let entry = row[i as usize] + carry;
        rounded[i as usize] = entry.hi;
        carry = Twofold::from(entry.lo);
    }
}

impl<const P: usize> Tables<P> {
    /// For windows of `length` with these `operators`, of which `free` is made.
    pub(super) fn new(operators: &Collocation, free: &LengthFree, length: Twofold) -> Box<Self> {
        let n = operators.points();
        assert!(n <= P, "{n} nodes do not fit {P}");
        let h_squared = length * length;
        let mut t = Box::new(Self {
            force: [[0.0; P]; P],
            force_lo: [[0.0; P]; P],
            guess: [[0.0; P]; P],
            weights: [0.0; P],
            weights_lo: [0.0; P],
            position_weights: [0.0; P],
            position_weights_lo: [0.0; P],
            line: [0.0; P],
            line_lo: [0.0; P],
            parabola: [0.0; P],
            length_unit: f64::from_bits(length.hi.to_bits() & 0x7ff0_0000_0000_0000) * 2.0,
            length,
            points: n,
            columns: n.next_multiple_of(4),
        });
        let order = &free.order;
        let (mut row, mut rounded) = ([Twofold::ZERO; P], [0.0; P]);
        for i in 0..n {
            let entries = i * n..(i + 1) * n;
            row.iter_mut().zip(&operators.a_squared()[entries.clone()]).for_each(|(row, &v)| *row = v * h_squared);
            round_row(&row, &order[entries], &mut rounded);
            for (j, &rounded) in rounded[..n].iter().enumerate() {
                t.force[j][i] = rounded;
                t.force_lo[j][i] = (row[j] - Twofold::from(rounded)).hi;
            }
            let (weight, line) = (operators.weights()[i] * length, operators.nodes()[i] * length);
            let position = operators.position_weight(i) * h_squared;
            (t.weights[i], t.weights_lo[i]) = (weight.hi, weight.lo);
            (t.position_weights[i], t.position_weights_lo[i]) = (position.hi, position.lo);
            (t.line[i], t.line_lo[i]) = (line.hi, line.lo);
            t.parabola[i] = 0.5 * line.hi * line.hi;
        }
        // To rounding, short windows gain from the whole polynomial. (Unit tables have no length of their own.)
        let guess = &free.guesses[usize::from(length.hi > 0.4)];
        for (column, unit) in t.guess.iter_mut().zip(guess.chunks_exact(n)) {
            column.iter_mut().zip(unit).for_each(|(entry, unit)| *entry = h_squared.hi * unit);
        }
        t
    }
}

/// The matrix that takes nodal values on the nodes of `operators` to the values at s(0) … s(rows − 1) of the polynomial
/// of `degree` that fits them; s runs over [0, 1] inside the window of the nodal values.
pub(super) fn evaluation_matrix<const P: usize>(
    operators: &Collocation,
    degree: usize,
    s: impl Fn(usize) -> f64,
    rows: usize,
) -> Box<Matrix<P>> {
    let modes: Vec<Vec<f64>> = (0..=degree.min(operators.points() - 1)).map(|k| operators.mode(k).collect()).collect();
    let mut e = Box::new([[0.0; P]; P]);
    // P_k at s(0) … s(rows − 1).
    let mut at = vec![[0.0; P]; modes.len()];
    for i in 0..rows {
        for (p, value) in at.iter_mut().zip(legendre_values(modes.len() - 1, 2.0 * s(i) - 1.0)) {
            p[i] = value;
        }
    }
    for (p, mode) in at.iter().zip(&modes) {
        for (column, mode) in e.iter_mut().zip(mode) {
            column.iter_mut().zip(p).for_each(|(e, p)| *e += p * mode);
        }
    }
    e
}

#[cfg(test)]
mod tests {
    use super::Tables;
    use crate::engine::lobatto::WeakRule;

    /// What is added to cut products may be large, but not small.
    #[test]
    fn the_unit_of_lengths_is_the_next_power_of_two() {
        let rule = WeakRule::new(12);
        for (length, unit) in [(0.75, 1.0), (1.0, 2.0), (1.5, 2.0), (3e-5, 2.0_f64.powi(-15)), (5e8, 2.0_f64.powi(29))]
        {
            let tables = Tables::<12>::new(&rule, rule.length_free(), length.into());
            assert_eq!(tables.length_unit, unit, "{length}");
        }
    }
}
