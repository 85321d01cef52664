//! How the rate of the motion goes on, and how long windows may be for it.
//!
//! How fast the modes of a window fall is decided by the nearest singularity of the motion in complex γ. Where the rate
//! has a pole its inverse, the time scale, has a root. So the roots of the quadratic polynomial through the time scales
//! at three points of a window tell where the singularities are. That is a model, but it is only used to compare two
//! windows: the one that was solved, whose modes are known, and the next. (Near a mass the rate is r^(-3/2), and r² is
//! nearly quadratic; the power that follows from that does worse than this one, on ellipses too.)

/// The rate of the motion, in radians, at the start of a window, at an inner point and at its end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    /// What part of the window comes before the inner point.
    pub(super) part: f64,
    pub(super) rates: [f64; 3],
    /// The factor by which the modes of the window fall from one to the next.
    pub(super) fall: f64,
}

/// |z| and Re z of a singularity z, in lengths of the window from its end.
type Pole = (f64, f64);

impl Course {
    /// Whether the rate changes by more than this factor.
    pub(super) fn is_uneven(&self, factor: f64) -> bool {
        let [least, most] = [f64::min, f64::max].map(|pick| self.rates.into_iter().fold(self.rates[0], pick));
        most > factor * least
    }

    /// The length of the next window in units of this one, so that its modes fall as fast as they would in this one if
    /// it were `fit` times as long. `None` if the course has no poles, or if the modes fall faster than its poles
    /// allow: then these are not those of the motion. Such is the course of an anharmonic oscillator, the rate of which
    /// is zero in the middle of its way.
    ///
    /// A window \[0, w\] whose polynomials converge in the ellipse through z with half the sum of the axes ρw/2 has
    /// (ρ + 1/ρ)/2 = (|z| + |z − w|)/w.
    pub(super) fn next(&self, fit: f64) -> Option<f64> {
        let poles = self.poles()?;
        let axis = |&(size, real): &Pole| size + (size * size + 2.0 * real + 1.0).max(0.0).sqrt();
        let axis = poles.iter().map(axis).fold(f64::INFINITY, f64::min).max(1.0);
        let radius = axis + (axis * axis - 1.0).sqrt();
        if radius * self.fall < 1.0 {
            return None;
        }
        let radius = radius / fit;
        let axis = 0.5 * (radius + 1.0 / radius);
        if radius <= 1.0 {
            return None;
        }
        let longest = |&(size, real): &Pole| 2.0 * (axis * size - real) / (axis * axis - 1.0);
        let next = poles.iter().map(longest).fold(f64::INFINITY, f64::min);
        (next.is_finite() && next > 0.0).then_some(next)
    }

    /// The roots of the quadratic polynomial through the time scales.
    fn poles(&self) -> Option<[Pole; 2]> {
        let [start, inner, end] = self.rates.map(|rate| 1.0 / rate);
        // Differences over [−1, −1 + part], [−1 + part, 0].
        let (first, second) = ((inner - start) / self.part, (end - inner) / (1.0 - self.part));
        let a = second - first;
        let b = second + a * (1.0 - self.part);
        let disc = b * b - 4.0 * a * end;
        if disc < 0.0 {
            return Some([((end / a).sqrt(), -0.5 * b / a); 2]);
        }
        let q = -0.5 * (b + disc.sqrt().copysign(b));
        let roots = [end / q, q / a];
        // A course that is a straight line has one root.
        let roots = roots.map(|root| if root.is_finite() { root } else { end / q });
        roots.iter().all(|root| root.is_finite()).then(|| roots.map(|root| (root.abs(), root)))
    }
}

#[cfg(test)]
mod tests {
    use super::Course;

    /// Of a rate with the poles ± i b around a periapsis, over a window.
    fn passing(periapsis: f64, b: f64, start: f64, h: f64) -> Course {
        let rate = |gamma: f64| 1.0 / ((gamma - periapsis).powi(2) + b * b);
        Course { part: 0.4, rates: [start, start + 0.4 * h, start + h].map(rate), fall: 1.0 }
    }

    /// ρ of a window with the singularities ± i b around a periapsis.
    fn radius(periapsis: f64, b: f64, start: f64, h: f64) -> f64 {
        let to = |gamma: f64| (gamma - periapsis).hypot(b);
        let axis = (to(start) + to(start + h)) / h;
        axis + (axis * axis - 1.0).sqrt()
    }

    #[test]
    fn modes_fall_as_fast_in_the_next_window() {
        for (b, start, h) in [(0.1, -2.0, 1.0), (0.1, -0.3, 0.2), (0.1, -0.05, 0.1), (0.1, 0.05, 0.2), (1.0, 3.0, 2.0)]
        {
            for fit in [0.8, 1.0, 1.3] {
                let next = passing(0.0, b, start, h).next(fit).unwrap();
                let (before, after) = (radius(0.0, b, start, h), radius(0.0, b, start + h, next * h));
                assert!((after * fit / before - 1.0).abs() < 1e-9, "{b} {start}: {before}, {after}");
            }
        }
    }

    #[test]
    fn a_singularity_ahead_is_approached_in_even_steps() {
        // A fall into a centre: r = (−γ)^(2/3) has the rate 1/(−γ), and windows shrink with γ.
        let rate = |gamma: f64| 1.0 / -gamma;
        let next = |start: f64, h: f64| {
            Course { part: 0.5, rates: [start, start + 0.5 * h, start + h].map(rate), fall: 1.0 }.next(1.0).unwrap()
        };
        let (first, second) = (next(-1.0, 0.4), next(-0.1, 0.04));
        assert!((first - second).abs() < 1e-9 && first < 0.8 && first > 0.2, "{first}, {second}");
    }

    #[test]
    fn modes_that_fall_faster_than_poles_allow_have_others() {
        // The rate of an oscillator in x⁴ over the middle of its way.
        let course = |fall| Course { part: 0.5, rates: [2.0, 0.02, 2.0], fall };
        assert!(course(1.0 / 1.01).next(1.0).is_some());
        assert_eq!(course(1.0 / 2.5).next(1.0), None);
        let radius = radius(0.0, 0.1, -0.3, 0.2);
        let course = |fall| Course { fall, ..passing(0.0, 0.1, -0.3, 0.2) };
        assert!(course(1.001 / radius).next(1.0).is_some() && course(0.999 / radius).next(1.0).is_none());
    }

    #[test]
    fn a_course_without_shape_says_nothing() {
        let of = |rates| Course { part: 0.5, rates, fall: 1.0 }.next(1.0);
        assert_eq!(of([f64::NAN, 1.0, 2.0]), None);
        assert!(of([0.0, 0.0, 0.0]).is_none_or(|next| next > 0.0));
        // A constant rate has no poles, a nearly constant one keeps its length.
        let nearly = of([1.0, 1.0 + 1e-6, 1.0 + 2e-6]).unwrap();
        assert!((nearly - 1.0).abs() < 1e-3, "{nearly}");
        assert!(Course { part: 0.5, rates: [1.0, 1.6, 1.0], fall: 1.0 }.is_uneven(1.5));
        assert!(!Course { part: 0.5, rates: [1.0, 1.4, 1.0], fall: 1.0 }.is_uneven(1.5));
    }
}
