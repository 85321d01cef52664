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

use super::deviations::Fields;
use crate::number::norm::max_abs;
use crate::number::{Real, sum};
use crate::sbp::RegularisedOperator;
use crate::solve::{Solution, WindowNodes};

/// The relative excess over the bound that is put down to rounding. A world-line with K = 0 meets its bound exactly, so
/// that rounding alone can take it beyond.
const ROUNDING: f64 = 1e-12;
/// The deviation for which [`Newtonian::c`] is chosen.
pub const NEGLIGIBLE: f64 = 1e-6;

/// Sums and extremes over a run in t and x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfX<S = f64> {
    /// H_BVP and its bound.
    pub bound: Bound<S>,
    /// Size, speed and frequency of the motion.
    pub scales: Scales,
    /// The deviation of the motion from Newton's.
    pub newtonian: Newtonian,
    /// The deviations of Q_x and Q_η, if the potential vanishes.
    pub free_particle: Option<FreeParticleCharges<S>>,
}

/// H_BVP = ∫ ½( g00 ṫ² + ẋ² ) dγ and its bound Q_t (t_f − t_i).
///
/// In the continuum H_BVP = Q_t (t_f − t_i) − ½ K (γ_f − γ_i), so the bound holds if and only if K ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound<S = f64> {
    /// H_BVP by the operator's quadrature with the regularised velocities.
    pub h_bvp: S,
    /// Q_t (t_N − t_i).
    pub h_bvp_bound: S,
    /// ½ K (γ_f − γ_i), the distance of H_BVP from its bound in the continuum.
    pub distance: S,
}

/// Extremes over the nodes. They serve to judge deviations, for which `f64` is enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Largest |dx/dγ|; in the strong form without the last node of each window.
    pub x_dot: f64,
    /// Largest local frequency: ω² = −dẍ/dx where that is positive, or 0.
    pub omega: f64,
    /// Largest (mean) spacing of the nodes of a window.
    pub spacing: f64,
    /// Least g00/c².
    pub g00: f64,
}

/// The deviation of a run from Newton's mechanics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newtonian {
    /// The largest 2v²/g00 over the nodes where a force acts; 0 for free motion, infinite if t does not change.
    pub deviation: f64,
    /// The largest v² of Newton's mechanics at the places visited, v_i² + 2(V_i − V)/m.
    speed_squared: f64,
    /// The largest −2V/m at the places visited.
    depth: f64,
}

/// The further charges of the free particle: its space-time is flat and has three Killing vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeParticleCharges<S = f64> {
    /// max |ΔQ_x|, Q_x = −ẋ (Killing vector (0, 1)).
    pub max_abs_delta_q_x: S,
    /// max |ΔQ_η|, Q_η = x ṫ − (t − t_i) ẋ (boost, Killing vector (x/c², t)).
    pub max_abs_delta_q_eta: S,
}

impl<S: Real> OfX<S> {
    /// `None` in another space-time.
    pub(super) fn new(fields: &Fields<'_, S>) -> Option<Self> {
        let solution = fields.run;
        let c_squared = solution.geometry().c_squared()?;
        let sources = solution.geometry().sources_of_g00();
        // g00, g00′ and g00″ at a node of the run.
        let g00 = |node: usize| sources.map(|source| fields.samples.at(source, node));
        let [t_dot, x_dot] = [&fields.velocities[0], &fields.velocities[1]];
        Some(Self {
            bound: Bound::new(solution, g00),
            scales: Scales::new(solution, g00, c_squared, x_dot),
            newtonian: Newtonian::new(solution, g00, c_squared, x_dot),
            free_particle: FreeParticleCharges::new(solution, t_dot, x_dot),
        })
    }

    /// The sums and extremes over a run, from those over its first part, `self`, and its second part, `next`.
    pub(super) fn followed_by(self, next: Self) -> Self {
        let charges = self.free_particle.zip(next.free_particle);
        Self {
            bound: Bound {
                h_bvp: self.bound.h_bvp + next.bound.h_bvp,
                h_bvp_bound: self.bound.h_bvp_bound + next.bound.h_bvp_bound,
                distance: self.bound.distance + next.bound.distance,
            },
            scales: Scales {
                x_dot: self.scales.x_dot.max(next.scales.x_dot),
                omega: self.scales.omega.max(next.scales.omega),
                spacing: self.scales.spacing.max(next.scales.spacing),
                g00: self.scales.g00.min(next.scales.g00),
            },
            newtonian: Newtonian {
                deviation: self.newtonian.deviation.max(next.newtonian.deviation),
                speed_squared: self.newtonian.speed_squared.max(next.newtonian.speed_squared),
                depth: self.newtonian.depth.max(next.newtonian.depth),
            },
            free_particle: charges.map(|(one, two)| FreeParticleCharges {
                max_abs_delta_q_x: one.max_abs_delta_q_x.max(two.max_abs_delta_q_x),
                max_abs_delta_q_eta: one.max_abs_delta_q_eta.max(two.max_abs_delta_q_eta),
            }),
        }
    }
}

