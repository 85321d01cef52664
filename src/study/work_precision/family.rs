//! The methods of `work-precision` and their ranges of settings.

use std::f64::consts::SQRT_2;

use super::OUTPUTS;
use crate::case::{Form, SbpName};

/// A method with a range of settings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Family {
    /// This program: one block of a finite-difference operator over all nodes.
    Block(SbpName, Form),
    /// This program: the weak form on spectral elements with this many nodes, in windows.
    Elements(usize),
    /// The library of this program: the windows of the same scheme, without certificate and storage.
    March(usize),
    /// This program: windows chosen for an accuracy, which are handed over one by one.
    Accuracy,
    /// The classical Runge–Kutta method.
    Rk4,
    /// Störmer–Verlet.
    Verlet,
    /// The composition of order 6 by Kahan and Li.
    KahanLi6,
    /// The composition of order 8 by the same authors.
    KahanLi8,
    /// The composition of order 8 with compensated sums.
    KahanLi8Compensated,
    /// Gauss–Legendre with this many stages.
    Gauss(usize),
    /// Dormand–Prince of order 8.
    Dop853,
    /// Radau IIA of order 5.
    Radau5,
    /// The Taylor method of the reference in `f64`.
    Taylor,
    /// A method of this name that another program measured.
    Other(String),
}

/// A group of methods, which are drawn as one curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // As in `Family`.
pub enum Group {
    StrongBlocks,
    WeakBlocks,
    Elements,
    March,
    Accuracy,
    Rk4,
    Verlet,
    KahanLi,
    Gauss,
    Dop853,
    Radau5,
    Taylor,
    Other,
}

impl Group {
    /// Entry of the legend.
    pub fn label(self) -> &'static str {
        match self {
            Self::StrongBlocks => "SBP strong",
            Self::WeakBlocks => "SBP weak",
            Self::Elements => "GLL weak",
            Self::March => "GLL march (library)",
            Self::Accuracy => "accuracy",
            Self::Rk4 => "RK4",
            Self::Verlet => "Störmer–Verlet",
            Self::KahanLi => "Kahan–Li 6, 8",
            Self::Gauss => "Gauss–Legendre",
            Self::Dop853 => "DOP853",
            Self::Radau5 => "Radau IIA 5",
            Self::Taylor => "Taylor",
            Self::Other => "measured elsewhere",
        }
    }

    /// Whether it belongs to this program.
    pub fn is_own(self) -> bool {
        self <= Self::Accuracy
    }
}

/// One setting of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Number of steps, of windows, or of nodes minus one; 0 for adaptive methods. If the method has no dense output,
    /// see [`Family::has_dense_output`], it is a multiple of the number of intervals between points of output.
    pub(super) count: usize,
    /// The tolerance of an adaptive method, or of the iteration of an implicit one (0 if it iterates to rounding).
    pub(super) tolerance: f64,
}

impl Setting {
    pub(super) fn steps(count: usize) -> Self {
        Self { count, tolerance: 0.0 }
    }

    pub(super) fn tolerance(tolerance: f64) -> Self {
        Self { count: 0, tolerance }
    }

    pub(super) fn with_inner(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }
}

impl Family {
    /// Every method that is measured by default.
    pub fn all() -> Vec<Self> {
        let operators = [SbpName::Sbp21, SbpName::Sbp42, SbpName::Sbp63, SbpName::Sbp84];
        let blocks = operators.iter().flat_map(|&sbp| [Self::Block(sbp, Form::Strong), Self::Block(sbp, Form::Weak)]);
        let sizes = [4, 6, 8, 12, 16, 20, 24];
        let mut all: Vec<Self> = blocks.collect();
        all.extend(sizes.map(Self::Elements));
        all.extend(sizes.map(Self::March));
        all.extend([Self::Accuracy, Self::Rk4, Self::Verlet, Self::KahanLi6, Self::KahanLi8]);
        all.push(Self::KahanLi8Compensated);
        all.extend([2, 4, 6, 8, 12].map(Self::Gauss));
        all.extend([Self::Dop853, Self::Radau5, Self::Taylor]);
        all
    }

