//! The pictures of `stability`: the atlas with one small map per method, where the sawtooth begins, and the charge at
//! the last node.

use super::look;
use crate::case::Form;
use crate::number::norm::larger;
use crate::output::chart::{Chart, Kind, Map, Mark, Panel, Series, Sign};
use crate::output::stability::onsets;
use crate::study::stability::{Arena, Cell, CellStatus, Limit, Method, Pace};

/// The values of Δγω that have ticks.
const TICKS: [f64; 8] = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0];

/// The kind of cell for a status. The colours are mostly those of Okabe and Ito, with a light blue for the best status
/// and nearly black for the worst; every kind has a sign of its own too.
fn kind(status: CellStatus) -> Kind {
    let (fill, sign) = match status {
        CellStatus::Accurate => ([126, 192, 232], Sign::EMPTY),
        CellStatus::Inaccurate => ([240, 228, 66], Sign::RING),
        CellStatus::Sawtooth => ([213, 94, 0], Sign::ZIGZAG),
        CellStatus::Drifting => ([230, 159, 0], Sign::SLASH),
        CellStatus::Diverged => ([204, 121, 167], Sign::CROSS),
        CellStatus::NoCriticalPoint => ([128, 128, 128], Sign::BAR),
        CellStatus::OutsideDomain => ([30, 30, 30], Sign::SQUARE),
    };
    Kind { label: status.label().to_owned(), fill, sign }
}

/// The different ones of `values`, sorted.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

fn place(values: &[f64], value: f64) -> Option<usize> {
    values.iter().position(|&known| known == value)
}

/// Where `value` lies among logarithmically spaced columns, in columns.
fn between(columns: &[f64], value: f64) -> Option<f64> {
    let (first, last) = (columns.first()?, columns.last()?);
    let step = if columns.len() > 1 { (last / first).ln() / (columns.len() - 1) as f64 } else { 1.0 };
    // Between two columns by their own distance, and outside of them all by the mean distance.
    let inside = columns.windows(2).zip(0..).find(|(pair, _)| pair[0] <= value && value <= pair[1]);
    Some(match inside {
        Some((pair, k)) => f64::from(k) + 0.5 + (value / pair[0]).ln() / (pair[1] / pair[0]).ln(),
        None if value < *first => 0.5 - (first / value).ln() / step,
        None => columns.len() as f64 - 0.5 + (value / last).ln() / step,
    })
}

/// The maps of `methods`. The abscissa is Δγω, or the tolerance of an adaptive method; the ordinate is the length.
pub fn stability_map(of: &str, arena: &Arena, methods: &[Method], cells: &[Cell]) -> Map {
    let lengths = distinct(cells.iter().map(Cell::length));
    let panel = |method: &Method| {
        let settings =
            distinct(cells.iter().filter(|c| c.method.is_adaptive() == method.is_adaptive()).map(|c| c.setting));
        let of_cell = |cell: &Cell| {
            let status = CellStatus::ALL.iter().position(|&status| status == cell.status)?;
            Some((place(&settings, cell.setting)?, place(&lengths, cell.length())?, status))
        };
        let here = cells.iter().filter(|cell| cell.method == *method);
        let columns: Vec<f64> = settings.iter().map(|setting| setting * arena.pace.rate()).collect();
        let within = |place: &f64| (0.0..=columns.len() as f64).contains(place);
        let limit = method.limit();
        let text = match limit {
            Limit::Adaptive => "tolerance".to_owned(),
            Limit::Step(step) if step > 0.0 => format!("≤ {step:.2}"),
            Limit::Step(_) => "grows".to_owned(),
            Limit::None => "any".to_owned(),
        };
        let tolerance = |(k, setting): (usize, &f64)| (k as f64 + 0.5, format!("{setting:e}"));
        let step = |value: f64| Some((between(&columns, value).filter(within)?, value.to_string()));
        Panel {
            title: format!("{} ({text})", method.label()),
            look: Some((look::of_method(method), !method.is_own())),
            columns: columns.len(),
            cells: here.filter_map(of_cell).collect(),
            ticks: match limit {
                Limit::Adaptive => settings.iter().enumerate().map(tolerance).collect(),
                _ => TICKS.into_iter().filter_map(step).collect(),
            },
            // The limit is one of Δγω; it has no meaning if the motion does not oscillate.
            line: match limit {
                Limit::Step(step) if step > 0.0 && arena.omega() > 0.0 => between(&columns, step),
                _ => None,
            },
        }
    };
    Map {
        title: "Where methods are accurate (blue), and how they fail".to_owned(),
        subtitle: format!("{of}; in parentheses the largest step that linear theory allows"),
        x_label: format!(
            "{} (of adaptive methods the tolerance)",
            match arena.pace {
                Pace::Frequency(_) => "step: Δγ ω",
                Pace::Growth(_) => "step: Δγ × rate of growth",
                Pace::Length(_) => "step: Δγ × 2π/length of the case",
            }
        ),
        y_label: "length γ_f − γ_i".to_owned(),
        rows: lengths.len(),
        row_ticks: lengths.iter().enumerate().map(|(k, &length)| (k as f64 + 0.5, short(length))).collect(),
        bar: None,
        kinds: CellStatus::ALL.map(kind).to_vec(),
        absent: Kind { label: "no such grid".to_owned(), fill: [255; 3], sign: Sign::DOT },
        panels: methods.iter().map(panel).collect(),
        line_label: "limit of linear theory".to_owned(),
    }
}