impl<S: Real> Bound<S> {
    fn new(solution: &Solution<S>, g00: impl Fn(usize) -> [S; 3]) -> Self {
        let (mut t_dot, mut x_dot) = (Vec::new(), Vec::new());
        let of_window = |view: WindowNodes<'_, S>| {
            for room in [&mut t_dot, &mut x_dot] {
                room.resize(view.window.points(), S::ZERO);
            }
            RegularisedOperator::new(view.window.sbp(), S::ZERO).apply(view.row(0), &mut t_dot);
            RegularisedOperator::new(view.window.sbp(), view.start.q[1]).apply(view.row(1), &mut x_dot);
            for ((u, &w), node) in t_dot.iter_mut().zip(&x_dot).zip(view.window.nodes()) {
                let [g, ..] = g00(node);
                *u = (g * *u * *u + w * w).half();
            }
            view.window.sbp().integrate(&t_dot)
        };
        let h_bvp = sum(solution.views().map(of_window));
        let begun = solution.joint(0).q[0];
        let length = solution.windows.last().map_or(S::ZERO, |window| window.gamma[1])
            - solution.windows.first().map_or(S::ZERO, |window| window.gamma[0]);
        let (q_t, k) = (solution.q_t(), solution.norm());
        let h_bvp_bound = q_t * (solution.duration() - begun);
        Self { h_bvp, h_bvp_bound, distance: (k * length).half() }
    }

    /// Returns true if H_BVP ≤ Q_t (t_N − t_i) on the grid.
    pub fn is_kept(&self) -> bool {
        let allowed = S::from(ROUNDING) * self.h_bvp_bound.abs();
        self.h_bvp <= self.h_bvp_bound + allowed
    }

    /// H_BVP − Q_t (t_N − t_i) + ½ K (γ_f − γ_i), which is 0 in the continuum.
    pub fn defect(&self) -> S {
        (self.h_bvp - self.h_bvp_bound) + self.distance
    }
}

impl Scales {
    fn new<S: Real>(solution: &Solution<S>, g00: impl Fn(usize) -> [S; 3], c_squared: S, x_dot: &[S]) -> Self {
        let (q_t, c_squared) = (solution.q_t(), c_squared.to_f64());
        let nodes = || (0..solution.nodes()).map(&g00);
        // ω² = −dẍ/dx = ½ g00″ ṫ² − g00′² Q_t²/g00³.
        let squares = nodes().map(|[g00, first, second]| {
            let t_dot = q_t / g00;
            (t_dot * t_dot * (second.half() - first * first / g00)).to_f64()
        });
        let exact = solution.views().flat_map(|view| x_dot[view.window.exact()].iter());
        Self {
            x_dot: exact.map(|x_dot| x_dot.to_f64().abs()).fold(0.0, f64::max),
            omega: squares.fold(0.0, f64::max).sqrt(),
            spacing: solution.views().map(|view| view.window.sbp().spacing().to_f64()).fold(0.0, f64::max),
            g00: nodes().map(|[g00, ..]| g00.to_f64() / c_squared).fold(f64::INFINITY, f64::min),
        }
    }

    /// Δγω: the largest spacing times the largest local frequency.
    pub fn step(&self) -> f64 {
        self.spacing * self.omega
    }
}

impl Newtonian {
    fn new<S: Real>(solution: &Solution<S>, g00: impl Fn(usize) -> [S; 3], c_squared: S, x_dot: &[S]) -> Self {
        let (q_t, begin) = (solution.q_t(), &solution.place.start);
        let start = solution.geometry().g00(&begin.q).unwrap_or(S::from(f64::NAN));
        let v = begin.q_dot[1] / begin.q_dot[0];
        let mut found = Self { deviation: 0.0, speed_squared: 0.0, depth: f64::NEG_INFINITY };
        for view in solution.views() {
            let last = view.window.points() - 1;
            for (k, node) in view.window.nodes().enumerate() {
                let [g00, first, _] = g00(node);
                let w = if k == last { -view.end.p[1] } else { x_dot[node] };
                if first != S::ZERO {
                    let v = w * g00 / q_t;
                    let deviation = (S::from(2.0) * v * v / g00).to_f64();
                    // dx/dt is 0/0 where neither t nor x changes.
                    found.deviation = found.deviation.max(if deviation.is_nan() { f64::INFINITY } else { deviation });
                }
                found.speed_squared = found.speed_squared.max((v * v + (start - g00)).to_f64());
                found.depth = found.depth.max((c_squared - g00).to_f64());
            }
        }
        found
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

impl<S: Real> FreeParticleCharges<S> {
    /// The charges if V = 0, over all nodes.
    fn new(solution: &Solution<S>, t_dot: &[S], x_dot: &[S]) -> Option<Self> {
        let (geometry, start) = (solution.geometry(), &solution.place.start);
        if geometry.depends_on(1) || geometry.g00(&start.q) != geometry.c_squared() {
            return None;
        }
        let delta_q_x: Vec<S> = x_dot.iter().map(|&w| start.q_dot[1] - w).collect();
        let q_eta = start.q[1] * start.q_dot[0];
        let time = solution.counted_from_origin(0, solution.elapsed());
        let delta_q_eta: Vec<S> = (solution.x().iter().zip(t_dot))
            .zip(time.zip(x_dot))
            .map(|((&x, &u), (t, &w))| x * u - t * w - q_eta)
            .collect();
        Some(Self { max_abs_delta_q_x: max_abs(&delta_q_x), max_abs_delta_q_eta: max_abs(&delta_q_eta) })
    }
}
