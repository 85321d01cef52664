//! The start that the initial data of a scene describe.

use geodesic_ivp::case::{Case, Rate};
use geodesic_ivp::geometry::{Geometry, Law, Start};
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::Limit;

use super::{KEPLER, KERR, SCHWARZSCHILD, scene};

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-14 * expected.abs().max(1.0), "{found} is not {expected}");
}

fn norm(scene: &Case, start: &Start) -> f64 {
    scene.geometry::<f64>().norm(&start.q, &start.q_dot)
}

#[test]
fn components_and_preset_give_the_same_start() {
    let by_components = scene(SCHWARZSCHILD);
    let start: Start = by_components.start();
    assert_eq!(start.q, [0.0, 10.0, 0.0]);
    assert_eq!(start.q_dot, [1.2, -0.05, 0.03]);
    [0.96, 0.0625, -3.0].into_iter().zip(&start.p).for_each(|(p, &found)| near(found, p));
    near(norm(&by_components, &start), 1.058875);
    let (head, tail) = SCHWARZSCHILD.split_once("[initial]").unwrap();
    assert!(head.contains("components"));
    let by_preset = scene(&format!("[metric]\npreset = \"schwarzschild\"\n\n[initial]{tail}"));
    assert_eq!(by_preset.start::<f64>(), start);
    assert_eq!(by_preset.geometry::<f64>().active(), by_components.geometry::<f64>().active());
    assert_eq!((by_preset.preset, by_components.preset), (Some("schwarzschild"), None));
    assert_eq!(by_components.limit::<f64>(), Limit::Length(40.0));
    let settings = by_components.settings;
    assert!(settings.n_gamma == 12 && settings.windows == 1 && !settings.is_extended());
}

#[test]
fn momenta_and_velocities_mix() {
    let text = SCHWARZSCHILD.replace("phi_dot = 0.03", "p_phi = -3").replace("t_dot = 1.2", "p_t = 0.96");
    let start: Start = scene(&text).start();
    [1.2, -0.05, 0.03].into_iter().zip(&start.q_dot).for_each(|(u, &found)| near(found, u));
    assert_eq!((start.p[0], start.p[2]), (0.96, -3.0));
    // A null coordinate, g_rr = 0: p_v alone has r_dot in it, and p_r alone v_dot.
    let plunge = "metric.preset = \"schwarzschild-ef\"\ninitial = { r = 10, p_v = 0.9, p_r = -1.1, phi_dot = 0 }\n\
                  grid.gamma_f = 1\nscheme.sbp = \"GLL8\"\n";
    let start: Start = scene(plunge).start();
    near(start.q_dot[0], 1.1);
    near(start.q_dot[1], 0.8 * 1.1 - 0.9);
}

#[test]
fn an_orbit_around_a_rotating_mass_by_its_charges() {
    let scene = scene(KERR);
    let start: Start = scene.start();
    assert_eq!([start.p[0], start.p[3], start.p[2]], [0.95, -2.5, 1.5]);
    assert!(start.q_dot[1] > 0.0);
    near(norm(&scene, &start), 1.0);
    let geometry: Geometry = scene.geometry();
    geometry.momenta(&start.q, &start.q_dot).iter().zip(&start.p).for_each(|(&p, &q)| near(p, q));
    let inward: Start = super::scene(&KERR.replace("\"+\"", "\"-\"")).start();
    assert_eq!(inward.q_dot[1], -start.q_dot[1]);
    assert_eq!(scene.invariants[0].0, "carter");
    assert_eq!(scene.grid.until.as_deref(), Some("r - 2.1"));
    // For the momentum in place of the velocity, g_rr < 0 turns the sign.
    let momentum: Start = super::scene(&KERR.replace("r_dot = \"+\"", "p_r = \"-\"")).start();
    near(momentum.q_dot[1], start.q_dot[1]);
    // The charge that a velocity and the norm belong to.
    let charge = KERR.replace("p_t = \"e\"\n", &format!("r_dot = {:?}\n", start.q_dot[1]));
    let charge: Start =
        super::scene(&charge.replace("solve = { r_dot", "solve = { p_t").replace("e = 0.95, ", "")).start();
    near(charge.p[0], 0.95);
}

