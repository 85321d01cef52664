//! The *atlas*: where methods fail. Every scheme of this program, and other methods, are run with many steps and over
//! many lengths of the world-line of a case or of a scene.
//!
//! A *cell* is one method on one grid. Its status is found by measurement against a reference trajectory; for the rules
//! and their thresholds see [`status`]. Exact conservation of a charge says nothing about the trajectory, and is only
//! reported. The [`Limit`] of linear theory is computed from the coefficients of the operators, to compare with.
//!
//! The length of the world-line is varied by γ_f, by ṫ_i, or by both. A larger ṫ_i stretches the whole tangent: ẋ_i
//! grows with it, and dx/dt is kept. As γ is only a parameter, that makes the world-line longer over the same range of
//! γ. In a scene only γ_f is varied: a one-form or a force tells one tangent from another, and there may be no t. The
//! step is the spacing Δγ of the nodes, and their mean spacing for spectral elements. Adaptive methods have a tolerance
//! instead, and the Δγ that results from it.

mod arena;
mod limit;
mod run;
pub mod status;

use rayon::prelude::*;

pub use super::method::Method;
pub use arena::{Arena, Pace};
pub use limit::Limit;
pub use status::{ACCURATE, CellStatus, DIVERGED, DRIFTING, ROUGHER, SAWTOOTH};

use self::run::Job;
use self::status::Sizes;

/// Number of intervals of each window of a finite-difference operator that is run in windows; it has one node more.
pub const WINDOW: usize = 20;

/// Tolerances of adaptive methods.
pub const TOLERANCES: [f64; 6] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8];

/// The plan of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The methods, in the order of the files.
    pub methods: Vec<Method>,
    /// γ_f − γ_i.
    pub lengths: Vec<f64>,
    /// The tangent at the start in units of the case's own; 1 in scenes.
    pub tangents: Vec<f64>,
    /// Δγ of constant steps.
    pub spacings: Vec<f64>,
}

/// The numbers that were measured on a result.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Numbers {
    /// max |ΔK|.
    pub delta_k_max: f64,
    /// The largest difference of ½mv² + V from its charge, in a scene that is the lift of Newton's law.
    pub delta_energy_max: Option<f64>,
    /// max |Δp_a| of every charge, in the order of the ignorable coordinates, over the nodes where it is exact; `None`
    /// for methods that have the charges as parameters.
    pub charges: Option<Vec<f64>>,
    /// Largest error of every coordinate over all nodes; `None` if the reference does not reach the last of them.
    pub errors: Option<Vec<f64>>,
    /// Amplitude of the (−1)^k component of x; of the active coordinates of a scene that of the one where it is largest
    /// relative to its size. `None` if the nodes are not equidistant.
    pub sawtooth: Option<f64>,
    /// γ − γ_i at which this amplitude first exceeds the threshold of the status, in any active coordinate.
    pub sawtooth_from: Option<f64>,
    /// Δp_a at the last node, and with the multiplier correction, of every charge (strong form, one block).
    pub last_node: Option<Vec<[f64; 2]>>,
}

/// One method on one grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The method.
    pub method: Method,
    /// The Δγ that was asked for, or the tolerance.
    pub setting: f64,
    /// Number of distinct nodes of all windows, or of steps plus one; `None` for an adaptive method that failed.
    pub n_gamma: Option<usize>,
    /// γ_f − γ_i.
    pub gamma_f: f64,
    /// ṫ_i, if there is a coordinate t.
    pub t_dot: Option<f64>,
    /// The tangent at the start in units of the case's own.
    pub tangent: f64,
    /// The actual Δγ times the largest local frequency along the reference.
    pub delta_gamma_omega: Option<f64>,
    /// Its outcome.
    pub status: CellStatus,
    /// The measures, if there is a result.
    pub numbers: Option<Numbers>,
    /// Number of iterations; `None` for methods that do not iterate.
    pub iterations: Option<usize>,
    /// Seconds, while other cells are computed in parallel.
    pub seconds: f64,
}

impl Cell {
    /// The length of the world-line in the parameter of the case: γ_f − γ_i, times the tangent in units of the case's
    /// own.
    pub fn length(&self) -> f64 {
        self.gamma_f * self.tangent
    }
}

/// The measured map.
#[derive(Debug, Clone, PartialEq)]
pub struct Atlas {
    /// Method by method, length by length, from fine to coarse.
    pub cells: Vec<Cell>,
    /// True if it is not complete.
    pub interrupted: bool,
}

impl Atlas {
    /// The atlas of these cells, each given with its index in the order.
    pub fn gathered(mut cells: Vec<(usize, Cell)>, interrupted: bool) -> Self {
        cells.sort_by_key(|(place, _)| *place);
        Self { interrupted, cells: cells.into_iter().map(|(_, cell)| cell).collect() }
    }
}

impl Plan {
    /// Number of grids that will be tried.
    pub fn grids(&self) -> usize {
        self.jobs().len()
    }

    fn jobs(&self) -> Vec<Job> {
        let mut jobs = Vec::new();
        for method in &self.methods {
            let settings = if method.is_adaptive() { TOLERANCES.as_slice() } else { &self.spacings };
            for &length in &self.lengths {
                for &tangent in &self.tangents {
                    for &setting in settings {
                        jobs.push(Job { method: method.clone(), length, tangent, setting });
                    }
                }
            }
        }
        jobs
    }
}

/// Measures all cells. `tried` is called after each grid, with its index in the order and its cell, if there is one.
pub fn measure(arena: &Arena, plan: &Plan, tried: &(dyn Fn(usize, Option<&Cell>) + Sync)) -> Atlas {
    let jobs = plan.jobs();
    let mut lengths: Vec<f64> = jobs.iter().map(Job::stretched).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    let sizes: Vec<Option<Sizes>> = lengths.par_iter().map(|&length| arena.sizes(length)).collect();
    let sizes_of = |length: f64| lengths.iter().position(|&known| known == length).and_then(|at| sizes[at].as_ref());
    let mut order: Vec<(usize, Job)> = jobs.into_iter().enumerate().collect();
    // The largest cells are started first, so that no core is still busy with one when the others have finished.
    let size = |job: &Job| job.length / job.setting;
    order.sort_by(|(_, a), (_, b)| size(b).total_cmp(&size(a)));
    let cells = order.into_par_iter().with_max_len(1).filter_map(|(place, job)| {
        let cell = job.measure(arena, sizes_of(job.stretched()));
        tried(place, cell.as_ref());
        Some((place, cell?))
    });
    Atlas::gathered(cells.collect(), false)
}
