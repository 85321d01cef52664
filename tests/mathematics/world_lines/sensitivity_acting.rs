//! Sensitivity behind events that act, and proofs behind events that set places.

use geodesic_ivp::Case;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::engine::Sensitivity;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::output::tables::write_growth;
use geodesic_ivp::study::run::{Run, Wanted, run};

use super::proved_acting::{decimal, largest, number, off, proved};
use crate::common::parsed;

const LAW: &str = "particle.law = \"newtonian\"\nsolver.accuracy = 1e-12\n";

/// Scenes with events that act several times: their text, the active coordinates, and the keys of the start by which
/// ends are changed.
const SCENES: [(&str, &str, [&str; 2], [&str; 4]); 4] = [
    (
        "a ball on a slope that moves",
        r#"
        potential = { coordinates = ["x", "z"], formula = "9.81*z + x^2/2" }
        initial = { x = 0.3, z = 1.1, x_dot = 0.2, z_dot = 0.1 }
        grid.t_f = 1.9
        events.slope.when = "z - 0.2*x - 0.05*sin(3*t)"
        events.slope.direction = "down"
        events.slope.set = { x_dot = "x_dot + 0.3*(z_dot - 0.2*x_dot)", z_dot = "-0.8*z_dot" }
        "#,
        ["x", "z"],
        ["x", "z", "x_dot", "z_dot"],
    ),
    (
        "kicks of momenta",
        r#"
        potential = { coordinates = ["x", "y"], formula = "x^2/2 + y^2 + x^2*y/5" }
        initial = { x = 0.7, y = 0.2, p_x = 0.1, p_y = 0.9 }
        grid.t_f = 9.0
        events.kick = { when = "y + x/3", set = { p_x = "0.9*x_dot + y/10", p_y = "1.05*y_dot" } }
        "#,
        ["x", "y"],
        ["x", "y", "p_x", "p_y"],
    ),
    (
        "a place that is set, in a field that depends on it",
        r#"
        potential = { coordinates = ["x", "y"], formula = "x^2/2 + y^2", one_form = { y = "x^2/4" } }
        initial = { x = 0.2, y = 0.2, x_dot = 0.6, y_dot = 0.3 }
        grid.t_f = 4.0
        events.portal = { when = "x - 0.5", direction = "up", set = { x = "-0.4 + y/10", y_dot = "0.9*y_dot" } }
        "#,
        ["x", "y"],
        ["x", "y", "x_dot", "y_dot"],
    ),
    (
        "a parameter that is set",
        r#"
        parameters.k = 1.0
        potential = { coordinates = ["x", "y"], formula = "k*x^2/2 + y^2/2 + x*y/5" }
        initial = { x = 0.7, y = 0.2, x_dot = 0.1, y_dot = 0.4 }
        grid.t_f = 4.0
        events.harder = { when = "x", set = { k = 2.0 } }
        "#,
        ["x", "y"],
        ["x", "y", "x_dot", "y_dot"],
    ),
];

fn solved(case: &Case) -> Run {
    run::<f64>(case, &case.setup(), Wanted::default()).0.unwrap_or_else(|_| panic!("it is solved"))
}

fn last(run: &Run) -> Vec<f64> {
    let joints = run.line.sensitivity.as_ref().expect("it was asked for").joints();
    joints.last().expect("nothing has left the range of numbers").to_vec()
}

/// The end of a run in more digits than it has: of a proof, if there is one.
fn end(case: &Case, names: &[&str]) -> Vec<Extended> {
    if let Some(proof) = proved(case).filter(|proof| !proof.ends.is_empty()) {
        let of = |name: &&str| decimal(&proof.ends.iter().find(|end| end.name == **name).unwrap().end);
        return names.iter().map(of).collect();
    }
    let run = solved(case);
    let place = |name: &&str| run.line.geometry().names().iter().position(|other| other == name).unwrap();
    names.iter().map(|name| Extended::from(run.line.end().q[place(name)])).collect()
}

