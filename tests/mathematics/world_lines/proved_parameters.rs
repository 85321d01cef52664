//! Hulls of motions whose parameters lie in intervals: proofs of single motions end within, on the way, too.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::find::find;
use geodesic_ivp::study::proof::{Hull, hull};

use super::proved_acting::{decimal, proved};
use crate::common::parsed;
use crate::random_scenes::random::Random;

/// Scenes with the parameters a and b in all that moves; `A` and `B` are their values.
const SCENES: [(&str, &str); 9] = [
    (
        "a potential, with a definition and a parameter that depends on another one",
        r#"
        parameters = { a = A, b = B, c = "a^2 + b" }
        potential.coordinates = ["x", "y"]
        potential.formula = "c*x^2/2 + u"
        potential.definitions.u = "b*(x^2*y - y^3/3) + y^2/2"
        particle.law = "newtonian"
        initial = { x = 0.3, y = -0.1, x_dot = 0.1, y_dot = 0.4 }
        grid.t_f = 4.0
        "#,
    ),
    (
        "friction and a drive",
        r#"
        parameters = { a = A, b = B }
        potential = { coordinates = ["x"], formula = "x^2/2 + x^4/4", force = { x = "-a*x_dot/5 + b*cos(1.3*t)" } }
        particle.law = "newtonian"
        initial = { x = 0.5, x_dot = 0.2 }
        grid.t_f = 5.0
        "#,
    ),
    (
        "masses",
        r#"
        parameters = { a = A, b = B }
        potential = { coordinates = ["x", "y"], formula = "x^2/2 + y^2/2 + x^2*y/5" }
        particle = { law = "newtonian", masses = { x = "1 + a", y = "b" } }
        initial = { x = 0.3, y = 0.2, p_x = 0.1, p_y = 0.4 }
        grid.t_f = 3.0
        "#,
    ),
    (
        "the force of a magnetic field",
        r#"
        parameters = { a = A, b = B }
        potential = { coordinates = ["x", "y"], formula = "x^2/2 + b*y^2", one_form = { x = "-a*y/2", y = "a*x/2" } }
        particle.law = "newtonian"
        initial = { x = 0.3, y = 0.2, x_dot = 0.1, y_dot = 0.4 }
        grid.t_f = 3.0
        "#,
    ),
    (
        "a metric",
        r#"
        parameters = { a = A, b = B }
        metric = { coordinates = ["r", "phi"], components = { "r r" = "1 + a*r^2", "phi phi" = "r^2 + b*r^4" } }
        initial = { r = 1.2, phi = 0.0, p_r = -0.3, p_phi = 0.9 }
        grid.gamma_f = 3.0
        "#,
    ),
    (
        "a charged black hole and the momentum that the start has with it",
        r#"
        parameters = { a = A, b = B }
        metric.coordinates = ["t", "r", "phi"]
        metric.definitions.f = "1 - 2*a/r + b/r^2"
        metric.components = { "t t" = "f", "r r" = "-1/f", "phi phi" = "-r^2" }
        initial = { t = 0.0, r = 9.0, phi = 0.0, t_dot = 1.3, r_dot = 0.0, p_phi = -3.6 }
        grid.gamma_f = 30.0
        "#,
    ),
    (
        "the relativistic law",
        r#"
        parameters = { a = A, b = B }
        potential = { coordinates = ["x"], formula = "a*x^2/2 + b*x/10" }
        particle.c = 3.0
        initial = { t = 0.0, x = 0.4, t_dot = 1.0, x_dot = 0.2 }
        grid.gamma_f = 3.0
        "#,
    ),
    (
        "a start and the end of time",
        r#"
        parameters = { a = A, b = B }
        potential = { coordinates = ["x"], formula = "1 - cos(a*x)" }
        particle.law = "newtonian"
        initial = { x = "b/2", x_dot = "1 - a" }
        grid.t_f = "1 + b"
        "#,
    ),
    (
        "the way back",
        r#"
        parameters = { a = A, b = B }
        potential = { coordinates = ["x"], formula = "a*x^4/4 - b*x" }
        particle.law = "newtonian"
        initial = { t = 1.0, x = 0.7, x_dot = 0.2 }
        grid.t_f = -1.5
        "#,
    ),
];

