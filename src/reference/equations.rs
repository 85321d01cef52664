//! Hamilton's equations over γ/unit: the state is q^a of all coordinates, and then p_a of the active ones. The momenta
//! of the ignorable ones are constants.
//!
//! ```text
//! q̇^a = g^ab (p_b − A_b),    ṗ_a = ½ ∂_a g_bc q̇^b q̇^c + ∂_a A_b q̇^b + F_a,    ˙ = d/dγ
//! ```

use super::series::{ProgramSeries, increment, slope};
use super::{EndReason, ReferenceEnds};
use crate::geometry::{Geometry, Hamiltonian, Point, Start};
use crate::number::Real;

/// The solution around one point: a series for each component of the state.
pub(super) type Series<S> = Vec<Vec<S>>;

/// If steps shrink while a determinant is below this share of its first value, or that many times above it, the
/// trajectory approaches the edge of the domain.
const EDGE: f64 = 1e-3;

/// By how much the state is shifted to see what rounding does to its derivatives: these multiples of ε, in turn.
const SHIFTS: [f64; 5] = [4.0, -8.0, 12.0, -4.0, 8.0];

/// The equations over γ/unit. Ignorable coordinates are counted from the start.
#[derive(Debug)]
pub(super) struct Equations<'g, S> {
    geometry: &'g Geometry<S>,
    start: &'g Start<S>,
    unit: S,
    /// Momenta; those of the active coordinates are overwritten.
    p: Vec<S>,
    /// The determinants of the metric's blocks at the start.
    determinants: Vec<S>,
    pub(super) values: ProgramSeries<S>,
    point: Point<S>,
}

impl<'g, S: Real> Equations<'g, S> {
    /// For series of this order.
    pub(super) fn new(geometry: &'g Geometry<S>, start: &'g Start<S>, unit: S, order: usize) -> Self {
        let Hamiltonian { program, velocities, forces, .. } = &*geometry.hamiltonian;
        Self {
            geometry,
            start,
            unit,
            p: start.p.clone(),
            determinants: geometry.determinants(&start.q),
            values: ProgramSeries::new(program, [&velocities[..], forces].concat(), order),
            point: geometry.point(),
        }
    }

    /// The state at the start. Positions and momenta have no unit of γ.
    pub(super) fn state(&self) -> Vec<S> {
        let Start { q, p, .. } = self.start;
        let mut state = q.clone();
        self.geometry.ignorable().for_each(|a| state[a] = S::ZERO);
        state.extend(self.geometry.active().iter().map(|&a| p[a]));
        state
    }

    /// The error that a trajectory ends at `gamma`, over the unit, and this state.
    pub(super) fn ends(&self, reason: EndReason, gamma: S, state: &[S]) -> ReferenceEnds {
        let mut q = state[..self.geometry.dimension()].to_vec();
        self.geometry.ignorable().for_each(|a| q[a] += self.start.q[a]);
        ReferenceEnds::new(self.geometry, reason, gamma * self.unit, &q)
    }

    /// dq^a/dγ of all coordinates and dp_a/dγ of the active ones; `None` outside the domain.
    fn derivatives(&mut self, state: &[S]) -> Option<Vec<S>> {
        let n = self.geometry.dimension();
        for (&a, &p) in self.geometry.active().iter().zip(&state[n..]) {
            self.p[a] = p;
        }
        self.point.evaluate(&state[..n], &self.p).ok()?;
        let q_dot = (0..n).map(|a| self.point.q_dot(a));
        let p_dot = (n..state.len()).map(|component| self.point.p_dot(component - n));
        Some(q_dot.chain(p_dot).map(|rate| rate * self.unit).collect())
    }

    /// A bound on the rounding error of the derivatives.
    fn rounding(&mut self, state: &[S], derivatives: &[S]) -> Vec<S> {
        let shifted = |(k, &value): (usize, &S)| value + value * (S::from(SHIFTS[k % SHIFTS.len()]) * S::EPSILON);
        let charges = self.p.clone();
        self.p = charges.iter().enumerate().map(shifted).collect();
        let state: Vec<S> = state.iter().enumerate().map(shifted).collect();
        let others = self.derivatives(&state);
        self.p = charges;
        match others {
            Some(others) => others.iter().zip(derivatives).map(|(&a, &b)| gap(a, b)).collect(),
            None => vec![S::ZERO; derivatives.len()],
        }
    }

