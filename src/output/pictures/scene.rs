//! The pictures of a run of a scene.

use crate::action::Form;
use crate::diagnostics::Diagnostics;
use crate::geometry::{ConservedSum, Observable};
use crate::number::Real;
use crate::output::chart::{Chart, Ink, Mark, Scale, Series};
use crate::solve::WorldLine;
use crate::trajectory::{Crossing, Sample, Sampler};

/// Points of an orbit: as many as a line may have without being thinned, and more of very long ones.
const LEAST_POINTS: usize = 2000;
const MOST_POINTS: usize = 20_000;
const NODES_PER_POINT: usize = 10;
/// Differences between events are rounding if they are below this share of the extent of the orbit.
const ROUNDING: f64 = 1e-9;
/// Axes whose ranges differ by more than this have scales of their own.
const ALIKE: f64 = 6.0;
/// Steps that differ by more than this are drawn on a logarithmic scale.
const MANY_STEPS: f64 = 30.0;
/// Steps that differ by less are equal.
const EVEN: f64 = 1.0 + 1e-6;

/// The axes of the picture of an orbit.
#[derive(Debug, Clone)]
pub struct PlotAxes<S = f64> {
    /// To the right, and upwards.
    pub formulas: [Observable<S>; 2],
    /// The same as text.
    pub labels: [String; 2],
}

impl<S: Real> PlotAxes<S> {
    /// Where a point of the world-line is in the picture.
    fn point(&mut self, sample: &Sample<S>, norm: S) -> (f64, f64) {
        let [x, y] = self.formulas.each_mut().map(|f| f.at(&sample.q, &sample.q_dot, &sample.p, norm).to_f64());
        (x, y)
    }

    /// Whether a length is the same along both axes, as far as one can tell: neither is a velocity.
    fn are_places(&self) -> bool {
        self.labels.iter().all(|label| !label.contains("_dot"))
    }

    fn chart(&self, title: &str, of: &str, series: Vec<Series>) -> Chart {
        let points = || series.iter().flat_map(|series| &series.points);
        let ratio = extent(points().map(|p| p.0)) / extent(points().map(|p| p.1));
        let [x_label, y_label] = self.labels.each_ref().map(|label| written(label));
        Chart {
            title: title.to_owned(),
            subtitle: of.to_owned(),
            x_label,
            y_label,
            is_isometric: self.are_places() && (1.0 / ALIKE..=ALIKE).contains(&ratio),
            series,
            ..Chart::default()
        }
    }
}