/// The text of a scene with these numbers.
fn with(scene: &str, [a, b]: [&str; 2]) -> String {
    format!("solver.accuracy = 1e-9\n{}", scene.replace("= A", &format!("= {a}")).replace("= B", &format!("= {b}")))
}

fn found(text: &str) -> Hull {
    hull(&parsed(text, &[]), &mut |_| true)
}

/// Single motions with parameters of the intervals end within the hull; and where these are short it is not much larger
/// than it has to be.
#[test]
fn motions_with_parameters_of_the_intervals_end_in_the_hull() {
    for (k, (what, scene)) in SCENES.iter().enumerate() {
        let (mut random, mut widest) = (Random(76 + 64 * k as u64), 0.0_f64);
        for width in [1e-2, 1e-5] {
            let [a, b] = [random.between(0.8, 1.1), random.between(0.3, 0.5)];
            let interval = |middle: f64| format!("[{}, {}]", middle - width, middle + width);
            let hull = found(&with(scene, [&interval(a), &interval(b)]));
            let ends = hull.ends.unwrap_or_else(|reason| panic!("{what}, {width:e}: {reason}"));
            let mut seen = vec![[f64::INFINITY, f64::NEG_INFINITY]; ends.len()];
            for [of_a, of_b] in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [0.3, -0.6]] {
                let [a, b] = [a + 0.999_999 * width * of_a, b + 0.999_999 * width * of_b].map(|it| it.to_string());
                let proof = proved(&parsed(&with(scene, [&a, &b]), &[])).unwrap();
                assert!(!proof.ends.is_empty(), "{what}: {proof:?}");
                for end in &proof.ends {
                    let place = ends.iter().position(|(name, _)| *name == end.name).unwrap();
                    let ([low, high], value) = (ends[place].1, decimal(&end.end).to_f64());
                    assert!(low <= value && value <= high, "{what}, {width:e}: {} {value} {:?}", end.name, [low, high]);
                    let [least, most] = &mut seen[place];
                    (*least, *most) = (least.min(value), most.max(value));
                }
            }
            for ((_, [low, high]), [least, most]) in ends.iter().zip(seen).filter(|(_, seen)| seen[1] - seen[0] > 1e-9)
            {
                widest = if width < 1e-4 { widest.max((high - low) / (most - least)) } else { widest };
            }
        }
        assert!((1.0..1.6).contains(&widest), "{what}: {widest}");
    }
}

/// The relativistic law, to a time: t is no parameter of the motion, and γ is another one at the end of each.
#[test]
fn sets_end_at_a_time_that_is_no_length() {
    let text = |k: &str, v: &str| {
        format!(
            "parameters.k = {k}\npotential = {{ coordinates = [\"x\"], formula = \"k*x^2/2\" }}\nparticle.c = 2.0\n\
             initial = {{ t = 0.0, x = 0.3, t_dot = 1.0, x_dot = {v} }}\ngrid.t_f = 2.5\nsolver.accuracy = 1e-9"
        )
    };
    for width in [1e-3, 1e-5] {
        let interval = |middle: f64| format!("[{}, {}]", middle - width, middle + width);
        let hull = found(&text(&interval(1.0), &interval(0.5)));
        let [low, high] = hull.ends.as_ref().unwrap_or_else(|reason| panic!("{reason}"))[1].1;
        let mut seen = [f64::INFINITY, f64::NEG_INFINITY];
        for [k, v] in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [0.2, -0.7]] {
            let [k, v] = [1.0 + 0.999_999 * k * width, 0.5 + 0.999_999 * v * width].map(|number| number.to_string());
            let proof = proved(&parsed(&text(&k, &v), &[])).unwrap();
            let x = decimal(&proof.ends.iter().find(|end| end.name == "x").unwrap().end).to_f64();
            assert!(low <= x && x <= high, "{width:e}: {x} {low} {high}");
            seen = [seen[0].min(x), seen[1].max(x)];
        }
        assert!(high - low < 1.2 * (seen[1] - seen[0]), "{width:e}: {low} {high} {seen:?}");
    }
    let later = text("[0.99, 1.01]", "0.5").replace("t_f = 2.5", "t_f = \"2 + k/2\"");
    assert!(found(&later).ends.unwrap_err().contains("its velocity changes"));
}

