//! Interpolation of a world-line in one window, as the parent module describes it.
//!
//! The error of the Hermite polynomial is O(Δγ⁸). In a spectral element of the weak form the rates at the nodes are
//! integrated from the start, and Picard sweeps on twice as many nodes refine that. Their fixed point is the same
//! method with 2n stages, so that the inside is as accurate as the ends.

use super::partition;
use crate::action::Form;
use crate::geometry::{Geometry, Motion as RatesOnNodes, OnNodes, Point};
use crate::number::Real;
use crate::number::norm::larger;
use crate::sbp::gll::MOST_NODES;
use crate::sbp::legendre::legendre;
use crate::sbp::polynomial::{Expansion, Tables, expansion, extent, integral, series};
use crate::solve::{WindowNodes, WorldLine};

/// Most Picard sweeps. Each gains two digits or more where the window resolves the motion.
const MOST_SWEEPS: usize = 100;
/// Sweeps that gain nothing any more have met rounding if their change is within this multiple of it.
const STALLED: f64 = 1e4;
/// Nodes that a Hermite polynomial goes through.
const STENCIL: usize = 4;

/// The curve of q^a of all coordinates, then p_a of the active ones, in a window. All are counted from its start, as is
/// γ.
#[derive(Debug)]
pub(super) struct Curve<S> {
    start: Position<S>,
    length: S,
    kind: Kind<S>,
}

/// q^a and p_a of all coordinates.
type Position<S> = [Vec<S>; 2];

#[derive(Debug)]
enum Kind<S> {
    /// Positions of the nodes, values there and their derivatives.
    Hermite { nodes: Vec<S>, values: Vec<Vec<S>>, slopes: Vec<Vec<S>> },
    /// Legendre coefficients of every row.
    Legendre(Vec<Vec<S>>),
}

impl<S: Real> Curve<S> {
    /// The curve in a window of `line`. `on_nodes` and `at` compute in its geometry.
    pub(super) fn new(
        line: &WorldLine<S>,
        view: &WindowNodes<'_, S>,
        tables: &mut Tables<S>,
        (on_nodes, at): (&mut RatesOnNodes<S>, &mut Point<S>),
    ) -> Self {
        let (grid, geometry, length) = (view.window, line.geometry(), view.window.length());
        let start = [view.start.q, view.start.p].map(<[S]>::to_vec);
        let values = view.increments();
        let mut motion = Motion { geometry, start: &start, on_nodes, at };
        let kind = if grid.is_equidistant() {
            let slopes = motion.slopes(&values);
            Kind::Hermite { nodes: (0..grid.points()).map(|k| grid.sbp().node(k)).collect(), values, slopes }
        } else if line.form == Form::Strong {
            let expansion = expansion(tables, grid.points());
            Kind::Legendre(values.iter().map(|row| expansion.coefficients(row)).collect())
        } else {
            let own = motion.integrals(&expansion(tables, grid.points()), &values, length);
            // An accuracy holds at the nodes, and the integrals of their rates are more accurate.
            if line.accuracy.is_some() {
                Kind::Legendre(own)
            } else {
                let fine = expansion(tables, (2 * grid.points()).min(MOST_NODES));
                Kind::Legendre(motion.refined(&fine, own, length, line.digits))
            }
        };
        Self { start, length, kind }
    }

    /// The positions and momenta at `gamma`.
    pub(super) fn at(&self, gamma: S, geometry: &Geometry<S>) -> Position<S> {
        let rows: Vec<S> = match &self.kind {
            Kind::Hermite { nodes, values, slopes } => {
                let k = partition(nodes.len() - 1, |k| nodes[k] <= gamma);
                if let Some(node) = [k, k + 1].into_iter().find(|&node| nodes[node] == gamma) {
                    values.iter().map(|row| row[node]).collect()
                } else {
                    let first = k.saturating_sub(STENCIL / 2 - 1).min(nodes.len().saturating_sub(STENCIL));
                    let stencil = first..(first + STENCIL).min(nodes.len());
                    let at = |(row, slopes): (&Vec<S>, &Vec<S>)| {
                        through(&nodes[stencil.clone()], &row[stencil.clone()], &slopes[stencil.clone()], gamma)
                    };
                    values.iter().zip(slopes).map(at).collect()
                }
            }
            // The start is known better than a sum of rounded terms.
            Kind::Legendre(rows) if gamma == S::ZERO => vec![S::ZERO; rows.len()],
            Kind::Legendre(rows) => {
                let degree = rows.iter().map(Vec::len).max().unwrap_or(2) - 1;
                let s = gamma / self.length;
                let basis = legendre(degree, s + s - S::ONE);
                rows.iter().map(|row| series(row, &basis)).collect()
            }
        };
        point(&self.start, &rows, geometry)
    }

