//! A solved window, which is lent to whoever pulls it, and what its end hands on to a run that continues this one: with
//! that it has the digits of one run.

use std::ops::{Deref, DerefMut};

use serde::{Deserialize, Serialize};

use super::dense::Dense;
use super::rule::Order;
use super::sensitivity::Sensitivity;
use super::window::Solver;
use crate::number::Compensated;

/// The state at the start or the end of a window, in sums that lose nothing.
#[derive(Debug, Clone, Default)]
pub struct State {
    /// q^a of all coordinates.
    pub(crate) q: Vec<Compensated<f64>>,
    /// p_a of active coordinates.
    pub(crate) p: Vec<Compensated<f64>>,
}

/// A function of a state.
pub type OfState<'f> = &'f mut dyn FnMut(&State) -> f64;

impl State {
    /// q^a of all coordinates, rounded.
    pub fn positions(&self) -> Vec<f64> {
        self.q.iter().map(|q| q.high).collect()
    }

    /// p_a of active coordinates, rounded.
    pub fn momenta(&self) -> Vec<f64> {
        self.p.iter().map(|p| p.high).collect()
    }
}

/// A solved window, which is lent until the next one is solved.
///
/// [`Engine::equal`](super::Engine::equal) walks windows of one length, [`Engine::accurate`](super::Engine::accurate)
/// chooses the lengths, and [`Engine::gauss`](super::Engine::gauss) takes steps of Gauss' method.
///
/// ```
/// use std::ops::ControlFlow;
/// use std::sync::Arc;
///
/// use geodesic_ivp::engine::{Accuracy, Engine, POINTS};
/// use geodesic_ivp::geometry::{Geometry, GeometryText, Law, Start};
///
/// let text = GeometryText::of_potential(&["x"], "x^4/2", Law::Relativistic);
/// let geometry: Arc<Geometry> = Geometry::of_x(&text)?.into(); // the coordinates are t and x, and only x is active
/// let (q, q_dot) = (vec![0.0, 1.0], vec![1.0, 0.1]);
/// let start = Start { p: geometry.momenta(&q, &q_dot), q, q_dot };
///
/// let mut engine = Engine::equal(&geometry, &start, 1.0, 2, 16)?;
/// while let Some(mut window) = engine.next()? {
///     // Ten points inside for next to nothing, and the proof that it is a critical point.
///     let (dense, mut q, mut p) = (window.dense(), [0.0; 2], [0.0]);
///     (1..=10).for_each(|k| dense.at(f64::from(k) / 10.0, &mut q, &mut p));
///     assert!(window.gradient_norm().is_some_and(|norm| norm < 1e-13));
/// }
/// assert!((engine.window().end().positions()[1] - 0.159_778_018_885_407).abs() < 1e-14);
///
/// let mut engine = Engine::accurate(&geometry, &start, 1.0, Accuracy::Promised(1e-10))?;
/// let mut x = 0.0;
/// engine.run(|window| {
///     x = window.end().positions()[1];
///     ControlFlow::Continue(())
/// })?;
/// assert!((x - 0.159_778_018_885_407).abs() < 1e-10 && engine.error_estimate() < Some(1e-10));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Window<'w> {
    /// Its place in the run.
    pub index: usize,
    /// γ at its start, from the start of the run.
    pub gamma: f64,
    /// Its length h.
    pub length: f64,
    /// True if the run ends with it.
    pub is_last: bool,
    /// The number of sweeps over it.
    pub sweeps: usize,
    pub(super) solved: &'w mut (dyn Solved + 'w),
}

/// The nodes of a solved window.
pub trait WindowNodes {
    /// Number n of nodes.
    fn points(&self) -> usize;
    /// Their places, as fractions of the window.
    fn fractions(&self) -> &[f64];
    /// q^a on the nodes; of an ignorable coordinate from the start of the window.
    fn q(&self, a: usize) -> &[f64];
    /// p_a on the nodes, by place among the active coordinates.
    fn p(&self, place: usize) -> &[f64];
}

