//! The axes of the picture of an orbit.

use super::{Axes, Case};
use crate::geometry::Geometry;
use crate::number::Real;

impl Case {
    /// The axes of the pictures of the orbit, with what is drawn in them: every body in x and y, unless `[plot]` is
    /// given, or the one orbit, which has no name.
    pub fn orbits<S: Real>(&self, geometry: &Geometry<S>) -> Vec<(String, Axes)> {
        if self.bodies.is_empty() || self.axes.is_some() {
            return vec![(String::new(), self.axes_or_default(geometry))];
        }
        let axes = |name: &String| Axes { x: format!("x_{name}"), y: format!("y_{name}") };
        self.bodies.iter().map(|name| (name.clone(), axes(name))).collect()
    }

    /// The axes of `[plot]` or, without it, those that suit the coordinates: the Cartesian ones of coordinates that are
    /// called r, phi and perhaps theta; otherwise the first two coordinates besides t and a last one that the scene
    /// adds itself, active ones before others. A single one is drawn over t or, without that, against its velocity.
    fn axes_or_default<S: Real>(&self, geometry: &Geometry<S>) -> Axes {
        if let Some(axes) = self.axes() {
            return axes.clone();
        }
        let names = geometry.names();
        let has = |name: &str| names.iter().any(|other| other == name);
        let axes = |x: &str, y: &str| Axes { x: x.to_owned(), y: y.to_owned() };
        match (has("r") && has("phi"), has("theta")) {
            (true, true) => return axes("r*sin(theta)*cos(phi)", "r*sin(theta)*sin(phi)"),
            (true, false) => return axes("r*cos(phi)", "r*sin(phi)"),
            (false, _) => {}
        }
        let is_last_added = self.is_lifted() || self.geometry_text().tau().is_some();
        let is_place = |a: &usize| names[*a] != "t" && !(is_last_added && *a + 1 == names.len());
        let active = geometry.active().iter().copied().filter(is_place);
        let places: Vec<usize> = active.chain(geometry.ignorable().filter(is_place)).collect();
        match places.as_slice() {
            [] => axes(&names[0], &format!("{}_dot", names[0])),
            [one] if has("t") => axes("t", &names[*one]),
            [one] => axes(&names[*one], &format!("{}_dot", names[*one])),
            [x, y, ..] => axes(&names[*x], &names[*y]),
        }
    }
}