/// On the way every oscillator x″ = −k x is in the boxes, of which there are many.
#[test]
fn motions_are_in_the_hull_on_their_way() {
    let oscillator = r#"
        parameters.k = [0.99, 1.01]
        potential = { coordinates = ["x"], formula = "k*x^2/2" }
        particle.law = "newtonian"
        initial = { x = [0.99, 1.0], x_dot = 0.0 }
        grid.t_f = 6.0
        solver.accuracy = 1e-9
    "#;
    let hull = found(oscillator);
    assert!(hull.way.len() > 60 && hull.way[0].ends[1].is_some_and(|[low, high]| low <= 0.99 && high >= 1.0));
    for at in &hull.way {
        let [[t, _], [low, high]] = [0, 1].map(|a| at.ends[a].unwrap());
        let ends =
            [[0.99, 0.99], [0.99, 1.0], [1.01, 0.99], [1.01, 1.0]].map(|[k, x]: [f64; 2]| x * (k.sqrt() * t).cos());
        assert!(ends.iter().all(|x| low <= *x && *x <= high), "{at:?} {ends:?}");
    }
    assert!(hull.way.last().is_some_and(|at| (at.gamma.to_f64() - 6.0).abs() < 1e-9), "{:?}", hull.way.last());
}

#[test]
fn parameters_that_are_no_numbers_of_a_proof_are_said() {
    let law = with(SCENES[6].1, ["[0.9, 1.0]", "0.1"]).replace("particle.c = 3.0", "particle.c = \"3*a\"");
    assert!(found(&law).ends.unwrap_err().contains("the relativistic law"));
    let bent = with(SCENES[7].1, ["1.0", "[0.3, 0.31]"]).replace("b/2", "b^2");
    assert!(found(&bent).ends.unwrap_err().contains("not linear in parameters.b"));
    let wrong = |of: &str, message: &str| {
        let text = with(SCENES[0].1, ["[0.9, 1.0]", of]);
        let error = geodesic_ivp::Case::parse("wrong", &text, &[]).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    };
    wrong("[\"a/3\", 0.6]", "depends on 'a'");
    wrong("[0.6, 0.5]", "no inside");
}

/// x″ = −k x from x = 0 is 0 at π for k = 1.
#[test]
fn a_parameter_of_the_equations_is_found_and_proved() {
    let of = |formula: &str, rest: &str| {
        let text = format!(
            "parameters.k = 1.1\npotential = {{ coordinates = [\"x\"], formula = \"{formula}\" }}\n\
             particle.law = \"newtonian\"\ninitial = {{ x = 0.0, x_dot = 1.0 }}\nsolver.accuracy = 1e-12\n{rest}"
        );
        let case = parsed(&text, &[]);
        let found = find(&case, case.find.as_ref().unwrap(), true, &mut |_| {}).unwrap_or_else(|none| panic!("{none}"));
        found.existence.unwrap().unwrap_or_else(|reason| panic!("{reason}")).values
    };
    let values = of("k*x^2/2", "grid.t_f = \"pi\"\nfind = { unknowns = [\"parameters.k\"], meet = [\"x\"] }");
    let (value, radius) = values[0];
    let off = (value - Extended::ONE).abs().to_f64();
    assert!(off <= radius && radius < 1e-18, "{value:?} {radius:e}");
    // What is met has the parameter in it, by itself and in the energy, which is ½: √k sin √k = ½ at t = 1.
    let values = of(
        "k*x^2/2",
        "grid.t_f = 1.0\nfind = { unknowns = [\"parameters.k\"], meet = [\"k*x - (x_dot^2 + k*x^2)/2\"] }",
    );
    let (value, radius) = values[0];
    let root = value.sqrt();
    let left = (root * root.sin() - Extended::from(0.5)).abs().to_f64();
    assert!(left <= radius && radius < 1e-18, "{value:?} {left:e} {radius:e}");
}
