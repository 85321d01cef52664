//! The pictures of `--plot`, many of them as in the paper, from solutions, their diagnostics and a reference.

mod look;
pub mod scene;
mod stability;
mod work_precision;

pub use stability::{last_node, sawtooth_onset, stability_map};
pub use work_precision::{WorkAxis, drift, work_precision};

use super::chart::{Chart, Ink, Mark, Scale, Series};
use crate::case::Form;
use crate::diagnostics::Diagnostics;
use crate::geometry::Start;
use crate::number::Real;
use crate::reference::{ReferenceTrajectory, TimeState};
use crate::solve::Solution;
use crate::study::convergence::{Convergence, Slope};

/// Number of points at which a continuous curve, such as the reference, is drawn.
const CURVE_POINTS: usize = 400;

/// A solved case, with its label in the legend.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a, S: Real = f64> {
    /// Entry in the legend. It may be empty if there is only one run.
    pub label: &'a str,
    /// The solution.
    pub solution: &'a Solution<S>,
    /// Its diagnostics.
    pub diagnostics: &'a Diagnostics<S>,
}

impl<S: Real> Run<'_, S> {
    fn against_gamma(&self, values: impl Iterator<Item = S>) -> Vec<(f64, f64)> {
        self.solution.gamma().zip(values).map(|(gamma, value)| (gamma.to_f64(), value.to_f64())).collect()
    }

    fn named(&self, what: &str) -> String {
        if self.label.is_empty() { what.to_owned() } else { format!("{what}, {}", self.label) }
    }
}

/// t(γ) and x(γ); for a solution of the doubled system both branches.
pub fn world_line<S: Real>(of: &str, solution: &Solution<S>) -> Chart {
    let curve = |label: &str, mark: Mark, values: &mut dyn Iterator<Item = S>| {
        let points = solution.gamma().zip(values).map(|(gamma, value)| (gamma.to_f64(), value.to_f64()));
        Series::new(label, mark, points.collect())
    };
    let [t, x] = if solution.is_doubled() { ["t_1(γ)", "x_1(γ)"] } else { ["t(γ)", "x(γ)"] };
    let forward = [t, x].into_iter().enumerate();
    let mut series: Vec<Series> =
        forward.map(|(a, label)| curve(label, Mark::LineAndPoints, &mut solution.q(a))).collect();
    for (a, label) in ["t_2(γ)", "x_2(γ)"].into_iter().enumerate() {
        series.extend(solution.backward(a).map(|mut row| curve(label, Mark::Points, &mut row)));
    }
    Chart {
        title: "Time t and place x along the world-line".to_owned(),
        subtitle: of.to_owned(),
        x_label: "γ".to_owned(),
        y_label: "t, x".to_owned(),
        series,
        ..Chart::default()
    }
}

