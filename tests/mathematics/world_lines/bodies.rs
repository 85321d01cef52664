//! `[[body]]`: bodies are the potential that one would write for them, and a body without mass moves no other.

use crate::common::text_solved;

pub(crate) const BODIES: &str = r#"
    pair = { formula = "-g*m_1*m_2/r", parameters = { g = 2.0, mu = 1e-3 } }
    grid.t_f = 10.0
    solver.accuracy = 1e-10

    [[body]]
    name = "sun"
    mass = 1.0
    position = [0.0, 0.0]
    velocity = [0.0, "-mu"]

    [[body]]
    name = "planet"
    mass = "mu"
    position = [1.0, 0.0]
    velocity = [0.0, 1.25]
"#;
pub(crate) const DUST: &str = "[[body]]\nname = \"dust\"\nmass = 0\nposition = [0.0, -2.0]\nvelocity = [1.0, 0.0]\n";
const WRITTEN: &str = r#"
    potential.coordinates = ["x", "y", "u", "v"]
    potential.formula = "-g*mu/sqrt((x - u)^2 + (y - v)^2)"
    parameters = { g = 2.0, mu = 1e-3 }
    particle = { law = "newtonian", masses = { x = 1.0, y = 1.0, u = "mu", v = "mu" } }
    initial = { x = 0.0, y = 0.0, u = 1.0, v = 0.0, x_dot = 0.0, y_dot = "-mu", u_dot = 0.0, v_dot = 1.25 }
    grid.t_f = 10.0
    solver.accuracy = 1e-10
"#;

#[test]
fn bodies_are_a_potential_in_their_coordinates() {
    let (bodies, written) = (text_solved(BODIES), text_solved(WRITTEN));
    assert_eq!(bodies.geometry().names(), ["t", "x_sun", "y_sun", "x_planet", "y_planet", "s"]);
    for (a, q) in written.end().q.iter().enumerate() {
        assert!((bodies.end().q[a] - q).abs() < 1e-13, "{a}: {} {q}", bodies.end().q[a]);
    }
}

/// Half of g = 2 keeps it on a circle of radius 2 around the sun, but for the planet's mass.
#[test]
fn a_body_without_mass_moves_no_other() {
    let (two, three) = (text_solved(BODIES), text_solved(&format!("{BODIES}{DUST}")));
    for a in 1..5 {
        assert!((two.end().q[a] - three.end().q[a]).abs() < 1e-12, "{a}");
    }
    let [x, y] = [5, 6].map(|a| three.end().q[a]);
    assert!((x.hypot(y) - 2.0).abs() < 0.02, "{x} {y}");
}
