//! Warnings about cases that are valid but may surprise.

use super::{Case, PotentialSpec, Scheme};
use crate::geometry::{Geometry, Start};

/// If K is below this share of g00 ṫ², it is a small difference of large numbers and has lost digits.
const NEARLY_SPACELIKE: f64 = 1e-2;

impl Case {
    /// What a user should know before believing the result.
    pub fn warnings(&self) -> Vec<String> {
        let geometry: Geometry = self.geometry();
        let Start { q, q_dot, .. } = self.start_in(&geometry);
        let k = geometry.norm(&q, &q_dot);
        let mut warnings = Vec::new();
        if !self.scheme.regularised {
            warnings.push(
                "regularised = false: without the regularisation critical points are wrong or missing".to_owned(),
            );
        }
        if self.solver.chooses_windows() && self.scheme != Scheme::default() {
            warnings.push(
                "with solver.accuracy or solver.tolerance the program chooses operator and form (weak): what [scheme] \
                 says is not used"
                    .to_owned(),
            );
        }
        if let PotentialSpec::Formula(spec) = &self.potential {
            let unused = spec.unused_parameters().into_iter();
            warnings.extend(unused.map(|name| format!("the formula does not use the parameter '{name}'")));
        }
        if k < 0.0 {
            warnings.push(format!(
                "the initial tangent is spacelike (K = g00 t_dot^2 - x_dot^2 = {:.6} < 0): the particle starts faster \
                 than light, and the bound on H_BVP does not hold; for a motion of matter start slower, or raise \
                 particle.c",
                k
            ));
        }
        let timelike = k + q_dot[1].powi(2);
        if (0.0..NEARLY_SPACELIKE * timelike).contains(&k) {
            warnings.push(format!(
                "the initial tangent is nearly spacelike: K = {:.2e} is below {NEARLY_SPACELIKE} of g00 t_dot^2 = \
                 {timelike:.2e}; the particle starts almost with the speed of light, and K has lost digits: start \
                 slower, or raise solver.digits",
                k
            ));
        }
        warnings
    }
}