    /// By how much q^a and p_a of all coordinates change at most, and what the window leaves open of them: none
    /// where that is not known.
    pub(super) fn extents(&self, geometry: &Geometry<S>) -> Vec<[S; 2]> {
        let most = |row: &Vec<S>| row.iter().fold(S::ZERO, |most, value| most.max(value.abs()));
        let rows: Vec<[S; 2]> = match &self.kind {
            Kind::Hermite { values, .. } => values.iter().map(|row| [most(row), S::ZERO]).collect(),
            Kind::Legendre(rows) => rows.iter().map(|row| extent(row)).collect(),
        };
        let n = geometry.dimension();
        let mut all = vec![[S::ZERO; 2]; 2 * n];
        all[..n].copy_from_slice(&rows[..n]);
        geometry.active().iter().zip(&rows[n..]).for_each(|(&a, &row)| all[n + a] = row);
        all
    }

    /// Pieces of the window on which the curve is one polynomial, as values of γ at their ends, and the number of
    /// points that resolve it.
    pub(super) fn cells(&self) -> (Vec<[S; 2]>, usize) {
        match &self.kind {
            Kind::Hermite { nodes, .. } => (nodes.windows(2).map(|ends| [ends[0], ends[1]]).collect(), 2 * STENCIL),
            Kind::Legendre(rows) => {
                let most = rows.iter().map(Vec::len).max().unwrap_or(2);
                (vec![[S::ZERO, self.length]], most.clamp(2 * STENCIL, MOST_NODES))
            }
        }
    }
}

/// The point whose coordinates and active momenta are `rows`, counted from `start`.
fn point<S: Real>(start: &Position<S>, rows: &[S], geometry: &Geometry<S>) -> Position<S> {
    let [mut q, mut p] = start.clone();
    geometry.active().iter().zip(&rows[q.len()..]).for_each(|(&a, &change)| p[a] += change);
    q.iter_mut().zip(rows).for_each(|(q, &change)| *q += change);
    [q, p]
}

/// Hamilton's equations around the start of a window.
struct Motion<'m, S> {
    geometry: &'m Geometry<S>,
    start: &'m Position<S>,
    on_nodes: &'m mut RatesOnNodes<S>,
    at: &'m mut Point<S>,
}

