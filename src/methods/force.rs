//! What drives the motion, u = Q_t/g00(x) and a = −½ g00′(x) u², at one point and as fast as possible.

use super::equations::{Work, World};
use super::one::One;
use super::{Problem, State};
use crate::formula::Program;
use crate::geometry::metric::Metric;
use crate::geometry::potential::Potential;

/// u = dt/dγ and a = d²x/dγ².
pub(super) trait Force {
    /// (u, a) at `x`.
    fn at(&mut self, x: f64) -> (f64, f64);
}

impl World for Problem {
    type Point = State;

    fn length(&self) -> f64 {
        self.length
    }

    fn is_separable(&self) -> bool {
        true
    }

    fn with_equations<W: Work<State>>(&self, work: W) -> W::Output {
        let force = AnyForce::new(&self.space, self.q_t());
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
fn with_avx2<W: Work<State>, F: Force>(simd: pulp::x86::V3, work: W, equations: One<F>) -> W::Output {
    simd.vectorize(
        #[inline(always)]
        || work.with(equations),
    )
}

/// The force of any potential. Every method is compiled for this, out of line, and once more for the forces that are
/// quickest to evaluate, as part of the method.
enum AnyForce<'m> {
    LowDegree(LowDegree),
    AnyDegree(AnyDegree),
    Program(ProgramForce<'m>),
}

impl<'m> AnyForce<'m> {
    fn new(metric: &'m Metric, q_t: f64) -> Self {
        match metric.potential() {
            Potential::Polynomial(p) => {
                let g = coefficients(metric, p.coefficients());
                if g.len() <= 5 {
                    Self::LowDegree(LowDegree::new(&g, q_t))
                } else {
                    Self::AnyDegree(AnyDegree { g, q_t })
                }
            }
            Potential::Formula(formula) => Self::Program(ProgramForce::new(metric, formula.program(), q_t)),
        }
    }
}

impl Force for AnyForce<'_> {
    #[inline(never)]
    fn at(&mut self, x: f64) -> (f64, f64) {
        match self {
            Self::LowDegree(force) => force.at(x),
            Self::AnyDegree(force) => force.at(x),
            Self::Program(force) => force.at(x),
        }
    }
}

/// Of g00, lowest power first.
fn coefficients(metric: &Metric, potential: &[f64]) -> Vec<f64> {
    let mut g: Vec<f64> = potential.iter().map(|c| metric.two_over_mass() * c).collect();
    g.resize(g.len().max(1), 0.0);
    g[0] += metric.c_squared();
    g
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

/// The program of a formula, as far as V and V′ need it; constants are in place once and for all.
struct ProgramForce<'m> {
    program: &'m Program<f64>,
    registers: Vec<f64>,
    c_squared: f64,
    two_over_mass: f64,
    q_t: f64,
}

impl<'m> ProgramForce<'m> {
    fn new(metric: &Metric, program: &'m Program<f64>, q_t: f64) -> Self {
        let registers = program.registers(|constant| constant);
        Self { program, registers, c_squared: metric.c_squared(), two_over_mass: metric.two_over_mass(), q_t }
    }
}

impl Force for ProgramForce<'_> {
    #[inline]
    fn at(&mut self, x: f64) -> (f64, f64) {
        self.registers[0] = x;
        self.program.run(2, &mut self.registers);
        let [value, slope] = [0, 1].map(|output| self.registers[self.program.output(output)]);
        let u = self.q_t / (self.c_squared + self.two_over_mass * value);
        (u, -0.5 * self.two_over_mass * slope * (u * u))
    }
}
