//! What a search has found exists, proved: the number that is told is the true one to its radius, and where there is no
//! proof the reason is said.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::find::{Existence, find};

use crate::common::{parsed, shipped};

const STONE: &str = r#"
potential = { coordinates = ["x", "y"], formula = "9.81*y" }
parameters = { v = 2.0 }
particle.law = "newtonian"
initial = { x = 0.0, y = 0.0, x_dot = 1.0, y_dot = 1.0 }
grid.t_f = 1.0
solver.accuracy = 1e-12
"#;

fn existence(text: &str, wanted: &str) -> Result<Existence, String> {
    let case = parsed(&format!("{text}\n[find]\n{wanted}"), &[]);
    let found = find(&case, case.find.as_ref().unwrap(), true, &mut |_| {});
    found.unwrap_or_else(|none| panic!("{none}")).existence.unwrap()
}

#[track_caller]
fn assert_exists(found: Result<Existence, String>, truth: &[&str], at_most: f64) {
    let found = found.unwrap_or_else(|reason| panic!("{reason}"));
    assert_eq!(found.values.len(), truth.len());
    for ((value, radius), truth) in found.values.iter().zip(truth) {
        let off = (*value - Extended::from_decimal(truth).unwrap()).abs().to_f64();
        assert!(off <= *radius && *radius <= at_most, "{off:e} of {radius:e}");
    }
}

#[test]
fn closed_forms_are_within_the_radius_that_is_proved() {
    // A stone falls to a place in a time, and to the ground at a time.
    let both = "unknowns = [\"initial.x_dot\", \"initial.y_dot\"]\nmeet = [\"x - 3\", \"y\"]";
    assert_exists(existence(STONE, both), &["3", "4.905"], 1e-20);
    let time = "unknowns = [\"grid.t_f\"]\nmeet = [\"y + 1\"]";
    // (1 + √(1 + 2·9.81))/9.81
    let truth = "0.564824160641905343914872053686592953466646568260336133563395";
    assert_exists(existence(STONE, time), &[truth], 1e-20);
    // A free motion has no windows.
    let free = STONE.replace("9.81*y", "0");
    assert_exists(existence(&free, "unknowns = [\"grid.t_f\"]\nmeet = [\"x - 3.1\"]"), &["3.1"], 1e-14);
    // A force instead of a potential: sin t from x = 0.
    let pushed =
        STONE.replace("potential = { coordinates = [\"x\", \"y\"], formula = \"9.81*y\" }", "force.x = \"-x\"");
    let pushed = pushed.replace("y = 0.0, ", "").replace(", y_dot = 1.0", "");
    let truth = "1.18839510577812121626159945237455100352782983409796";
    assert_exists(existence(&pushed, "unknowns = [\"initial.x_dot\"]\nmeet = [\"x - 1\"]"), &[truth], 1e-20);
    // An oscillator from its start to an angle: the velocity, with start(x) in what is met.
    let oscillator = r#"
        potential = { coordinates = ["x"], formula = "x^2/2" }
        particle.law = "newtonian"
        initial = { x = 1.0, x_dot = 0.3 }
        grid.t_f = 1.0
        solver.accuracy = 1e-12
    "#;
    let returns = "unknowns = [\"initial.x_dot\"]\nmeet = [\"x - start(x)\"]";
    // (1 − cos 1)/sin 1 = tan ½
    let truth = "0.546302489843790513255179465780285383297551720179791246164091";
    assert_exists(existence(oscillator, returns), &[truth], 1e-20);
}

#[test]
fn orbits_of_the_cases_exist() {
    for (name, at_most) in [("lambert", 1e-15), ("choreography", 1e-15), ("halo", 1e-15)] {
        let case = shipped(name, &[]);
        let found = find(&case, case.find.as_ref().unwrap(), true, &mut |_| {}).unwrap();
        let exists = found.existence.unwrap().unwrap_or_else(|reason| panic!("{name}: {reason}"));
        for ((value, radius), (own, error)) in exists.values.iter().zip(found.values.iter().zip(&found.errors)) {
            let off = (*value - Extended::from(*own)).abs().to_f64();
            assert!(*radius <= at_most && off <= error + radius, "{name}: {off:e} of {error:e}, {radius:e}");
        }
    }
}

