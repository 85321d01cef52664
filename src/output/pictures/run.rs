//! The pictures of a run, from its solution, its diagnostics and a reference: those of every run, and those of the
//! paper.

use crate::case::Form;
use crate::diagnostics::{Diagnostics, Extent};
use crate::geometry::{ConservedSum, Observable};
use crate::number::Real;
use crate::output::chart::{Chart, Mark, Scale, Series, Shape, Style};
use crate::output::tables::Part;
use crate::reference::ReferenceTrajectory;
use crate::solve::WorldLine;
use crate::trajectory::{Crossing, Sample, Sampler};

/// Number of points at which the reference is drawn.
const CURVE_POINTS: usize = 400;
/// Points of an orbit, and more of very long ones.
const LEAST_POINTS: usize = 2000;
const MOST_POINTS: usize = 20_000;
const NODES_PER_POINT: usize = 10;
/// Differences between events are rounding if they are below this share of the extent of the orbit.
const ROUNDING: f64 = 1e-9;
/// Axes whose ranges differ by more than this have scales of their own.
const ALIKE: f64 = 6.0;
/// Steps that differ by more than this are drawn on a logarithmic scale.
const MANY_STEPS: f64 = 30.0;
/// The start and the end of an orbit, which both show where they are one place.
const ENDS: Style = Style { colour: [0, 0, 0], shape: Shape::Circle };
/// Steps that differ by less are equal.
const EVEN: f64 = 1.0 + 1e-6;

/// A picture of deviations along the world-line, on a logarithmic scale.
fn deviations(title: &str, of: &str, y_label: &str, series: Vec<Series>) -> Chart {
    Chart { y_scale: Scale::Log, ..Chart::new(title, of, ["γ", y_label], series) }
}

/// Values at the nodes.
fn at_nodes<S: Real>(line: &WorldLine<S>, values: impl IntoIterator<Item = S>) -> Vec<(f64, f64)> {
    line.gamma().zip(values).map(|(gamma, value)| (gamma.to_f64(), value.to_f64())).collect()
}

/// The sizes of deviations at the nodes.
fn deviation<S: Real>(label: impl Into<String>, line: &WorldLine<S>, row: &[S]) -> Series {
    Series::new(label, Mark::POINTS, at_nodes(line, row.iter().map(|value| value.abs())))
}