/// A formula as it is read: velocities as derivatives, momenta with their index below, Greek letters by their signs.
fn written(formula: &str) -> String {
    let mut text = String::new();
    let mut rest = formula;
    while let Some(first) = rest.chars().next() {
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let length = rest.find(|c: char| !is_name(c)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(length.max(first.len_utf8()));
        let of = |name: &str| match name {
            "phi" => "φ".to_owned(),
            "theta" => "θ".to_owned(),
            "tau" => "τ".to_owned(),
            _ => name.to_owned(),
        };
        text += &match word.strip_suffix("_dot") {
            Some(name) => format!("d{}/dγ", of(name)),
            None if word.starts_with("p_") => format!("p_{{{}}}", of(&word[2..])),
            None if word == "*" => " ".to_owned(),
            None => of(word),
        };
        rest = after;
    }
    text
}

fn norm<S: Real>(line: &WorldLine<S>) -> S {
    line.geometry().norm(&line.place.start.q, &line.place.start.q_dot)
}

/// So many points of the orbit, evenly in γ.
fn points<S: Real>(line: &WorldLine<S>, axes: &mut PlotAxes<S>, count: usize) -> Vec<(f64, f64)> {
    let (norm, mut sampler) = (norm(line), Sampler::new(line));
    let step = line.length / S::from((count - 1) as f64);
    let gammas = (0..count).map(|k| line.gamma_at(S::from(k as f64) * step));
    gammas.filter_map(|gamma| sampler.at_gamma(gamma).ok()).map(|sample| axes.point(&sample, norm)).collect()
}

/// The orbit in the plane of `axes`, with its start.
pub fn orbit<S: Real>(of: &str, line: &WorldLine<S>, axes: &PlotAxes<S>) -> Chart {
    let mut axes = axes.clone();
    let points = points(line, &mut axes, (line.nodes() / NODES_PER_POINT).clamp(LEAST_POINTS, MOST_POINTS));
    let start = points.iter().copied().take(1).collect();
    let series =
        vec![Series::new("", Mark::Line, points), Series::new("start", Mark::OpenPoints, start).with_ink(Ink::Next)];
    axes.chart("The orbit, and where it starts", of, series)
}

/// The events in the plane of `axes`. `names` are those of what was watched.
pub fn section<S: Real>(
    of: &str,
    line: &WorldLine<S>,
    axes: &PlotAxes<S>,
    names: &[&str],
    crossings: &[Crossing<S>],
) -> Chart {
    let (mut axes, norm) = (axes.clone(), norm(line));
    let (x, y): (Vec<f64>, Vec<f64>) = points(line, &mut axes, LEAST_POINTS).into_iter().unzip();
    let grains = [x, y].map(|values| ROUNDING * extent(values.into_iter()));
    let events: Vec<(f64, f64)> = crossings.iter().map(|crossing| axes.point(&crossing.sample, norm)).collect();
    let (mut x, mut y): (Vec<f64>, Vec<f64>) = events.into_iter().unzip();
    level(&mut x, grains[0]);
    level(&mut y, grains[1]);
    let of_watch = |watch: usize| {
        let places = crossings.iter().zip(x.iter().zip(&y)).filter(|(crossing, _)| crossing.watch == watch);
        places.map(|(_, (&x, &y))| (x, y)).collect()
    };
    let series = names.iter().enumerate().map(|(watch, name)| Series::new(*name, Mark::Points, of_watch(watch)));
    let series = series.collect();
    axes.chart("Where the events are on the orbit", of, series)
}

/// The distance between the least and the greatest.
fn extent(values: impl Iterator<Item = f64>) -> f64 {
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    most - least
}

/// Makes values equal whose differences are below `grain`, and zero if they are below it themselves: the events of an
/// axis along which they all lie differ by rounding, which is not to be seen.
fn level(values: &mut [f64], grain: f64) {
    if extent(values.iter().copied()) > grain {
        return;
    }
    let first = values.first().copied().filter(|first| first.abs() > grain).unwrap_or(0.0);
    values.fill(first);
}

/// |ΔQ| of every charge and conserved sum, and the deviations of K, or of Newton's energy, and of the invariants.
pub fn charges<S: Real>(of: &str, line: &WorldLine<S>, diagnostics: &Diagnostics<S>, sums: &[ConservedSum]) -> Chart {
    let names = line.geometry().names();
    let gamma: Vec<f64> = line.gamma().map(S::to_f64).collect();
    let curve = |label: String, row: &[S]| {
        let points = gamma.iter().zip(row).map(|(&gamma, value)| (gamma, value.abs().to_f64())).collect();
        Series::new(label, Mark::Points, points)
    };
    // What only measures is drawn first: the charges are below it, and are to be seen.
    let mut series: Vec<Series> =
        diagnostics.invariants.iter().map(|invariant| curve(invariant.name.clone(), &invariant.delta)).collect();
    series.push(match &diagnostics.delta_energy {
        Some(energy) => curve("energy".to_owned(), energy),
        None => curve("K".to_owned(), &diagnostics.norm.delta),
    });
    let charges = diagnostics.charges.iter().map(|charge| (format!("p_{}", names[charge.terms[0].0]), &charge.delta));
    let sums = sums.iter().zip(&diagnostics.sums).map(|(sum, charge)| (sum.formula(names), &charge.delta));
    series.extend(charges.chain(sums).map(|(name, delta)| curve(written(&name), delta)));
    Chart {
        title: match line.form {
            Form::Strong => "Charges are exact but at the ends of windows; the others show the error".to_owned(),
            Form::Weak => "Charges are exact; what is not a charge shows the error".to_owned(),
        },
        subtitle: of.to_owned(),
        x_label: "γ".to_owned(),
        y_label: "|deviation from the start|".to_owned(),
        y_scale: Scale::Log,
        series,
        ..Chart::default()
    }
}

/// The steps between nodes along the run, in γ and, where it is another one, in t. In windows of spectral elements,
/// whose nodes crowd at the ends, the mean step of a window takes their place.
pub fn mesh<S: Real>(of: &str, line: &WorldLine<S>) -> Chart {
    let gamma: Vec<f64> = line.gamma().map(S::to_f64).collect();
    let t = line.geometry().names().iter().position(|name| name == "t");
    let t: Option<Vec<f64>> = t.map(|t| line.q(t).map(S::to_f64).collect());
    let is_averaged = line.windows.len() > 1 && !line.sbp().is_equidistant();
    let pairs: Vec<[usize; 2]> = (line.grids())
        .flat_map(|grid| {
            let nodes = grid.nodes();
            match is_averaged {
                true => vec![[nodes.start, nodes.end - 1]],
                false => nodes.clone().skip(1).map(|k| [k - 1, k]).collect(),
            }
        })
        .collect();
    let steps = |values: &[f64]| -> Vec<(f64, f64)> {
        let step = |&[a, b]: &[usize; 2]| (0.5 * (gamma[a] + gamma[b]), (values[b] - values[a]) / (b - a) as f64);
        pairs.iter().map(step).collect()
    };
    let spread = |steps: &[(f64, f64)]| {
        let sizes = steps.iter().map(|step| step.1.abs());
        let (least, most) = sizes.fold((f64::INFINITY, 0.0_f64), |(least, most), v| (least.min(v), most.max(v)));
        most / least
    };
    let in_gamma = steps(&gamma);
    let in_t = t.map(|t| steps(&t)).filter(|steps| {
        let differs = |(a, b): (&(f64, f64), &(f64, f64))| (a.1 / b.1 - 1.0).abs() > EVEN - 1.0;
        steps.iter().zip(&in_gamma).any(differs)
    });
    let said = |steps: &[(f64, f64)], of: &str| match spread(steps) {
        ratio if ratio <= EVEN => format!("steps in {of} are even"),
        ratio => format!("steps in {of} differ by a factor of {ratio:.3}"),
    };
    let texts: Vec<String> =
        std::iter::once(said(&in_gamma, "γ")).chain(in_t.as_deref().map(|steps| said(steps, "t"))).collect();
    let widest = spread(&in_gamma).max(in_t.as_deref().map_or(1.0, spread));
    let mut series = vec![Series::new("Δγ", Mark::Points, in_gamma)];
    series.extend(in_t.map(|steps| Series::new("Δt", Mark::Points, steps)));
    Chart {
        title: format!("The mesh: {}", texts.join(", ")),
        subtitle: of.to_owned(),
        x_label: "γ".to_owned(),
        y_label: if is_averaged { "mean step of a window" } else { "step between nodes" }.to_owned(),
        y_scale: if widest > MANY_STEPS { Scale::Log } else { Scale::Linear },
        series,
        ..Chart::default()
    }
}