/// The places at the end change as neighbouring runs say, through all events; a momentum of the start is the velocity
/// at a constant place where nothing else is in it.
#[test]
fn small_changes_behind_events_are_those_of_neighbouring_runs() {
    for (what, text, names, keys) in SCENES {
        let text = format!("{LAW}{text}");
        let run = solved(&parsed(&text, &["solver.sensitivity=true"]));
        assert!(run.parts().len() > 2, "{what}: {} pieces", run.parts().len());
        let found = last(&run);
        let start = parsed(&text, &[]).setup::<f64>().place;
        // The momenta that a user sees have the other sign than those of the geometry.
        let momentum = |changed: &Case, a: usize| -changed.setup::<f64>().place.start.p[a + 1];
        for (column, key) in keys.into_iter().enumerate() {
            let step = 1e-6;
            let value: f64 = value_of(&text, key);
            let cases = [-1.0, 1.0].map(|side| parsed(&text, &[&format!("initial.{key}={}", value + side * step)]));
            let ends = cases.each_ref().map(|case| end(case, &names));
            // What the key changes of the start: a place may be in momenta, too.
            let of_start = |k: usize| match k.checked_sub(2) {
                None => f64::from(u8::from(k == column)),
                Some(a) => (momentum(&cases[1], a) - momentum(&cases[0], a)) / (2.0 * step),
            };
            for (row, name) in names.iter().enumerate() {
                let wanted = (ends[1][row] - ends[0][row]).to_f64() / (2.0 * step);
                let seen = |k: usize| if k < 2 { 1.0 } else { -1.0 };
                let own: f64 = (0..4).map(|k| found[row * 4 + k] * seen(k) * of_start(k)).sum();
                let room = 2e-6 * (1.0 + wanted.abs());
                assert!((own - wanted).abs() < room, "{what}: d{name}/d{key} = {own} and {wanted}");
            }
        }
        assert_eq!(start.start.q.len(), 4, "{what}");
    }
}

/// The number of a key of the start in a text.
fn value_of(text: &str, key: &str) -> f64 {
    let initial = text.lines().find(|line| line.contains("initial")).unwrap();
    let rest =
        initial.split([' ', ',', '{', '}']).skip_while(|word| *word != key).find(|word| word.parse::<f64>().is_ok());
    rest.unwrap().parse().unwrap()
}

/// By Newton's law the momentum of t is the energy. Where that is not conserved it changes with the others, also by an
/// event: as E(end) − E(start) does, as it was held at the start.
#[test]
fn the_energy_changes_behind_an_event_as_the_motion_does() {
    let text = format!(
        "{LAW}potential = {{ coordinates = [\"x\"], formula = \"x*t/5\", force = {{ x = \"-x_dot/10\" }} }}\n\
         grid.t_f = 2.0\n\
         events.wall = {{ when = \"x - 0.2*t\", direction = \"down\", set = {{ x_dot = \"-2*x_dot\" }} }}"
    );
    let case = |v: f64, more: &str| parsed(&format!("{text}\ninitial = {{ x = 1.0, x_dot = {v} }}\n{more}"), &[]);
    let run = solved(&case(-1.0, "solver.sensitivity = true"));
    assert_eq!(run.parts().len(), 2);
    let geometry = run.line.geometry();
    let active = geometry.active();
    let (n, t, x) = (2 * active.len(), 0, active.iter().position(|&a| a == 1).unwrap());
    assert_eq!(active[0], 0);
    // That is by p_x = ẋ of the user at the start; the momentum of t has the sign of mechanics.
    let found = -last(&run)[(active.len() + t) * n + active.len() + x];
    let gain = |v: f64| {
        let run = solved(&case(v, ""));
        let end = run.line.end();
        end.q[1] * end.q[0] / 5.0 + 0.5 * end.q_dot[1] * end.q_dot[1] - 0.5 * v * v
    };
    let wanted = (gain(-1.0 + 1e-5) - gain(-1.0 - 1e-5)) / 2e-5;
    assert!((found - wanted).abs() < 1e-7, "{found} {wanted}");
}

/// An oscillator that loses a part of its velocity whenever it meets a wall in its middle: all of δ is lost with it,
/// and the exponent is ln e/π. Both states of a blow are in the table.
#[test]
fn exponents_behind_blows_are_those_of_what_is_lost() {
    let text = format!(
        "{LAW}potential.formula = \"x^2/2\"\ninitial = {{ x = 1.0, x_dot = 0.0 }}\ngrid.t_f = \"10*pi\"\n\
         solver.sensitivity = true\n\
         events.wall = {{ when = \"x\", direction = \"down\", set = {{ x_dot = \"-0.9*x_dot\" }} }}"
    );
    let case = parsed(&text, &[]);
    let run = solved(&case);
    let growth = run.line.sensitivity.as_ref().map(Sensitivity::growth).unwrap();
    let wanted = 0.9_f64.ln() / std::f64::consts::PI;
    assert!((growth.lyapunov - wanted).abs() < 1e-12, "{growth:?} {wanted}");
    assert_eq!(run.judged(&case.setup(), false, false).verdict.grade, Grade::Trusted);
    let pieces: Vec<_> = run.parts().into_iter().map(|(line, _)| line).collect();
    let mut table = Vec::new();
    write_growth(&mut table, &pieces).unwrap();
    let table = String::from_utf8(table).unwrap();
    let gammas: Vec<f64> = table.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert!(gammas.is_sorted() && gammas.windows(2).filter(|pair| pair[0] == pair[1]).count() == 10, "{gammas:?}");
}

