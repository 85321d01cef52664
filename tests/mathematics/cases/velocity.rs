//! `initial.velocity`, dq/dt of the one coordinate besides t.

use geodesic_ivp::case::Case;

use super::read;

/// A case of that law in the coordinate y with these keys of `[initial]`.
fn text(law: &str, initial: &str) -> String {
    format!(
        "potential = {{ coordinates = [\"y\"], formula = \"y^2/2\" }}\nparticle.law = \"{law}\"\n\
         initial = {{ y = 0.5, {initial} }}\ngrid.t_f = 1.0\nsolver.accuracy = 1e-6\n"
    )
}

#[test]
fn every_case_of_one_coordinate_takes_a_velocity() {
    for (law, initial, y_dot) in [
        ("newtonian", "velocity = 0.25", 0.25),
        ("newtonian", "velocity = \"1/4\", t_dot = 2", 0.5),
        ("relativistic", "velocity = 0.25, t_dot = 2", 0.5),
    ] {
        let case = read(&text(law, initial)).unwrap();
        assert_eq!(case.start::<f64>().q_dot[1], y_dot, "{law} {initial}");
        // The effective case keeps the velocity, and is the same.
        let again = read(&case.to_toml()).unwrap();
        assert_eq!(again.start::<f64>().q_dot, case.start::<f64>().q_dot, "{}", case.to_toml());
    }
    let flat = "metric = { coordinates = [\"t\", \"z\"], components = { \"t t\" = 1, \"z z\" = -1 } }\n\
                initial = { t_dot = 1.5, velocity = 0.5 }\ngrid.t_f = 1.0\nsolver.accuracy = 1e-6\n";
    assert_eq!(read(flat).unwrap().start::<f64>().q_dot, [1.5, 0.75]);
}

#[test]
fn elsewhere_a_message_says_what_to_give() {
    let plane = text("newtonian", "z = 0, velocity = 0.5").replace("[\"y\"]", "[\"y\", \"z\"]");
    for (text, message, help) in [
        (plane, "velocity is that of one coordinate, and there are y, z", "give y_dot, z_dot"),
        (
            text("newtonian", "velocity = 0.5, y_dot = 1"),
            "velocity and another rate of y are given",
            "keep one of y_dot",
        ),
        (text("relativistic", "velocity = 0.5"), "velocity needs t_dot", "give y_dot or p_y"),
        (text("newtonian", "velocity = 0.5, p_t = 1"), "velocity needs t_dot", "give y_dot or p_y"),
    ] {
        let error = read(&text).unwrap_err();
        assert_eq!(error.message, message, "{text}");
        assert!(error.help.unwrap().starts_with(help));
    }
}

#[test]
fn an_override_takes_the_place_of_another_rate() {
    let with = |initial: &str, setting: &str| {
        let case = Case::parse("case", &text("newtonian", initial), &[setting.to_owned()]).unwrap();
        case.start::<f64>().q_dot[1]
    };
    assert_eq!(with("y_dot = 1", "initial.velocity=0.5"), 0.5);
    assert_eq!(with("p_y = 1", "initial.velocity=0.5"), 0.5);
    assert_eq!(with("velocity = 0.5", "initial.y_dot=1"), 1.0);
    assert_eq!(with("velocity = 0.5", "initial.p_y=1"), 1.0);
}
