//! Collocation on Gauss nodes: symplectic, symmetric, of order 2s.

use super::peer::{About, Peer, PeerIn, Setting, Step};
use super::{Failure, Marks, Output, Problem, SceneState, State, Trajectory};
use crate::engine::{self, Engine};
use crate::geometry::geodesic::InitialData;
use crate::geometry::metric::Metric;
use crate::geometry::{Geometry, Start};

/// The Gauss–Legendre Runge–Kutta method as it is written for q̈ = a(q),
///
/// ```text
/// Q = q + h c q̇ + h² A² a(Q),    q⁺ = q + h q̇ + h² Σ b_j (1 − c_j) a_j,    q̇⁺ = q̇ + h Σ b_j a_j,
/// ```
///
/// and as Y = y + h A f(Y), y⁺ = y + h Σ b_j f_j for equations of the first order. It is this program's own engine with
/// other tables: sweeps from the polynomial of the step before, sums without loss and weights of 30 digits, as in
/// Hairer, McLachlan, Razakarivony (2008), "Achieving Brouwer's law with implicit Runge–Kutta methods". Between the
/// ends of steps the motion is the integral of the polynomial through the slopes at the stages.
///
/// The iteration ends when the error of the unknowns is below the tolerance, relative to their size; 0 goes to
/// rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gauss {
    /// Number of stages s, from 1 to 16.
    pub stages: usize,
}

impl Gauss {
    /// Calls `see(q, p)` at the points of output, with q^a of all coordinates and p_a of active ones. Returns the
    /// numbers of evaluations and of steps.
    fn drive(
        self,
        (geometry, start, length): (&Geometry, &Start, f64),
        output: &Output,
        Setting { count, tolerance }: Setting,
        mut see: impl FnMut(&[f64], &[f64]),
    ) -> Result<[usize; 2], Failure> {
        let mut marks = Marks::new(output, count);
        let active = geometry.active();
        let (mut q, mut p) = (start.q.clone(), active.iter().map(|&a| start.p[a]).collect::<Vec<_>>());
        output.marks.iter().take_while(|&&mark| mark == 0).for_each(|_| see(&q, &p));
        marks.skip_start();
        let engine = Engine::gauss(geometry, start, length, count, self.stages, tolerance);
        let (mut engine, mut sweeps) = (engine.map_err(|_| Failure::OutsideDomain)?, 0);
        let steps = Marks::last(output, count);
        for step in 0..steps {
            let window = match engine.next() {
                Ok(window) => window.expect("there are as many steps"),
                Err(engine::Failure::OutsideDomain(_)) => return Err(Failure::OutsideDomain),
                Err(_) => return Err(Failure::NotConverged),
            };
            sweeps += window.sweeps;
            let mut dense = None;
            while let Some(fraction) = marks.within(step) {
                dense.get_or_insert_with(|| window.dense()).at(fraction, &mut q, &mut p);
                if q.iter().chain(&p).any(|value| !value.is_finite()) {
                    return Err(Failure::Diverged);
                }
                see(&q, &p);
            }
        }
        Ok([sweeps * self.stages, steps])
    }
}

impl Peer for Gauss {
    fn about(&self) -> About {
        About {
            name: format!("Gauss {}", self.stages),
            curve: "Gauss–Legendre",
            order: Some(2 * self.stages),
            step: Step::Iterated,
            has_dense_output: true,
            needs_second_order: false,
            coarsest: 0.05,
            source: "Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231",
        }
    }
}

impl PeerIn<Geometry> for Gauss {
    fn run(
        &self,
        Problem { space, start, length }: &Problem<Geometry>,
        output: &Output,
        setting: Setting,
    ) -> Result<Trajectory<SceneState>, Failure> {
        let mut states = Vec::with_capacity(output.marks.len());
        let [evaluations, steps] = self.drive((space, start, *length), output, setting, |q, active| {
            let mut p = start.p.clone();
            space.active().iter().zip(active).for_each(|(&a, &momentum)| p[a] = momentum);
            states.push(SceneState { q: q.to_vec(), p });
        })?;
        Ok(Trajectory { states, evaluations, steps })
    }
}

impl PeerIn<Metric> for Gauss {
    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        let Problem { space, start, length } = problem;
        let mut states = Vec::with_capacity(output.marks.len());
        let start = InitialData { t: 0.0, ..*start }.start(space);
        let scene = (space.scene(), &start, *length);
        let [evaluations, steps] = self.drive(scene, output, setting, |q, p| {
            // Without a potential x is ignorable, and its momentum a constant.
            let momentum = p.first().copied().unwrap_or(start.p[1]);
            states.push(State { elapsed: q[0], x: q[1], w: -momentum });
        })?;
        Ok(Trajectory { states, evaluations, steps })
    }
}
