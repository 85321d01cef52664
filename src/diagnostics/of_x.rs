//! The measures of a run in a potential of x alone: the paper's bound on H_BVP, the scales of the motion, its deviation
//! from Newton's mechanics, and the further charges of a free particle.
//!
//! With time as the parameter and v = dx/dt, the geodesic equations of the metric diag(g00, −1), g00 = c² + 2V/m, are
//!
//! ```text
//! dv/dt = −(V′/m) (1 − 2v²/g00).
//! ```
//!
//! (ẋ = vṫ gives ẍ = ṫ² dv/dt + v ẗ, and g00 ṫ = Q_t gives ẗ = −g00′ ẋ ṫ/g00.) So the acceleration differs from
//! Newton's by exactly the share 2v²/g00, and the motion is Newton's in the limit of large c.

use super::fields::Fields;
use crate::number::norm::{larger, max_abs};
use crate::number::{Real, sum};
use crate::sbp::RegularisedOperator;
use crate::solve::Solution;

/// The relative excess over the bound that is put down to rounding. A world-line with K = 0 meets its bound exactly, so
/// that rounding alone can take it beyond.
const ROUNDING: f64 = 1e-12;
/// The deviation for which [`OfX::c`] is chosen.
pub const NEGLIGIBLE: f64 = 1e-6;

/// Sums and extremes over a run in t and x. Extremes serve to judge deviations, for which `f64` is enough.
///
/// In the continuum H_BVP = ∫ ½( g00 ṫ² + ẋ² ) dγ is Q_t (t_f − t_i) − ½ K (γ_f − γ_i), so the bound Q_t (t_f − t_i)
/// holds if and only if K ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfX<S = f64> {
    /// H_BVP by the operator's quadrature with the regularised velocities.
    pub h_bvp: S,
    /// Q_t (t_N − t_i).
    pub h_bvp_bound: S,
    /// ½ K (γ_f − γ_i), the distance of H_BVP from its bound in the continuum.
    pub distance: S,
    /// Largest |dx/dγ|; in the strong form without the last node of each window.
    pub x_dot: f64,
    /// Largest local frequency: ω² = −dẍ/dx where that is positive, or 0.
    pub omega: f64,
    /// Largest (mean) spacing of the nodes of a window.
    pub spacing: f64,
    /// Least g00/c².
    pub g00: f64,
    /// The largest 2v²/g00 over the nodes where a force acts, by which the acceleration differs from Newton's; 0 for
    /// free motion, infinite if t does not change.
    pub deviation: f64,
    /// The largest v² of Newton's mechanics at the places visited, v_i² + 2(V_i − V)/m.
    speed_squared: f64,
    /// The largest −2V/m at the places visited.
    depth: f64,
    /// max |ΔQ_x| and max |ΔQ_η| if the potential vanishes: the space-time of a free particle is flat and has three
    /// Killing vectors. Q_x = −ẋ is the charge of (0, 1), and Q_η = x ṫ − (t − t_i) ẋ that of the boost (x/c², t).
    pub free_particle: Option<[S; 2]>,
}

impl<S: Real> OfX<S> {
    /// `None` in another space-time.
    pub(super) fn new(fields: &Fields<'_, S>) -> Option<Self> {
        let (line, [t_dot, x_dot]) = (fields.run, [0, 1].map(|a| fields.velocities.get(a)));
        let (c_squared, t_dot, x_dot) = (line.geometry().c_squared?, t_dot?, x_dot?);
        let sources = line.geometry().sources_of_g00();
        // g00, g00′ and g00″ at a node of the run.
        let g00 = |node: usize| sources.map(|source| fields.samples.at(source, node));
        let (q_t, begin) = (line.q_t(), &line.place.start);
        let (v_i, g00_i) =
            (begin.q_dot[1] / begin.q_dot[0], line.geometry().g00(&begin.q).unwrap_or(S::from(f64::NAN)));
        let length = line.windows.last().map_or(S::ZERO, |window| window.gamma[1])
            - line.windows.first().map_or(S::ZERO, |window| window.gamma[0]);
        let mut found = Self {
            h_bvp: h_bvp(line, g00),
            h_bvp_bound: q_t * (line.duration() - line.joint(0).q[0]),
            distance: (line.norm() * length).half(),
            x_dot: 0.0,
            omega: 0.0,
            spacing: 0.0,
            g00: f64::INFINITY,
            deviation: 0.0,
            speed_squared: 0.0,
            depth: f64::NEG_INFINITY,
            free_particle: free_particle(line, t_dot, x_dot),
        };
        // ω² = −dẍ/dx = ½ g00″ ṫ² − g00′² Q_t²/g00³.
        let squares = (0..line.nodes()).map(g00).map(|[g00, first, second]| {
            let t_dot = q_t / g00;
            (t_dot * t_dot * (second.half() - first * first / g00)).to_f64()
        });
        found.omega = squares.fold(0.0, larger).sqrt();
        for view in line.views() {
            let nodes = view.window.nodes();
            found.spacing = larger(found.spacing, view.window.sbp().spacing().to_f64());
            found.x_dot = x_dot[view.window.exact()].iter().map(|x_dot| x_dot.to_f64().abs()).fold(found.x_dot, larger);
            for node in nodes.clone() {
                let [g00, first, _] = g00(node);
                found.g00 = -larger(-found.g00, -g00.to_f64() / c_squared.to_f64());
                let w = if node + 1 == nodes.end { -view.end.p[1] } else { x_dot[node] };
                if first != S::ZERO {
                    let v = w * g00 / q_t;
                    let deviation = (S::from(2.0) * v * v / g00).to_f64();
                    // dx/dt is 0/0 where neither t nor x changes.
                    found.deviation = found.deviation.max(if deviation.is_nan() { f64::INFINITY } else { deviation });
                }
                found.speed_squared = larger(found.speed_squared, (v_i * v_i + (g00_i - g00)).to_f64());
                found.depth = larger(found.depth, (c_squared - g00).to_f64());
            }
        }
        Some(found)
    }