/// A length with few digits, for display: no more than fit beside a map.
fn short(length: f64) -> String {
    if !(1e-3..1e5).contains(&length) {
        return format!("{length:.1e}");
    }
    let text = format!("{}", (length * 1e4).round() / 1e4);
    if text.len() <= 6 && length < 1.0 || text.len() <= 5 {
        return text;
    }
    let unit = 10.0_f64.powi(2 - length.log10().floor() as i32);
    format!("{}", (length * unit).round() / unit)
}

/// A curve for each label, with the look of its method.
fn curves<'m>(points: impl Iterator<Item = (String, &'m Method, (f64, f64))>) -> Vec<Series> {
    let mut curves: Vec<Series> = Vec::new();
    for (label, method, point) in points {
        match curves.iter_mut().find(|known| known.label == label) {
            Some(known) => known.points.push(point),
            None => {
                let curve = Series::new(label, Mark::LINE_AND_POINTS, vec![point]);
                curves.push(curve.with_look(look::of_method(method)));
            }
        }
    }
    curves
}

/// Where on the world-line the sawtooth begins, against Δγω.
pub fn sawtooth_onset(of: &str, cells: &[Cell]) -> Chart {
    // Beyond half the limit of SBP21 the sawtooth begins at once. Methods other than these have no such mode.
    let has_mode = |cell: &&Cell| matches!(cell.method, Method::Block(..) | Method::Windows(..));
    let resolved = |cell: &&Cell| cell.delta_gamma_omega.is_some_and(|at| at <= 0.5);
    let onsets = onsets(cells.iter().filter(has_mode).filter(resolved)).into_iter();
    let points =
        onsets.filter_map(|(cell, gamma)| Some((cell.method.label(), &cell.method, (cell.delta_gamma_omega?, gamma))));
    let mut series = curves(points);
    series.iter_mut().for_each(|series| series.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    let title = "How far SBP schemes run before their sawtooth begins";
    Chart::new(title, of, ["step: Δγ ω", "γ − γ_i where it is first seen"], series).log_log()
}

/// The last node is drawn for the spacing whose Δγω is nearest to this.
const LAST_NODE_AT: f64 = 0.1;

/// |ΔQ_t| at the last node against length, for blocks of the strong form with one spacing, also with the multiplier
/// correction; of the charges of a scene the largest.
pub fn last_node(of: &str, arena: &Arena, cells: &[Cell]) -> Chart {
    let blocks = || cells.iter().filter(|cell| matches!(cell.method, Method::Block(_, Form::Strong)));
    let distance = |cell: &&Cell| cell.delta_gamma_omega.map_or(f64::INFINITY, |at| (at / LAST_NODE_AT).ln().abs());
    let nearest = blocks().min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|cell| cell.setting);
    // The charge itself is the first of both, and the corrected one the second.
    let curves_of = |which: usize| {
        let shown = blocks().filter(|cell| Some(cell.setting) == nearest);
        curves(shown.filter_map(|cell| {
            let all = cell.numbers.as_ref()?.last_node.as_ref()?;
            let label = format!("{}, Δγ = {}", cell.method.name(), short(cell.setting));
            let largest = all.iter().map(|charge| charge[which].abs()).fold(0.0, larger);
            Some((label, &cell.method, (cell.gamma_f, largest)))
        }))
    };
    let open = |curve: Series| Series { label: String::new(), mark: Mark::OPEN_POINTS, ..curve };
    let pairs = curves_of(0).into_iter().zip(curves_of(1));
    let mut all: Vec<Series> = pairs.flat_map(|(raw, corrected)| [raw, open(corrected)]).collect();
    // The multiplier of the last node, as the theory calls it.
    let share = if arena.geometry().c_squared.is_none() { "κ_a" } else { "λ_7" };
    if let Some(first) = all.get_mut(1) {
        first.label = format!("open: with + {share}/H_N");
    }
    let (charge, deviation) = match arena.geometry().c_squared.is_none() {
        true => ("largest change of a charge", "largest |Δp_a|"),
        false => ("charge", "|ΔQ_t|"),
    };
    let title = format!("The {charge} at the last node, and what + {share}/H_N makes of it");
    Chart::new(title, of, ["γ_f − γ_i", &format!("{deviation} at the last node")], all).log_log()
}

#[cfg(test)]
mod tests {
    use super::super::look::tests::grey;
    use super::*;

    #[test]
    fn lengths_have_few_digits() {
        for (length, text) in
            [(62.8319, "62.8"), (2000.0, "2000"), (0.0625, "0.0625"), (12_345.6, "12300"), (1e5, "1.0e5")]
        {
            assert_eq!(short(length), text);
        }
    }

    #[test]
    fn what_a_cell_is_can_be_told_in_greyscale() {
        let kinds = CellStatus::ALL.map(kind);
        for (k, one) in kinds.iter().enumerate() {
            assert!(kinds[..k].iter().all(|other| other.sign != one.sign && other.fill != one.fill), "{}", one.label);
            // Only a place without a cell is nearly white.
            assert!(grey(one.fill) < 220.0, "{}", one.label);
        }
        // The only kind without a sign is clearly darker than white.
        assert!(grey(kind(CellStatus::Accurate).fill) < 255.0 - 60.0);
    }
}
