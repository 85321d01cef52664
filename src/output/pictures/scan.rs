//! A column of the table of many runs: over one key that varies a line, over two a map, by colour.

use crate::diagnostics::Extent;
use crate::output::chart::{Bar, Chart, Kind, Map, Mark, Panel, Scale, Series, Sign, ticks_of_cells};
use crate::study::many::Axis;

/// From the least to the largest value, light to dark: the perceptually uniform map viridis, backwards.
const SHADES: [[u8; 3]; 8] = [
    [253, 231, 37],
    [160, 218, 57],
    [74, 193, 109],
    [31, 161, 135],
    [39, 127, 142],
    [54, 92, 141],
    [70, 50, 127],
    [68, 1, 84],
];
/// A cell without a value is grey, which no value is.
const ABSENT: [u8; 3] = [224; 3];
/// So many steps of colour look like none.
const STEPS: usize = 64;
/// The colours and signs of words, of which more than these are shown as the last one.
const WORDS: [([u8; 3], Sign); 6] = [
    ([204, 229, 255], Sign::EMPTY),
    ([230, 159, 0], Sign::SLASH),
    ([0, 158, 115], Sign::RING),
    ([204, 121, 167], Sign::CROSS),
    ([0, 114, 178], Sign::BAR),
    ([90, 90, 90], Sign::SQUARE),
];
/// Values whose logarithms are drawn differ by more than this factor, and have one sign.
const MANY_DECADES: f64 = 1e3;

/// A key that varies, with its values as they are written.
#[derive(Debug, Clone, Copy)]
pub struct Varied<'a> {
    /// The key.
    pub key: &'a str,
    /// Its values.
    pub values: &'a [String],
}

impl Varied<'_> {
    /// The key as a person would say it.
    pub(super) fn name(&self) -> String {
        match self.key.split_once('.') {
            Some(("initial", name)) if !name.contains('.') => format!("{name} at the start"),
            Some(("parameters", name)) => name.to_owned(),
            _ => self.key.to_owned(),
        }
    }
}

impl<'a> From<&'a Axis> for Varied<'a> {
    fn from(axis: &'a Axis) -> Self {
        Self { key: &axis.key, values: &axis.values }
    }
}

