//! The picture of a set of motions: the boxes in which they are proved to be.

use super::scan::Varied;
use crate::case::Case;
use crate::diagnostics::Extent;
use crate::geometry::Geometry;
use crate::number::Real;
use crate::number::norm::larger;
use crate::output::chart::{Chart, Mark, Series, Shape, Style};
use crate::study::proof::{Hull, OnWay};

/// From left to right, and from its low end to its high one.
type Box = ([f64; 2], [f64; 2]);

const BOX: Style = Style { colour: [20, 140, 225], shape: Shape::Circle };
/// Boxes are drawn that are at most so many times as large as the way of their middles, or the first box.
const LARGEST: f64 = 1.0;
const MIDDLE: Style = Style { colour: [0, 0, 0], shape: Shape::Circle };

/// The ends of a value that is an interval of two numbers.
pub fn ends_of(value: &str) -> Option<[f64; 2]> {
    let (low, high) = value.strip_prefix('[')?.strip_suffix(']')?.split_once(',')?;
    Some([low.trim().parse().ok()?, high.trim().parse().ok()?])
}

/// The hulls of a coordinate at the end over the intervals of the key that varies; none where they are not proved.
pub fn hulls(of: &str, column: &str, varied: Varied<'_>, [low, high]: [&[String]; 2]) -> Chart {
    let number = |cell: &String| cell.parse().unwrap_or(f64::NAN);
    let ends = low.iter().zip(high).map(|(low, high)| [number(low), number(high)]);
    let across = varied.values.iter().map(|value| ends_of(value).unwrap_or([f64::NAN; 2]));
    let boxes: Vec<Box> = across.zip(ends).collect();
    let title = format!("All {column} at the end over {}", varied.name());
    let series = Series::new("proved", Mark::LINE, boxes.iter().flat_map(around).collect()).with_look(BOX);
    Chart::new(title, of, [&varied.name(), column], vec![series])
}

fn middle_of(([left, right], [low, high]): &Box) -> (f64, f64) {
    (0.5 * (left + right), 0.5 * (low + high))
}

/// A point that is no number ends the line around a box.
fn around(([left, right], [low, high]): &Box) -> [(f64, f64); 6] {
    [(*left, *low), (*right, *low), (*right, *high), (*left, *high), (*left, *low), (f64::NAN, f64::NAN)]
}

/// The boxes on the axes of the orbit, if these are coordinates, and elsewhere those of the first one over γ.
pub fn of_hull(of: &str, case: &Case, hull: &Hull) -> Chart {
    let geometry: Geometry = case.geometry();
    let names = geometry.names();
    let place = |name: &String| names.iter().position(|other| other == name);
    let axes = case.orbits(&geometry).swap_remove(0).1;
    let of_orbit = place(&axes.x).zip(place(&axes.y)).map(|(x, y)| (Some(x), y));
    let (x, y) = of_orbit.unwrap_or((None, geometry.active().first().copied().unwrap_or(0)));
    let on = |at: &OnWay| {
        let ends = |a: usize| at.ends[a].unwrap_or([f64::NAN; 2]);
        (x.map_or([at.gamma.to_f64(); 2], ends), ends(y))
    };
    // While some motions have met an event and others have not, nothing is known.
    let is_known = |(across, along): &Box| across.iter().chain(along).all(|end| end.is_finite());
    let mut boxes: Vec<Box> = hull.way.iter().map(on).filter(is_known).collect();
    // Where a proof is lost boxes become larger than all of the motion, which could not be seen any more.
    let most = |side: fn(&Box) -> [f64; 2], middle: fn((f64, f64)) -> f64| {
        let way = Extent::of(boxes.iter().map(|one| middle(middle_of(one)))).range();
        boxes.first().map_or(0.0, |first| LARGEST * larger(way, side(first)[1] - side(first)[0]))
    };
    let [wide, high] = [most(|of| of.0, |at| at.0), most(|of| of.1, |at| at.1)];
    boxes.retain(|([left, right], [low, top])| right - left <= wide && top - low <= high);
    let series = vec![
        Series::new("all motions are in these boxes", Mark::LINE, boxes.iter().flat_map(around).collect())
            .with_look(BOX),
        Series::new("their middles", Mark::LINE, boxes.iter().map(middle_of).collect()).with_look(MIDDLE),
    ];
    let x_label = x.map_or("gamma", |x| &names[x]);
    Chart::new("Where all motions from the intervals are", of, [x_label, &names[y]], series)
}
