//! Leaves out points of long series that do not change the picture.

use std::collections::BTreeMap;

use super::page::At;

/// A line is drawn to this part of a pixel.
const FLAT: f64 = 0.1;
/// A line of more points than this is drawn in strokes.
const MANY: usize = 20_000;
/// Points that follow each other within this part of a pixel are a stroke from the lowest to the highest. A curve that
/// turns back in x would have corners there.
const COLUMN: f64 = 0.5;

/// A line without the points that lie on it anyway.
pub(super) fn line(run: &[At]) -> Vec<At> {
    let column = |points: &[At]| {
        let rows = || points.iter().enumerate();
        let low = rows().min_by(|a, b| a.1.1.total_cmp(&b.1.1)).map_or(0, |row| row.0);
        let high = rows().max_by(|a, b| a.1.1.total_cmp(&b.1.1)).map_or(0, |row| row.0);
        let mut kept = vec![0, low, high, points.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        kept.into_iter().map(|k| points[k]).collect::<Vec<_>>()
    };
    let run: Vec<At> = match run.len() {
        ..=MANY => run.to_vec(),
        _ => run.chunk_by(|a, b| (a.0 / COLUMN).floor() == (b.0 / COLUMN).floor()).flat_map(column).collect(),
    };
    // The point that is farthest from a chord is kept, and what is before and behind it is looked at in the same way.
    let mut is_kept = vec![false; run.len()];
    let mut chords = vec![(0, run.len().saturating_sub(1))];
    while let Some((from, to)) = chords.pop() {
        let Some((&start, &end)) = run.get(from).zip(run.get(to)) else { break };
        (is_kept[from], is_kept[to]) = (true, true);
        let far = (from + 1..to).map(|k| (distance(run[k], start, end), k));
        if let Some((_, k)) = far.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|far| far.0 > FLAT) {
            chords.extend([(from, k), (k, to)]);
        }
    }
    run.into_iter().zip(is_kept).filter(|(_, is_kept)| *is_kept).map(|(at, _)| at).collect()
}

/// The distance of a point from the stroke between two others.
fn distance(at: At, start: At, end: At) -> f64 {
    let (dx, dy) = (end.0 - start.0, end.1 - start.1);
    let along = ((at.0 - start.0) * dx + (at.1 - start.1) * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
    let share = along.clamp(0.0, 1.0);
    (at.0 - start.0 - share * dx).hypot(at.1 - start.1 - share * dy)
}

/// At most so many places of symbols: of those in a square of some pixels the lowest and the highest.
pub(super) fn marks(marks: Vec<At>, most: usize) -> Vec<At> {
    let mut size = 1.0;
    let mut kept = marks;
    while kept.len() > most {
        size += 1.0;
        let mut squares: BTreeMap<(i32, i32), (At, At)> = BTreeMap::new();
        for &at in &kept {
            let square = ((at.0 / size) as i32, (at.1 / size) as i32);
            let (high, low) = squares.entry(square).or_insert((at, at));
            *high = if at.1 < high.1 { at } else { *high };
            *low = if at.1 > low.1 { at } else { *low };
        }
        kept = squares
            .into_values()
            .flat_map(|(high, low)| if high == low { vec![low] } else { vec![high, low] })
            .collect();
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave over 500 columns with a spike.
    fn wave() -> Vec<At> {
        let spike = |k: i32| if k == 4321 { 300.0 } else { 0.0 };
        (0..30_000).map(|k| (f64::from(k) / 60.0, 100.0 + 40.0 * (f64::from(k) / 900.0).sin() + spike(k))).collect()
    }

    #[test]
    fn what_is_left_shows_the_same() {
        let points = wave();
        let drawn = line(&points);
        assert!(drawn.len() < 800, "{}", drawn.len());
        // A line is nowhere farther away than the width of a column, and a spike stays.
        for &at in &points {
            let near = drawn.windows(2).map(|ends| distance(at, ends[0], ends[1])).fold(f64::INFINITY, f64::min);
            assert!(near <= COLUMN, "{at:?} {near}");
        }
        let thinned = marks(points.clone(), 700);
        assert!((300..=700).contains(&thinned.len()));
        let extremes = |points: &[At]| {
            let rows = || points.iter().map(|p| p.1);
            (rows().fold(f64::INFINITY, f64::min), rows().fold(0.0, f64::max))
        };
        assert_eq!(extremes(&thinned), extremes(&points));
    }

    #[test]
    fn a_circle_has_no_corners() {
        let circle: Vec<At> =
            (0..=2000).map(|k| f64::from(k) * std::f64::consts::TAU / 2000.0).map(f64::sin_cos).collect();
        let drawn = line(&circle.iter().map(|(x, y)| (60.0 * x, 60.0 * y)).collect::<Vec<_>>());
        let longest =
            drawn.windows(2).map(|ends| (ends[1].0 - ends[0].0).hypot(ends[1].1 - ends[0].1)).fold(0.0, f64::max);
        // A chord of a circle is this far from it: c²/(8 r).
        assert!(longest * longest / 480.0 <= 1.1 * FLAT, "{longest}");
    }

    #[test]
    fn a_line_keeps_its_order_and_its_ends() {
        let there_and_back = [(0.0, 0.0), (5.0, 1.0), (0.0, 2.0), (5.0, 3.0)];
        assert_eq!(line(&there_and_back), there_and_back);
        assert_eq!(line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.05), (3.0, 0.0)]), [(0.0, 0.0), (3.0, 0.0)]);
        assert_eq!((line(&[]), line(&[(1.0, 1.0)])), (vec![], vec![(1.0, 1.0)]));
    }
}