    /// The first coefficient of a component that has to do with its scale: 1 where the component itself has no meaning,
    /// because it is counted from the start, and 0 elsewhere.
    pub(super) fn first_of_scale(&self, component: usize) -> usize {
        let is_ignorable = component < self.geometry.dimension() && !self.geometry.active().contains(&component);
        usize::from(is_ignorable)
    }

    /// The series of every component around `state`, to the given order.
    pub(super) fn expand(&mut self, state: &[S], order: usize) -> Series<S> {
        let n = self.geometry.dimension();
        let mut series: Series<S> = state.iter().map(|&value| vec![value]).collect();
        let mut place_of = vec![None; n];
        for (place, &a) in self.geometry.active().iter().enumerate() {
            place_of[a] = Some(n + place);
        }
        self.values.restart();
        for k in 0..order {
            let charge = |a: usize| if k == 0 { self.p[a] } else { S::ZERO };
            let q = (0..n).map(|a| (a, series[a][k]));
            let p = (0..n).map(|a| (2 * n + a, place_of[a].map_or_else(|| charge(a), |place| series[place][k])));
            self.values.extend(k, q.chain(p));
            let next = S::from((k + 1) as f64);
            for (component, series) in series.iter_mut().enumerate() {
                series.push(self.values.output(component)[k] * self.unit / next);
            }
        }
        series
    }

    /// The difference at s between the derivatives of the series and those that the equations want there, relative to
    /// the size of the terms of the series over a step `h`. What differs by more than `small` may be rounding: if it
    /// is known to be, the difference may be taken as zero.
    pub(super) fn missed(&mut self, series: &Series<S>, h: S, s: S, small: S) -> S {
        let state: Vec<S> = series.iter().map(|c| c[0] + increment(c, s)).collect();
        let Some(derivatives) = self.derivatives(&state) else { return S::from(f64::INFINITY) };
        let sizes: Vec<S> = (series.iter().enumerate())
            .map(|(component, c)| {
                let of_value = if self.first_of_scale(component) == 0 { c[0].abs() / h } else { S::ZERO };
                c[1].abs().max((c[2] * h).abs()).max(of_value).max(S::MIN_POSITIVE)
            })
            .collect();
        let gaps: Vec<S> = series.iter().zip(&derivatives).map(|(c, &d)| gap(slope(c, s), d)).collect();
        let largest = |gaps: &[S]| gaps.iter().zip(&sizes).fold(S::ZERO, |all, (&gap, &size)| all.max(gap / size));
        let missed = largest(&gaps);
        if missed <= small {
            return missed;
        }
        // A force that is the small difference of large ones is not known to so many digits.
        let rounding = self.rounding(&state, &derivatives);
        largest(&gaps.iter().zip(&rounding).map(|(&gap, &rounding)| gap - rounding).collect::<Vec<S>>())
    }

    /// Returns true if `state` lies inside the domain.
    pub(super) fn is_inside(&mut self, state: &[S]) -> bool {
        self.derivatives(state).is_some()
    }

    /// Returns true if the edge of the domain is near, compared with the start.
    pub(super) fn is_near_the_edge(&mut self, state: &[S]) -> bool {
        let determinants = self.geometry.determinants(&state[..self.geometry.dimension()]);
        let edge = S::from(EDGE);
        determinants.iter().zip(&self.determinants).any(|(here, start)| {
            let (here, start) = (here.abs(), start.abs());
            here < edge * start || start < edge * here
        })
    }
}

/// |a − b|, or infinity if that is not a number.
fn gap<S: Real>(a: S, b: S) -> S {
    let gap = (a - b).abs();
    if gap.is_nan() { S::from(f64::INFINITY) } else { gap }
}
