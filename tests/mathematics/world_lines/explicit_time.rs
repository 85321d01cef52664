//! Potentials, forces and one-forms that depend on time.

use geodesic_ivp::solve::WorldLine;

use crate::common::{line_of, parsed};

const SCHEMES: [&str; 3] =
    ["solver.accuracy = 1e-11", "scheme = { sbp = \"GLL16\", form = \"weak\" }", "scheme.sbp = \"GLL16\""];

fn solved(physics: &str, scheme: &str) -> WorldLine {
    let windows = if scheme.starts_with("solver") { "" } else { "grid.windows = 12\n" };
    let text = format!("{physics}\ngrid.t_f = 9.0\n{windows}{scheme}\n");
    let case = parsed(&text, &[]);
    assert!(!case.is_of_x);
    line_of(&case)
}

fn newtonian(table: &str, [t, x, x_dot]: [f64; 3]) -> String {
    // A time of 0 may be left out.
    let t = if t == 0.0 { String::new() } else { format!("t = {t}, ") };
    format!("potential = {{ {table} }}\nparticle.law = \"newtonian\"\ninitial = {{ {t}x = {x}, x_dot = {x_dot} }}")
}

#[test]
fn a_driven_oscillator_moves_as_its_equation_says() {
    let exact = |t: f64| (t.cos() - (2.0 * t).cos()) / 3.0;
    let tables = ["formula = \"x^2/2 - x*cos(2*t)\"", "formula = \"x^2/2\", force = { x = \"cos(2*t)\" }"];
    for (table, scheme) in tables.iter().flat_map(|table| SCHEMES.map(|scheme| (table, scheme))) {
        let line = solved(&newtonian(table, [0.0, 0.0, 0.0]), scheme);
        let end = line.end();
        assert!((end.q[0] - 9.0).abs() < 1e-12 && (end.q[1] - exact(9.0)).abs() < 1e-10, "{table} {scheme}: {end:?}");
        // The momentum of t is no charge.
        assert_eq!(line.geometry().ignorable().collect::<Vec<_>>(), [2]);
    }
}

#[test]
fn a_moving_well_is_one_at_rest_in_its_own_frame() {
    let rest = solved(&newtonian("formula = \"x^4/4 + 0*t\"", [0.0, 1.0, 0.3]), SCHEMES[0]).end();
    for scheme in SCHEMES {
        let moving = solved(&newtonian("formula = \"(x - t/2)^4/4\"", [0.0, 1.0, 0.8]), scheme).end();
        assert!((moving.q[1] - 4.5 - rest.q[1]).abs() < 1e-9, "{scheme}: {moving:?} {rest:?}");
    }
}

/// Tsiolkovsky's rocket: v = u ln(m0/m), with what the exhaust takes as a force. Sand that trickles out at rest takes
/// nothing: m v is constant.
#[test]
fn masses_may_change_in_time() {
    let text = |force: &str, x_dot: f64| {
        format!(
            "particle = {{ law = \"newtonian\", masses = {{ x = \"2 - k*t\", y = 3.0 }} }}\n\
             parameters = {{ k = 0.1, u = 3.0 }}\nforce = {{ x = \"{force}\", y = \"-y\" }}\n\
             initial = {{ x = 0.0, x_dot = {x_dot}, y = 1.0, y_dot = 0.0 }}"
        )
    };
    for scheme in SCHEMES {
        let end = solved(&text("-k*(x_dot - u)", 0.0), scheme).end();
        let (logarithm, y) = ((2.0_f64 / 1.1).ln(), (9.0 / 3.0_f64.sqrt()).cos());
        let (x, x_dot) = (3.0 * (9.0 - 11.0 * logarithm), 3.0 * logarithm);
        let off = [end.q[1] - x, end.q_dot[1] - x_dot, end.q[2] - y];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{scheme}: {off:?}");
        let end = solved(&text("0", 0.5), scheme).end();
        assert!((end.q_dot[1] - 0.5 * 2.0 / 1.1).abs() < 1e-9, "{scheme}: {end:?}");
    }
}

/// With a large speed of light the paper's metric has Newton's motion as its limit.
#[test]
fn the_paper_s_metric_may_depend_on_time() {
    let newton = solved(&newtonian("formula = \"x*cos(t)/4\"", [0.0, 0.5, 0.1]), SCHEMES[0]).end();
    let text = "potential.formula = \"x*cos(t)/4\"\nparticle.c = 1e4\n\
                initial = { t = 0.0, x = 0.5, t_dot = 1.0, x_dot = 0.1 }";
    for scheme in &SCHEMES[1..] {
        let end = solved(text, scheme).end();
        assert!((end.q[1] - newton.q[1]).abs() < 1e-7, "{scheme}: {end:?} {newton:?}");
    }
}
