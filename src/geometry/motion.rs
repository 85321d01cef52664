//! Hamilton's equations as the solvers of the physical limit use them.

use super::Geometry;
use super::hamiltonian::Point;
use super::outside::OutsideGeometry;
use super::structure::Dynamics;
use crate::number::Real;

/// The rates of positions and momenta of a Lagrangian with a force: q̇^a = g^ab (p_b − A_b), ṗ_a = f_a + F_a.
///
/// Only the active coordinates are unknowns, with their momenta; the momenta of ignorable ones are constants.
pub trait Motion<S: Real>: Dynamics<S> {
    /// What was computed last, and room for it.
    type Room;

    /// Room for all that is computed here.
    fn motion_room(&self) -> Self::Room;

    /// The active coordinates, in order.
    fn active(&self) -> &[usize];

    /// Computes the rates at one point, from q^a and p_a of all coordinates. The index in the error is `index`.
    ///
    /// # Errors
    /// If the point is outside the domain.
    fn rates_at(&self, q: &[S], p: &[S], index: usize, room: &mut Self::Room) -> Result<(), Self::Outside>;

    /// dq^a/dγ at the point that was computed last.
    fn q_dot(&self, room: &Self::Room, a: usize) -> S;

    /// dp/dγ at the point that was computed last, of the active coordinate with that place among the active ones.
    fn p_dot(&self, room: &Self::Room, place: usize) -> S;

    /// d²q/dγ² at the point that was computed last, of the active coordinate with that place, if it does not depend on
    /// the momenta: if the active part of g^ab is constant and coupled to nothing else.
    fn acceleration(&self, room: &Self::Room, place: usize) -> Option<S>;

    /// Computes the rates of the active coordinates on all nodes, from q^a (all) and p_a (active) there and the momenta
    /// at the start (all), and writes rows of q̇, then rows of ṗ, into `out`.
    ///
    /// # Errors
    /// The first node that is outside the domain.
    fn rates(
        &self,
        q: &[Vec<S>],
        p: &[Vec<S>],
        start: &[S],
        room: &mut Self::Room,
        out: &mut [Vec<S>],
    ) -> Result<(), Self::Outside>;

    /// The rates of the ignorable coordinates times `h` on all nodes, a row for each, where [`Self::rates`]
    /// computed the rates from this q and p.
    fn steps(&self, q: &[Vec<S>], p: &[Vec<S>], start: &[S], h: S, room: &mut Self::Room) -> Vec<Vec<S>>;

    /// Calls `see(row, column, value)` for the entries of ∂(q̇, ṗ)/∂(q, p) of the active coordinates that are not zero,
    /// at node k, where [`Self::rates`] computed the rates from this q and p (all coordinates).
    fn jacobian(&self, q: &[S], p: &[S], k: usize, room: &mut Self::Room, see: impl FnMut(usize, usize, S));
}

/// Room for the equations of a geometry.
#[derive(Debug, Clone)]
pub struct MotionRoom<S> {
    point: Point<S>,
    /// All coordinates and momenta at one node.
    q: Vec<S>,
    p: Vec<S>,
}

impl<S: Real> Geometry<S> {
    /// Puts node k of the rows into the room.
    fn gather(&self, q: &[Vec<S>], p: &[Vec<S>], start: &[S], k: usize, room: &mut MotionRoom<S>) {
        room.p.copy_from_slice(start);
        for (place, &a) in self.active().iter().enumerate() {
            (room.q[a], room.p[a]) = (q[a][k], p[place][k]);
        }
    }

    /// Computes the rates at node k of the rows.
    fn rates_of_node(
        &self,
        (q, p): (&[Vec<S>], &[Vec<S>]),
        start: &[S],
        k: usize,
        room: &mut MotionRoom<S>,
    ) -> Result<(), OutsideGeometry> {
        self.gather(q, p, start, k, room);
        let MotionRoom { point, q, p } = room;
        point.evaluate(q, p).map_err(|point| OutsideGeometry { index: k, ..point })
    }
}

impl<S: Real> Motion<S> for Geometry<S> {
    type Room = MotionRoom<S>;

    fn motion_room(&self) -> MotionRoom<S> {
        let n = self.dimension();
        MotionRoom { point: self.point(), q: vec![S::ZERO; n], p: vec![S::ZERO; n] }
    }

    fn active(&self) -> &[usize] {
        &self.hamiltonian.active
    }

    fn rates_at(&self, q: &[S], p: &[S], index: usize, room: &mut MotionRoom<S>) -> Result<(), OutsideGeometry> {
        room.point.evaluate(q, p).map_err(|point| OutsideGeometry { index, ..point })
    }

    fn q_dot(&self, room: &MotionRoom<S>, a: usize) -> S {
        room.point.q_dot(a)
    }

    fn p_dot(&self, room: &MotionRoom<S>, place: usize) -> S {
        room.point.p_dot(place)
    }

    fn acceleration(&self, room: &MotionRoom<S>, place: usize) -> Option<S> {
        let (inverse, m) = (self.separable()?, self.active().len());
        let row = &inverse[place * m..][..m];
        Some(row.iter().enumerate().fold(S::ZERO, |sum, (other, &g)| sum + g * room.point.p_dot(other)))
    }

    fn rates(
        &self,
        q: &[Vec<S>],
        p: &[Vec<S>],
        start: &[S],
        room: &mut MotionRoom<S>,
        out: &mut [Vec<S>],
    ) -> Result<(), OutsideGeometry> {
        let (q_dot, p_dot) = out.split_at_mut(self.active().len());
        for k in 0..q.first().map_or(0, Vec::len) {
            self.rates_of_node((q, p), start, k, room)?;
            for (place, &a) in self.active().iter().enumerate() {
                q_dot[place][k] = room.point.q_dot(a);
                p_dot[place][k] = room.point.p_dot(place);
            }
        }
        Ok(())
    }

    fn steps(&self, q: &[Vec<S>], p: &[Vec<S>], start: &[S], h: S, room: &mut MotionRoom<S>) -> Vec<Vec<S>> {
        let ignorable: Vec<usize> = self.ignorable().collect();
        let points = q.first().map_or(0, Vec::len);
        let mut steps = vec![Vec::with_capacity(points); ignorable.len()];
        for k in 0..points {
            // A node outside the domain has rates that are not finite, which the certificate of the window shows.
            let _ = self.rates_of_node((q, p), start, k, room);
            for (&a, steps) in ignorable.iter().zip(&mut steps) {
                steps.push(h * room.point.q_dot(a));
            }
        }
        steps
    }

    fn jacobian(&self, q: &[S], p: &[S], _: usize, room: &mut MotionRoom<S>, see: impl FnMut(usize, usize, S)) {
        room.point.jacobian(q, p, see);
    }
}
