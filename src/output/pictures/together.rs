//! The curves of several runs in one picture.

use super::run::{axes_of_orbits, names_of_run};
use crate::case::Case;
use crate::output::chart::{Chart, Mark, Scale, Series, Shape, Style, colour};

/// The curves of more runs than this cannot be told apart by their colours: black is that of what all have.
pub const MOST_TOGETHER: usize = 6;

/// A curve that all runs have, as a reference.
const SHARED: Style = Style { colour: [0, 0, 0], shape: Shape::Circle };
/// The lines of a run are told apart by their dashes, as its points are by their symbols.
const LINES: [Mark; 3] = [Mark::LINE, Mark::DASHED, Mark::DOTTED];

/// The names of the pictures that runs of all these cases have.
pub fn names_of_together(cases: &[&Case]) -> Vec<&'static str> {
    let (first, others) = cases.split_first().expect("there is a case");
    let others: Vec<Vec<&str>> = others.iter().map(|case| names_of_run(case)).collect();
    names_of_run(first).into_iter().filter(|name| others.iter().all(|names| names.contains(name))).collect()
}

/// The reason why runs of two cases are not drawn in one picture, in words that follow the names of both, if there is
/// one.
pub fn are_apart(one: &Case, other: &Case) -> Option<String> {
    let names = [one, other].map(Case::coordinates);
    if names[0] != names[1] {
        let [one, other] = names.map(|names| names.join(", "));
        return Some(format!("have other coordinates, {one} and {other}"));
    }
    let axes = [one, other].map(axes_of_orbits);
    (axes[0] != axes[1]).then(|| {
        let [one, other] = axes.map(|axes| axes.join("; "));
        format!("are drawn in other axes, {one} and {other}")
    })
}

/// One picture of the same kind for each run, which has a name, in one; of no runs a picture without data.
///
/// Colours are runs, and symbols or dashes what a run has several of. What all runs have in the same place is drawn
/// once, without the name of a run.
pub fn together(of: &str, mut charts: Vec<(String, Chart)>) -> Chart {
    let of_first = charts.first().map(|(_, chart)| chart.series.clone()).unwrap_or_default();
    let shared: Vec<Series> = of_first.into_iter().filter(|one| is_shared(one, &charts)).collect();
    let with_look = |one: &Series| one.clone().with_look(one.look.unwrap_or(SHARED));
    let mut series: Vec<Series> = shared.iter().map(with_look).collect();
    for (run, (name, chart)) in charts.iter_mut().enumerate() {
        let mut place = 0;
        chart.series.retain(|one| !shared.iter().any(|other| is_same(one, other)));
        let is_lone = chart.series.iter().filter(|one| one.look.is_none()).count() == 1;
        for one in std::mem::take(&mut chart.series) {
            if one.look.is_some() {
                // Starts and ends, and all else with a look of its own, are explained once.
                let is_known = series.iter().any(|other| other.label == one.label);
                series.push(Series { label: if is_known { String::new() } else { one.label.clone() }, ..one });
                continue;
            }
            let label = if is_lone || one.label.is_empty() { name.clone() } else { format!("{}, {name}", one.label) };
            let mark = if one.mark == Mark::LINE { LINES[place % LINES.len()] } else { one.mark };
            let look = Style { colour: colour(run), shape: Shape::ALL[place % Shape::ALL.len()] };
            series.push(Series { label, mark, ..one }.with_look(look));
            place += 1;
        }
    }
    joined(of, charts.into_iter().map(|(_, chart)| chart).collect(), series)
}

