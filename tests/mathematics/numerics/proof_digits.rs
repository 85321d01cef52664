//! Ends of motions, proved, against digits that another program computed: 45 of them, from Taylor series whose order is
//! the number of digits, in a library of arbitrary precision.

use super::proof::{is_proved, newtonian, number};

/// The decimal of a double that is between two marks, to all of its digits: the other program ended at doubles.
fn of_doubles(text: &str) -> String {
    let part = |(place, part): (usize, &str)| {
        let number = || part.parse::<f64>().expect("a number is between two marks");
        if place % 2 == 0 { part.to_owned() } else { format!("{:.70}", number()) }
    };
    text.split('@').enumerate().map(part).collect()
}

/// Every coordinate with its digits is within its radius, which is below `most`.
#[track_caller]
fn has_digits(text: &str, ends: &[(&str, &str)], most: f64) {
    ends.iter().for_each(|(name, digits)| is_proved(&of_doubles(text), name, number(digits), most));
}

#[test]
fn stars_have_their_digits() {
    let text = |length| {
        let rest = "potential.formula = \"(x^2 + y^2)/2 + x^2*y - y^3/3\"\n\
                    initial = { x = 0.1, y = 0, x_dot = 0, y_dot = 0.5 }";
        newtonian(length, "\"x\", \"y\"", rest)
    };
    let at_100 = [
        ("x", "-0.0401942378760688167944025003237361721562454887"),
        ("y", "0.679016921772021642134721800871534099545540387"),
    ];
    has_digits(&text(100), &at_100, 1e-18);
    let at_1000 = [
        ("x", "-0.0208696549472955075951537470875114001739670630"),
        ("y", "-0.381630841346697338642931066772540909475720115"),
    ];
    has_digits(&text(1000), &at_1000, 1e-16);
}

fn relativistic(length: u32, c: u32, formula: &str, x: &str, x_dot: &str) -> String {
    format!(
        "particle.c = {c}\npotential.formula = \"{formula}\"\ngrid.gamma_f = {length}\nsolver.accuracy = 1e-8\n\
         initial = {{ t = 0, x = {x}, t_dot = 1, x_dot = {x_dot} }}"
    )
}

#[test]
fn a_quartic_oscillator_has_its_digits() {
    let text = |length| relativistic(length, 1, "x^4/2", "1", "0.1");
    let at_10 = [
        ("x", "-0.538386123532716794600604149202520306641280220"),
        ("t", "15.6066805067837356979877139945066450666563053728"),
    ];
    has_digits(&text(10), &at_10, 1e-17);
    let at_1000 = [
        ("x", "-0.0223762946241877753857379858640326776100099004"),
        ("t", "1547.19368328250722164961116268717024756326307"),
    ];
    has_digits(&text(1000), &at_1000, 1e-14);
}

#[test]
fn a_pendulum_has_its_digits() {
    let text = |length| relativistic(length, 10, "1 - cos(x)", "2.5", "0");
    let at_10 = [
        ("x", "2.48009995589305324633831986963362299704791109"),
        ("t", "10.1325102113288374802245741512890923932597000"),
    ];
    has_digits(&text(10), &at_10, 1e-17);
    let at_1000 = [
        ("x", "-2.49772607056073541976990323392976929227809392"),
        ("t", "1012.92167954257231902483046209171256712530760"),
    ];
    has_digits(&text(1000), &at_1000, 1e-14);
}

/// Ten and a hundred turns of an ellipse of eccentricity 0.6.
#[test]
fn an_ellipse_has_its_digits() {
    let text = |length| {
        let rest = "potential.formula = \"-1/sqrt(x^2 + y^2)\"\n\
                    initial = { x = 0.4, y = 0, x_dot = 0, y_dot = 2 }";
        newtonian(length, "\"x\", \"y\"", rest)
    };
    let after_10 = [
        ("x", "0.399999999999999999999999999981253002716726781"),
        ("y", "-4.89858719658941270890426372930944898469098757e-15"),
    ];
    has_digits(&text("@62.83185307179586@"), &after_10, 1e-14);
    let after_100 = [
        ("x", "0.399999999999999999999999999951764809995491505"),
        ("y", "7.85754689491388778064730410287428874739887128e-15"),
    ];
    has_digits(&text("@628.3185307179587@"), &after_100, 1e-12);
}

