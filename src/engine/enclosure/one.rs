//! What drives the motion in one coordinate, and what of it does nothing.

use super::Enclosure;
use crate::geometry::metric::Metric;
use crate::geometry::potential::Potential;

impl Enclosure {
    /// For the motion of x in a potential; `None` where nothing can hide. The only variable of its path is x.
    pub(crate) fn of_metric(metric: &Metric) -> Option<Self> {
        match metric.potential() {
            Potential::Polynomial(_) => None,
            // V and V′ drive the motion.
            Potential::Formula(formula) => Self::new(formula.program(), 2, |_| true),
        }
    }
}

/// By how much V and V′ may change on all of the way, `length`, without moving t or x by more than a `share` of their
/// `sizes`, for motion with the charge `q_t` around x.
pub(crate) fn negligible_potential(
    metric: &Metric,
    (q_t, x): (f64, f64),
    length: f64,
    sizes: [f64; 2],
    share: f64,
) -> Vec<f64> {
    let (g00, two_over_mass) = (metric.g00(x), metric.two_over_mass());
    let u = (q_t / g00).abs();
    let [t_size, x_size] = sizes;
    // a = −½ g00′ u² moves x by a γ²/2 at most; a relative change of u = Q_t/g00 is that of t.
    let slope = 2.0 * share * x_size / (length * length * two_over_mass * u * u);
    vec![share * g00 / two_over_mass * t_size / t_size.max(u * length), slope]
}
