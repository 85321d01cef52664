//! Random potentials of one coordinate, with something in them that is no polynomial on a window.

use super::random::Random;

/// Draws the kind of a potential, and a case with it but without a scheme. Cusps are no narrower than `narrowest`, and
/// `hump` gives the place and the width of a hump.
pub(crate) fn rough(random: &mut Random, narrowest: f64, hump: fn(&mut Random) -> [f64; 2]) -> (&'static str, String) {
    let c: f64 = [1.0, 3.0, 10.0][random.next() as usize % 3];
    let strength = random.scale(0.05, 0.4) * c * c;
    let (kind, formula) = match random.next() % 6 {
        0 => ("cusp", format!("{strength}*sqrt(x^2 + {}^2)", random.scale(narrowest, 0.1))),
        1 => ("kink", format!("{strength}*abs(x - {})", random.between(-0.3, 0.3))),
        2 => ("wall", format!("{strength}*tanh({}*(x - 1))", random.scale(1.0, 200.0))),
        3 => ("power", format!("{strength}*x^{}", 2 * (2 + random.next() % 10))),
        4 => {
            let [place, width] = hump(random);
            ("hump", format!("{strength}*exp(-((x - {place})/{width})^2)"))
        }
        _ => {
            let s = random.scale(1e-3, 0.1);
            ("cusps", format!("{strength}*(sqrt((x - 0.3)^2 + {s}^2) + abs(x + 0.2))"))
        }
    };
    let t_dot = random.scale(1.0, 4.0);
    let start = [random.between(-0.9, 0.9), t_dot, random.between(-0.6, 0.6) * c * t_dot];
    let end = ("gamma_f", random.scale(0.5, 12.0) / t_dot);
    (kind, one_coordinate(&formula, c, start, end))
}

/// Writes a case without a scheme from V, c, the start in x, dt/dγ and dx/dγ, and the name of the end with its value.
pub(crate) fn one_coordinate(formula: &str, c: f64, [x, t_dot, x_dot]: [f64; 3], (name, end): (&str, f64)) -> String {
    format!(
        "[potential]\nformula = \"{formula}\"\n[particle]\nc = {c:?}\n[initial]\nx = {x:?}\nt_dot = {t_dot:?}\n\
         x_dot = {x_dot:?}\n[grid]\n{name} = {end:?}\n"
    )
}