    /// The sums and extremes over a run, from those over its first part, `self`, and its second part, `next`.
    pub(super) fn followed_by(self, next: Self) -> Self {
        let both = self.free_particle.zip(next.free_particle);
        Self {
            h_bvp: self.h_bvp + next.h_bvp,
            h_bvp_bound: self.h_bvp_bound + next.h_bvp_bound,
            distance: self.distance + next.distance,
            x_dot: larger(self.x_dot, next.x_dot),
            omega: larger(self.omega, next.omega),
            spacing: larger(self.spacing, next.spacing),
            g00: -larger(-self.g00, -next.g00),
            deviation: self.deviation.max(next.deviation),
            speed_squared: larger(self.speed_squared, next.speed_squared),
            depth: larger(self.depth, next.depth),
            free_particle: both.map(|(one, next)| [larger(one[0], next[0]), larger(one[1], next[1])]),
        }
    }

    /// Returns true if H_BVP ≤ Q_t (t_N − t_i) on the grid.
    pub fn is_kept(&self) -> bool {
        let allowed = S::from(ROUNDING) * self.h_bvp_bound.abs();
        self.h_bvp <= self.h_bvp_bound.abs() + allowed
    }

    /// H_BVP − Q_t (t_N − t_i) + ½ K (γ_f − γ_i), which is 0 in the continuum.
    pub fn defect(&self) -> S {
        (self.h_bvp - self.h_bvp_bound) + self.distance
    }

    /// Δγω: the largest spacing times the largest local frequency.
    pub fn step(&self) -> f64 {
        self.spacing * self.omega
    }

    /// The speed of light, rounded up to three digits, with which the deviation at the places visited would be
    /// [`NEGLIGIBLE`]; `None` if the particle does not move.
    pub fn c(&self) -> Option<f64> {
        let squared = 2.0 / NEGLIGIBLE * self.speed_squared + self.depth;
        if !(self.speed_squared > 0.0 && squared > 0.0 && squared.is_finite()) {
            return None;
        }
        let c = squared.sqrt();
        let unit = 10.0_f64.powi(c.log10().floor() as i32 - 2);
        Some((c / unit).ceil() * unit)
    }
}

/// H_BVP, with g00 and its derivatives at the nodes.
fn h_bvp<S: Real>(line: &Solution<S>, g00: impl Fn(usize) -> [S; 3]) -> S {
    sum(line.views().map(|view| {
        let (window, mut rows) = (view.window, [0, 1].map(|_| vec![S::ZERO; view.window.points()]));
        for (a, (row, start)) in rows.iter_mut().zip([S::ZERO, view.start.q[1]]).enumerate() {
            RegularisedOperator::new(window.sbp(), start).apply(view.row(a), row);
        }
        let [mut t_dot, x_dot] = rows;
        for ((u, &w), node) in t_dot.iter_mut().zip(&x_dot).zip(window.nodes()) {
            let [g, ..] = g00(node);
            *u = (g * *u * *u + w * w).half();
        }
        window.sbp().integrate(&t_dot)
    }))
}

/// The largest deviations of the further charges over all nodes, if V = 0.
fn free_particle<S: Real>(line: &Solution<S>, t_dot: &[S], x_dot: &[S]) -> Option<[S; 2]> {
    let (geometry, start) = (line.geometry(), &line.place.start);
    if geometry.depends_on(1) || geometry.g00(&start.q) != geometry.c_squared {
        return None;
    }
    let q_x: Vec<S> = x_dot.iter().map(|&w| start.q_dot[1] - w).collect();
    let q_eta = start.q[1] * start.q_dot[0];
    let time = line.counted_from_origin(0, line.elapsed());
    let rates = (line.x().iter().zip(t_dot)).zip(time.zip(x_dot));
    let q_eta: Vec<S> = rates.map(|((&x, &u), (t, &w))| x * u - t * w - q_eta).collect();
    Some([max_abs(&q_x), max_abs(&q_eta)])
}
