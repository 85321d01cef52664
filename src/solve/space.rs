//! A space-time as the solvers and what judges their runs see it.

use super::leap;
use super::memory::Kept;
use super::world_line::Joint;
use crate::geometry::metric::{G00, Metric, OutsideDomain};
use crate::geometry::{Dynamics, Geometry, Motion, OutsideGeometry, Samples};
use crate::number::Real;

/// A space-time in which world-lines are looked for.
pub trait Space<S: Real>: Motion<S> + Sized {
    /// The same kind in `f64`.
    type Rough: Space<f64, Rough = Self::Rough, Outside = Self::Outside>;

    /// Whether there are runs that keep one window at a time.
    const RUNS_WINDOW_BY_WINDOW: bool;

    /// The names of the coordinates, in order.
    fn coordinates(&self) -> Vec<String>;

    /// Whether the accelerations of the active coordinates depend on positions only.
    fn has_accelerations(&self) -> bool;

    /// Number of rows of momenta that a run keeps.
    fn kept_momenta(&self) -> usize;

    /// What a run keeps.
    fn kept(&self) -> Kept;

    /// The first point outside the domain that an explicit rule has leapt over, from row to row of `q`.
    fn leapt_over(&self, q: &[Vec<S>]) -> Option<Self::Outside>;

    /// Whether the parts of the action are within the range of numbers, of a window of this `length` that ends there.
    fn has_finite_action(&self, end: Joint<'_, S>, length: S) -> bool;

    /// K at the end of a window; `samples` are those of the nodes, of which that of index `node` is there.
    fn norm_of_joint(&self, end: Joint<'_, S>, samples: &Samples<S>, node: usize) -> S;
}

impl<S: Real> Space<S> for Metric<S> {
    type Rough = Metric;

    const RUNS_WINDOW_BY_WINDOW: bool = true;

    fn coordinates(&self) -> Vec<String> {
        ["t", "x"].map(str::to_owned).to_vec()
    }

    fn has_accelerations(&self) -> bool {
        true
    }

    /// The momentum of x is minus its velocity, which D gives.
    fn kept_momenta(&self) -> usize {
        0
    }

    fn kept(&self) -> Kept {
        Kept {
            numbers_of_node: 17.0,
            numbers_of_window: 0.0,
            numbers_of_sample: 6.0,
            lists_of_sample: 0.0,
            coordinates: 2.0,
            fields: 2.0,
        }
    }

    /// g00 is one function of x, and a particle that crosses a horizon is met outside soon.
    fn leapt_over(&self, _: &[Vec<S>]) -> Option<OutsideDomain> {
        None
    }

    /// Q_t (t − t_i) from the start of the run, and (dx/dγ)² over the window, by what it is at its end.
    fn has_finite_action(&self, Joint { q, p }: Joint<'_, S>, length: S) -> bool {
        (p[0] * q[0]).is_finite() && (p[1] * p[1] * length).is_finite()
    }

    fn norm_of_joint(&self, Joint { p, .. }: Joint<'_, S>, samples: &Samples<S>, node: usize) -> S {
        p[0] * p[0] / samples.row(G00)[node] - p[1] * p[1]
    }
}

impl<S: Real> Space<S> for Geometry<S> {
    type Rough = Geometry;

    const RUNS_WINDOW_BY_WINDOW: bool = false;

    fn coordinates(&self) -> Vec<String> {
        self.names().to_vec()
    }

    fn has_accelerations(&self) -> bool {
        self.is_separable()
    }

    fn kept_momenta(&self) -> usize {
        self.active().len()
    }

    /// Each row of the structure is one number of a node more.
    fn kept(&self) -> Kept {
        let (structure, coordinates) = (self.structure(), self.dimension() as f64);
        Kept {
            numbers_of_node: 10.0 * coordinates + (structure.rows + structure.force_rows) as f64,
            numbers_of_window: 30.0 * coordinates,
            numbers_of_sample: 1.0 + 3.0 * coordinates,
            lists_of_sample: 3.0,
            coordinates,
            fields: 2.0 * self.active().len() as f64,
        }
    }

    fn leapt_over(&self, q: &[Vec<S>]) -> Option<OutsideGeometry> {
        leap::outside(self, q)
    }

    /// The action from the start, ∫ p_a dq^a, may be beyond the range of numbers although every window is not.
    fn has_finite_action(&self, Joint { q, p }: Joint<'_, S>, _: S) -> bool {
        q.iter().zip(p).all(|(&q, &p)| (p * q).is_finite())
    }

    fn norm_of_joint(&self, Joint { q, p }: Joint<'_, S>, _: &Samples<S>, _: usize) -> S {
        let mut room = self.motion_room();
        // A joint lies inside the domain.
        let _ = self.rates_at(q, p, 0, &mut room);
        let q_dot: Vec<S> = (0..q.len()).map(|a| self.q_dot(&room, a)).collect();
        self.norm(q, &q_dot)
    }
}

#[cfg(test)]
mod tests {
    use super::{Joint, Space};
    use crate::geometry::metric::Metric;
    use crate::geometry::potential::Potential;

    /// t counts from the start of the run, and x over the window alone.
    #[test]
    fn an_action_is_one_of_numbers() {
        let metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
        let is_finite = |t: f64, x_dot: f64| metric.has_finite_action(Joint { q: &[t, 0.0], p: &[1e100, -x_dot] }, 1e5);
        assert!(is_finite(1e200, 1e151));
        assert!(!is_finite(1e210, 1e151) && !is_finite(1e200, 1e152));
    }
}
