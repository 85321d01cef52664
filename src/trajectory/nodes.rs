//! The world-line at the nodes of a window, as the solver has left it there.

use super::inside::{epsilon, of_inside};
use super::{Sample, Sampler};
use crate::geometry::{Motion, Observable, OnNodes, Start};
use crate::number::Real;
use crate::solve::{At, noise, rounding};

/// A curve that moves by so many times what it moves by on the nodes of its window is none that resolves the motion.
const BETWEEN: f64 = 4.0;

/// The states at all nodes of a window, a row for each coordinate.
#[derive(Debug, Default)]
pub(super) struct States<S> {
    /// q^a.
    pub(super) q: Vec<Vec<S>>,
    /// dq^a/dγ, or zeros if they were not wanted.
    pub(super) q_dot: Vec<Vec<S>>,
    /// p_a.
    pub(super) p: Vec<Vec<S>>,
    /// The momenta of active coordinates as the solver has them.
    active: Vec<Vec<S>>,
}

impl<S: Real> States<S> {
    /// The rows of q^a, of dq^a/dγ and of p_a.
    pub(super) fn rows(&self) -> [Vec<&[S]>; 3] {
        [&self.q, &self.q_dot, &self.p].map(|rows| rows.iter().map(Vec::as_slice).collect())
    }
}

