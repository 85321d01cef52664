//! The map of many runs over two keys that vary: a column of their table by colour.

use crate::diagnostics::Extent;
use crate::output::chart::{Kind, Map, Panel, Sign};

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
pub type Varied<'a> = (&'a str, &'a [String]);

/// A map of `values`, one for each combination of which the second key varies fastest; an empty one has no cell.
pub fn scan(of: &str, column: &str, [x, y]: [Varied<'_>; 2], values: &[String]) -> Map {
    let numbers: Vec<Option<f64>> =
        values.iter().map(|value| value.parse().ok().filter(|v: &f64| v.is_finite())).collect();
    let is_of_words = values.iter().zip(&numbers).any(|(value, number)| !value.is_empty() && number.is_none());
    let (kinds, kind_of) = if is_of_words { words(values) } else { shades(&numbers) };
    let cells = kind_of.iter().enumerate().filter_map(|(run, kind)| Some((run / y.1.len(), run % y.1.len(), (*kind)?)));
    let ticks = x.1.iter().enumerate().map(|(k, value)| (k as f64 + 0.5, value.clone())).collect();
    let panel = Panel { columns: x.1.len(), cells: cells.collect(), ticks, ..Panel::default() };
    Map {
        title: format!("{column} over {} and {}", x.0, y.0),
        subtitle: of.to_owned(),
        x_label: x.0.to_owned(),
        y_label: y.0.to_owned(),
        rows: y.1.to_vec(),
        kinds,
        absent: Kind { label: "no value".to_owned(), fill: [255; 3], sign: Sign::DOT },
        panels: vec![panel],
        line_label: String::new(),
    }
}

/// The kinds of cells, and the one of each run.
type Kinds = (Vec<Kind>, Vec<Option<usize>>);

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
    (kinds.collect(), values.iter().map(kind_of).collect())
}

fn shades(numbers: &[Option<f64>]) -> Kinds {
    let Extent { least, most } = Extent::of(numbers.iter().flatten().copied());
    let is_logarithmic = least > 0.0 && most > MANY_DECADES * least;
    let scale = |value: f64| if is_logarithmic { value.ln() } else { value };
    let [from, to] = [least, most].map(scale);
    let count = if to > from { SHADES.len() } else { usize::from(most >= least) };
    let step = (to - from) / count as f64;
    let kind_of = |number: &Option<f64>| {
        number.map(|value| if step > 0.0 { (((scale(value) - from) / step) as usize).min(count - 1) } else { 0 })
    };
    let edge = |k: usize| from + k as f64 * step;
    let text = |edge: f64| {
        let value = if is_logarithmic { edge.exp() } else { edge };
        let is_plain = value == 0.0 || (1e-2..1e4).contains(&value.abs());
        if is_plain { format!("{:.3}", value + 0.0) } else { format!("{value:.1e}") }
    };
    let kind = |k: usize| Kind {
        label: format!("{} … {}", text(edge(k)), text(edge(k + 1))),
        fill: SHADES[k * (SHADES.len() - 1) / (count.max(2) - 1)],
        sign: Sign::EMPTY,
    };
    ((0..count).map(kind).collect(), numbers.iter().map(kind_of).collect())
}

#[cfg(test)]
mod tests {
    use super::scan;

    fn map(values: &[&str]) -> (Vec<String>, Vec<(usize, usize, usize)>) {
        let [x, y] = [["1", "2"], ["a", "b"]].map(|values| values.map(str::to_owned));
        let values: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
        let map = scan("case", "column", [("x", &x), ("y", &y)], &values);
        assert!(map.to_svg().contains("column over x and y"));
        (map.kinds.into_iter().map(|kind| kind.label).collect(), map.panels[0].cells.clone())
    }

    #[test]
    fn numbers_have_shades_and_words_have_signs() {
        let (labels, cells) = map(&["0", "1", "", "8"]);
        assert_eq!((labels.len(), labels[0].as_str()), (8, "0.000 … 1.000"));
        assert_eq!(cells, [(0, 0, 0), (0, 1, 1), (1, 1, 7)]);
        let (labels, cells) = map(&["1e-8", "1e-4", "1e-6", "1"]);
        assert_eq!(labels[7], "1.0e-1 … 1.000".replace("1.0e-1", "0.100"));
        assert_eq!(cells, [(0, 0, 0), (0, 1, 4), (1, 0, 2), (1, 1, 7)]);
        assert_eq!(
            map(&["escaped", "captured", "escaped", ""]),
            (vec!["escaped".to_owned(), "captured".to_owned()], vec![(0, 0, 0), (0, 1, 1), (1, 0, 0)],)
        );
        assert_eq!(map(&["2", "2", "2", "2"]).1, [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)]);
        assert!(map(&["", "", "", ""]).1.is_empty());
    }
}
