//! A method as the studies see it, and the list of all methods.

use std::fmt;

use super::{Composition, Dop853, Failure, Gauss, Output, Problem, Radau5, Rk4, Taylor, Trajectory};

/// Every method to compare with, in the order of tables and pictures.
pub static PEERS: [&dyn Peer; 13] = [
    &Rk4,
    &Composition::VERLET,
    &Composition::KAHAN_LI_6,
    &Composition::KAHAN_LI_8,
    &Composition::KAHAN_LI_8_COMPENSATED,
    &Gauss { stages: 2 },
    &Gauss { stages: 4 },
    &Gauss { stages: 6 },
    &Gauss { stages: 8 },
    &Gauss { stages: 12 },
    &Dop853,
    &Radau5,
    &Taylor,
];

/// A method to compare with.
pub trait Peer: Sync {
    /// Its description.
    fn about(&self) -> About;

    /// A setting for display.
    fn label(&self, Setting { count, tolerance }: Setting) -> String {
        match self.about().step {
            Step::Adaptive => format!("tol={tolerance:e}"),
            Step::Iterated if tolerance > 0.0 => format!("steps={count} tol={tolerance:e}"),
            _ => format!("steps={count}"),
        }
    }

    /// Why it suits no scene that is not separable, if it does not.
    fn unsuitable(&self, is_separable: bool) -> Option<&'static str> {
        const REASON: &str = "needs a scene that is separable: accelerations that depend on the positions only";
        (self.about().needs_second_order && !is_separable).then_some(REASON)
    }

    /// The world-line of `problem` in this setting, at the points of `output`.
    ///
    /// # Errors
    /// [`Failure`]; [`Failure::NotSeparable`] if the method needs equations of the second order and a scene has none.
    ///
    /// # Panics
    /// If it has no dense output, takes constant steps, and their number is no multiple of the intervals of `output`.
    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure>;

    /// The same run, to be made many times: what it needs beforehand is kept.
    fn prepared<'p>(&'p self, problem: &'p Problem, output: Output, setting: Setting) -> Prepared<'p> {
        Box::new(move || self.run(problem, &output, setting))
    }
}

/// A run that can be made again and again.
pub type Prepared<'p> = Box<dyn FnMut() -> Result<Trajectory, Failure> + 'p>;

impl dyn Peer + '_ {
    /// Its name in files.
    pub fn name(&self) -> String {
        self.about().name
    }
}

impl fmt::Debug for dyn Peer + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name())
    }
}

/// A method is its name.
impl PartialEq for dyn Peer {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for dyn Peer {}

/// The description of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// The name in files, which no other method has.
    pub name: String,
    /// Entry of the legend for the curve that it shares with its kin.
    pub curve: &'static str,
    /// Order at the ends of steps; `None` if the tolerance chooses it.
    pub order: Option<usize>,
    /// The rule by which its steps are chosen.
    pub step: Step,
    /// True if points of output may lie anywhere between the ends of its steps.
    pub has_dense_output: bool,
    /// True if it is for equations of the second order only, q̈ = a(q).
    pub needs_second_order: bool,
    /// With constant steps: how many for each Taylor step of the reference make its coarsest useful setting.
    pub coarsest: f64,
    /// Where it is described.
    pub source: &'static str,
}

impl About {
    /// A method with a dense output for equations of both orders.
    pub(super) fn new(name: impl Into<String>, curve: &'static str, step: Step, source: &'static str) -> Self {
        Self {
            name: name.into(),
            curve,
            order: None,
            step,
            has_dense_output: true,
            needs_second_order: false,
            coarsest: 1.0,
            source,
        }
    }
}

/// The rule by which the steps of a method are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// They have one length.
    Constant,
    /// They have one length, and an iteration with a tolerance of its own solves each of them.
    Iterated,
    /// A tolerance chooses them.
    Adaptive,
}

/// The step or the tolerance of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Number of steps; for schemes of this program that of windows, or of nodes minus one. 0 for adaptive methods.
    pub count: usize,
    /// The tolerance of an adaptive method, or of the iteration of an implicit one (0 if it iterates to rounding).
    pub tolerance: f64,
}

impl Setting {
    /// With so many steps.
    pub fn steps(count: usize) -> Self {
        Self { count, tolerance: 0.0 }
    }

    /// With a tolerance that chooses the steps.
    pub fn tolerance(tolerance: f64) -> Self {
        Self { count: 0, tolerance }
    }

    /// With the tolerance of an iteration.
    #[must_use]
    pub fn with_inner(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }
}
