//! The law of events: an event is a change of sign of its function along the motion; each is found, acts or ends the
//! run once, and what cannot be seen is said.

use geodesic_ivp::case::Case;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::solve::{NoSolution, Setup, Status};
use geodesic_ivp::study::run::{NoRun, Run, Wanted, run};

use crate::common::parsed;

const ACCURACIES: [&str; 3] = ["accuracy=1e-4", "accuracy=1e-7", "tolerance=1e-9"];

/// A body in one dimension with a force, and what is watched.
fn scene(force: &str, x_dot: f64, t_f: f64, solver: &str, events: &str) -> Case {
    let text = format!(
        "particle.law='newtonian'\npotential={{coordinates=['x'], formula='0', force={{x='{force}'}}}}\n\
         initial={{x=0, x_dot={x_dot:?}}}\ngrid.t_f={t_f:?}\nsolver={{{solver}}}\n[events]\n{events}\n"
    );
    parsed(&text, &[])
}

fn solved(case: &Case) -> Result<(Run, Setup), NoSolution> {
    let setup = case.setup();
    match run(case, &setup, Wanted::default()).0 {
        Ok(found) => Ok((found, setup)),
        Err(NoRun::Unsolved(failure, _)) => Err(failure),
        Err(none) => panic!("{none:?}"),
    }
}

/// The run of a free body, x = 0.3 t, and its verdict.
fn free(solver: &str, events: &str) -> (Run, Grade) {
    let (found, setup) = solved(&scene("0", 0.3, 30.0, solver, events)).unwrap();
    let grade = found.judged(&setup, false, false).verdict.grade;
    (found, grade)
}

/// The names of the events of a run with their times.
fn times(case: &Case, found: &Run) -> Vec<(String, f64)> {
    found.events.iter().map(|event| (case.events[event.watch].name.clone(), event.sample.gamma)).collect()
}

/// A body at rest that is pushed later goes one way only. That its velocity is not quite 0 before is no sign.
#[test]
fn what_rests_until_it_is_pushed_changes_no_sign() {
    for force in
        ["exp(-((t - 5)/0.1)^2)", "exp(-((t - 5)/0.3)^2)", "step(t - 5)*step(6 - t)", "step(t - 5)*(t - 5)*exp(5 - t)"]
    {
        for solver in ACCURACIES {
            for events in ["v={when='x_dot'}", "v={when='x_dot', until=true}", "v={when='x_dot', set={x_dot='-1'}}"] {
                let (found, _) = solved(&scene(force, 0.0, 8.0, solver, events)).unwrap();
                assert!(found.events.is_empty(), "{force} {solver} {events}: {}", found.events.len());
                assert!((found.line.gamma_f() - 8.0).abs() < 1e-12, "{force} {solver} {events}");
                // Other doubts, as of the digits of the force, are none of events.
                assert!(found.unpaired.is_none() && found.missed == 0, "{force} {solver} {events}");
            }
        }
    }
}

/// However narrow a formula is at one place, it is followed there.
#[test]
fn formulas_that_are_narrow_at_a_place_are_followed() {
    let of_gauss = 3.3 - 1e-7 * 2.0_f64.ln().sqrt();
    for (when, x) in [
        ("1e-9 - abs(x - 3.3)", 3.3 - 1e-9),
        ("exp(-((x - 3.3)/1e-7)^2) - 0.5", of_gauss),
        ("step(1e-8 - abs(x - 3.3)) - 0.5", 3.3 - 1e-8),
        ("1e-6 - sqrt((x - 3.3)^2)", 3.3 - 1e-6),
    ] {
        for solver in ACCURACIES {
            for action in ["", ", until=true", ", set={x_dot='0.1'}"] {
                let (found, grade) = free(solver, &format!("met={{when='{when}', direction='up'{action}}}"));
                let at: Vec<f64> = found.events.iter().map(|event| event.sample.gamma).collect();
                let is_met = at.len() == 1 && (at[0] - x / 0.3).abs() < 1e-13 / 0.3 + 1e-14 * at[0];
                assert!(is_met && grade == Grade::Trusted, "{when} {solver} {action}: {at:?} {grade:?}");
            }
        }
    }
}

