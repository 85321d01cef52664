//! The step that linear theory allows for a method.

use std::sync::Arc;

use nalgebra::{Complex, ComplexField};

use super::{Method, WINDOW};
use crate::case::{Form, SbpName};
use crate::geometry::{Geometry, GeometryText, Start};
use crate::methods::{Output, Peer, Problem, Setting};
use crate::sbp::symbol::{amplification, largest_symbol};

/// The relative growth of an oscillation over a window or step, above which it cannot be rounding.
const GROWTH: f64 = 1e-9;
/// The values of hω that are tried: the first, the last, and the factor from each to the next.
const TRIED: (f64, f64, f64) = (0.02, 30.0, 1.005);

/// The limit of a method in linear theory, for an oscillation of frequency ω with the step h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Stable for hω up to this.
    Step(f64),
    /// Stable for every step.
    None,
    /// Not applicable: the method chooses its steps.
    Adaptive,
}

impl Method {
    /// The step that linear theory allows, from the operator's or the method's own coefficients.
    ///
    /// For one block it is the limit of the interior stencil, see [`crate::sbp::symbol`], and for windows the condition
    /// |R(iω)| ≤ 1. The other methods are run: on x″ = −ω²x one step is a 2 × 2 matrix, and the step is allowed as long
    /// as its spectral radius is at most 1. For an implicit method it is also the step at which the iteration fails.
    pub fn limit(&self) -> Limit {
        match self {
            Self::Block(sbp, _) | Self::Unregularised(sbp) => {
                sbp.coefficients().map_or(Limit::None, |table| Limit::Step(largest_symbol(table)))
            }
            Self::Windows(sbp, form) => of_windows(*sbp, WINDOW + 1, *form),
            Self::Elements(nodes) => of_windows(SbpName::Gll(*nodes as u8), *nodes, Form::Weak),
            Self::Peer(peer) if !self.is_adaptive() => first_growing(|step| step_radius(*peer, step)),
            _ => Limit::Adaptive,
        }
    }
}

fn of_windows(sbp: SbpName, points: usize, form: Form) -> Limit {
    let Ok(operator) = sbp.operator(points, 1.0) else { return Limit::None };
    first_growing(|step| amplification(&operator, form == Form::Weak, Complex::new(0.0, step)).modulus())
}

/// The first hω at which an oscillation grows.
fn first_growing(radius: impl Fn(f64) -> f64) -> Limit {
    let (first, last, ratio) = TRIED;
    let grows = |step: f64| {
        let radius = radius(step);
        radius.is_nan() || radius > 1.0 + GROWTH
    };
    let (mut stable, mut step) = (0.0, first);
    while !grows(step) {
        (stable, step) = (step, step * ratio);
        if step > last {
            return Limit::None;
        }
    }
    for _ in 0..30 {
        let middle = 0.5 * (stable + step);
        if grows(middle) { step = middle } else { stable = middle }
    }
    // A method that grows at the first step tried is taken to grow for every step.
    Limit::Step(if stable < first { 0.0 } else { stable })
}

/// The spectral radius of one step of a method on x″ = −x; infinite if it fails.
fn step_radius(peer: Peer, step: f64) -> f64 {
    // So near to x = 0 the geodesic in V = x²/2 is a harmonic oscillation, up to rounding.
    const SMALL: f64 = 1e-12;
    let Ok(space) = Geometry::of_x(&GeometryText::of_x("x*x/2", 1.0, 1.0)).map(Arc::new) else { return f64::INFINITY };
    let column = |x: f64, x_dot: f64| {
        let (q, q_dot) = (vec![0.0, SMALL * x], vec![1.0, SMALL * x_dot]);
        let start = Start { p: space.momenta(&q, &q_dot), q, q_dot };
        let problem = Problem { space: Arc::clone(&space), start, length: step, g00: Some(vec![1.0, 0.0, 1.0]) };
        let states = peer.run(&problem, &Output::even(1), Setting::steps(1)).ok()?.states;
        let state = states.last()?;
        Some([state.q[1] / SMALL, -state.p[1] / SMALL])
    };
    let (Some([a, c]), Some([b, d])) = (column(1.0, 0.0), column(0.0, 1.0)) else { return f64::INFINITY };
    let (half_trace, determinant) = (0.5 * (a + d), a * d - b * c);
    let discriminant = half_trace * half_trace - determinant;
    if discriminant <= 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(method: Method) -> f64 {
        if let Limit::Step(step) = method.limit() { step } else { f64::NAN }
    }

    #[test]
    fn limits_are_those_of_the_textbooks() {
        assert!((step(Method::Block(SbpName::Sbp42, Form::Strong)) - 1.372).abs() < 6e-4);
        assert!((step(Method::Peer(Peer::Verlet)) - 2.0).abs() < 1e-3);
        assert!((step(Method::Peer(Peer::Rk4)) - 8.0_f64.sqrt()).abs() < 1e-3);
        // Windows of the weak form are A-stable; in the strong form each begins with an Euler step, which grows.
        for method in [Method::Windows(SbpName::Sbp21, Form::Weak), Method::Elements(8)] {
            assert_eq!(method.limit(), Limit::None, "{}", method.label());
        }
        assert_eq!(step(Method::Windows(SbpName::Sbp21, Form::Strong)), 0.0);
        assert_eq!(Method::Peer(Peer::Dop853).limit(), Limit::Adaptive);
    }
}