/// Of two solutions that lie side by side each is alone within less than their distance: where a condition has two
/// zeros, and where the flow leads two starts to one value, in front of the fold of Bratu's problem.
#[test]
fn what_is_alone_has_no_other_beside_it() {
    let one = |text: &str, wanted: &str| {
        let found = existence(text, wanted).unwrap_or_else(|reason| panic!("{reason}"));
        (found.values[0].0, found.alone_within.expect("it is alone")[0])
    };
    for apart in [1e-3, 1e-6, 1e-9, 1e-11] {
        let wanted =
            format!("unknowns = [\"initial.x_dot\"]\nmeet = [\"(x - 1 - {apart})*(x - 1 + {apart})/{apart}\"]");
        let (_, alone) = one(&STONE.replace("x_dot = 1.0", &format!("x_dot = {}", 1.0 + 0.9 * apart)), &wanted);
        assert!(alone < 2.0 * apart && alone > 1e-15, "{alone:e} {apart:e}");
    }
    for below in [1e-3, 1e-6, 1e-9] {
        let bratu = |slope: f64| {
            let text = format!(
                r#"
                potential = {{ coordinates = ["y"], formula = "{}*exp(y)" }}
                particle.law = "newtonian"
                initial = {{ y = 0.0, y_dot = {slope} }}
                grid.t_f = 1.0
                solver.accuracy = 1e-12
                "#,
                3.513_830_719_125_161 - below
            );
            one(&text, "unknowns = [\"initial.y_dot\"]\nmeet = [\"y\"]")
        };
        // The slope at the fold, to either side.
        let [lower, upper] = [-1.0, 1.0].map(|side| bratu(4.0 + side * 2.0 * f64::sqrt(below)));
        let apart = (upper.0 - lower.0).to_f64();
        assert!(apart > 0.0 && lower.1 < apart && upper.1 < apart, "{apart:e} {:e} {:e}", lower.1, upper.1);
    }
}

#[test]
fn a_search_without_a_proof_says_why() {
    let reason = |text: &str, wanted: &str| existence(text, wanted).unwrap_err();
    let x_dot = "unknowns = [\"initial.x_dot\"]";
    let many = reason(STONE, &format!("{x_dot}\nmeet = [\"x - 3\", \"2*x - 6\"]"));
    assert!(many.contains("2 for 1"), "{many}");
    let oscillator = STONE.replace("9.81*y", "v*x^2/2");
    let oscillator =
        oscillator.replace("particle.law = \"newtonian\"", "particle = { law = \"newtonian\", mass = 1.0 }");
    let mass = reason(&oscillator, "unknowns = [\"particle.mass\"]\nmeet = [\"x - 0.5\"]");
    assert!(mass.contains("particle.mass is in the equations"), "{mass}");
    let square = STONE.replace("x_dot = 1.0", "x_dot = \"v^2\"");
    let bent = reason(&square, "unknowns = [\"parameters.v\"]\nmeet = [\"x - 3\"]");
    assert!(bent.contains("not linear in parameters.v"), "{bent}");
    // A formula that jumps over 0 is nowhere 0.
    let jump = reason(STONE, &format!("{x_dot}\nmeet = [\"x - 3 + 1e-14*(step(x - 3) - 0.5)\"]"));
    assert!(jump.contains("errors"), "{jump}");
    // A product of two numbers is linear in each.
    let product = STONE.replace("v = 2.0", "v = 1.2, w = 0.85").replace("x_dot = 1.0", "x_dot = \"v*w\"");
    let product = product.replace("y_dot = 1.0", "y_dot = \"v + w\"");
    let both = "unknowns = [\"parameters.v\", \"parameters.w\"]\nmeet = [\"x - 0.99\", \"y - 2 + 4.905\"]";
    let product = reason(&product, both);
    assert!(product.contains("not linear in parameters.v and parameters.w together"), "{product}");
    let event = format!("{STONE}\n[events.ground]\nwhen = \"y + 100\"\nuntil = true\n");
    let event = reason(&event, &format!("{x_dot}\nmeet = [\"x - 3\"]"));
    assert!(event.contains("event"), "{event}");
}
