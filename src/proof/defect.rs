//! The defect d = v − f(y) at the nodes, in balls.

use super::algebras::{Balls, Discs, InBalls, LANES, Row};
use super::equations::{Equations, number};
use super::tables::{Pairs, TABLES, UP};
use crate::formula::run;
use crate::number::ball::{Ball, Disc, two_product, two_sum};

/// What a sum of 32 products is off by, in units of Σ |terms|. Sums and products of leading parts are exact with their
/// errors. These errors, at most 34 u Σ altogether, are added with three roundings a term: 96 · 34 u² < 3300 u². The
/// tables are off by 2 u².
const SUM_OF_PRODUCTS: f64 = 3400.0 * (f64::EPSILON / 2.0) * (f64::EPSILON / 2.0);

/// Room for registers.
pub(super) struct Defect {
    registers: Vec<Balls>,
}

/// Middles of d at the nodes, and radii.
pub(super) struct Found {
    pub(super) middle: Vec<Row>,
    pub(super) radius: Vec<Row>,
    /// y of active unknowns, as discs.
    pub(super) places: Vec<Discs>,
}

/// Σ c_k T_k, for exact c.
#[inline(always)]
fn combined(table: &[Pairs], factors: &Row) -> Balls {
    let (mut sum, mut low, mut size) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for (row, &factor) in table.iter().zip(factors) {
        for i in 0..LANES {
            let (product, error) = two_product(factor, row.hi[i]);
            let (next, lost) = two_sum(sum[i], product);
            sum[i] = next;
            low[i] += factor.mul_add(row.lo[i], error + lost);
            size[i] += product.abs();
        }
    }
    let mut balls = Balls { hi: sum, lo: low, rad: size };
    for i in 0..LANES {
        let (hi, lo) = two_sum(sum[i], low[i]);
        balls.set(i, Ball { hi, lo, rad: (SUM_OF_PRODUCTS * size[i] + f64::MIN_POSITIVE) * UP });
    }
    balls
}

impl Defect {
    pub(super) fn new(equations: &Equations<'_>) -> Self {
        Self { registers: equations.registers(false, |constant| Balls::of(number(constant))) }
    }

    /// The defect of slopes with these coefficients, in the window of length `h` from `start`.
    #[inline(always)]
    pub(super) fn at_nodes(&mut self, equations: &Equations<'_>, start: &[f64], h: f64, modes: &[Row]) -> Found {
        let half = Ball::exact(0.5 * h);
        let mut places = Vec::with_capacity(equations.active);
        for k in 0..equations.active {
            let mut y = combined(&TABLES.integral, &modes[k]);
            let mut place = Discs::of(Disc::default());
            for i in 0..LANES {
                y.set(i, Ball::exact(start[k]) + half * y.at(i));
                place.set(i, Disc::of(y.at(i)));
            }
            self.registers[equations.variables[k]] = y;
            places.push(place);
        }
        run(&InBalls, &equations.all, &mut self.registers);
        let (mut middle, mut radius) = (vec![[0.0; LANES]; modes.len()], vec![[0.0; LANES]; modes.len()]);
        for (k, modes) in modes.iter().enumerate() {
            let v = combined(&TABLES.legendre, modes);
            for i in 0..LANES {
                let gap = v.at(i) - self.registers[equations.slopes[k]].at(i);
                (middle[k][i], radius[k][i]) = gap.rounded();
            }
        }
        Found { middle, radius, places }
    }
}

#[cfg(test)]
mod tests;
