//! What the atlas asks of a scene of n coordinates.

use super::arena::{amplitude, half_range, largest};
use super::frequency::Linearised;
use super::line::Charted;
use super::status::Sizes;
use crate::geometry::Geometry;
use crate::solve::Place;
use crate::study::space::Point;

impl Charted for Geometry {
    const IS_SCENE: bool = true;

    fn frequencies(place: &Place, points: &[Point]) -> [f64; 2] {
        Linearised::new(&place.geometry).rates(points)
    }

    /// Coordinates of one unit share their size; see [`Geometry::alike`]. The range of γ in which the motion is felt is
    /// the shortest in which an active coordinate moves by its amplitude.
    fn sizes(place: &Place, points: &[Point], length: f64) -> Sizes {
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
        let k = || geometry.norm(start, &place.start.q_dot).abs();
        Sizes { q: all.map(size).collect(), k: if motion > 0.0 { motion } else { k() } }
    }

    /// Its tangent is given with its start.
    fn stretched(place: &Place, _: f64) -> Place {
        place.clone()
    }
}