#[test]
fn three_bodies_have_their_digits() {
    let rest = "potential.formula = \"-1/sqrt((x1 - x2)^2 + (y1 - y2)^2) - 1/sqrt((x2 - x3)^2 + (y2 - y3)^2) \
                - 1/sqrt((x3 - x1)^2 + (y3 - y1)^2)\"\n[initial]\n\
                x1 = 0.97000435664712467982\ny1 = -0.24308753046758826958\n\
                x2 = -0.97000435664712467982\ny2 = 0.24308753046758826958\nx3 = 0\ny3 = 0\n\
                x1_dot = 0.466203685347163\ny1_dot = 0.432365730734568\n\
                x2_dot = 0.466203685347163\ny2_dot = 0.432365730734568\n\
                x3_dot = -0.932407370694326\ny3_dot = -0.864731461469136";
    let text = newtonian("@6.32591398@", "\"x1\", \"y1\", \"x2\", \"y2\", \"x3\", \"y3\"", rest);
    let ends = [
        ("x1", "0.970004357544238968519472320278844055924883144"),
        ("y1", "-0.243087528160040282912341612946643098193002879"),
        ("x2", "-0.970004353992363476847577531771302460387581401"),
        ("y2", "0.243087531118522754273107222601244081969990097"),
        ("x3", "-3.55187549167189478850754159553730174328395277e-9"),
        ("y3", "-2.95848247136076560965460098377698721779943833e-9"),
    ];
    has_digits(&text, &ends, 1e-18);
}

#[test]
fn an_orbit_around_a_black_hole_has_its_digits() {
    let text = "grid.gamma_f = 2000\nsolver.accuracy = 1e-8\n\
                initial = { t = 0, r = \"20/3\", phi = 0, p_t = 0.96609178307929590491, r_dot = 0, \
                p_phi = -3.84900179459750509673 }\n[metric]\ncoordinates = [\"t\", \"r\", \"phi\"]\n\
                components = { \"t t\" = \"1 - 2/r\", \"r r\" = \"-1/(1 - 2/r)\", \"phi phi\" = \"-r^2\" }";
    let ends = [
        ("r", "17.2622435444318357936113649596177284004000675"),
        ("t", "2303.94620819036822990884857934245824207095156"),
        ("phi", "54.4916372788802557985566925837688494037244286"),
    ];
    has_digits(text, &ends, 1e-14);
}

/// Friction and a force in time; and the periodic orbit of the planar restricted problem that CAPD proves as its own
/// example.
#[test]
fn forces_and_one_forms_have_their_digits() {
    let driven = "potential.formula = \"x^2/2 + x^4/4\"\npotential.force.x = \"-x_dot/10 + cos(t)/3\"\n\
                  initial = { x = 1, x_dot = 0 }";
    let end = [("x", "0.537793675895076626149310967612394177407696740")];
    has_digits(&newtonian(100, "\"x\"", driven), &end, 1e-18);
    let restricted = "potential.formula = \"-(x^2 + y^2)/2 - (1 - mu)/sqrt((x + mu)^2 + y^2) \
                      - mu/sqrt((x - 1 + mu)^2 + y^2)\"\nparameters.mu = 0.0009537\n\
                      potential.one_form = { x = \"-y\", y = \"x\" }\n\
                      initial = { x = 0.9208034913207400196, y = 0, x_dot = 0, y_dot = 0.10444767270690774 }";
    let ends = [
        ("x", "0.920803491318327171136930821510912781311644471"),
        ("y", "-9.79967267382431543830954033177637022927454548e-13"),
    ];
    has_digits(&newtonian("@3.0821191263765@", "\"x\", \"y\"", restricted), &ends, 1e-18);
}