#[test]
fn what_small_changes_do_not_tell_is_refused_or_said() {
    let stone = |events: &str| {
        format!(
            "{LAW}solver.sensitivity = true\npotential = {{ coordinates = [\"x\", \"z\"], formula = \"9.81*z\" }}\n\
             initial = {{ x = 0.0, z = 1.0, x_dot = 1.0, z_dot = 0.0 }}\ngrid.t_f = 0.8\n[events]\n{events}"
        )
    };
    let refused = |events: &str| Case::parse("stone", &stone(events), &[]).unwrap_err().to_string();
    let set = "set = { z_dot = \"-z_dot\", x_dot = \"0.9*x_dot\" }";
    let of_place = refused(&format!("slope = {{ when = \"z - x/9\", direction = \"down\", {set} }}"));
    assert!(of_place.contains("'slope'") && of_place.contains("ignorable"), "{of_place}");
    let of_momentum = refused("floor = { when = \"z\", direction = \"down\", set = { x_dot = \"-z_dot\" } }");
    assert!(of_momentum.contains("conserved momentum"), "{of_momentum}");
    let both = "a = { when = \"z\", direction = \"down\", set = { z_dot = \"-z_dot\" } }\n\
                b = { when = \"2*z\", direction = \"down\", set = { x_dot = \"0.9*x_dot\" } }";
    let case = parsed(&stone(both), &[]);
    let run = solved(&case);
    let verdict = run.judged(&case.setup(), false, false).verdict;
    assert!(run.line.sensitivity.is_none() && verdict.grade == Grade::Doubtful, "{verdict:?}");
    assert!(verdict.reasons.iter().any(|reason| reason.to_string().contains("several events")), "{verdict:?}");
}

/// A ball that comes back above whenever it meets the floor, with the velocity that it has: pieces of parabolas.
#[test]
fn a_ball_that_comes_back_above_is_where_parabolas_are() {
    let most = largest(|random| {
        let mut of = |least, most| number(random, least, most);
        let [z, v, top] = [of(0.5, 1.5), of(-1.0, 1.0), of(1.0, 2.0)];
        let case = parsed(
            &format!(
                "potential = {{ coordinates = [\"z\"], formula = \"9.81*z\" }}\nparticle.law = \"newtonian\"\n\
                 initial = {{ z = {z}, z_dot = {v} }}\ngrid.t_f = 1.5\nsolver.accuracy = 1e-9\n\
                 events.floor = {{ when = \"z\", direction = \"down\", set = {{ z = \"{top} - z_dot/100\" }} }}"
            ),
            &[],
        );
        let [mut z, mut v, top] = [z, v, top].map(|text| decimal(&text));
        let (mut left, g, two) = (decimal("1.5"), decimal("9.81"), Extended::from(2.0));
        loop {
            let next = (v + (v * v + two * g * z).sqrt()) / g;
            let time = if next < left { next } else { left };
            z += v * time - g * time * time / two;
            v -= g * time;
            left -= time;
            if left <= Extended::ZERO {
                break;
            }
            z = top - v / Extended::from(100.0);
        }
        off(&proved(&case)?, "z", z)
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}

/// Free motion in polar coordinates, from one circle back to a smaller one: the angular momentum changes with the
/// place, as the angular velocity stays.
#[test]
fn momenta_follow_places_that_are_set() {
    let most = largest(|random| {
        let mut of = |least, most| number(random, least, most);
        let [r, w, u] = [of(1.0, 1.8), of(0.3, 0.8), of(-0.4, 0.4)];
        let case = parsed(
            &format!(
                "metric.coordinates = [\"r\", \"phi\"]\n\
                 metric.components = {{ \"r r\" = \"1\", \"phi phi\" = \"r^2\" }}\n\
                 initial = {{ r = {r}, phi = 0.0, r_dot = {u}, phi_dot = {w} }}\ngrid.gamma_f = 5.0\n\
                 solver.accuracy = 1e-9\n\
                 events.rim = {{ when = \"r - 2\", direction = \"up\", set = {{ r = 1.0 }} }}"
            ),
            &[],
        );
        let [mut r, mut w, mut u] = [r, w, u].map(|text| decimal(&text));
        let (mut left, two) = (decimal("5"), Extended::from(2.0));
        loop {
            // r² = r₀² + 2 r₀ ṙ₀ γ + (ṙ₀² + r₀² φ̇₀²) γ²
            let (b, square, l) = (r * u, u * u + r * r * w * w, r * r * w);
            let at = |time: Extended| (r * r + two * b * time + square * time * time).sqrt();
            let next = ((b * b + square * (two * two - r * r)).sqrt() - b) / square;
            let time = if next < left { next } else { left };
            let radius = at(time);
            u = (b + square * time) / radius;
            left -= time;
            if left <= Extended::ZERO {
                r = radius;
                break;
            }
            (r, w) = (Extended::ONE, l / (two * two));
        }
        off(&proved(&case)?, "r", r)
    });
    assert!(most <= 1.0 && most > 1e-6, "{most}");
}
