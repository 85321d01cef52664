//! The pictures of the paper, which has t and x.

use crate::case::{Case, Form};
use crate::diagnostics::{Diagnostics, Extent};
use crate::number::Real;
use crate::output::chart::{Chart, Mark, Scale, Series, Style};
use crate::reference::{ReferenceTrajectory, time_parametrised};
use crate::solve::{Place, WorldLine};

/// Number of points at which the reference is drawn.
const CURVE_POINTS: usize = 400;

/// A picture of deviations along the world-line, on a logarithmic scale.
pub(super) fn deviations(title: &str, of: &str, y_label: &str, series: Vec<Series>) -> Chart {
    Chart { y_scale: Scale::Log, ..Chart::new(title, of, ["γ", y_label], series) }
}

/// Values at the nodes.
pub(super) fn at_nodes<S: Real>(line: &WorldLine<S>, values: impl IntoIterator<Item = S>) -> Vec<(f64, f64)> {
    line.gamma().zip(values).map(|(gamma, value)| (gamma.to_f64(), value.to_f64())).collect()
}

/// The sizes of deviations at the nodes.
pub(super) fn deviation<S: Real>(label: impl Into<String>, line: &WorldLine<S>, row: &[S]) -> Series {
    Series::new(label, Mark::POINTS, at_nodes(line, row.iter().map(|value| value.abs())))
}

/// The pictures of the paper.
pub(super) fn pictures_of_x<S: Real>(
    of: &str,
    case: &Case,
    line: &WorldLine<S>,
    diagnostics: &Diagnostics<S>,
) -> [Chart; 5] {
    // If the reference does not reach the end, the picture is drawn without it. For a line f64 is precise enough.
    let Place { geometry, start } = case.setup::<f64>().place;
    let reference = ReferenceTrajectory::new(&geometry, &start, line.length.to_f64(), f64::MOST_DIGITS).ok();
    let duration = (line.end_state().t - line.t_i()).to_f64();
    let in_time = time_parametrised(&geometry, &start, duration, CURVE_POINTS);
    [
        world_line(of, line),
        time_mesh(of, line, diagnostics),
        trajectory(of, line, reference.as_ref(), &in_time),
        noether_charge(of, line, diagnostics),
        geodesic_residuals(of, line, diagnostics),
    ]
}

/// t(γ) and x(γ); for a solution of the doubled system both branches.
fn world_line<S: Real>(of: &str, solution: &WorldLine<S>) -> Chart {
    let forward = if solution.is_doubled() { ["t_1(γ)", "x_1(γ)"] } else { ["t(γ)", "x(γ)"] };
    let forward = forward.into_iter().enumerate();
    let forward =
        forward.map(|(a, label)| Series::new(label, Mark::LINE_AND_POINTS, at_nodes(solution, solution.q(a))));
    let backward = ["t_2(γ)", "x_2(γ)"].into_iter().enumerate();
    let backward = backward
        .filter_map(|(a, label)| Some(Series::new(label, Mark::POINTS, at_nodes(solution, solution.backward(a)?))));
    Chart::new("Time t and place x along the world-line", of, ["γ", "t, x"], forward.chain(backward).collect())
}

/// dt/dγ on the nodes: the time mesh that emerges. At the last node of a window in the strong form it is the value with
/// which the next window starts; the value of Dt there shows in the picture of ΔQ_t.
fn time_mesh<S: Real>(of: &str, solution: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Chart {
    let tangent = diagnostics.tangent(solution);
    let label = match solution.form {
        Form::Strong => "(Dt)(γ)",
        Form::Weak => "(D̄t)(γ)",
    };
    let points = at_nodes(solution, tangent[0].iter().copied());
    let Extent { least, most } = Extent::of(points.iter().map(|point| point.1));
    let title = if least > 0.0 && most > 1.005 * least {
        format!("The time mesh: steps in t differ by a factor of {:.2}", most / least)
    } else {
        "The time mesh: dt/dγ".to_owned()
    };
    Chart::new(title, of, ["γ", "dt/dγ"], vec![Series::new(label, Mark::LINE_AND_POINTS, points)])
}

/// x(t): the nodes, the reference geodesic and the motion with time as its parameter.
fn trajectory<S: Real>(
    of: &str,
    solution: &WorldLine<S>,
    reference: Option<&ReferenceTrajectory>,
    time_parametrised: &[(f64, f64)],
) -> Chart {
    let (mut series, t_i) = (Vec::new(), solution.t_i().to_f64());
    if let Some(reference) = reference {
        let at = |k: usize| reference.at(solution.length.to_f64() * k as f64 / (CURVE_POINTS - 1) as f64);
        let points = (0..CURVE_POINTS).map(at).map(|point| (t_i + point.q[0], point.q[1])).collect();
        series.push(Series::new("geodesic (reference)", Mark::LINE, points));
    }
    let points = time_parametrised.iter().map(|&(elapsed, x)| (t_i + elapsed, x)).collect();
    series.push(Series::new("x(t) with time as parameter", Mark::DASHED, points).with_look(Style::NEUTRAL));
    let points = solution.t().zip(solution.x()).map(|(t, x)| (t.to_f64(), x.to_f64())).collect();
    series.push(Series::new("nodes", Mark::POINTS, points));
    Chart::new("Where the nodes lie on the trajectory x(t)", of, ["t", "x"], series)
}

/// |ΔQ_t| on the nodes. In the strong form the value at the last node with the multiplier correction is shown, too; at
/// all other nodes the two agree.
fn noether_charge<S: Real>(of: &str, solution: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Chart {
    let charge = &diagnostics.charges[0];
    let mut series = vec![deviation("|ΔQ_t|", solution, &charge.delta)];
    if let Some(corrected) = solution.multipliers().and(charge.corrected.last()) {
        let last = vec![(solution.gamma_f().to_f64(), corrected.to_f64().abs())];
        series.push(Series::new("last node, with + λ_7/H_N", Mark::POINTS, last));
    }
    deviations("How far the charge Q_t is from its initial value", of, "|ΔQ_t|", series)
}

/// |ΔG^t| and |ΔG^x| on the nodes.
fn geodesic_residuals<S: Real>(of: &str, solution: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Chart {
    let rows = ["|ΔG^t|", "|ΔG^x|"].into_iter().zip(&diagnostics.delta_g);
    let series = rows.map(|(label, row)| deviation(label, solution, row)).collect();
    deviations("How far the nodes are from the discrete geodesic equations", of, "|ΔG|", series)
}