    /// The name in files.
    pub fn name(&self) -> String {
        match self {
            Self::Block(sbp, form) => format!("{sbp} {}", form.as_str()),
            Self::Elements(nodes) => format!("GLL{nodes} weak"),
            Self::March(nodes) => format!("GLL{nodes} march"),
            Self::Accuracy => "accuracy".to_owned(),
            Self::Rk4 => "RK4".to_owned(),
            Self::Verlet => "Verlet".to_owned(),
            Self::KahanLi6 => "Kahan-Li 6".to_owned(),
            Self::KahanLi8 => "Kahan-Li 8".to_owned(),
            Self::KahanLi8Compensated => "Kahan-Li 8 compensated".to_owned(),
            Self::Gauss(stages) => format!("Gauss {stages}"),
            Self::Dop853 => "DOP853".to_owned(),
            Self::Radau5 => "Radau5".to_owned(),
            Self::Taylor => "Taylor".to_owned(),
            Self::Other(name) => name.clone(),
        }
    }

    /// The curve it belongs to.
    pub fn group(&self) -> Group {
        match self {
            Self::Block(_, Form::Strong) => Group::StrongBlocks,
            Self::Block(_, Form::Weak) => Group::WeakBlocks,
            Self::Elements(_) => Group::Elements,
            Self::March(_) => Group::March,
            Self::Accuracy => Group::Accuracy,
            Self::Rk4 => Group::Rk4,
            Self::Verlet => Group::Verlet,
            Self::KahanLi6 | Self::KahanLi8 | Self::KahanLi8Compensated => Group::KahanLi,
            Self::Gauss(_) => Group::Gauss,
            Self::Dop853 => Group::Dop853,
            Self::Radau5 => Group::Radau5,
            Self::Taylor => Group::Taylor,
            Self::Other(_) => Group::Other,
        }
    }

    /// Whether it belongs to this program.
    pub fn is_own(&self) -> bool {
        self.group().is_own()
    }

    /// Whether its results are certified: it calls [`crate::solve()`] and not the library below that.
    pub fn is_certified(&self) -> bool {
        matches!(self, Self::Block(..) | Self::Elements(_) | Self::Accuracy)
    }

    /// Whether its iteration has a tolerance of its own.
    pub(super) fn has_inner_tolerance(&self) -> bool {
        matches!(self, Self::March(_) | Self::Gauss(_))
    }

    /// Whether its steps are chosen by a tolerance.
    pub(super) fn is_adaptive(&self) -> bool {
        matches!(self, Self::Accuracy | Self::Dop853 | Self::Radau5 | Self::Taylor)
    }

    /// Whether points of output may lie anywhere between the ends of its steps.
    pub(super) fn has_dense_output(&self) -> bool {
        matches!(self, Self::March(_) | Self::Gauss(_) | Self::Rk4)
    }

    /// Its settings, from cheap to expensive and without a last one for constant steps. The world-line takes `scale`
    /// Taylor steps of the reference, which are pieces of similar difficulty.
    pub(super) fn settings(&self, scale: f64) -> Box<dyn Iterator<Item = Setting>> {
        if self.is_adaptive() {
            return Box::new((2..=15).map(|digits| Setting::tolerance(10.0_f64.powi(-digits))));
        }
        // The number of steps per piece at the coarsest setting, and the factor from setting to setting.
        let (coarsest, factor) = match self {
            Self::Block(..) => (2.0, 2.0),
            Self::Rk4 | Self::Verlet => (1.0, SQRT_2),
            Self::KahanLi6 | Self::KahanLi8 | Self::KahanLi8Compensated => (0.25, SQRT_2),
            _ => (0.05, SQRT_2),
        };
        let unit = if self.has_dense_output() { 1 } else { OUTPUTS };
        let first = (coarsest * scale / unit as f64).max(1.0);
        let steps = (0..).map(move |k| unit * (first * f64::powi(factor, k)).round() as usize);
        let mut last = 0;
        Box::new(steps.filter(move |&steps| std::mem::replace(&mut last, steps) != steps).map(Setting::steps))
    }

    /// A setting for display.
    pub(super) fn label(&self, setting: &Setting) -> String {
        let Setting { count, tolerance } = *setting;
        let inner = if tolerance > 0.0 { format!(" tol={tolerance:e}") } else { String::new() };
        match self {
            Self::Block(..) => format!("N={}", count + 1),
            Self::Elements(_) | Self::March(_) => format!("windows={count}{inner}"),
            Self::Taylor => format!("order={} tol={tolerance:e}", taylor_order(tolerance)),
            _ if self.is_adaptive() => format!("tol={tolerance:e}"),
            _ => format!("steps={count}{inner}"),
        }
    }
}

/// The number of digits that a tolerance stands for.
pub(super) fn taylor_digits(tolerance: f64) -> u32 {
    (-tolerance.log10()).round().max(1.0) as u32
}

/// The order that is cheapest for a tolerance.
pub(super) fn taylor_order(tolerance: f64) -> usize {
    (1.15 * f64::from(taylor_digits(tolerance))).ceil() as usize + 2
}