#[test]
fn newtons_law_needs_neither_time_nor_action() {
    let scene = scene(KEPLER);
    let start: Start = scene.start();
    assert_eq!(scene.coordinates(), ["t", "x", "y", "s"]);
    assert_eq!(start.q, [0.0, 0.1, 0.0, 0.0]);
    // s_dot = (½v² − V) t_dot, p_t = the energy, p_s = t_dot.
    assert_eq!(start.q_dot[..3], [1.0, 0.0, 19.0_f64.sqrt()]);
    near(start.q_dot[3], 9.5 + 10.0);
    near(start.p[0], -0.5);
    assert_eq!(start.p[3], 1.0);
    assert_eq!(scene.limit::<f64>(), Limit::Value { coordinate: 0, value: std::f64::consts::TAU });
    // By the energy in place of a velocity.
    let by_energy = KEPLER.replace("y_dot = \"sqrt(19)\"", "p_t = -0.5\nnorm = 0\nsolve = { y_dot = \"+\" }");
    let start: Start = super::scene(&by_energy).start();
    near(start.q_dot[2], 19.0_f64.sqrt());
    // By p_s in place of t_dot: time runs at twice the rate of gamma, and everything with it.
    let twice = KEPLER.replace("y_dot = \"sqrt(19)\"", "y_dot = \"2*sqrt(19)\"\np_s = 2");
    let start: Start = super::scene(&twice).start();
    near(start.q_dot[0], 2.0);
    near(start.p[0], -1.0);
}

#[test]
fn a_conformal_factor_keeps_the_path_and_the_charges() {
    let text = KEPLER.replace("formula =", "conformal = \"1/sqrt(x^2 + y^2)\"\nformula =");
    let text = text.replace("y_dot = \"sqrt(19)\"", "t_dot = 0.1\ny_dot = \"sqrt(19)/10\"");
    let start: Start = scene(&text).start();
    near(start.p[0], -0.5);
    near(start.p[3], 1.0);
}

#[test]
fn masses_of_their_own() {
    let text = "potential = { coordinates = [\"x\", \"y\"], formula = \"x*y\" }\n\
                particle = { masses = { x = 2, y = \"k\" }, law = \"newtonian\" }\n\
                potential.parameters.k = 3\n";
    assert!(Case::parse("case", text, &[]).is_err(), "an inline table cannot be extended");
    let text = "[potential]\ncoordinates = [\"x\", \"y\"]\nformula = \"x*y\"\nparameters = { k = 3 }\n[particle]\n\
                masses = { x = 2, y = \"k\" }\nmass = 1.5\nc = 10\n[initial]\nx = 1\ny = 2\nx_dot = 0.1\ny_dot = 0.2\n\
                t_dot = 1\n[grid]\ngamma_f = 1\nn_gamma = 20\n[scheme]\nsbp = \"SBP42\"\n";
    let start: Start = scene(text).start();
    near(start.p[1], -0.1 * 2.0 / 1.5);
    near(start.p[2], -0.2 * 3.0 / 1.5);
    near(start.p[0], 100.0 + 2.0 * 2.0 / 1.5);
    let potential = scene(text).geometry_text.potential.clone().unwrap();
    assert_eq!((potential.law, potential.masses[1].as_str()), (Law::Relativistic, "k"));
}

#[test]
fn named_potentials_are_those_of_one_coordinate() {
    for (named, formula) in [
        ("quartic = { kappa = 0.5 }", "0.5*x^4"),
        ("linear = { alpha = -0.25 }", "-0.25*x"),
        ("free = {}", "0"),
        ("polynomial = { coefficients = [1, -2.5, 0, 3e-1] }", "1 - 2.5*x + 0.3*x^3"),
        ("formula = { expression = \"k*x\", parameters = { k = 2 } }", "2*x"),
        ("formula = { expression = \"k*x\" }\nparameters = { k = 2 }", "2*x"),
    ] {
        let start = |potential: &str| -> Start {
            let text = format!(
                "[potential]\ncoordinates = [\"x\"]\n{potential}\n[initial]\nx = 0.5\nt_dot = 1\nx_dot = 0.1\n\
                 [grid]\ngamma_f = 1\nn_gamma = 20\n[scheme]\nsbp = \"SBP42\"\n"
            );
            scene(&text).start()
        };
        let (named, formula) = (start(named), start(&format!("formula = \"{formula}\"")));
        near(named.p[0], formula.p[0]);
        assert_eq!((named.p[1], named.q_dot), (-0.1, vec![1.0, 0.1]));
    }
}

#[test]
fn forty_digits_of_a_root() {
    let text = format!("{KEPLER}\n[solver]\ndigits = 40\n");
    let scene = scene(&text);
    assert!(scene.settings.is_extended());
    let start: Start<Extended> = scene.start();
    let root = Extended::from(19.0).sqrt();
    assert!((start.q_dot[2] - root).abs() < Extended::from(1e-60));
    assert!((start.p[0] + Extended::ONE.half()).abs() < Extended::from(1e-60));
    assert_eq!(start.q[1], Extended::from_decimal("0.1").unwrap());
    let end: Extended = scene.t_f().unwrap();
    assert!((end - Extended::PI - Extended::PI).abs() < Extended::from(1e-60));
}