impl<S: Real> Motion<'_, S> {
    /// The derivatives of rows of values. Outside the domain they are not finite, or mean nothing.
    fn slopes(&mut self, values: &[Vec<S>]) -> Vec<Vec<S>> {
        // Extended numbers have no vectors, and blocks are filled up.
        let at_once = if S::IS_EXTENDED { None } else { self.slopes_at_once(values) };
        if let Some(slopes) = at_once {
            return slopes;
        }
        let (n, points) = (self.geometry.dimension(), values.first().map_or(0, Vec::len));
        let mut slopes = vec![Vec::with_capacity(points); values.len()];
        for k in 0..points {
            let rows: Vec<S> = values.iter().map(|row| row[k]).collect();
            let [q, p] = point(self.start, &rows, self.geometry);
            let outside = self.at.evaluate(&q, &p).is_err();
            for (row, slopes) in slopes.iter_mut().enumerate() {
                let slope = if row < n { self.at.q_dot(row) } else { self.at.p_dot(row - n) };
                slopes.push(if outside { S::from(f64::NAN) } else { slope });
            }
        }
        slopes
    }

    /// The same of a block of points at a time; `None` if one of them is outside of the domain.
    fn slopes_at_once(&mut self, values: &[Vec<S>]) -> Option<Vec<Vec<S>>> {
        let [of_q, of_p] = self.start;
        let ahead = |(start, row): (S, &Vec<S>)| row.iter().map(|&change| start + change).collect();
        let q: Vec<Vec<S>> = of_q.iter().copied().zip(values).map(ahead).collect();
        let own = self.geometry.active().iter().map(|&a| of_p[a]);
        let p: Vec<Vec<S>> = own.zip(&values[q.len()..]).map(ahead).collect();
        let mut rates = Vec::new();
        self.on_nodes.all_rates(OnNodes { q: &q, p: &p, start: of_p }, q[0].len(), &mut rates).ok()?;
        Some(rates)
    }

    /// The coefficients of the integrals of the rates, which are polynomials through their values at `values`.
    fn integrals(&mut self, expansion: &Expansion<S>, values: &[Vec<S>], length: S) -> Vec<Vec<S>> {
        let scaled = |row: Vec<S>| row.into_iter().map(|value| length * value).collect();
        let slopes = self.slopes(values).into_iter();
        slopes.map(|slopes| scaled(integral(&expansion.coefficients(&slopes)))).collect()
    }

    /// The curve that Picard sweeps on the nodes of `fine` make of `own`. Where the window is too long for them to
    /// converge it is `own`, which is still more accurate than the nodes.
    fn refined(&mut self, fine: &Expansion<S>, own: Vec<Vec<S>>, length: S, digits: u32) -> Vec<Vec<S>> {
        let enough = S::EPSILON + S::EPSILON;
        let enough = enough.max(S::from(0.1_f64.powi(digits as i32 + 1)));
        let sizes = self.sizes();
        let mut values: Vec<Vec<S>> = own.iter().map(|row| fine.values(row)).collect();
        let mut before = S::from(f64::INFINITY);
        for _ in 0..MOST_SWEEPS {
            let coefficients = self.integrals(fine, &values, length);
            let next: Vec<Vec<S>> = coefficients.iter().map(|row| fine.values(row)).collect();
            let change = change(&values, &next, &sizes);
            if !change.is_finite() {
                return own;
            }
            let is_stalled = change >= before.half() && change <= S::from(STALLED) * enough;
            if change <= enough || is_stalled {
                return coefficients;
            }
            (values, before) = (next, change);
        }
        own
    }

    /// The sizes that changes of the rows are compared with: the values at the start, and those that the other momenta
    /// have in the units of this one. The radial momentum of a circular orbit is zero but for rounding of the others.
    fn sizes(&self) -> Vec<S> {
        let [q, p] = self.start;
        let units: Vec<S> = self.geometry.diagonal(q).iter().map(|g| g.abs().sqrt()).collect();
        let with_unit = units.iter().zip(p).filter(|(unit, _)| **unit != S::ZERO);
        let momentum = with_unit.fold(S::ZERO, |most, (&unit, &p)| most.max((p / unit).abs()));
        let momenta = self.geometry.active().iter().map(|&a| p[a].abs().max(momentum * units[a]));
        q.iter().map(|q| q.abs()).chain(momenta).collect()
    }
}

/// The largest change of a row, relative to its size.
fn change<S: Real>(before: &[Vec<S>], after: &[Vec<S>], sizes: &[S]) -> S {
    let rows = before.iter().zip(after).zip(sizes);
    rows.fold(S::ZERO, |most, ((before, after), &size)| {
        let pairs = before.iter().zip(after);
        let change = pairs.fold(S::ZERO, |change, (&before, &after)| larger(change, (after - before).abs()));
        let size = after.iter().fold(size, |size, value| size.max(value.abs()));
        if change == S::ZERO { most } else { larger(most, change / size) }
    })
}

/// The Hermite polynomial of degree 2m − 1 through `values` with `slopes` on m `nodes`, at a place: divided differences
/// with every node twice, in Newton's form.
fn through<S: Real>(nodes: &[S], values: &[S], slopes: &[S], at: S) -> S {
    let place = |i: usize| nodes[i / 2];
    let mut differences: Vec<S> = (0..2 * nodes.len()).map(|i| values[i / 2]).collect();
    for order in 1..differences.len() {
        for i in (order..differences.len()).rev() {
            differences[i] = if order == 1 && i % 2 == 1 {
                slopes[i / 2]
            } else {
                (differences[i] - differences[i - 1]) / (place(i) - place(i - order))
            };
        }
    }
    (0..differences.len()).rev().fold(S::ZERO, |sum, i| sum * (at - place(i)) + differences[i])
}