/// A picture with the axes of these, and these series.
fn joined(of: &str, charts: Vec<Chart>, series: Vec<Series>) -> Chart {
    let any_log = |scale: fn(&Chart) -> Scale| charts.iter().map(scale).find(|scale| *scale == Scale::Log);
    let (x_scale, y_scale) = (any_log(|chart| chart.x_scale), any_log(|chart| chart.y_scale));
    // Titles say what a picture is of and, behind a mark, what is to be seen of its own run.
    let kind = |chart: &Chart| chart.title.split([':', ';']).next().unwrap_or_default().to_owned();
    let is_one = |title: &dyn Fn(&Chart) -> String| charts.windows(2).all(|pair| title(&pair[0]) == title(&pair[1]));
    let has_one_title = is_one(&|chart| chart.title.clone());
    let (has_one_kind, is_isometric) = (is_one(&kind), charts.iter().all(|chart| chart.is_isometric));
    let first = charts.into_iter().next().unwrap_or_default();
    let title = match (has_one_title, has_one_kind) {
        (true, _) => first.title.clone(),
        (false, true) => kind(&first),
        (false, false) => String::new(),
    };
    Chart {
        title,
        subtitle: of.to_owned(),
        x_scale: x_scale.unwrap_or_default(),
        y_scale: y_scale.unwrap_or_default(),
        is_isometric,
        series,
        ..first
    }
}

/// Returns true if all pictures have this series. A curve without a name of its own is that of its run.
fn is_shared(one: &Series, charts: &[(String, Chart)]) -> bool {
    let has_name = charts.len() > 1 && !one.label.is_empty();
    has_name && charts.iter().all(|(_, chart)| chart.series.iter().any(|other| is_same(one, other)))
}

fn is_same(one: &Series, other: &Series) -> bool {
    one.label == other.label && one.points == other.points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with a reference that all have, the curves of a run, and its start.
    fn chart(title: &str, height: f64) -> Chart {
        let points = |y: f64| vec![(0.0, 0.0), (1.0, y)];
        let series = vec![
            Series::new("reference", Mark::LINE, points(5.0)),
            Series::new("a", Mark::POINTS, points(height)),
            Series::new("b", Mark::POINTS, points(-height)),
            Series::new("start", Mark::OPEN_POINTS, vec![(0.0, height)]).with_look(Style::NEUTRAL),
        ];
        Chart::new(title, "one run", ["x", "y"], series)
    }

    #[test]
    fn colours_are_runs_symbols_are_their_curves_and_what_all_have_is_drawn_once() {
        let charts = vec![("16".to_owned(), chart("Curves: 1", 1.0)), ("32".to_owned(), chart("Curves: 2", 2.0))];
        let picture = together("several", charts);
        let labels: Vec<&str> = picture.series.iter().map(|series| &*series.label).collect();
        assert_eq!(labels, ["reference", "a, 16", "b, 16", "start", "a, 32", "b, 32", ""]);
        let looks: Vec<Style> = picture.series.iter().map(|series| series.look.unwrap()).collect();
        assert!(looks[0] == SHARED && looks[3] == Style::NEUTRAL && looks[6] == Style::NEUTRAL);
        let [a, b, c, d] = [1, 2, 4, 5].map(|place| looks[place]);
        assert!(a.colour == b.colour && c.colour == d.colour && a.colour != c.colour);
        assert!(a.shape == c.shape && b.shape == d.shape && a.shape != b.shape);
        assert_eq!([&*picture.title, &picture.subtitle], ["Curves", "several"]);
    }

    #[test]
    fn a_lone_curve_has_the_name_of_its_run_and_one_logarithm_is_enough() {
        let lone = |y_scale, height: f64| {
            let series = vec![Series::new("|x|", Mark::POINTS, vec![(0.0, height)])];
            Chart { y_scale, ..Chart::new("x", "", ["t", "x"], series) }
        };
        let charts = vec![("a".to_owned(), lone(Scale::Linear, 1.0)), ("b".to_owned(), lone(Scale::Log, 2.0))];
        let picture = together("", charts);
        assert_eq!(picture.series.iter().map(|series| &*series.label).collect::<Vec<_>>(), ["a", "b"]);
        assert_eq!((picture.x_scale, picture.y_scale, &*picture.title), (Scale::Linear, Scale::Log, "x"));
    }
}