/// At a turning point the root is zero, and stays so where rounding would make it 1e-8, or no root.
#[test]
fn a_root_below_rounding_is_zero() {
    let orbit = |digits: u32| {
        format!(
            "metric.preset = \"schwarzschild\"\ngrid.gamma_f = 1\nscheme.sbp = \"GLL12\"\n\
             solver.digits = {digits}\n[initial]\n\
             r = \"20/3\"\np_t = 0.96609178307929590491\np_phi = 3.84900179459750509673\nnorm = 1\n\
             solve = {{ r_dot = \"+\" }}\n"
        )
    };
    let (double, more) = (scene(&orbit(16)), scene(&orbit(20)));
    for start in [double.start::<f64>(), more.start::<f64>()] {
        assert_eq!(start.q_dot[1], 0.0);
    }
    for start in [double.start::<Extended>(), more.start::<Extended>()] {
        assert_eq!(start.q_dot[1], Extended::ZERO);
    }
    // In 30 digits these data are not those of a turning point.
    let error = Case::parse("case", &orbit(30), &[]);
    let moving = error.map(|scene| scene.start::<Extended>().q_dot[1].abs().to_f64());
    assert!(moving.is_err() || moving.is_ok_and(|r_dot| r_dot > 1e-12));
}

#[test]
fn a_null_coordinate_makes_the_equation_linear() {
    let ray = |sign: &str| {
        format!(
            "metric.preset = \"schwarzschild-ef\"\ngrid.gamma_f = 1\nscheme.sbp = \"GLL8\"\n\
             [initial]\nr = 10\nv_dot = 1\n\
             phi_dot = 0.02\nnorm = \"null\"\nsolve = {{ r_dot = \"{sign}\" }}\n"
        )
    };
    // One root is the larger one and the smaller one.
    for sign in ["+", "-"] {
        let start: Start = scene(&ray(sign)).start();
        near(start.q_dot[1], (0.8 - 0.04) / 2.0);
    }
}

#[test]
fn units_of_any_size() {
    let text = "[metric]\ncoordinates = [\"t\", \"x\"]\n\
                components = { \"t t\" = 1e40, \"x x\" = -1e-40, \"t x\" = 0.5 }\n\
                [initial]\np_t = 2e40\np_x = -3e-40\n[grid]\ngamma_f = 1\nn_gamma = 3\n[scheme]\nsbp = \"SBP21\"\n";
    let start: Start = scene(text).start();
    assert!(start.q_dot.iter().all(|u| u.is_finite()), "{start:?}");
}

#[test]
fn rates_are_kept_as_they_are_given() {
    let scene = scene(KERR);
    assert!(matches!(&scene.initial.rates[0], Rate::Momentum(number) if number == "e"));
    assert_eq!(scene.initial.norm.as_deref(), Some("1"));
}

#[test]
fn cases_of_one_coordinate_are_no_scenes() {
    let text = "potential.quartic.kappa = 0.5\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\n\
                grid = { gamma_f = 1, n_gamma = 32 }\nscheme.sbp = \"SBP42\"\n";
    let is_of_x = |overrides: &[String]| Case::parse("case", text, overrides).unwrap().is_of_x;
    assert!(is_of_x(&[]));
    assert!(!is_of_x(&["particle.law=newtonian".to_owned()]));
    // Formulas of the case's own see t itself, which counts from the start elsewhere.
    let turn = "events.turn.when=x_dot".to_owned();
    assert!(is_of_x(std::slice::from_ref(&turn)));
    let origin = |overrides: &[String]| Case::parse("case", text, overrides).unwrap().setup::<f64>().origin;
    let late = "initial.t=3.0".to_owned();
    assert_eq!((origin(std::slice::from_ref(&late)), origin(&[late, turn])), (Some((0, 3.0)), None));
}

/// What is no value of TOML is a formula where a number may be one, in a case of x, too.
#[test]
fn an_override_by_a_formula_needs_no_quotes() {
    let text = "potential.quartic.kappa = 0.5\ninitial = { x = 1.0, t_dot = 1.0, x_dot = 0.1 }\n\
                grid = { gamma_f = 1, n_gamma = 32 }\nscheme.sbp = \"SBP42\"\n";
    let length =
        |setting: &str| match Case::parse("case", text, &[setting.to_owned()]).map(|case| case.setup::<f64>().limit) {
            Ok(Limit::Length(length)) => Some(length),
            _ => None,
        };
    assert_eq!(length("grid.gamma_f=2*pi"), length("grid.gamma_f=\"2*pi\""));
    assert_eq!(length("grid.gamma_f=2*pi"), Some(std::f64::consts::TAU));
    assert_eq!([length("grid.gamma_f=2*"), length("grid.n_gamma=4*8")], [None, None]);
}

#[test]
fn unused_parameters_are_warned_of() {
    let text = SCHWARZSCHILD.replace("{ m = 1.0 }", "{ m = 1.0, k = 2 }");
    assert_eq!(scene(&text).warnings(), ["no formula uses the parameter 'k'"]);
    assert!(scene(KERR).warnings().is_empty() && scene(SCHWARZSCHILD).warnings().is_empty());
}
