//! This program's own engine as a method among others: steps of Gauss' method, windows of one length, and windows as
//! long as an accuracy needs.

use super::peer::{About, Peer, Prepared, Setting, Step};
use super::{Failure, Output, Problem, States, Trajectory};
use crate::engine::{self, Accuracy, Engine, POINTS};

/// What the engine does as a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Windows {
    /// The Gauss–Legendre Runge–Kutta method, symplectic, symmetric and of order 2s, as it is written for q̈ = a(q),
    ///
    /// ```text
    /// Q = q + h c q̇ + h² A² a(Q),    q⁺ = q + h q̇ + h² Σ b_j (1 − c_j) a_j,    q̇⁺ = q̇ + h Σ b_j a_j,
    /// ```
    ///
    /// and as Y = y + h A f(Y), y⁺ = y + h Σ b_j f_j for equations of the first order. The engine has other tables for
    /// it: sweeps from the polynomial of the step before, sums without loss and weights of 30 digits, as in Hairer,
    /// McLachlan, Razakarivony (2008), "Achieving Brouwer's law with implicit Runge–Kutta methods". Between the ends of
    /// steps the motion is the integral of the polynomial through the slopes at the stages.
    ///
    /// The iteration ends when the error of the unknowns is below the tolerance, relative to their size; 0 goes to
    /// rounding.
    Gauss {
        /// Number of stages s, from 1 to 16.
        stages: usize,
    },
    /// The weak scheme of this program, without its tables in files, in windows of one length with so many nodes, from
    /// 2 to 24. The tolerance is that of sweeps, as for Gauss' method.
    Equal(usize),
    /// Its windows for an accuracy of the whole run, certified, with an estimate of their error.
    Accuracy,
    /// Its windows for a tolerance of each of them.
    Tolerance,
}

impl From<engine::Failure> for Failure {
    fn from(failure: engine::Failure) -> Self {
        match failure {
            engine::Failure::OutsideDomain(_) => Self::OutsideDomain,
            engine::Failure::Rounding | engine::Failure::BeginAgain => Self::AccuracyNotReached,
            _ => Self::NotConverged,
        }
    }
}

impl Windows {
    /// A run to be made many times.
    pub(crate) fn windows(self, problem: &Problem, output: Output, setting: Setting) -> Prepared<'_> {
        let Problem { space: geometry, start, length, .. } = problem;
        let Setting { count, tolerance } = setting;
        let accurate = |accuracy| Engine::accurate(geometry, start, *length, accuracy);
        let engine = match self {
            Self::Gauss { stages } => Engine::gauss(geometry, start, *length, count, stages, tolerance),
            Self::Equal(points) => Engine::lobatto(geometry, start, *length, count, points, tolerance),
            Self::Accuracy => accurate(Accuracy::Promised(tolerance)),
            Self::Tolerance => accurate(Accuracy::Local(tolerance)),
        };
        let Ok(mut engine) = engine else { return Box::new(|| Err(Failure::OutsideDomain)) };
        Box::new(move || self.run_over(problem, &mut engine, &output, count))
    }

    /// True if windows have one length.
    fn is_equal(self) -> bool {
        matches!(self, Self::Gauss { .. } | Self::Equal(_))
    }

    fn run_over(
        self,
        Problem { space: geometry, start, length, .. }: &Problem,
        engine: &mut Engine<'_>,
        output: &Output,
        count: usize,
    ) -> Result<Trajectory, Failure> {
        engine.rewind();
        let mut marks = output.gamma(*length).peekable();
        // Where windows have one length, the places of the points are known without rounding.
        let mut places = self.is_equal().then(|| output.places(count));
        let (mut q, mut p) = (start.q.clone(), start.p.clone());
        let mut momenta: Vec<f64> = geometry.active().iter().map(|&a| p[a]).collect();
        let mut states = States::new(q.len(), output.marks.len());
        let mut windows = 0;
        // What is certified is the whole run.
        while !self.is_equal() || states.len() < output.marks.len() {
            let mut window = match engine.next() {
                Ok(Some(window)) => window,
                Ok(None) => break,
                Err(engine::Failure::BeginAgain) => {
                    engine.begin_again();
                    states.clear();
                    marks = output.gamma(*length).peekable();
                    continue;
                }
                Err(failure) => return Err(failure.into()),
            };
            if self == Self::Accuracy && !window.gradient_norm().is_some_and(f64::is_finite) {
                return Err(Failure::Diverged);
            }
            windows = window.index + 1;
            let (from, end, mut dense) = (window.gamma, window.gamma + window.length, None);
            while let Some(fraction) = match &mut places {
                Some(places) => places.next_if(|place| place.0 == window.index).map(|place| place.1),
                None => {
                    let mark = marks.next_if(|&mark| mark <= end || end >= *length);
                    mark.map(|mark| ((mark - from) / window.length).min(1.0))
                }
            } {
                dense.get_or_insert_with(|| window.dense()).at(fraction, &mut q, &mut momenta);
                if q.iter().chain(&momenta).any(|value| !value.is_finite()) {
                    return Err(Failure::Diverged);
                }
                geometry.active().iter().zip(&momenta).for_each(|(&a, momentum)| p[a] = *momentum);
                states.push(&q, &p);
            }
        }
        let (points, nodes_per_step) = match self {
            Self::Gauss { stages } => (stages, 1),
            Self::Equal(points) => (points, points),
            _ => (POINTS, POINTS),
        };
        Ok(Trajectory { states, evaluations: engine.sweeps() * points, steps: windows * nodes_per_step })
    }
}

impl Peer for Windows {
    fn about(&self) -> About {
        let about =
            |name, curve, order, step| About { order, coarsest: 0.05, ..About::new(name, curve, step, "this program") };
        match self {
            Self::Gauss { stages } => About {
                source: "Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231",
                ..about(format!("Gauss {stages}"), "Gauss–Legendre", Some(2 * stages), Step::Iterated)
            },
            Self::Equal(points) => {
                about(format!("GLL{points} march"), "GLL march (library)", Some(2 * points - 2), Step::Iterated)
            }
            Self::Accuracy => about("accuracy".to_owned(), "accuracy", None, Step::Adaptive),
            Self::Tolerance => about("tolerance".to_owned(), "tolerance", None, Step::Adaptive),
        }
    }

    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        self.windows(problem, output.clone(), setting)()
    }

    fn prepared<'p>(&'p self, problem: &'p Problem, output: Output, setting: Setting) -> Prepared<'p> {
        self.windows(problem, output, setting)
    }
}