/// A solved window of rules of any width.
pub trait Solved {
    /// The state at its start.
    fn start(&self) -> &State;
    /// The state at its end.
    fn end(&self) -> &State;
    /// Its nodes, of which some values are computed when they are first asked for.
    fn nodes(&mut self) -> &dyn WindowNodes;
    /// The motion over it.
    fn dense(&self) -> Dense;
    /// The values that its end hands on to a run that continues this one.
    fn handed(&self) -> Handed;
    /// The largest entry of the gradient of its action. `None` for steps of Gauss' method, which are critical points of
    /// no action.
    fn gradient_norm(&mut self) -> Option<f64>;
    /// Carries a sensitivity from its start to its end.
    fn carry(&mut self, sensitivity: &mut Sensitivity);
}

impl Window<'_> {
    /// Carries a sensitivity from its start to its end; with the first window it begins.
    pub fn carry(&mut self, sensitivity: &mut Sensitivity) {
        if self.index == 0 {
            sensitivity.begin();
        }
        if !sensitivity.is_empty() {
            self.solved.carry(sensitivity);
        }
    }
}

impl<'w> Deref for Window<'w> {
    type Target = dyn Solved + 'w;

    fn deref(&self) -> &Self::Target {
        self.solved
    }
}

impl DerefMut for Window<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        self.solved
    }
}

/// The rounding errors of the numbers at the end of a run, and the state of the march there.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Handed {
    /// The rounding errors of q^a of all coordinates and of p_a of active ones; nothing where they are not known.
    pub q_low: Vec<f64>,
    /// The same of p_a.
    pub p_low: Vec<f64>,
    /// The march.
    pub march: Option<Marched>,
}

/// The state of a march: the unknowns that are not among q and p, the sizes that changes are compared with, and the
/// slopes that its next first guess continues.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Marched {
    /// The length of its last window.
    pub length: f64,
    /// Velocities where these are unknowns, each with what rounding took from it.
    pub velocities: Vec<[f64; 2]>,
    /// 1/size of every unknown, and of its slope.
    pub inverse_sizes: Vec<[f64; 2]>,
    /// Where ignorable coordinates began, and 1/size of their ways.
    pub ways: Vec<[f64; 2]>,
    /// Slopes on the nodes.
    pub slopes: Vec<Vec<f64>>,
}

impl<const N: usize> Solver<'_, N> {
    /// Goes to the start of a run that continues another one. Returns true if the slopes of a window like those of this
    /// run, of this length, are known.
    pub(super) fn resume(&mut self, handed: &Handed, length: f64) -> bool {
        let m = self.geometry.active().len();
        let State { q, p } = &mut self.end;
        for (sums, lows) in [(q, &handed.q_low), (p, &handed.p_low)] {
            sums.iter_mut().zip(lows).for_each(|(sum, &low)| sum.low = low);
        }
        for (row, &a) in self.rows.iter_mut().zip(self.geometry.active()) {
            row.end = self.end.q[a];
        }
        let is_second = self.system.order == Order::Second;
        if !is_second {
            self.rows[m..].iter_mut().zip(&self.end.p).for_each(|(row, &p)| row.end = p);
        }
        let fits = |march: &&Marched| march.slopes.is_empty() || march.slopes.len() == self.system.iterated();
        let Some(march) = handed.march.as_ref().filter(fits) else {
            self.advance();
            return false;
        };
        if is_second {
            for (row, &[high, low]) in self.rows[m..].iter_mut().zip(&march.velocities) {
                row.end = Compensated { high, low };
            }
        }
        let is_same = !march.slopes.is_empty()
            && march.length == length
            && march.slopes.iter().all(|row| row.len() == self.rule.points());
        if is_same {
            for (k, (slopes, sizes)) in march.slopes.iter().zip(&march.inverse_sizes).enumerate() {
                self.rows[k].size.inverse = sizes[0];
                if is_second {
                    self.rows[m + k].size.inverse = sizes[1];
                }
                self.rows[k].slopes_before.0[..slopes.len()].copy_from_slice(slopes);
            }
            for (way, &[origin, inverse]) in self.ways.iter_mut().zip(&march.ways) {
                (way.origin, way.inverse) = (origin, inverse);
            }
        }
        self.advance();
        is_same
    }
}