/// Where a formula changes everywhere faster than can be followed, the run says so, and names it.
#[test]
fn what_is_not_followed_is_said() {
    for action in ["", ", until=true", ", set={x_dot='0.1'}"] {
        let events = format!("met={{when='sin(1e9*x) - 2 + 4*step(x - 5)', direction='up'{action}}}");
        let (found, grade) = free("accuracy=1e-6", &events);
        assert!(grade == Grade::Doubtful && found.unseen.as_ref().is_some_and(|(name, _)| name == "met"), "{action}");
    }
    let text = "particle.law='newtonian'\npotential={coordinates=['x'], formula='0'}\ninitial={x=0, x_dot=0.3}\n\
                grid={t_f=30, until='sin(1e9*x) - 2'}\n";
    for solver in ["solver.accuracy=1e-6", "scheme={sbp='GLL16', form='weak'}\ngrid.windows=3"] {
        let lines: Vec<&str> = solver.lines().collect();
        let (found, setup) = solved(&parsed(text, &lines)).unwrap();
        assert_eq!(found.judged(&setup, false, false).verdict.grade, Grade::Doubtful, "{solver}");
        assert_eq!(found.unseen.map(|(name, _)| name).as_deref(), Some("grid.until"), "{solver}");
    }
}

/// Any number of zeros between two nodes counts, however close they are, and one that is threefold counts once.
#[test]
fn close_zeros_are_all_found() {
    for solver in ACCURACIES {
        for count in 3..=8 {
            for apart in [0.1, 1e-2, 1e-3, 1e-4] {
                let zeros: Vec<f64> = (0..count).map(|k| 4.3123 + apart * f64::from(k)).collect();
                let factors: Vec<String> = zeros.iter().map(|x| format!("(x - {x:?})")).collect();
                let (found, grade) = free(solver, &format!("met={{when='{}'}}", factors.join("*")));
                let are_met = found.events.iter().zip(&zeros).all(|(event, x)| (event.sample.q[1] - x).abs() < 1e-12);
                assert!(
                    found.events.len() == zeros.len() && are_met,
                    "{solver} {count} {apart}: {:?}",
                    found.events.len()
                );
                assert_eq!(grade, Grade::Trusted, "{solver} {count} {apart}");
                // The first one ends a run.
                let direction = if count % 2 == 0 { "down" } else { "up" };
                let events = format!("met={{when='{}', direction='{direction}', until=true}}", factors.join("*"));
                let (found, _) = free(solver, &events);
                assert!((found.line.end().q[1] - zeros[0]).abs() < 1e-11, "{solver} {count} {apart}");
            }
        }
        assert_eq!(free(solver, "met={when='(x - 4.3123)^3'}").0.events.len(), 1);
        assert_eq!(free(solver, "met={when='(x - 4.3123)^2'}").0.events.len(), 0);
    }
}

/// Friction stops a body when its formula says so: v = 1 − 0.3 t, and v = 4 exp(−t/10) − 3.
#[test]
fn friction_stops_a_body_in_time() {
    for (force, exact) in
        [("-0.3*sign(x_dot)", 1.0 / 0.3), ("-0.3*sign(x_dot) - 0.1*x_dot", 10.0 * (4.0_f64 / 3.0).ln())]
    {
        for accuracy in ["accuracy=1e-6", "accuracy=1e-8", "accuracy=1e-10", "tolerance=1e-9"] {
            for direction in ["down", "both"] {
                let events = format!("stop={{when='x_dot', direction='{direction}', until=true}}");
                let (found, _) = solved(&scene(force, 1.0, 8.0, accuracy, &events)).expect(accuracy);
                let off = (found.line.gamma_f() - exact).abs();
                assert!(off < 1e-10 && found.line.ended_by == Some(0), "{force} {accuracy} {direction}: {off:e}");
                assert_eq!(found.events.len(), 1, "{force} {accuracy} {direction}");
            }
        }
    }
}