impl<S: Real> Sampler<'_, S> {
    /// Returns true if the solver has left the states at the nodes of a window, and the motion is followed by the
    /// polynomial through them.
    pub(super) fn has_states(&self, window: usize) -> bool {
        !self.line.is_doubled() && !self.line.windows[window].is_equidistant()
    }

    /// q^a and p_a of the world-line at a node inside a window.
    pub(crate) fn inside(&mut self, window: usize, node: usize) -> [Vec<S>; 2] {
        let (line, grid) = (self.line, &self.line.windows[window]);
        if !self.has_states(window) {
            let Sample { q, p, .. } = self.in_window(window, grid.gamma_at(node) - grid.gamma[0]);
            return [q, p];
        }
        if node + 1 == grid.points() && window + 1 == line.windows.len() {
            let Start { q, p, .. } = line.end();
            return [q, p];
        }
        let q = (0..line.q.len()).map(|a| self.of_q(window, a)(node) + line.origin_of(a)).collect();
        [q, (0..line.q.len()).map(|a| line.signed(self.of_p(window, a)(node))).collect()]
    }

    /// Takes the states at all nodes of a window of which [`Self::has_states`] is true into these rows. Velocities are
    /// zeros if they are not `wanted`.
    pub(super) fn states(&mut self, window: usize, wanted: bool, into: &mut States<S>) {
        let (line, n, points) = (self.line, self.line.q.len(), self.line.windows[window].points());
        for rows in [&mut into.q, &mut into.q_dot, &mut into.p] {
            rows.resize_with(n, Vec::new);
            rows.iter_mut().for_each(Vec::clear);
        }
        into.q.iter_mut().enumerate().for_each(|(a, row)| row.extend((0..points).map(self.of_q(window, a))));
        into.p.iter_mut().enumerate().for_each(|(a, row)| row.extend((0..points).map(self.of_p(window, a))));
        match wanted {
            true => self.velocities(window, into),
            false => into.q_dot.iter_mut().for_each(|row| row.resize(points, S::ZERO)),
        }
        if line.is_backward {
            into.q_dot.iter_mut().chain(&mut into.p).flatten().for_each(|rate| *rate = -*rate);
        }
        for (a, row) in into.q.iter_mut().enumerate() {
            let origin = line.origin_of(a);
            row.iter_mut().for_each(|q| *q += origin);
        }
        if window + 1 == line.windows.len() {
            self.see_end(wanted, into);
        }
    }

    /// The last node of the line is its end, which is known to the last bit.
    fn see_end(&self, wanted: bool, into: &mut States<S>) {
        let (line, last) = (self.line, into.q.first().map_or(0, Vec::len) - 1);
        into.q.iter_mut().enumerate().for_each(|(a, row)| row[last] = line.last_position(a));
        if wanted {
            let Start { q_dot, p, .. } = line.end();
            into.q_dot.iter_mut().zip(q_dot).for_each(|(row, q_dot)| row[last] = q_dot);
            into.p.iter_mut().zip(p).for_each(|(row, p)| row[last] = p);
        }
    }

    /// The velocities at such nodes, of the solver's states.
    fn velocities(&mut self, window: usize, into: &mut States<S>) {
        let (line, geometry) = (self.line, self.line.geometry());
        let (n, points) = (line.q.len(), line.windows[window].points());
        into.active.resize_with(geometry.active().len(), Vec::new);
        into.active.iter_mut().zip(geometry.active()).for_each(|(row, &a)| row.clone_from(&into.p[a]));
        // Extended numbers have no vectors, and blocks are filled up.
        if !S::IS_EXTENDED {
            let on_nodes = self.on_nodes.get_or_insert_with(|| Motion::new(geometry));
            let on = OnNodes { q: &into.q, p: &into.active, start: line.joint(window).p };
            if on_nodes.all_rates(on, points, &mut into.q_dot).is_ok() {
                into.q_dot.truncate(n);
                return;
            }
            into.q_dot = vec![Vec::new(); n];
        }
        for node in 0..points {
            let [q, p] = [&into.q, &into.p].map(|rows| rows.iter().map(|row| row[node]).collect::<Vec<S>>());
            let _ = self.point.evaluate(&q, &p);
            into.q_dot.iter_mut().enumerate().for_each(|(a, row)| row.push(self.point.q_dot(a)));
        }
    }

    /// The node of such a window that is this length of γ behind its start, if one is.
    pub(super) fn node_at(&self, window: usize, place: S) -> Option<usize> {
        let grid = &self.line.windows[window];
        let nodes = &self.tables.get(&grid.points()).filter(|_| self.has_states(window))?.nodes;
        let at = |node: usize| if node + 1 == nodes.len() { grid.length() } else { nodes[node] * grid.length() };
        (0..nodes.len()).find(|&node| at(node) == place)
    }

    /// More than rounding makes of a formula at a node of such a window, as the nodes tell it without the curve. The
    /// Legendre coefficients of a curve through n nodes add up to n² times the largest change on these at most.
    pub(super) fn most_noise(
        &self,
        (window, node): (usize, usize),
        at: &mut At<'_, S>,
        (formula, norm): (&mut Observable<S>, S),
    ) -> S {
        let (line, n, points) = (self.line, self.line.q.len(), self.line.windows[window].points());
        let (reads, most) = (formula.reads(), S::from(BETWEEN * (points * points) as f64));
        let largest = |of: &dyn Fn(usize) -> S| (1..points).fold(S::ZERO, |way, k| way.max((of(k) - of(0)).abs()));
        let (mut state, mut changes) = (Vec::with_capacity(2 * n), Vec::with_capacity(2 * n));
        for (k, is_read) in reads.iter().enumerate() {
            let of: &dyn Fn(usize) -> S = if k < n { &self.of_q(window, k) } else { &self.of_p(window, k - n) };
            state.push(of(node));
            changes.push(if *is_read { most * largest(of) } else { S::ZERO });
        }
        let off = |k: usize, value: S| if reads[k] { rounding(value, changes[k], epsilon(line)) } else { S::ZERO };
        noise(at, &mut of_inside(line, formula, norm), &mut state, off)
    }

    /// q^a at each node of such a window, as the solver counts it.
    fn of_q(&self, window: usize, a: usize) -> impl Fn(usize) -> S {
        let (line, [start, end]) = (self.line, [window, window + 1].map(|joint| self.line.joint(joint).q[a]));
        let (row, is_active) = (&line.q[a][line.windows[window].nodes()], line.geometry().active().contains(&a));
        let last = row.len() - 1;
        move |node| match node {
            0 => start,
            _ if node == last => end,
            _ if is_active => row[node],
            _ => start + row[node],
        }
    }

    /// p_a at each node of such a window, of the motion that the solver computes. That of an ignorable coordinate is a
    /// constant.
    fn of_p(&self, window: usize, a: usize) -> impl Fn(usize) -> S {
        let (line, [start, end]) = (self.line, [window, window + 1].map(|joint| self.line.joint(joint).p[a]));
        let (nodes, place) = (line.windows[window].nodes(), line.geometry().active().iter().position(|&b| b == a));
        let (row, last) = (place.map(|place| &line.p[place][nodes.clone()]), nodes.len() - 1);
        move |node| match (node, row) {
            (0, _) => start,
            _ if node == last => end,
            (_, Some(row)) => row[node],
            (_, None) => start,
        }
    }
}