/// dt/dγ on the nodes: the time mesh that emerges. At the last node of a window in the strong form it is the value with
/// which the next window starts; the value of Dt there shows in the picture of ΔQ_t.
pub fn time_mesh<S: Real>(of: &str, runs: &[Run<'_, S>]) -> Chart {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    let mut series = Vec::new();
    for run in runs {
        let tangent = run.diagnostics.tangent(run.solution);
        let what = match run.solution.form {
            Form::Strong => "(Dt)(γ)",
            Form::Weak => "(D̄t)(γ)",
        };
        let points = run.against_gamma(tangent[0].iter().copied());
        (least, most) = points.iter().fold((least, most), |(least, most), p| (least.min(p.1), most.max(p.1)));
        series.push(Series::new(run.named(what), Mark::LineAndPoints, points));
    }
    let title = if least > 0.0 && most > 1.005 * least {
        format!("The time mesh: steps in t differ by a factor of {:.2}", most / least)
    } else {
        "The time mesh: dt/dγ".to_owned()
    };
    Chart {
        title,
        subtitle: of.to_owned(),
        x_label: "γ".to_owned(),
        y_label: "dt/dγ".to_owned(),
        series,
        ..Chart::default()
    }
}

/// x(t): the nodes, the reference geodesic and the motion with time as its parameter.
pub fn trajectory<S: Real>(
    of: &str,
    runs: &[Run<'_, S>],
    reference: Option<&ReferenceTrajectory>,
    time_parametrised: &[TimeState],
) -> Chart {
    let mut series = Vec::new();
    if let Some(first) = runs.first().map(|run| run.solution) {
        let t_i = first.t_i().to_f64();
        if let Some(reference) = reference {
            let at = |k: usize| reference.at(first.length.to_f64() * k as f64 / (CURVE_POINTS - 1) as f64);
            let place = |point: Start| (t_i + point.q[0], point.q[1]);
            let points = (0..CURVE_POINTS).map(at).map(place).collect();
            series.push(Series::new("geodesic (reference)", Mark::Line, points));
        }
        let points = time_parametrised.iter().map(|state| (t_i + state.elapsed, state.x)).collect();
        series.push(Series::new("x(t) with time as parameter", Mark::Dashed, points).with_ink(Ink::Neutral));
    }
    for run in runs {
        let points = run.solution.t().zip(run.solution.x()).map(|(t, x)| (t.to_f64(), x.to_f64())).collect();
        series.push(Series::new(run.named("nodes"), Mark::Points, points));
    }
    Chart {
        title: "Where the nodes lie on the trajectory x(t)".to_owned(),
        subtitle: of.to_owned(),
        x_label: "t".to_owned(),
        y_label: "x".to_owned(),
        series,
        ..Chart::default()
    }
}

/// |ΔQ_t| on the nodes. A single run of the strong form has also the value at the last node with the multiplier
/// correction; at all other nodes the two agree.
pub fn noether_charge<S: Real>(of: &str, runs: &[Run<'_, S>]) -> Chart {
    let mut series = Vec::new();
    for run in runs {
        let charge = &run.diagnostics.charges[0];
        let points = run.against_gamma(charge.delta.iter().map(|v| v.abs()));
        series.push(Series::new(run.named("|ΔQ_t|"), Mark::Points, points));
        let corrected = run.solution.multipliers().and(charge.corrected.last());
        if let ([_], Some(corrected)) = (runs, corrected) {
            let last = vec![(run.solution.gamma_f().to_f64(), corrected.to_f64().abs())];
            series.push(Series::new("last node, with + λ_7/H_N", Mark::Points, last));
        }
    }
    residual_chart("How far the charge Q_t is from its initial value", of, "|ΔQ_t|", series)
}

/// |ΔG^t| and |ΔG^x| on the nodes.
pub fn geodesic_residuals<S: Real>(of: &str, runs: &[Run<'_, S>]) -> Chart {
    let mut series = Vec::new();
    for run in runs {
        for (label, values) in ["|ΔG^t|", "|ΔG^x|"].into_iter().zip(&run.diagnostics.delta_g) {
            let points = run.against_gamma(values.iter().map(|v| v.abs()));
            series.push(Series::new(run.named(label), Mark::Points, points));
        }
    }
    residual_chart("How far the nodes are from the discrete geodesic equations", of, "|ΔG|", series)
}

fn residual_chart(title: &str, of: &str, y_label: &str, series: Vec<Series>) -> Chart {
    Chart {
        title: title.to_owned(),
        subtitle: of.to_owned(),
        x_label: "γ".to_owned(),
        y_label: y_label.to_owned(),
        y_scale: Scale::Log,
        series,
        ..Chart::default()
    }
}

/// With more schemes than this in one picture, the legend gives the fits and they are not drawn as lines.
const MOST_FITTED: usize = 4;

/// The errors of these slopes against Δγ with their fits, and dotted lines of each operator's order.
pub fn errors<S>(of: &str, convergence: &Convergence<S>, slopes: &[Slope]) -> Chart {
    let mut series = Vec::new();
    let mut guides: Vec<(i32, (f64, f64), f64)> = Vec::new();
    let crowded = slopes.len() > MOST_FITTED;
    for slope in slopes {
        let points: Vec<(usize, (f64, f64))> = (convergence.points.iter())
            .filter(|point| (point.sbp, point.form) == (slope.sbp, slope.form))
            .filter_map(|point| {
                let errors = point.errors.as_ref()?;
                Some((point.n_gamma, (point.delta_gamma, slope.quantity.of(errors))))
            })
            .collect();
        let all = points.iter().map(|&(_, place)| place).collect();
        let name = format!("{} {}", slope.scheme(), slope.quantity.symbol(&convergence.coordinates));
        let ink = Ink::Fixed(look::of_scheme(slope.sbp, slope.form));
        // x has filled symbols and t open ones.
        let is_time = slope.quantity.coordinate() == Some(0);
        if crowded {
            let fitted = slope.fit.as_ref().map_or(String::new(), |fit| format!(", slope {:.2}", fit.slope));
            let mark = if is_time { Mark::DashedAndOpenPoints } else { Mark::LineAndPoints };
            series.push(Series::new(name + &fitted, mark, all).with_ink(ink));
            continue;
        }
        let mark = if is_time { Mark::OpenPoints } else { Mark::Points };
        series.push(Series::new(name, mark, all).with_ink(ink));
        let Some((fit, (n_min, n_max))) = slope.fit.as_ref().zip(slope.n_range) else { continue };
        let in_range = points.iter().filter(|(n, _)| (n_min..=n_max).contains(n));
        let fitted: Vec<(f64, f64)> = in_range.map(|&(_, place)| place).collect();
        // The fitted line passes through the mean of the logarithms.
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| fitted.iter().map(f).sum::<f64>() / fitted.len() as f64;
        let (log_h, log_error) = (mean(&|p| p.0.ln()), mean(&|p| p.1.ln()));
        let line = |h: f64| (h, (log_error + fit.slope * (h.ln() - log_h)).exp());
        let ends = [fitted[0].0, fitted[fitted.len() - 1].0];
        let label = format!("slope {:.2}", fit.slope);
        series.push(Series::new(label, Mark::Dashed, ends.map(line).to_vec()).with_ink(Ink::Previous));
        // The global error has one order more than the boundary closure; at the end of the weak form the error has the
        // order of the interior.
        let boundary_order = slope.sbp.boundary_order() as i32;
        let at_weak_end = slope.form == Form::Weak && slope.quantity.is_at_end();
        let order = if at_weak_end { 2 * boundary_order } else { boundary_order + 1 };
        if guides.iter().all(|(known, ..)| *known != order) {
            guides.push((order, fitted[fitted.len() - 1], ends[0]));
        }
    }
    for (order, (h, error), coarsest) in guides {
        // A factor of four below the data, so that the guide can be told from the fit.
        let points = vec![(h, error / 4.0), (coarsest, error / 4.0 * (coarsest / h).powi(order))];
        series.push(Series::new(format!("slope {order}"), Mark::Dotted, points).with_ink(Ink::Neutral));
    }
    Chart {
        title: "How errors fall with the step: the steeper, the higher the order".to_owned(),
        subtitle: of.to_owned(),
        x_label: "step Δγ".to_owned(),
        y_label: "error".to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series,
        ..Chart::default()
    }
}
