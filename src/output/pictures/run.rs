//! The pictures of a run.

use csv::StringRecord;

use super::of_x::{deviation, deviations, pictures_of_x};
use super::scan::shade;
use crate::case::{Axes, Case, Form};
use crate::diagnostics::{Diagnostics, Extent};
use crate::geometry::{ConservedSum, Geometry, Observable};
use crate::number::Real;
use crate::output::chart::{Chart, Mark, Scale, Series, Shape, Style};
use crate::output::tables::Part;
use crate::solve::WorldLine;
use crate::study::run::Run;
use crate::trajectory::{Crossing, Sample, Sampler};

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

/// The names of a run's pictures: those of every run, then those of the paper, which has t and x.
pub fn names_of_run(case: &Case) -> Vec<&'static str> {
    let section = (!case.events.is_empty()).then_some("section.svg");
    let of_x = ["world_line.svg", "t_dot.svg", "trajectory.svg", "delta_q_t.svg", "delta_g.svg"];
    let of_x = of_x.into_iter().filter(|_| case.is_of_x);
    ["orbit.svg", "charges.svg", "mesh.svg"].into_iter().chain(section).chain(of_x).collect()
}

/// The pictures of a run, in the order of their names.
pub fn of_run<S: Real>(title: &str, case: &Case, run: &Run<S>) -> Vec<Chart> {
    let (line, parts) = (&run.line, &run.parts()[..]);
    let windows = if line.window_count > 1 { format!(", {} windows", line.window_count) } else { String::new() };
    let of = &format!("{title} ({}, N = {}{windows})", line.sbp_name, line.sbp().points());
    let orbits = orbits_of(case, line.geometry());
    let mut drawn = vec![orbit(of, parts, &orbits), charges(of, parts, &run.sums), mesh(of, parts)];
    if !case.events.is_empty() {
        drawn.push(section(of, parts, &orbits[0].1, &case.event_names(), &run.events));
    }
    if case.is_of_x {
        drawn.extend(pictures_of_x(of, case, line, &run.diagnostics));
    }
    drawn
}

/// The axes of the picture of an orbit: to the right, and upwards.
#[derive(Clone)]
struct PlotAxes<S> {
    formulas: [Observable<S>; 2],
    /// The same as text.
    labels: [String; 2],
    /// The symbol of what velocities are derivatives by.
    parameter: &'static str,
}

/// The axes of the orbits of a case, and their names.
fn orbits_of<S: Real>(case: &Case, geometry: &Geometry<S>) -> Vec<(String, PlotAxes<S>)> {
    let axes = |(name, Axes { x, y }): (String, Axes)| {
        let (formulas, is_lone) = ([&x, &y].map(|formula| case.axis(formula)), name.is_empty());
        let labels = if is_lone { [x, y] } else { ["x", "y"].map(str::to_owned) };
        // The parameter of Newton's law is t, but for a factor.
        (name, PlotAxes { formulas, labels, parameter: if case.is_lifted() { "t" } else { "γ" } })
    };
    case.orbits(geometry).into_iter().map(axes).collect()
}

/// The axes of the orbits of a case in words: first what is drawn to the right, then upwards.
pub(super) fn axes_of_orbits(case: &Case) -> Vec<String> {
    let axes = case.orbits(&case.geometry::<f64>()).into_iter();
    axes.map(|(_, Axes { x, y })| format!("{x} and {y}")).collect()
}

/// The events of a row of many runs: their names, and their places on the axes of its case, by their records in
/// `runs-events.csv`.
pub fn places_of_events(case: &Case, events: &[StringRecord]) -> Vec<(String, (f64, f64))> {
    let geometry: Geometry = case.geometry();
    let (mut axes, n) = (orbits_of(case, &geometry).swap_remove(0).1, geometry.dimension());
    let place = |record: &StringRecord| {
        // Behind the number of the row and the name are γ, q and q̇.
        let numbers: Vec<f64> = record.iter().skip(2).filter_map(|cell| cell.parse().ok()).collect();
        let [q, q_dot] = [numbers.get(1..=n)?, numbers.get(n + 1..=2 * n)?].map(<[f64]>::to_vec);
        let (p, norm) = (geometry.momenta(&q, &q_dot), geometry.norm(&q, &q_dot));
        let sample = Sample { gamma: numbers[0], q, q_dot, p };
        Some((record.get(1)?.to_owned(), axes.point(&sample, norm)))
    };
    events.iter().filter_map(place).collect()
}

/// So many series have colours that one can tell apart.
pub const MOST_COLOURS: usize = 7;

/// The events of many runs, which differ from this case by the keys that vary: the points of each series with its name.
/// Many series go from light to dark, and only the first and the last are named.
pub fn section_of_runs(of: &str, case: &Case, named: Vec<(String, Vec<(f64, f64)>)>) -> Chart {
    let axes = orbits_of(case, &case.geometry::<f64>()).swap_remove(0).1;
    let last = named.len().saturating_sub(1);
    let series = named.into_iter().enumerate().map(|(k, (name, places))| {
        if last < MOST_COLOURS {
            return Series::new(name, Mark::POINTS, places);
        }
        let look = Style { colour: shade(k as f64 / last as f64), shape: Shape::Circle };
        let name = if k == 0 || k == last { name } else { String::new() };
        Series::new(name, Mark::POINTS, places).with_look(look)
    });
    axes.chart("Where the events of all rows are", of, series.collect())
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
fn orbit<S: Real>(of: &str, parts: &[Part<'_, S>], orbits: &[(String, PlotAxes<S>)]) -> Chart {
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
fn section<S: Real>(
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
fn charges<S: Real>(of: &str, parts: &[Part<'_, S>], sums: &[ConservedSum]) -> Chart {
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
fn mesh<S: Real>(of: &str, parts: &[Part<'_, S>]) -> Chart {
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
