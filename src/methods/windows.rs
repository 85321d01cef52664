//! This program's own engine as a method among others: steps of Gauss' method, windows of one length, and windows as
//! long as an accuracy needs.

use super::peer::{About, Peer, PeerIn, Prepared, Setting, Step};
use super::{Driven, Failure, Marks, Output, Problem, SceneState, State, Trajectory};
use crate::engine::{self, Accuracy, Engine, POINTS, Window};
use crate::geometry::geodesic::InitialData;
use crate::geometry::metric::Metric;
use crate::geometry::{Geometry, Start};

/// The Gauss–Legendre Runge–Kutta method, symplectic, symmetric and of order 2s, as it is written for q̈ = a(q),
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

/// The weak scheme of this program, without its tables in files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Windows {
    /// Windows of one length with so many nodes, from 2 to 24. The tolerance is that of sweeps, as for [`Gauss`].
    Equal(usize),
    /// Windows for an accuracy of the whole run, certified, with an estimate of their error.
    Accuracy,
    /// Windows for a tolerance of each of them.
    Tolerance,
}

/// A space-time in which the engine runs.
trait Scene: Driven {
    /// The scene of a problem, and its start.
    fn scene(problem: &Problem<Self>) -> (&Geometry, Start);

    /// The state with q^a of all coordinates and p_a of active ones, in a run from that start.
    fn state_of(geometry: &Geometry, start: &Start, q: &[f64], p: &[f64]) -> Self::State;
}

impl Scene for Geometry {
    fn scene(problem: &Problem<Self>) -> (&Geometry, Start) {
        (&problem.space, problem.start.clone())
    }

    fn state_of(geometry: &Geometry, start: &Start, q: &[f64], active: &[f64]) -> SceneState {
        let mut p = start.p.clone();
        geometry.active().iter().zip(active).for_each(|(&a, &momentum)| p[a] = momentum);
        SceneState { q: q.to_vec(), p }
    }
}

impl Scene for Metric {
    fn scene(Problem { space, start, .. }: &Problem) -> (&Geometry, Start) {
        (space.scene(), InitialData { t: 0.0, ..*start }.start(space))
    }

    /// Without a potential x is ignorable, and its momentum a constant.
    fn state_of(_: &Geometry, start: &Start, q: &[f64], p: &[f64]) -> State {
        State { elapsed: q[0], x: q[1], w: -p.first().copied().unwrap_or(start.p[1]) }
    }
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
struct States<'s, G: Scene> {
    geometry: &'s Geometry,
    start: &'s Start,
    q: Vec<f64>,
    p: Vec<f64>,
    states: Vec<G::State>,
}

impl<'s, G: Scene> States<'s, G> {
    fn new(geometry: &'s Geometry, start: &'s Start, output: &Output) -> Self {
        let p = geometry.active().iter().map(|&a| start.p[a]).collect();
        Self { geometry, start, q: start.q.clone(), p, states: Vec::with_capacity(output.marks.len()) }
    }

    /// Takes in the state at these fractions of a window.
    fn see(&mut self, window: &Window<'_>, fractions: impl IntoIterator<Item = f64>) -> Result<(), Failure> {
        let mut dense = None;
        for fraction in fractions {
            dense.get_or_insert_with(|| window.dense()).at(fraction, &mut self.q, &mut self.p);
            if self.q.iter().chain(&self.p).any(|value| !value.is_finite()) {
                return Err(Failure::Diverged);
            }
            self.take();
        }
        Ok(())
    }

    fn take(&mut self) {
        self.states.push(G::state_of(self.geometry, self.start, &self.q, &self.p));
    }
}

/// So many windows of one length, of which each has so many points.
fn drive<G: Scene>(
    (geometry, start): (&Geometry, &Start),
    engine: &mut Engine<'_>,
    output: &Output,
    (count, points): (usize, usize),
) -> Result<Trajectory<G::State>, Failure> {
    let (mut marks, mut sweeps) = (Marks::new(output, count), 0);
    engine.rewind();
    let mut states = States::<G>::new(geometry, start, output);
    output.marks.iter().take_while(|&&mark| mark == 0).for_each(|_| states.take());
    marks.skip_start();
    let windows = Marks::last(output, count);
    for index in 0..windows {
        let window = engine.next()?.expect("there are as many windows");
        sweeps += window.sweeps;
        states.see(&window, std::iter::from_fn(|| marks.within(index)))?;
    }
    Ok(Trajectory { states: states.states, evaluations: sweeps * points, steps: windows })
}

