//! The metric diag(g00(x), −1) of the curved space-time in which the particle moves freely. This module knows no grid.
//!
//! ```
//! use geodesic_ivp::geometry::metric::Metric;
//! use geodesic_ivp::geometry::potential::Potential;
//!
//! let metric = Metric::new(Potential::linear(-0.5), 1.0, 1.0);
//! assert_eq!(metric.at(0.5).g00, 0.5);
//! assert!(!metric.at(1.0).is_inside(), "a horizon");
//! ```

mod motion;

pub use motion::{G00, G00_FIRST, G00_SECOND, MetricRoom, acceleration, acceleration_slope};

use std::sync::OnceLock;

use crate::geometry::potential::Potential;
use crate::geometry::{Geometry, Structure};
use crate::number::Real;

/// g00(x) = c² + 2V(x)/m for a particle of mass m in the potential V.
///
/// It is defined where g00 > 0. Its geodesics approach Newton's mechanics where |V| ≪ mc² and speeds are far below c.
#[derive(Debug, Clone)]
pub struct Metric<S = f64> {
    potential: Potential<S>,
    c_squared: S,
    /// 2/m.
    two_over_mass: S,
    /// Made when the doubled action is.
    structure: OnceLock<Structure<S>>,
    /// Made when the engine runs in it.
    scene: OnceLock<Box<Geometry<S>>>,
}

/// g00 with its first two derivatives at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetricJet<S = f64> {
    /// g00(x); its unit is that of c².
    pub g00: S,
    /// dg00/dx.
    pub first: S,
    /// d²g00/dx².
    pub second: S,
}

impl<S: Real> MetricJet<S> {
    /// Whether the point lies inside the space-time: everything finite and g00 > 0.
    #[inline]
    pub fn is_inside(&self) -> bool {
        self.g00 > S::ZERO && self.g00.is_finite() && self.first.is_finite()
    }
}

/// g00 and its derivatives at many points, one contiguous array each.
#[derive(Debug, Clone)]
pub struct MetricSamples<S = f64> {
    /// g00(x_k).
    pub g00: Vec<S>,
    /// g00′(x_k).
    pub first: Vec<S>,
    /// g00″(x_k).
    pub second: Vec<S>,
}

impl<S: Real> MetricSamples<S> {
    /// Samples at `points` points, all zero, to be filled in.
    pub fn zeros(points: usize) -> Self {
        Self { g00: vec![S::ZERO; points], first: vec![S::ZERO; points], second: vec![S::ZERO; points] }
    }
}

/// A point lies outside the space-time: g00 ≤ 0 (a horizon) or not finite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("x = {x} lies outside the domain: g00 = {g00}")]
pub struct OutsideDomain {
    /// Index of the point in the array that was sampled.
    pub index: usize,
    /// Its coordinate.
    pub x: f64,
    /// g00 there.
    pub g00: f64,
}

impl<S: Real> Metric<S> {
    /// The metric of a particle of the given `mass` in `potential`, with the speed of light `c`.
    pub fn new(potential: Potential<S>, mass: S, c: S) -> Self {
        let (structure, scene) = (OnceLock::new(), OnceLock::new());
        Self { potential, c_squared: c * c, two_over_mass: S::from(2.0) / mass, structure, scene }
    }

    /// The same space-time as a scene in t and x.
    pub fn scene(&self) -> &Geometry<S> {
        self.scene.get_or_init(|| Box::new(Geometry::of_one_coordinate(self)))
    }

    /// c².
    pub fn c_squared(&self) -> S {
        self.c_squared
    }

    /// 2/m.
    pub fn two_over_mass(&self) -> S {
        self.two_over_mass
    }

    /// The potential V.
    pub fn potential(&self) -> &Potential<S> {
        &self.potential
    }

    /// g00, g00′, g00″ at `x`.
    #[inline]
    pub fn at(&self, x: S) -> MetricJet<S> {
        let v = self.potential.at(x);
        MetricJet {
            g00: self.c_squared + self.two_over_mass * v.value,
            first: self.two_over_mass * v.first,
            second: self.two_over_mass * v.second,
        }
    }

    /// g00 at `x`.
    #[inline]
    pub fn g00(&self, x: S) -> S {
        self.c_squared + self.two_over_mass * self.potential.value(x)
    }

    /// g00 and g00′ at `x`.
    #[inline]
    pub fn g00_and_slope(&self, x: S) -> [S; 2] {
        let [value, first] = self.potential.value_and_slope(x);
        [self.c_squared + self.two_over_mass * value, self.two_over_mass * first]
    }

    /// g00, g00′, g00″ at every entry of `x`.
    ///
    /// # Errors
    /// [`OutsideDomain`] with the first point where g00 is not positive and finite.
    pub fn sample(&self, x: &[S]) -> Result<MetricSamples<S>, OutsideDomain> {
        let mut samples = MetricSamples::zeros(x.len());
        self.sample_into(x, &mut samples)?;
        Ok(samples)
    }

    /// Does the same as [`Self::sample`], into arrays that exist already. They must be as long as `x`.
    ///
    /// # Errors
    /// [`OutsideDomain`] with the first point where g00 is not positive and finite.
    pub fn sample_into(&self, x: &[S], samples: &mut MetricSamples<S>) -> Result<(), OutsideDomain> {
        let MetricSamples { g00, first, second } = samples;
        self.sample_rows(x, [g00, first, second])
    }

    fn sample_rows(&self, x: &[S], [g00, first, second]: [&mut [S]; 3]) -> Result<(), OutsideDomain> {
        self.potential.sample(x, [&mut *g00, &mut *first, &mut *second]);
        for g in g00.iter_mut() {
            *g = self.c_squared + self.two_over_mass * *g;
        }
        for derivative in first.iter_mut().chain(second) {
            *derivative *= self.two_over_mass;
        }
        let outside = |k: &usize| !MetricJet { g00: g00[*k], first: first[*k], second: S::ZERO }.is_inside();
        match (0..x.len()).find(outside) {
            Some(index) => Err(OutsideDomain { index, x: x[index].to_f64(), g00: g00[index].to_f64() }),
            None => Ok(()),
        }
    }
}
