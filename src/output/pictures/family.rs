//! A family of what a search finds.

use crate::case::Find;
use crate::output::chart::{Chart, Mark, Series};
use crate::study::find::{Family, Member};

/// The first unknown over the number that is followed, with the folds, as SVG.
pub fn family(title: &str, wanted: &Find, family: &Family) -> String {
    let last = wanted.unknowns.len() - 1;
    let point = |member: &Member| (member.values[last], member.values[0]);
    let curve = family.members.iter().map(point).collect();
    let folds: Vec<(f64, f64)> = family.members.iter().filter(|member| member.is_fold).map(point).collect();
    let mut series = vec![Series::new("", Mark::LINE, curve)];
    if !folds.is_empty() {
        series.push(Series::new("folds", Mark::POINTS, folds));
    }
    let [x, y] = [&wanted.unknowns[last].key, &wanted.unknowns[0].key];
    Chart::new(format!("{y} over {x}"), title, [x, y], series).to_svg()
}