/// Windows for an accuracy.
fn choose<G: Scene>(
    (geometry, start): (&Geometry, &Start),
    engine: &mut Engine<'_>,
    output: &Output,
    (length, is_certified): (f64, bool),
) -> Result<Trajectory<G::State>, Failure> {
    engine.rewind();
    let marks: Vec<f64> = output.gamma(length).collect();
    let mut states = States::<G>::new(geometry, start, output);
    let mut windows = 0;
    loop {
        let mut window = match engine.next() {
            Ok(Some(window)) => window,
            Ok(None) => break,
            Err(engine::Failure::BeginAgain) => {
                engine.begin_again();
                states.states.clear();
                continue;
            }
            Err(failure) => return Err(failure.into()),
        };
        if is_certified && !window.gradient_norm().is_some_and(f64::is_finite) {
            return Err(Failure::Diverged);
        }
        windows = window.index + 1;
        let (from, end, seen) = (window.gamma, window.gamma + window.length, states.states.len());
        let here = marks[seen..].iter().take_while(|&&mark| mark <= end || end >= length);
        states.see(&window, here.map(|mark| ((mark - from) / window.length).min(1.0)))?;
    }
    Ok(Trajectory { states: states.states, evaluations: engine.sweeps() * POINTS, steps: windows * POINTS })
}

impl<G: Scene> PeerIn<G> for Gauss {
    fn run(&self, problem: &Problem<G>, output: &Output, setting: Setting) -> Result<Trajectory<G::State>, Failure> {
        self.prepared(problem, output.clone(), setting)()
    }

    fn prepared<'p>(&'p self, problem: &'p Problem<G>, output: Output, setting: Setting) -> Prepared<'p, G> {
        let (geometry, start) = G::scene(problem);
        let Setting { count, tolerance } = setting;
        let engine = Engine::gauss(geometry, &start, problem.length, count, self.stages, tolerance);
        let Ok(mut engine) = engine else { return outside::<G>() };
        Box::new(move || drive::<G>((geometry, &start), &mut engine, &output, (count, self.stages)))
    }
}

impl<G: Scene> PeerIn<G> for Windows {
    fn run(&self, problem: &Problem<G>, output: &Output, setting: Setting) -> Result<Trajectory<G::State>, Failure> {
        self.prepared(problem, output.clone(), setting)()
    }

    fn prepared<'p>(&'p self, problem: &'p Problem<G>, output: Output, setting: Setting) -> Prepared<'p, G> {
        let ((geometry, start), length) = (G::scene(problem), problem.length);
        let Setting { count, tolerance } = setting;
        let engine = match *self {
            Self::Equal(points) => Engine::lobatto(geometry, &start, length, count, points, tolerance),
            Self::Accuracy => Engine::accurate(geometry, &start, length, Accuracy::Promised(tolerance), POINTS),
            Self::Tolerance => Engine::accurate(geometry, &start, length, Accuracy::Local(tolerance), POINTS),
        };
        let Ok(mut engine) = engine else { return outside::<G>() };
        Box::new(move || match *self {
            Self::Equal(points) => {
                let trajectory = drive::<G>((geometry, &start), &mut engine, &output, (count, points))?;
                Ok(Trajectory { steps: trajectory.steps * points, ..trajectory })
            }
            _ => choose::<G>((geometry, &start), &mut engine, &output, (length, *self == Self::Accuracy)),
        })
    }
}

/// For a start outside the domain.
fn outside<'p, G: Driven>() -> Prepared<'p, G> {
    Box::new(|| Err(Failure::OutsideDomain))
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

impl Peer for Windows {
    fn about(&self) -> About {
        let (name, curve, order, step) = match self {
            Self::Equal(points) => {
                (format!("GLL{points} march"), "GLL march (library)", Some(2 * points - 2), Step::Iterated)
            }
            Self::Accuracy => ("accuracy".to_owned(), "accuracy", None, Step::Adaptive),
            Self::Tolerance => ("tolerance".to_owned(), "tolerance", None, Step::Adaptive),
        };
        About {
            name,
            curve,
            order,
            step,
            has_dense_output: true,
            needs_second_order: false,
            coarsest: 0.05,
            source: "this program",
        }
    }
}
