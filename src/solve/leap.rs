//! Steps of an explicit rule that are long enough to leap over what lies outside the domain: a horizon and what is
//! behind it. The nodes on both sides are inside, and say nothing.

use crate::geometry::{Geometry, OutsideGeometry};
use crate::number::Real;

/// A step is looked into if some coordinate changes by more than this multiple of its largest change so far.
const LONG: f64 = 2.0;
/// Most pieces that a step is divided into.
const MOST_PIECES: f64 = 1024.0;

/// The first point outside the domain within a long step, on the straight line from node to node, with the index of the
/// node behind it. `q` has a row for each coordinate. A step is divided into pieces as long as the longest one before.
pub(super) fn outside<S: Real>(geometry: &Geometry<S>, q: &[Vec<S>]) -> Option<OutsideGeometry> {
    let mut long: Vec<(usize, f64)> = geometry.active().iter().flat_map(|&a| long_steps(&q[a])).collect();
    long.sort_by_key(|&(k, _)| k);
    long.chunk_by(|(one, _), (other, _)| one == other).find_map(|steps| {
        let ratio = steps.iter().fold(0.0, |most, &(_, ratio)| f64::max(most, ratio));
        within(geometry, q, steps[0].0, ratio.ceil().min(MOST_PIECES) as usize)
    })
}

/// The steps of a coordinate that are much longer than the longest one before, with the ratio.
fn long_steps<S: Real>(row: &[S]) -> Vec<(usize, f64)> {
    let (mut longest, mut long) = (0.0_f64, Vec::new());
    for (k, pair) in row.windows(2).enumerate() {
        let change = (pair[1] - pair[0]).abs().to_f64();
        if change > LONG * longest && longest > 0.0 {
            long.push((k + 1, change / longest));
        }
        longest = longest.max(change);
    }
    long
}

/// The first point outside the domain between nodes k − 1 and k, among those that divide the step into equal pieces.
fn within<S: Real>(geometry: &Geometry<S>, q: &[Vec<S>], k: usize, pieces: usize) -> Option<OutsideGeometry> {
    let share = |piece: usize| S::from(piece as f64 / pieces as f64);
    let inside = |row: &Vec<S>| (1..pieces).map(|piece| row[k - 1] + share(piece) * (row[k] - row[k - 1])).collect();
    let points: Vec<Vec<S>> = q.iter().map(inside).collect();
    let rows: Vec<&[S]> = points.iter().map(Vec::as_slice).collect();
    let outside = geometry.fill(&rows, &mut geometry.room(pieces - 1)).err()?;
    Some(OutsideGeometry { index: k, ..outside })
}

#[cfg(test)]
mod tests {
    use super::outside;
    use crate::geometry::{Geometry, GeometryText, MetricText};

    /// g_tt is negative on an interval of x, which only the last step leaps over.
    #[test]
    fn a_leap_over_what_is_outside_is_seen() {
        let leap = |from: f64, to: f64, [hole, width]: [f64; 2]| {
            let t_t = format!("(x - ({hole:?}))^2 - {:?}", width * width);
            let components = [([0, 0], t_t), ([1, 1], "-1".to_owned())];
            let text = MetricText {
                coordinates: ["t", "x"].map(str::to_owned).to_vec(),
                components: components.to_vec(),
                ..MetricText::default()
            };
            let geometry: Geometry = Geometry::new(&GeometryText::Metric(text)).unwrap().around(&[0.0, from]).unwrap();
            let before = from + 0.1 * (from - to).signum();
            outside(&geometry, &[vec![0.0, 1.0, 2.0], vec![before, from, to]]).map(|outside| outside.index)
        };
        for (from, to) in [(-1.0, 1.0), (1.0, -1.0), (2.0, 4.0)] {
            let middle = 0.5 * (from + to);
            assert_eq!(leap(from, to, [middle, 0.2]), Some(2), "{from} {to}");
            assert_eq!(leap(from, to, [from + 0.8 * (to - from), 0.15]), Some(2), "{from} {to}");
            // A hole that lies on no way is not leapt over, and steps that grow slowly are no leaps.
            assert_eq!(leap(from, to, [10.0, 0.2]), None, "{from} {to}");
            assert_eq!(leap(from, from + 0.15, [middle, 0.2]), None, "{from} {to}");
        }
    }
}
