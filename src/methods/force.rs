//! The rates that drive the motion, u = Q_t/g00(x) and a = −½ g00′(x) u², at one point and as fast as possible.

use super::Problem;
use super::equations::Work;
use super::one::One;
use super::scene::SceneEquations;
use crate::geometry::Point;

/// u = dt/dγ and a = d²x/dγ².
pub(super) trait Force {
    /// (u, a) at `x`.
    fn at(&mut self, x: f64) -> (f64, f64);
}

impl Problem {
    /// Does `work` with the equations, compiled for the instructions of this machine.
    pub(super) fn with_equations<W: Work>(&self, work: W) -> W::Output {
        if self.space.c_squared().is_none() {
            return work.with(SceneEquations::new(self));
        }
        let force = AnyForce::new(self);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return match force {
                AnyForce::LowDegree(force) => with_avx2(simd, work, One::new(self, force)),
                force => with_avx2(simd, work, One::new(self, force)),
            };
        }
        #[cfg(not(target_arch = "x86_64"))]
        if let AnyForce::LowDegree(force) = force {
            return work.with(One::new(self, force));
        }
        work.with(One::new(self, force))
    }
}

/// Does `work` with AVX2 and fused multiply-add. Longer vectors would gain nothing on one particle.
#[cfg(target_arch = "x86_64")]
fn with_avx2<W: Work, F: Force>(simd: pulp::x86::V3, work: W, equations: One<F>) -> W::Output {
    simd.vectorize(
        #[inline(always)]
        || work.with(equations),
    )
}

/// The force of any potential. Every method is compiled for this, out of line, and once more for the forces that are
/// quickest to evaluate, as part of the method.
enum AnyForce {
    LowDegree(LowDegree),
    AnyDegree(AnyDegree),
    Program(ProgramForce),
}

impl AnyForce {
    fn new(problem: &Problem) -> Self {
        let q_t = problem.start.p[0];
        match &problem.g00 {
            Some(g) if g.len() <= 5 => Self::LowDegree(LowDegree::new(g, q_t)),
            Some(g) => Self::AnyDegree(AnyDegree { g: g.clone(), q_t }),
            None => Self::Program(ProgramForce { point: problem.space.point(), q_t }),
        }
    }
}

impl Force for AnyForce {
    #[inline(never)]
    fn at(&mut self, x: f64) -> (f64, f64) {
        match self {
            Self::LowDegree(force) => force.at(x),
            Self::AnyDegree(force) => force.at(x),
            Self::Program(force) => force.at(x),
        }
    }
}

/// g00 of degree four at most, by Estrin's scheme: half the latency of Horner's, which is what a step waits for.
struct LowDegree {
    g: [f64; 5],
    /// −½ g00′.
    d: [f64; 4],
    q_t: f64,
}

impl LowDegree {
    fn new(coefficients: &[f64], q_t: f64) -> Self {
        let mut g = [0.0; 5];
        g[..coefficients.len()].copy_from_slice(coefficients);
        Self { g, d: [-0.5 * g[1], -g[2], -1.5 * g[3], -2.0 * g[4]], q_t }
    }
}

impl Force for LowDegree {
    #[inline(always)]
    fn at(&mut self, x: f64) -> (f64, f64) {
        let Self { g, d, q_t } = self;
        let x2 = x * x;
        let g00 = (g[0] + g[1] * x) + x2 * ((g[2] + g[3] * x) + x2 * g[4]);
        let u = *q_t / g00;
        (u, ((d[0] + d[1] * x) + x2 * (d[2] + d[3] * x)) * (u * u))
    }
}

/// g00 of any degree, by Horner's rule.
struct AnyDegree {
    g: Vec<f64>,
    q_t: f64,
}

impl Force for AnyDegree {
    #[inline(always)]
    fn at(&mut self, x: f64) -> (f64, f64) {
        let (mut g00, mut slope) = (0.0, 0.0);
        for &c in self.g.iter().rev() {
            slope = slope * x + g00;
            g00 = g00 * x + c;
        }
        let u = self.q_t / g00;
        (u, -0.5 * slope * (u * u))
    }
}

/// The program of the equations.
struct ProgramForce {
    point: Point,
    q_t: f64,
}

impl Force for ProgramForce {
    #[inline]
    fn at(&mut self, x: f64) -> (f64, f64) {
        match self.point.evaluate(&[0.0, x], &[self.q_t, 0.0]) {
            Ok(()) => (self.point.q_dot(0), self.point.acceleration(0).unwrap_or(f64::NAN)),
            Err(_) => (f64::NAN, f64::NAN),
        }
    }
}
