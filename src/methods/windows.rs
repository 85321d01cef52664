//! This program's own engine as a method among others: steps of Gauss' method, windows of one length, and windows as
//! long as an accuracy needs.

use super::peer::{About, Peer, Prepared, Setting, Step};
use super::{Failure, Marks, Output, Problem, States, Trajectory};
use crate::engine::{self, Accuracy, Engine, POINTS, Window};
use crate::geometry::{Geometry, Start};

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

/// The points of output of a run.
struct Points<'s> {
    geometry: &'s Geometry,
    /// q^a of all coordinates, p_a of the active ones, and p_a of all.
    q: Vec<f64>,
    momenta: Vec<f64>,
    p: Vec<f64>,
    states: States,
}

impl<'s> Points<'s> {
    fn new(geometry: &'s Geometry, start: &Start, output: &Output) -> Self {
        let momenta = geometry.active().iter().map(|&a| start.p[a]).collect();
        let states = States::new(start.q.len(), output.marks.len());
        Self { geometry, q: start.q.clone(), momenta, p: start.p.clone(), states }
    }

    /// Takes in the state at these fractions of a window.
    fn see(&mut self, window: &Window<'_>, fractions: impl IntoIterator<Item = f64>) -> Result<(), Failure> {
        let mut dense = None;
        for fraction in fractions {
            dense.get_or_insert_with(|| window.dense()).at(fraction, &mut self.q, &mut self.momenta);
            if self.q.iter().chain(&self.momenta).any(|value| !value.is_finite()) {
                return Err(Failure::Diverged);
            }
            self.take();
        }
        Ok(())
    }

    fn take(&mut self) {
        let Self { geometry, q, momenta, p, states } = self;
        geometry.active().iter().zip(momenta).for_each(|(&a, momentum)| p[a] = *momentum);
        states.push(q, p);
    }
}

/// So many windows of one length, of which each has so many points.
fn drive(
    (geometry, start): (&Geometry, &Start),
    engine: &mut Engine<'_>,
    output: &Output,
    (count, points): (usize, usize),
) -> Result<Trajectory, Failure> {
    let (mut marks, mut sweeps) = (Marks::new(output, count), 0);
    engine.rewind();
    let mut output_points = Points::new(geometry, start, output);
    output.marks.iter().take_while(|&&mark| mark == 0).for_each(|_| output_points.take());
    marks.skip_start();
    let windows = Marks::last(output, count);
    for index in 0..windows {
        let window = engine.next()?.expect("there are as many windows");
        sweeps += window.sweeps;
        output_points.see(&window, std::iter::from_fn(|| marks.within(index)))?;
    }
    Ok(Trajectory { states: output_points.states, evaluations: sweeps * points, steps: windows })
}

/// Windows for an accuracy.
fn choose(
    (geometry, start): (&Geometry, &Start),
    engine: &mut Engine<'_>,
    output: &Output,
    (length, is_certified): (f64, bool),
) -> Result<Trajectory, Failure> {
    engine.rewind();
    let marks: Vec<f64> = output.gamma(length).collect();
    let mut output_points = Points::new(geometry, start, output);
    let mut windows = 0;
    loop {
        let mut window = match engine.next() {
            Ok(Some(window)) => window,
            Ok(None) => break,
            Err(engine::Failure::BeginAgain) => {
                engine.begin_again();
                output_points.states.clear();
                continue;
            }
            Err(failure) => return Err(failure.into()),
        };
        if is_certified && !window.gradient_norm().is_some_and(f64::is_finite) {
            return Err(Failure::Diverged);
        }
        windows = window.index + 1;
        let (from, end, seen) = (window.gamma, window.gamma + window.length, output_points.states.len());
        let here = marks[seen..].iter().take_while(|&&mark| mark <= end || end >= length);
        output_points.see(&window, here.map(|mark| ((mark - from) / window.length).min(1.0)))?;
    }
    Ok(Trajectory { states: output_points.states, evaluations: engine.sweeps() * POINTS, steps: windows * POINTS })
}

impl Windows {
    /// A run to be made many times.
    pub(crate) fn windows(self, problem: &Problem, output: Output, setting: Setting) -> Prepared<'_> {
        let Problem { space: geometry, start, length, .. } = problem;
        let Setting { count, tolerance } = setting;
        let accurate = |accuracy| Engine::accurate(geometry, start, *length, accuracy, POINTS);
        let engine = match self {
            Self::Gauss { stages } => Engine::gauss(geometry, start, *length, count, stages, tolerance),
            Self::Equal(points) => Engine::lobatto(geometry, start, *length, count, points, tolerance),
            Self::Accuracy => accurate(Accuracy::Promised(tolerance)),
            Self::Tolerance => accurate(Accuracy::Local(tolerance)),
        };
        let Ok(mut engine) = engine else { return Box::new(|| Err(Failure::OutsideDomain)) };
        Box::new(move || match self {
            Self::Gauss { stages } => drive((geometry, start), &mut engine, &output, (count, stages)),
            Self::Equal(points) => {
                let trajectory = drive((geometry, start), &mut engine, &output, (count, points))?;
                Ok(Trajectory { steps: trajectory.steps * points, ..trajectory })
            }
            _ => choose((geometry, start), &mut engine, &output, (*length, self == Self::Accuracy)),
        })
    }
}

impl Peer for Windows {
    fn about(&self) -> About {
        let about = |name, curve, order, step| About {
            name,
            curve,
            order,
            step,
            has_dense_output: true,
            needs_second_order: false,
            coarsest: 0.05,
            source: "this program",
        };
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