/// A map of `values`, one for each combination of which the second key varies fastest; an empty one has no cell.
pub fn scan(of: &str, column: &str, [x, y]: [Varied<'_>; 2], values: &[String]) -> Map {
    let numbers: Vec<Option<f64>> = values.iter().map(|value| number(value)).collect();
    let is_of_words = values.iter().zip(&numbers).any(|(value, number)| !value.is_empty() && number.is_none());
    let (kinds, kind_of, bar) = if is_of_words { words(values) } else { shades(&numbers) };
    let cells = kind_of
        .iter()
        .enumerate()
        .filter_map(|(run, kind)| Some((run / y.values.len(), run % y.values.len(), (*kind)?)));
    let panel = Panel { columns: x.values.len(), cells: cells.collect(), ticks: ticks(x.values), ..Panel::default() };
    let absent = if kind_of.contains(&None) { "no value" } else { "" };
    Map {
        title: format!("{column} over {} and {}", x.name(), y.name()),
        subtitle: of.to_owned(),
        x_label: x.name(),
        y_label: y.name(),
        rows: y.values.len(),
        row_ticks: ticks(y.values),
        kinds,
        bar,
        absent: Kind { label: absent.to_owned(), fill: ABSENT, sign: Sign::DOT },
        panels: vec![panel],
        line_label: String::new(),
    }
}

/// The values of a column over the key that varies, as SVG: a line with gaps where there is no number, or, where there
/// are words among the values of the key or of the column, a row of cells.
pub fn line(of: &str, column: &str, varied: Varied<'_>, values: &[String]) -> String {
    match curve(of, column, varied, values) {
        Some(chart) => chart.to_svg(),
        None => {
            let row = [String::new()];
            let map = scan(of, column, [varied, Varied { key: "", values: &row }], values);
            Map { title: format!("{column} over {}", varied.name()), ..map }.to_svg()
        }
    }
}

fn curve(of: &str, column: &str, varied: Varied<'_>, values: &[String]) -> Option<Chart> {
    let xs: Option<Vec<f64>> = varied.values.iter().map(|value| number(value)).collect();
    let has_words = values.iter().any(|value| !value.is_empty() && value.parse::<f64>().is_err());
    let points = xs?.into_iter().zip(values.iter().map(|value| number(value).unwrap_or(f64::NAN))).collect();
    let series = Series::new("", Mark::LINE_AND_POINTS, points);
    let name = varied.name();
    (!has_words).then(|| Chart::new(format!("{column} over {name}"), of, [&name, column], vec![series]))
}

/// A value as a number, if it is a finite one.
fn number(value: &str) -> Option<f64> {
    value.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Round ticks where values are equidistant numbers, and the values elsewhere.
fn ticks(values: &[String]) -> Vec<(f64, String)> {
    let numbers: Option<Vec<f64>> = values.iter().map(|value| number(value)).collect();
    let named = || values.iter().enumerate().map(|(k, value)| (k as f64 + 0.5, value.clone())).collect();
    numbers.and_then(|numbers| ticks_of_cells(&numbers)).unwrap_or_else(named)
}

/// The kinds of cells, the one of each run, and the bar that explains colours.
type Kinds = (Vec<Kind>, Vec<Option<usize>>, Option<Bar>);

fn words(values: &[String]) -> Kinds {
    let mut known: Vec<&str> = Vec::new();
    for value in values.iter().filter(|value| !value.is_empty()) {
        if !known.contains(&value.as_str()) {
            known.push(value);
        }
    }
    let kind_of = |value: &String| known.iter().position(|word| word == value).map(|k| k.min(WORDS.len() - 1));
    let label = |k: usize| if k + 1 == WORDS.len() && known.len() > WORDS.len() { "others" } else { known[k] };
    let kinds = WORDS.iter().take(known.len()).enumerate();
    let kinds = kinds.map(|(k, &(fill, sign))| Kind { label: label(k).to_owned(), fill, sign });
    (kinds.collect(), values.iter().map(kind_of).collect(), None)
}

fn shades(numbers: &[Option<f64>]) -> Kinds {
    let Extent { least, most } = Extent::of(numbers.iter().flatten().copied());
    let is_logarithmic = least > 0.0 && most > MANY_DECADES * least;
    let scale = |value: f64| if is_logarithmic { value.ln() } else { value };
    let [from, to] = [least, most].map(scale);
    let step = (to - from) / STEPS as f64;
    if !(step.is_finite() && step > 0.0) {
        // There is one value, or none.
        let one = Kind { label: least.to_string(), fill: shade(0.5), sign: Sign::EMPTY };
        let kinds = if numbers.iter().any(Option::is_some) { vec![one] } else { Vec::new() };
        return (kinds, numbers.iter().map(|number| number.map(|_| 0)).collect(), None);
    }
    let kind_of = |number: &Option<f64>| number.map(|value| (((scale(value) - from) / step) as usize).min(STEPS - 1));
    let kind = |k: usize| {
        let fill = shade(k as f64 / (STEPS - 1) as f64);
        Kind { label: String::new(), fill, sign: Sign::EMPTY }
    };
    let scale = if is_logarithmic { Scale::Log } else { Scale::Linear };
    let bar = Bar { scale, range: [least, most] };
    ((0..STEPS).map(kind).collect(), numbers.iter().map(kind_of).collect(), Some(bar))
}

/// The colour at a share of the way from the first to the last.
pub(super) fn shade(share: f64) -> [u8; 3] {
    let at = share * (SHADES.len() - 1) as f64;
    let k = (at as usize).min(SHADES.len() - 2);
    let part = at - k as f64;
    std::array::from_fn(|c| ((1.0 - part) * f64::from(SHADES[k][c]) + part * f64::from(SHADES[k + 1][c])).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::{Varied, curve, line, scan};

    fn map(values: &[&str]) -> (Vec<String>, Vec<(usize, usize, usize)>) {
        let [x, y] = [["1", "2"], ["a", "b"]].map(|values| values.map(str::to_owned));
        let values: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
        let varied = [Varied { key: "x", values: &x }, Varied { key: "y", values: &y }];
        let map = scan("case", "column", varied, &values);
        assert!(map.to_svg().contains("column over x and y"));
        (map.kinds.into_iter().map(|kind| kind.label).collect(), map.panels[0].cells.clone())
    }

    #[test]
    fn numbers_have_shades_and_words_have_signs() {
        let (labels, cells) = map(&["0", "1", "", "8"]);
        assert!(labels.len() == 64 && labels.iter().all(String::is_empty));
        assert_eq!(cells, [(0, 0, 0), (0, 1, 8), (1, 1, 63)]);
        let (_, cells) = map(&["1e-8", "1e-4", "1e-6", "1"]);
        assert_eq!(cells, [(0, 0, 0), (0, 1, 32), (1, 0, 16), (1, 1, 63)]);
        assert_eq!(
            map(&["escaped", "captured", "escaped", ""]),
            (vec!["escaped".to_owned(), "captured".to_owned()], vec![(0, 0, 0), (0, 1, 1), (1, 0, 0)],)
        );
        let (labels, cells) = map(&["2", "2", "2", "2"]);
        assert_eq!((labels, cells), (vec!["2".to_owned()], vec![(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)]));
        assert!(map(&["", "", "", ""]).1.is_empty());
    }

    #[test]
    fn a_line_has_a_gap_where_a_run_has_no_number() {
        let texts = |values: &[&str]| -> Vec<String> { values.iter().map(|value| (*value).to_owned()).collect() };
        let [at, words] = [texts(&["1", "2", "3"]), texts(&["SBP21", "SBP42", "GLL4"])];
        let [of_numbers, of_words] = [("k", &at), ("sbp", &words)].map(|(key, values)| Varied { key, values });
        let chart = curve("case", "x", of_numbers, &texts(&["0.5", "", "7"])).unwrap();
        assert!(chart.series[0].points[1].1.is_nan() && chart.series[0].points[2] == (3.0, 7.0));
        let statuses = texts(&["converged", "stalled", ""]);
        assert!(curve("case", "status", of_numbers, &statuses).is_none());
        assert!(curve("case", "x", of_words, &at).is_none());
        let svg = line("case", "status", of_numbers, &statuses);
        assert!(svg.contains("status over k<") && svg.contains("stalled") && svg.contains("no value"), "{svg}");
    }
}