/// t(γ) and x(γ); for a solution of the doubled system both branches.
pub fn world_line<S: Real>(of: &str, solution: &WorldLine<S>) -> Chart {
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
pub fn time_mesh<S: Real>(of: &str, solution: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Chart {
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
pub fn trajectory<S: Real>(
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
pub fn noether_charge<S: Real>(of: &str, solution: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Chart {
    let charge = &diagnostics.charges[0];
    let mut series = vec![deviation("|ΔQ_t|", solution, &charge.delta)];
    if let Some(corrected) = solution.multipliers().and(charge.corrected.last()) {
        let last = vec![(solution.gamma_f().to_f64(), corrected.to_f64().abs())];
        series.push(Series::new("last node, with + λ_7/H_N", Mark::POINTS, last));
    }
    deviations("How far the charge Q_t is from its initial value", of, "|ΔQ_t|", series)
}

/// |ΔG^t| and |ΔG^x| on the nodes.
pub fn geodesic_residuals<S: Real>(of: &str, solution: &WorldLine<S>, diagnostics: &Diagnostics<S>) -> Chart {
    let rows = ["|ΔG^t|", "|ΔG^x|"].into_iter().zip(&diagnostics.delta_g);
    let series = rows.map(|(label, row)| deviation(label, solution, row)).collect();
    deviations("How far the nodes are from the discrete geodesic equations", of, "|ΔG|", series)
}

/// The axes of the picture of an orbit.
#[derive(Debug, Clone)]
pub struct PlotAxes<S = f64> {
    /// To the right, and upwards.
    pub formulas: [Observable<S>; 2],
    /// The same as text.
    pub labels: [String; 2],
    /// The symbol of what velocities are derivatives by.
    pub parameter: &'static str,
}

impl<S: Real> PlotAxes<S> {
    /// Where a point of the world-line is in the picture.
    fn point(&mut self, sample: &Sample<S>, norm: S) -> (f64, f64) {
        let [x, y] = self.formulas.each_mut().map(|f| f.at(&sample.q, &sample.q_dot, &sample.p, norm).to_f64());
        (x, y)
    }

    /// Returns true if a length is the same along both axes, as far as one can tell: neither is a velocity.
    fn are_places(&self) -> bool {
        self.labels.iter().all(|label| !label.contains("_dot"))
    }

    fn chart(&self, title: &str, of: &str, series: Vec<Series>) -> Chart {
        let points = || series.iter().flat_map(|series| &series.points);
        let ratio = Extent::of(points().map(|p| p.0)).range() / Extent::of(points().map(|p| p.1)).range();
        let [x_label, y_label] = self.labels.each_ref().map(|label| written(label, self.parameter));
        let is_isometric = self.are_places() && (1.0 / ALIKE..=ALIKE).contains(&ratio);
        Chart { is_isometric, ..Chart::new(title, of, [&x_label, &y_label], series) }
    }
}

/// A formula as it is read: velocities as derivatives, momenta with their index below, Greek letters by their signs.
fn written(formula: &str, parameter: &str) -> String {
    let is_other = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
    let of = |name: &str| match name {
        "phi" => "φ".to_owned(),
        "theta" => "θ".to_owned(),
        "tau" => "τ".to_owned(),
        _ => name.to_owned(),
    };
    let word = |word: &str| match (word.strip_suffix("_dot"), word.split_once('_')) {
        (Some(name), _) => format!("d{}/d{parameter}", of(name)),
        (_, Some((axis @ ("p" | "x" | "y" | "z"), index))) => format!("{axis}_{{{}}}", of(index)),
        _ => of(word),
    };
    let part = |part: &str| {
        let (name, sign) = part.split_at(part.find(is_other).unwrap_or(part.len()));
        word(name) + if sign == "*" { " " } else { sign }
    };
    formula.split_inclusive(is_other).map(part).collect()
}

fn norm<S: Real>(line: &WorldLine<S>) -> S {
    line.geometry().norm(&line.place.start.q, &line.place.start.q_dot)
}

/// So many points of the orbit, evenly in γ of each piece, which have numbers of them by their lengths.
fn points<S: Real>(parts: &[Part<'_, S>], axes: &mut PlotAxes<S>, count: usize) -> Vec<(f64, f64)> {
    let whole: f64 = parts.iter().map(|(line, _)| line.length.to_f64()).sum();
    let mut points = Vec::new();
    for (line, _) in parts {
        let share = if parts.len() == 1 { 1.0 } else { line.length.to_f64() / whole };
        let count = ((count as f64 * share).ceil() as usize).max(2);
        let (norm, mut sampler) = (norm(line), Sampler::new(line));
        let step = line.length / S::from((count - 1) as f64);
        let gammas = (0..count).map(|k| line.gamma_at(S::from(k as f64) * step));
        let samples = gammas.filter_map(|gamma| sampler.at_gamma(gamma).ok());
        points.extend(samples.map(|sample| axes.point(&sample, norm)));
    }
    points
}

/// The orbit in the plane of its axes, with its start and its end; of several bodies each has a name.
pub fn orbit<S: Real>(of: &str, parts: &[Part<'_, S>], orbits: &[(String, PlotAxes<S>)]) -> Chart {
    let nodes: usize = parts.iter().map(|(line, _)| line.nodes()).sum();
    let count = (nodes / NODES_PER_POINT).clamp(LEAST_POINTS, MOST_POINTS);
    let mut series = Vec::new();
    let (mut starts, mut ends) = (Vec::new(), Vec::new());
    for (name, axes) in orbits {
        let points = points(parts, &mut axes.clone(), count);
        starts.extend(points.first().copied());
        ends.extend(points.last().copied());
        series.push(Series::new(name.clone(), Mark::LINE, points));
    }
    let mark = |shape: Shape| Style { shape, ..ENDS };
    series.push(Series::new("start", Mark::OPEN_POINTS, starts).with_look(mark(Shape::Circle)));
    series.push(Series::new("end", Mark::POINTS, ends).with_look(mark(Shape::Cross)));
    let axes = &orbits[0].1;
    let title = match orbits {
        [_] if axes.labels[0] == "t" => format!("{} over time, from its start to its end", axes.labels[1]),
        [_] => "The orbit, where it starts and where it ends".to_owned(),
        _ => "The orbits of the bodies, where they start and where they end".to_owned(),
    };
    axes.chart(&title, of, series)
}

/// The events in the plane of `axes`. `names` are those of what was watched.
pub fn section<S: Real>(
    of: &str,
    parts: &[Part<'_, S>],
    axes: &PlotAxes<S>,
    names: &[&str],
    crossings: &[Crossing<S>],
) -> Chart {
    let (mut axes, norm) = (axes.clone(), parts.first().map_or(S::ZERO, |(line, _)| norm(line)));
    let (x, y): (Vec<f64>, Vec<f64>) = points(parts, &mut axes, LEAST_POINTS).into_iter().unzip();
    let grains = [x, y].map(|values| ROUNDING * Extent::of(values.into_iter()).range());
    let events: Vec<(f64, f64)> = crossings.iter().map(|crossing| axes.point(&crossing.sample, norm)).collect();
    let (mut x, mut y): (Vec<f64>, Vec<f64>) = events.into_iter().unzip();
    level(&mut x, grains[0]);
    level(&mut y, grains[1]);
    let of_watch = |watch: usize| {
        let places = crossings.iter().zip(x.iter().zip(&y)).filter(|(crossing, _)| crossing.watch == watch);
        places.map(|(_, (&x, &y))| (x, y)).collect()
    };
    let series = names.iter().enumerate().map(|(watch, name)| Series::new(*name, Mark::POINTS, of_watch(watch)));
    let series = series.collect();
    axes.chart("Where the events are on the orbit", of, series)
}

/// Makes values equal whose differences are below `grain`, and zero if they are below it themselves: the events of an
/// axis along which they all lie differ by rounding, which is not to be seen.
fn level(values: &mut [f64], grain: f64) {
    if Extent::of(values.iter().copied()).range() > grain {
        return;
    }
    let first = values.first().copied().filter(|first| first.abs() > grain).unwrap_or(0.0);
    values.fill(first);
}

/// |ΔQ| of every charge and conserved sum, and the deviations of K, or of Newton's energy, and of the invariants.
pub fn charges<S: Real>(of: &str, parts: &[Part<'_, S>], sums: &[ConservedSum]) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    for (line, diagnostics) in parts {
        let rows = rows_of_charges(line, diagnostics, sums).into_iter();
        let rows = rows.map(|(label, row)| deviation(label, line, row));
        if series.is_empty() {
            series = rows.collect();
        } else {
            series.iter_mut().zip(rows).for_each(|(all, row)| all.points.extend(row.points));
        }
    }
    let title = match parts.first().map(|(line, _)| line.form) {
        Some(Form::Strong) => "Charges are exact but at the ends of windows; the others show the error",
        _ if parts.len() > 1 => "Charges are exact between events; what is not a charge shows the error",
        _ => "Charges are exact; what is not a charge shows the error",
    };
    deviations(title, of, "|deviation from the start|", series)
}

/// The rows of that picture, with their names.
fn rows_of_charges<'d, S: Real>(
    line: &WorldLine<S>,
    diagnostics: &'d Diagnostics<S>,
    sums: &[ConservedSum],
) -> Vec<(String, &'d [S])> {
    let names = line.geometry().names();
    // What only measures is drawn first: the charges are below it, and are to be seen.
    let mut rows: Vec<(String, &'d [S])> =
        diagnostics.invariants.iter().map(|(name, invariant)| (name.clone(), &*invariant.delta)).collect();
    rows.push(match &diagnostics.energy {
        Some(energy) => ("energy".to_owned(), &energy.delta),
        None => ("K".to_owned(), &diagnostics.norm.delta),
    });
    let charges = diagnostics.charges.iter().map(|charge| (format!("p_{}", names[charge.terms[0].0]), charge));
    let sums = sums.iter().zip(&diagnostics.sums).map(|(sum, charge)| (sum.formula(names), charge));
    rows.extend(charges.chain(sums).map(|(name, charge)| (written(&name, "γ"), &*charge.delta)));
    rows
}

/// The steps between nodes along the run, in γ and, where it is another one, in t. In windows of spectral elements,
/// whose nodes crowd at the ends, the mean step of a window takes their place.
pub fn mesh<S: Real>(of: &str, parts: &[Part<'_, S>]) -> Chart {
    let lines = || parts.iter().map(|(line, _)| *line);
    let gamma: Vec<f64> = lines().flat_map(WorldLine::gamma).map(S::to_f64).collect();
    let t = lines().next().and_then(|line| line.geometry().names().iter().position(|name| name == "t"));
    let t: Option<Vec<f64>> = t.map(|t| lines().flat_map(|line| line.q(t)).map(S::to_f64).collect());
    let windows: usize = lines().map(|line| line.windows.len()).sum();
    let is_averaged = windows > 1 && lines().all(|line| !line.sbp().is_equidistant());
    let (mut pairs, mut first) = (Vec::new(), 0);
    for grid in lines().flat_map(|line| &line.windows) {
        let last = first + grid.points() - 1;
        let stride = if is_averaged { last - first } else { 1 };
        pairs.extend((first..last).step_by(stride).map(|k| [k, k + stride]));
        first = last + 1;
    }
    let steps = |values: &[f64]| -> Vec<(f64, f64)> {
        let step = |&[a, b]: &[usize; 2]| (0.5 * (gamma[a] + gamma[b]), (values[b] - values[a]) / (b - a) as f64);
        pairs.iter().map(step).collect()
    };
    let in_gamma = steps(&gamma);
    let in_t = t.map(|t| steps(&t)).filter(|steps| {
        let differs = |(a, b): (&(f64, f64), &(f64, f64))| (a.1 / b.1 - 1.0).abs() > EVEN - 1.0;
        steps.iter().zip(&in_gamma).any(differs)
    });
    let (mut series, mut texts, mut widest) = (Vec::new(), Vec::new(), 1.0);
    for (name, steps) in [("γ", Some(in_gamma)), ("t", in_t)] {
        let Some(steps) = steps else { continue };
        let Extent { least, most } = Extent::of(steps.iter().map(|step| step.1.abs()));
        let ratio = most / least;
        widest = f64::max(widest, ratio);
        texts.push(match ratio <= EVEN {
            true => format!("steps in {name} are even"),
            false => format!("steps in {name} differ by a factor of {ratio:.3}"),
        });
        series.push(Series::new(format!("Δ{name}"), Mark::POINTS, steps));
    }
    let y_label = if is_averaged { "mean step of a window" } else { "step between nodes" };
    Chart {
        y_scale: if widest > MANY_STEPS { Scale::Log } else { Scale::Linear },
        ..Chart::new(format!("The mesh: {}", texts.join(", ")), of, ["γ", y_label], series)
    }
}
