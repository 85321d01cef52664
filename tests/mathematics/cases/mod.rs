//! Case files of scenes: what they mean, and how a mistake in one is reported.

mod conformal;
mod ends;
mod fuzz;
mod malformed;
mod overrides;
mod parameters;
mod starts;
mod velocity;
mod written;

use geodesic_ivp::case::{Case, CaseError};

use crate::common::parsed;

/// A fall in the plane around a mass, with every table that a metric needs.
pub(crate) const SCHWARZSCHILD: &str = r#"
[metric]
coordinates = ["t", "r", "phi"]
components = { "t t" = "f", "r r" = "-1/f", "phi phi" = "-r^2" }
definitions = { f = "1 - 2*m/r" }
parameters = { m = 1.0 }

[initial]
r = 10.0
t_dot = 1.2
r_dot = -0.05
phi_dot = 0.03

[grid]
gamma_f = 40.0

[scheme]
sbp = "GLL12"
form = "weak"
"#;

/// Kepler's ellipse of eccentricity 0.9 under Newton's law.
pub(crate) const KEPLER: &str = r#"
[potential]
coordinates = ["x", "y"]
formula = "-1/sqrt(x^2 + y^2)"

[particle]
law = "newtonian"

[initial]
x = 0.1
y = 0
x_dot = 0
y_dot = "sqrt(19)"

[grid]
t_f = "2*pi"
n_gamma = 64

[scheme]
sbp = "SBP42"
"#;

/// An orbit around a rotating mass by its energy and angular momentum.
pub(crate) const KERR: &str = r#"
[metric]
preset = "kerr"
parameters = { a = 0.9, e = 0.95, l = 2.5 }
definitions = { w = "2*m*r/sigma" }

[initial]
r = 8.0
theta = "pi/2"
p_t = "e"
p_phi = "-l"
p_theta = 1.5
norm = "timelike"
solve = { r_dot = "+" }

[grid]
until = "r - 2.1"
gamma_f = 100

[scheme]
sbp = "GLL16"

[invariants]
carter = "p_theta^2 + cos(theta)^2*(a^2*(norm - p_t^2) + (p_phi/sin(theta))^2)"
"#;

/// The scene of a text that is valid.
pub(crate) fn scene(text: &str) -> Case {
    let case = parsed(text, &[]);
    assert!(!case.is_of_x, "{text}");
    case
}

/// The case of a text, or its mistake.
pub(crate) fn read(text: &str) -> Result<Case, CaseError> {
    Case::parse("test", text, &[])
}
