//! The methods as the studies see them.

use super::composition::Composition;
use super::dop853::Dop853;
use super::driver::Task;
use super::radau5::Radau5;
use super::rk4::Rk4;
use super::{Failure, Output, Problem, Trajectory, taylor, windows};

/// Every method to compare with, in the order of tables and pictures.
pub const PEERS: [Peer; 13] = [
    Peer::Rk4,
    Peer::Verlet,
    Peer::KahanLi6,
    Peer::KahanLi8,
    Peer::KahanLi8Compensated,
    Peer::Gauss(2),
    Peer::Gauss(4),
    Peer::Gauss(6),
    Peer::Gauss(8),
    Peer::Gauss(12),
    Peer::Dop853,
    Peer::Radau5,
    Peer::Taylor,
];

/// A method to compare with, or windows of this program's own engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Peer {
    /// The classical Runge–Kutta method; between the ends of steps the cubics that fit states and derivatives there.
    Rk4,
    /// Störmer–Verlet (leapfrog), order 2.
    Verlet,
    /// The composition of order 6 in 9 stages by Kahan and Li.
    KahanLi6,
    /// The one of order 8 in 17 stages.
    KahanLi8,
    /// The same with compensated sums, which keep the rounding of a long run from piling up.
    KahanLi8Compensated,
    /// The Gauss–Legendre Runge–Kutta method, symplectic, symmetric and of order 2s, of so many stages s from 1 to 16.
    /// It is written for q̈ = a(q) as
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
    Gauss(usize),
    /// The explicit Runge–Kutta pair of order 8 by Dormand and Prince.
    ///
    /// Relative and absolute tolerance for positions and velocities or momenta. Quadratures are carried along outside
    /// the error norm, where they would only cost; between the ends of steps are the polynomials of degree 7 of the
    /// dense output.
    Dop853,
    /// Radau IIA of order 5, the implicit method for stiff problems.
    ///
    /// Relative and absolute tolerance for positions and velocities or momenta; quadratures are outside the error norm.
    /// Steps end on the points of output.
    Radau5,
    /// The world-line in `f64` by series whose last terms are below the first by the tolerance, at the order that is
    /// cheapest for it, and by their polynomials between the ends of steps.
    ///
    /// This is the program's reference, written for any number of digits and not for speed: heyoka, in
    /// `scripts/work-precision.py`, shows what a Taylor method can achieve.
    Taylor,
    /// The weak scheme of this program, without its tables in files, in windows of one length with so many nodes, from
    /// 2 to 24. The tolerance is that of sweeps, as for Gauss' method.
    Equal(usize),
    /// Its windows for an accuracy of the whole run, certified, with an estimate of their error.
    Accuracy,
    /// Its windows for a tolerance of each of them.
    Tolerance,
}

impl Peer {
    /// Its description.
    pub fn about(self) -> About {
        let about = |name: &str, curve, order, step, source| About {
            name: name.to_owned(),
            curve,
            order,
            step,
            has_dense_output: true,
            needs_second_order: false,
            coarsest: 1.0,
            source,
        };
        let composed = |name, curve, order, coarsest, source| About {
            has_dense_output: false,
            needs_second_order: true,
            coarsest,
            ..about(name, curve, Some(order), Step::Constant, source)
        };
        let kahan_li = |name, order| composed(name, "Kahan–Li", order, 0.25, "Kahan, Li, Math. Comp. 66 (1997) 1089");
        let own = |name: &str, curve, order, step| About { coarsest: 0.05, ..about(name, curve, order, step, OWN) };
        match self {
            Self::Rk4 => about("RK4", "RK4", Some(4), Step::Constant, "Kutta, Z. Math. Phys. 46 (1901) 435"),
            Self::Verlet => {
                let source = "Hairer, Lubich, Wanner, Acta Numerica 12 (2003) 399";
                composed("Verlet", "Verlet", 2, 1.0, source)
            }
            Self::KahanLi6 => kahan_li("Kahan-Li 6", 6),
            Self::KahanLi8 => kahan_li("Kahan-Li 8", 8),
            Self::KahanLi8Compensated => kahan_li("Kahan-Li 8 compensated", 8),
            Self::Gauss(stages) => About {
                source: "Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231",
                ..own(&format!("Gauss {stages}"), "Gauss", Some(2 * stages), Step::Iterated)
            },
            Self::Dop853 => {
                let source = "Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, II.5";
                about("DOP853", "DOP853", Some(8), Step::Adaptive, source)
            }
            Self::Radau5 => {
                let source = "Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8";
                let about = about("Radau5", "Radau5", Some(5), Step::Adaptive, source);
                About { has_dense_output: false, ..about }
            }
            Self::Taylor => about("Taylor", "Taylor", None, Step::Adaptive, "Jorba, Zou, Exp. Math. 14 (2005) 99"),
            Self::Equal(points) => {
                let order = Some(2 * points - 2);
                own(&format!("GLL{points} march"), "march", order, Step::Iterated)
            }
            Self::Accuracy => own("accuracy", "accuracy", None, Step::Adaptive),
            Self::Tolerance => own("tolerance", "tolerance", None, Step::Adaptive),
        }
    }

    /// Its name in files.
    pub fn name(self) -> String {
        self.about().name
    }

    /// A setting for display.
    pub fn label(self, Setting { count, tolerance }: Setting) -> String {
        match self.about().step {
            _ if self == Self::Taylor => format!("order={} tol={tolerance:e}", taylor::digits_and_order(tolerance).1),
            Step::Adaptive => format!("tol={tolerance:e}"),
            Step::Iterated if tolerance > 0.0 => format!("steps={count} tol={tolerance:e}"),
            _ => format!("steps={count}"),
        }
    }

    /// Why it suits no scene that is not separable, if it does not.
    pub fn unsuitable(self, is_separable: bool) -> Option<&'static str> {
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
    pub fn run(self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        let task = Task { problem, output, setting };
        match self {
            Self::Rk4 => task.run(&Rk4),
            Self::Verlet => task.run(&Composition::VERLET),
            Self::KahanLi6 => task.run(&Composition::KAHAN_LI_6),
            Self::KahanLi8 => task.run(&Composition::KAHAN_LI_8),
            Self::KahanLi8Compensated => task.run(&Composition::KAHAN_LI_8_COMPENSATED),
            Self::Dop853 => task.run(&Dop853),
            Self::Radau5 => task.run(&Radau5),
            Self::Taylor => taylor::run(&task),
            Self::Gauss(_) | Self::Equal(_) | Self::Accuracy | Self::Tolerance => {
                self.prepared(problem, output.clone(), setting)()
            }
        }
    }

    /// The same run, to be made many times: what it needs beforehand is kept.
    pub fn prepared(self, problem: &Problem, output: Output, setting: Setting) -> Prepared<'_> {
        match self {
            Self::Gauss(_) | Self::Equal(_) | Self::Accuracy | Self::Tolerance => {
                windows::prepared(self, problem, output, setting)
            }
            _ => Box::new(move || self.run(problem, &output, setting)),
        }
    }
}

/// A run that can be made again and again.
pub type Prepared<'p> = Box<dyn FnMut() -> Result<Trajectory, Failure> + 'p>;

/// The source of what is described in these pages alone.
const OWN: &str = "this program";

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
}
