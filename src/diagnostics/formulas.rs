//! The places of formulas of the user, which are witnesses of a run as its charges are.

use super::fields::{Fields, gamma_at, largest_of, row_sum};
use super::witnesses::{Heard, Place};
use crate::geometry::Observable;
use crate::number::Real;
use crate::number::norm::larger;
use crate::solve::Window;

/// So many windows are looked at together: enough for vectors, and few enough for the room that their points take.
const TOGETHER: usize = 64;

/// The place in a window at which a formula changes most.
struct Largest<S> {
    /// Its node.
    k: usize,
    /// The sizes of q^a and q̇^a of each coordinate in the window.
    sizes: Vec<[f64; 2]>,
    /// The steps of differences for all q^a and then all q̇^a.
    steps: Vec<S>,
}

impl<S: Real> Largest<S> {
    fn new(window: &Window<S>, delta: &[S], [q, q_dot]: [&[&[S]]; 2]) -> Self {
        let (nodes, length, n) = (window.nodes(), window.length().to_f64().abs(), q.len());
        let largest = |row: &[S]| row[nodes.clone()].iter().fold(0.0, |most, x| larger(most, x.to_f64().abs()));
        let sizes_of = |a: usize| {
            let sizes = [largest(q[a]), largest(q_dot[a])];
            [larger(sizes[0], length * sizes[1]), larger(sizes[1], sizes[0] / length)]
        };
        let sizes: Vec<[f64; 2]> = (0..n).map(sizes_of).collect();
        let step = |variable: usize| {
            let size = sizes[variable % n][variable / n];
            S::from(S::EPSILON.to_f64().cbrt() * if size > 0.0 { size } else { 1.0 })
        };
        Self { k: largest_of(delta, nodes.clone()), steps: (0..2 * n).map(step).collect(), sizes }
    }
}

impl<S: Real> Fields<'_, S> {
    /// The places of a formula of q^a, q̇^a and p_a, and of K at the start, which changes by `delta` on the nodes where
    /// positions and velocities are these rows. Its derivatives are central differences, whose steps are the cube root
    /// of rounding times the size of a number. What its terms are is not known: Σ |x ∂W/∂x| is their sizes, each times
    /// its degree.
    pub(super) fn formula_heard(&self, delta: &[S], rows: [&[&[S]]; 2], (formula, norm): (&Observable<S>, S)) -> Heard {
        let (n, mut heard) = (rows[0].len(), Heard::default());
        for (chunk, windows) in self.run.windows.chunks(TOGETHER).enumerate() {
            let largest: Vec<Largest<S>> = windows.iter().map(|window| Largest::new(window, delta, rows)).collect();
            let slopes = self.slopes(&largest, rows, (formula, norm));
            for (at, (window, Largest { k, sizes, .. })) in windows.iter().zip(&largest).enumerate() {
                let (index, slopes) = (TOGETHER * chunk + at, &slopes[2 * n * at..][..2 * n]);
                let (mut by, mut terms, row_sum) = (vec![0.0; n], 0.0, row_sum(window, k - window.nodes().start));
                for (a, sizes) in sizes.iter().enumerate() {
                    let slopes = [slopes[a], slopes[n + a]];
                    by[a] = slopes[0] + row_sum * slopes[1];
                    terms += slopes[0] * sizes[0] + slopes[1] * sizes[1];
                }
                let rounding = self.rounding(index, &by, 2 * n, terms);
                let change = delta[*k].to_f64().abs();
                heard.see(Place { change, terms, rounding, ..Place::of(gamma_at(self.run, index, *k), by) });
            }
        }
        heard
    }

    /// The sizes of the derivatives of the formula with respect to all q^a and then all q̇^a at these places, one place
    /// after the other. Each is a difference of two points beside the place.
    fn slopes(
        &self,
        places: &[Largest<S>],
        [q, q_dot]: [&[&[S]]; 2],
        (formula, norm): (&Observable<S>, S),
    ) -> Vec<f64> {
        let n = q.len();
        let beside = |(variable, row): (usize, &&[S])| {
            let mut points = Vec::with_capacity(4 * n * places.len());
            for Largest { k, steps, .. } in places {
                let first = points.len();
                points.resize(first + 4 * n, row[*k]);
                points[first + 2 * variable] += steps[variable];
                points[first + 2 * variable + 1] -= steps[variable];
            }
            points
        };
        let rows: Vec<Vec<S>> = q.iter().chain(q_dot).enumerate().map(beside).collect();
        let rows: Vec<&[S]> = rows.iter().map(Vec::as_slice).collect();
        let momenta = self.run.geometry().rows_of_momenta(&rows[..n], &rows[n..]);
        let momenta: Vec<&[S]> = momenta.iter().map(Vec::as_slice).collect();
        let mut values = vec![S::ZERO; rows[0].len()];
        formula.along([&rows[..n], &rows[n..], &momenta], norm, &mut values);
        let steps = places.iter().flat_map(|place| &place.steps);
        let pairs = values.chunks_exact(2).zip(steps);
        pairs.map(|(pair, &step)| ((pair[0] - pair[1]) / (step + step)).to_f64().abs()).collect()
    }
}