/// Functions that are zero at one place, written in other ways, and flat ones: all are met there in the order of the
/// case, and act in that order.
#[test]
fn events_at_one_place_are_met_in_the_order_of_the_case() {
    let ways = ["x - 3.3", "t - 11", "7*x - 23.1", "x/3 - 1.1", "11 - t", "(t - 11)^3", "(x - 3.3)^3"];
    for one in ways {
        for two in ways {
            for solver in &ACCURACIES[1..] {
                let events = [
                    format!("a={{when='{one}', until=true}}\nb={{when='{two}'}}"),
                    format!("a={{when='{two}'}}\nb={{when='{one}', until=true}}"),
                    format!(
                        "a={{when='{one}', set={{x_dot='3*x_dot'}}}}\nb={{when='{two}', set={{x_dot='x_dot + 1'}}}}"
                    ),
                    format!(
                        "a={{when='{one}', set={{x_dot='x_dot + 1'}}}}\nb={{when='{two}', set={{x_dot='3*x_dot'}}}}"
                    ),
                    format!("a={{when='{one}', set={{x_dot='3*x_dot'}}}}\nb={{when='{two}'}}"),
                ];
                for (events, speed) in events.iter().zip([0.3, 0.3, 1.9, 3.9, 0.9]) {
                    let case = scene("0", 0.3, 12.0, solver, events);
                    let (found, _) = solved(&case).unwrap();
                    let met = times(&case, &found);
                    let names: String = met.iter().map(|(name, _)| name.as_str()).collect();
                    assert!(names == "ab" && met.iter().all(|met| (met.1 - 11.0).abs() < 1e-4), "{events}: {met:?}");
                    assert!(
                        (found.line.end().q_dot[1] - speed).abs() < 1e-12,
                        "{events}: {:?}",
                        found.line.end().q_dot
                    );
                }
            }
        }
    }
}

/// What an action makes of another function is no event: this one was negative before, and is after.
#[test]
fn what_is_turned_back_does_not_cross() {
    let events = "a={when='x - 3.3', direction='up', set={x_dot='-x_dot'}}\n\
                  b={when='x - 3.3', direction='down', set={x_dot='-x_dot'}}";
    let (found, grade) = free("accuracy=1e-7", events);
    assert_eq!((found.acting_events, grade), (1, Grade::Trusted));
    assert!((found.line.end().q[1] + 2.4).abs() < 1e-10);
}

/// +, 0 on a stretch, and − is one change of sign, where it reaches 0; + again is none; and 0 that is left is none.
#[test]
fn a_stretch_of_zeros_is_crossed_where_it_begins() {
    let (through, back) = ("max(3.3 - x, 0) + min(3.6 - x, 0)", "max(3.3 - x, 0) + max(x - 3.6, 0)");
    for solver in ACCURACIES {
        for (action, end) in [("", 9.0), (", until=true", 3.3), (", set={x_dot='2*x_dot'}", 14.7)] {
            let (found, grade) = free(solver, &format!("a={{when='{through}', direction='down'{action}}}"));
            let at: Vec<f64> = found.events.iter().map(|event| event.sample.gamma).collect();
            assert!(at.len() == 1 && (at[0] - 11.0).abs() < 1e-12, "{solver} {action}: {at:?}");
            assert!((found.line.end().q[1] - end).abs() < 1e-10 && grade == Grade::Trusted, "{solver} {action}");
        }
        assert!(free(solver, &format!("a={{when='{back}'}}")).0.events.is_empty());
        assert!(free(solver, "a={when='max(x - 3.3, 0)'}").0.events.is_empty());
    }
}

/// A ball that lies on the floor has no next window, and one that begins there and falls on is doubted.
#[test]
fn a_ball_that_rests_on_the_floor_ends_the_run_with_its_reason() {
    let ball = |start: &str, z_dot: &str| {
        let text = format!(
            "potential={{coordinates=['z'], formula='9.81*z'}}\nparticle.law='newtonian'\ninitial={{{start}}}\n\
             grid.gamma_f=2\nsolver.accuracy=1e-9\n\
             events.floor={{when='z', direction='down', set={{z_dot='{z_dot}'}}}}\n"
        );
        parsed(&text, &[])
    };
    let failure = solved(&ball("z=1, z_dot=0", "0")).unwrap_err();
    let text = failure.to_string();
    assert!(failure.status == Status::EventsRest && text.contains("'floor'") && text.contains("rest"), "{text}");
    assert!((failure.gamma - (2.0 / 9.81_f64).sqrt()).abs() < 1e-9);
    for (start, beyond) in [("z=0, z_dot=-1", Some("floor")), ("z=0, z_dot=0", Some("floor")), ("z=0, z_dot=1", None)] {
        let (found, setup) = solved(&ball(start, "-z_dot")).unwrap();
        let grade = found.judged(&setup, false, false).verdict.grade;
        assert_eq!((found.beyond.as_deref(), grade == Grade::Doubtful), (beyond, beyond.is_some()), "{start}");
    }
}
