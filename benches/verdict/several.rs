//! Random scenes of several coordinates.

use super::random::Random;

/// Draws the kind of a scene, and the scene as a case without a scheme.
pub(crate) fn several(random: &mut Random) -> (&'static str, String) {
    match random.next() % 6 {
        0 => ("newtonian", potential(random, "law = \"newtonian\"")),
        1 => {
            let c = random.between(3.0, 8.0);
            ("relativistic", potential(random, &format!("c = {c:?}")))
        }
        2 => ("planet", planet(random)),
        3 => ("schwarzschild", schwarzschild(random)),
        4 => ("kerr", kerr(random)),
        _ => ("coupled", coupled(random)),
    }
}

/// One to four coordinates in a potential that binds, with couplings, a wave and a hill.
fn potential(random: &mut Random, law: &str) -> String {
    let n = 1 + (random.next() % 4) as usize;
    let names: Vec<String> = (0..n).map(|k| format!("x{k}")).collect();
    let mut v = String::from("0");
    for name in &names {
        let (stiffness, quartic) = (random.scale(0.2, 4.0), random.between(0.0, 0.5));
        v += &format!(" + {stiffness:?}*{name}^2/2 + {quartic:?}*{name}^4");
    }
    for pair in names.windows(2) {
        let (coupling, wave) = (random.between(-0.1, 0.1), random.between(-0.3, 0.3));
        v += &format!(" + {coupling:?}*{}^2*{} + {wave:?}*cos({0} - {1})", pair[0], pair[1]);
    }
    let (height, width, place) = (random.between(-0.5, 0.5), random.scale(0.3, 2.0), random.between(-0.5, 0.5));
    v += &format!(" + {height:?}*exp(-(({} - {place:?})/{width:?})^2)", names[0]);
    let mut text = format!("[potential]\ncoordinates = {names:?}\nformula = \"{v}\"\n[particle]\n{law}\n[initial]\n");
    for name in &names {
        text += &format!("{name} = {:?}\n{name}_dot = {:?}\n", random.between(-0.6, 0.6), random.between(-0.5, 0.5));
    }
    if law.starts_with('c') {
        text += "t_dot = 1.0\n";
    }
    text + &format!("[grid]\n{} = {:?}\n", end(random), random.scale(1.0, 60.0))
}

/// A run goes to a γ or a time.
fn end(random: &mut Random) -> &'static str {
    if random.next().is_multiple_of(2) { "gamma_f" } else { "t_f" }
}

/// A planet on an ellipse, with and without steps that adapt to it by a conformal factor.
fn planet(random: &mut Random) -> String {
    let e = random.between(0.0, 0.85);
    let end = random.scale(2.0, 60.0);
    let conformal = match random.next() % 3 {
        0 => "",
        1 => "conformal = \"1/sqrt(x^2 + y^2)\"\n",
        _ => "conformal = \"1/(x^2 + y^2)\"\n",
    };
    format!(
        "[potential]\ncoordinates = [\"x\", \"y\"]\nformula = \"-1/sqrt(x^2 + y^2)\"\n{conformal}\
         [particle]\nlaw = \"newtonian\"\n[initial]\nx = {:?}\ny = 0.0\nx_dot = 0.0\ny_dot = {:?}\n\
         [grid]\nt_f = {end:?}\n",
        1.0 - e,
        ((1.0 + e) / (1.0 - e)).sqrt()
    )
}

/// A particle that starts outside a black hole.
fn schwarzschild(random: &mut Random) -> String {
    let (r, angular, r_dot) = (random.between(8.0, 30.0), random.between(3.8, 5.5), random.between(-0.1, 0.1));
    format!(
        "[metric]\npreset = \"schwarzschild\"\n[initial]\nr = {r:?}\nr_dot = {r_dot:?}\np_phi = -{angular:?}\n\
         norm = \"timelike\"\nsolve = {{ t_dot = \"+\" }}\n[grid]\nuntil = \"r - 2.2\"\n{} = {:?}\n",
        end(random),
        random.scale(20.0, 1000.0)
    )
}

/// An inclined orbit around a rotating black hole.
fn kerr(random: &mut Random) -> String {
    let (a, r, theta) = (random.between(0.0, 0.98), random.between(7.0, 20.0), random.between(1.0, 2.0));
    let (theta_dot, phi_dot) = (random.between(-0.01, 0.01), random.between(0.015, 0.03));
    format!(
        "parameters = {{ a = {a:?} }}\n[metric]\npreset = \"kerr\"\n[initial]\nr = {r:?}\ntheta = {theta:?}\n\
         r_dot = {:?}\ntheta_dot = {theta_dot:?}\nphi_dot = {phi_dot:?}\nnorm = \"timelike\"\n\
         solve = {{ t_dot = \"+\" }}\n[grid]\nuntil = \"r - 2.5\"\n{} = {:?}\n",
        random.between(-0.05, 0.05),
        end(random),
        random.scale(20.0, 400.0)
    )
}

/// Coordinates that the metric couples, with a one-form and friction.
fn coupled(random: &mut Random) -> String {
    let [a, b, c, d] = [0; 4].map(|_| random.between(-0.3, 0.3));
    let (charge, friction) = (random.between(-0.5, 0.5), random.between(0.0, 0.1));
    let mut text = format!(
        "[metric]\ncoordinates = [\"u\", \"v\", \"w\"]\n[metric.components]\n\"u u\" = \"1 + {a:?}*cos(v)\"\n\
         \"v v\" = \"2 + {b:?}*sin(u + w)\"\n\"w w\" = \"1 + {c:?}^2*u^2\"\n\"u v\" = \"{d:?}*cos(u - v)\"\n\
         [metric.one_form]\nv = \"{charge:?}*u\"\n[metric.force]\nu = \"-{friction:?}*u_dot\"\n[initial]\n"
    );
    for name in ["u", "v", "w"] {
        text += &format!("{name} = {:?}\n{name}_dot = {:?}\n", random.between(-1.0, 1.0), random.between(-1.0, 1.0));
    }
    text + &format!("[grid]\ngamma_f = {:?}\n", random.scale(1.0, 40.0))
}
