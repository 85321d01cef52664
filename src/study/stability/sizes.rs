//! The sizes by which trajectories of an atlas are judged.

use super::arena::{amplitude, half_range, largest};
use super::status::Sizes;
use crate::solve::Place;
use crate::study::space::Point;

/// The sizes by which trajectories with these points are judged. `points` are at least two, ends included. Coordinates
/// of one unit share their size. The range of γ in which the motion is felt is the shortest in which an active
/// coordinate moves by its amplitude.
pub(super) fn sizes(place: &Place, points: &[Point], length: f64) -> Sizes {
    let (geometry, start) = (&*place.geometry, &place.start.q);
    let all = 0..geometry.dimension();
    let is_active = |a: usize| geometry.active().contains(&a);
    let half = all.clone().map(|a| if is_active(a) { half_range(points, a) } else { 0.0 }).collect::<Vec<_>>();
    let speeds: Vec<f64> = all.clone().map(|a| largest(points, |point| point.q_dot[a])).collect();
    let [half, speeds] = [half, speeds].map(|row| geometry.shared(start, &row));
    let amplitude = |a: usize| amplitude(half[a], largest(points, |point| point.q[a]));
    let moved = geometry.active().iter().filter(|&&a| speeds[a] > 0.0).map(|&a| amplitude(a) / speeds[a]);
    let felt = moved.fold(length, f64::min);
    let size = |a: usize| if is_active(a) { amplitude(a) } else { (speeds[a] * felt).max(f64::MIN_POSITIVE) };
    let motion = points.iter().map(|point| geometry.motion(&point.q, &point.q_dot)).fold(0.0, f64::max);
    let k = if motion > 0.0 { motion } else { geometry.norm(start, &place.start.q_dot).abs() };
    if geometry.c_squared().is_some() {
        return Sizes { q: vec![time(points, amplitude(1)), amplitude(1)], k };
    }
    Sizes { q: all.map(size).collect(), k }
}

/// The size of t in one coordinate: the time in which x moves by its amplitude at its largest speed.
fn time(points: &[Point], amplitude: f64) -> f64 {
    let speed = largest(points, |point| point.q_dot[1] / point.q_dot[0]);
    let duration = points.last().map_or(0.0, |end| end.q[0].abs());
    if speed > 0.0 { duration.min(amplitude / speed) } else { duration }
}
