//! `[events]`: where formulas of the state change their sign.

use std::cell::RefCell;
use std::f64::consts::{PI, TAU};

use geodesic_ivp::case::Case;
use geodesic_ivp::diagnostics::verdict::Grade;
use geodesic_ivp::geometry::Start;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::run::{Run, Wanted, run as studied};
use geodesic_ivp::trajectory::{Crossing, crossings};

use crate::common::{line_of, parsed, reference_of, shipped};

fn run<S: Real>(case: &Case) -> (WorldLine<S>, Vec<Crossing<S>>) {
    let line = line_of(case);
    let found = crossings(&line, &mut case.watches());
    (line, found)
}

/// γ of the crossings of one of the events.
fn gammas<S: Real>(found: &[Crossing<S>], watch: usize) -> Vec<f64> {
    found.iter().filter(|crossing| crossing.watch == watch).map(|crossing| crossing.sample.gamma.to_f64()).collect()
}

/// The changes of sign of every event in its direction, by the reference.
fn expected(case: &Case, line: &WorldLine) -> Vec<Vec<f64>> {
    let (start, reference) = (&line.place.start, reference_of(line));
    let norm = line.geometry().norm(&start.q, &start.q_dot);
    let of = |watch: geodesic_ivp::trajectory::Watch| {
        let formula = RefCell::new(watch.formula);
        let value = |point: &Start| formula.borrow_mut().at(&point.q, &point.q_dot, &point.p, norm);
        let changes = reference.directed_sign_changes(value).into_iter();
        changes.filter(|change| watch.direction.counts(change.1)).map(|change| change.0).collect()
    };
    case.watches().into_iter().map(of).collect()
}

#[test]
fn a_planet_is_closest_at_multiples_of_its_period() {
    // Ten periods; the last closest approach is the end of the run, and the first is its start and none.
    for windows in ["200", "150"] {
        let case = shipped("kepler", &["grid.gamma_f='20*pi'", &format!("grid.windows={windows}")]);
        let (_, found) = run::<f64>(&case);
        let (closest, farthest) = (gammas(&found, 0), gammas(&found, 1));
        assert_eq!((closest.len(), farthest.len()), (10, 10), "{closest:?} {farthest:?}");
        for (k, (closest, farthest)) in (0..).zip(closest.iter().zip(&farthest)) {
            let k = f64::from(k);
            assert!((closest - TAU * (k + 1.0)).abs() < 1e-12, "{closest} after {k} periods");
            assert!((farthest - TAU * k - PI).abs() < 1e-12, "{farthest} after {k} periods");
        }
        assert!(found.is_sorted_by_key(|crossing| crossing.sample.gamma.to_f64().to_bits()));
    }
}

#[test]
fn events_have_the_digits_of_the_run() {
    let (_, found) =
        run::<Extended>(&shipped("kepler", &["solver.digits=40", "grid.windows=30", "scheme.sbp='GLL32'"]));
    let apoapsis = found.iter().find(|crossing| crossing.watch == 1).unwrap();
    assert!((apoapsis.sample.gamma - Extended::PI).abs().to_f64() < 1e-36);
    assert!((apoapsis.sample.q[1] + Extended::from_decimal("1.6").unwrap()).abs().to_f64() < 1e-36);
}

#[test]
fn crossings_of_a_section_and_turning_points_are_those_of_the_reference() {
    for (name, set, least, most) in [
        ("henon-heiles", &["grid.windows=100"] as &[&str], 13, 1e-11),
        // Windows in which the orbit crosses several times.
        ("henon-heiles", &["grid.windows=20", "scheme.sbp='GLL48'"], 13, 1e-11),
        ("henon-heiles", &["grid.windows=40", "scheme.form='strong'", "scheme.sbp='GLL40'"], 13, 1e-11),
        ("kerr-inclined", &[], 1, 1e-9),
    ] {
        let case = shipped(name, set);
        let (line, found) = run(&case);
        for (watch, expected) in expected(&case, &line).iter().enumerate() {
            let found = gammas(&found, watch);
            // The reference does not see that it starts where both coordinates turn.
            let expected: Vec<f64> = expected.iter().copied().filter(|gamma| *gamma > 1e-6).collect();
            let are_near = found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < most);
            assert!(
                found.len() == expected.len() && found.len() >= least && are_near,
                "{set:?}: {found:?} {expected:?}"
            );
        }
    }
}

#[test]
fn events_on_even_grids_have_the_accuracy_of_the_grid() {
    let set = ["scheme.sbp='SBP84'", "grid.n_gamma=400", "grid.windows=2"];
    for form in ["strong", "weak"] {
        let form = format!("scheme.form='{form}'");
        let (line, found) = run::<f64>(&shipped("kepler", &[set[0], set[1], set[2], &form]));
        let reference = reference_of(&line);
        let off = line
            .gamma()
            .zip(line.q(1))
            .fold(0.0, |most: f64, (gamma, x)| most.max((x - reference.at(gamma).q[1]).abs()));
        let (closest, farthest) = (gammas(&found, 0), gammas(&found, 1));
        assert_eq!(farthest.len(), 1, "{closest:?} {farthest:?}");
        assert!((farthest[0] - PI).abs() < 3.0 * off && off < 1e-3, "{form}: {farthest:?}, {off:e}");
    }
}

/// A straight line at unit speed: γ is x.
const LINE: &str = r#"
    metric = { coordinates = ["x", "y"], components = { "x x" = "1", "y y" = "1 + x^2" } }
    initial = { x = 0.0, y = 0.0, x_dot = 1.0, y_dot = 0.0 }
    grid.gamma_f = 2.0
    scheme = { sbp = "GLL12", form = "weak" }
"#;

fn on_a_line(when: &str, direction: &str, windows: usize) -> Vec<f64> {
    let event = format!("events={{found={{when={when:?}, direction={direction:?}}}}}");
    gammas(&run::<f64>(&parsed(LINE, &[&event, &format!("grid.windows={windows}")])).1, 0)
}

#[test]
fn two_crossings_between_two_nodes_are_both_found() {
    for windows in [1, 3] {
        // Nodes of the only window around 1 are a quarter apart.
        for distance in [0.1, 1e-2, 1e-4, 1e-6] {
            let when = format!("(x - 1.0123)^2 - ({distance:e}/2)^2");
            let found = on_a_line(&when, "both", windows);
            assert_eq!(found.len(), 2, "{distance}");
            let apart = found[1] - found[0];
            assert!((apart - distance).abs() < 1e-9 && (found[0] + 0.5 * distance - 1.0123).abs() < 1e-9, "{found:?}");
            assert_eq!(on_a_line(&when, "down", windows), found[..1]);
            assert_eq!(on_a_line(&when, "up", windows), found[1..]);
        }
        // It touches zero, or does not reach it.
        assert!(on_a_line("(x - 1.0123)^2 + 1e-9", "both", windows).is_empty());
    }
}

/// Three crossings count as three, and the second one ends a run that waits for its direction.
#[test]
fn three_crossings_between_two_nodes_are_all_found() {
    for distance in [0.1, 1e-2, 1e-3] {
        let when = format!("(x - 1.0123)*((x - 1.0123)^2 - {distance:e}^2)");
        let expected = [1.0123 - distance, 1.0123, 1.0123 + distance];
        for windows in [1, 3] {
            let found = on_a_line(&when, "both", windows);
            let are_met = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9);
            assert!(found.len() == 3 && are_met, "{distance}: {found:?}");
            assert_eq!(on_a_line(&when, "down", windows), found[1..2]);
        }
        let place = expected.map(|x| (x - 0.1) / 0.3);
        for (direction, place) in [("up", place[0]), ("down", place[1])] {
            let end = free(&format!("when='{when}', direction='{direction}', until=true"), &[]).line.gamma_f();
            assert!((end - place).abs() < 1e-6, "{distance} {direction}: {end} {place}");
        }
    }
}

#[test]
fn a_crossing_at_a_joint_or_at_the_end_counts_once_and_one_at_the_start_not_at_all() {
    for windows in [1, 2, 4, 7] {
        assert_eq!(on_a_line("x - 1", "both", windows).len(), 1, "{windows} windows");
        let end = on_a_line("x - 2", "both", windows);
        assert!(end.len() == 1 && (end[0] - 2.0).abs() < 1e-14, "{windows} windows: {end:?}");
        assert!(on_a_line("x", "both", windows).is_empty());
        assert!(on_a_line("2 - x", "up", windows).is_empty());
        let many = on_a_line("sin(10*pi*x)", "both", windows);
        // A formula needs windows that resolve it: it is a polynomial of degree 23 on each.
        if windows > 2 {
            assert_eq!(many.len(), 20, "{windows} windows: {many:?}");
        }
    }
}

/// The first node of the weak form is not the start, but close to it: where an event is at the start, rounding and the
/// error of that node decide nothing.
#[test]
fn the_error_of_the_first_node_is_no_event() {
    for form in ["weak", "strong"] {
        for system in ["physical-limit", "doubled"] {
            let (form, system) = (format!("scheme.form={form}"), format!("solver.system={system}"));
            let grid = ["scheme.sbp=SBP42", "grid.n_gamma=20", "grid.windows=1", "grid.gamma_f=2.0"];
            let set: Vec<&str> = grid.into_iter().chain([form.as_str(), system.as_str()]).collect();
            let (line, found) = run::<f64>(&shipped("kerr-inclined", &set));
            assert!(found.is_empty(), "{form} {system}: {:?}", gammas(&found, 0));
            // The orbit starts at r = 4 and goes out. A radius just beyond the first node is met.
            let first = line.q(1).next().unwrap();
            assert!((first - 4.0).abs() < 1e-6 && (form.ends_with("strong") == (first == 4.0)), "{first}");
            let beyond = shipped("kerr-inclined", &[&set[..], &["events={beyond={when='r - 4.0000001'}}"]].concat());
            let met = gammas(&run::<f64>(&beyond).1, 0);
            assert!(met.len() == 1 && met[0] < 0.01, "{form} {system}: {met:?}");
        }
    }
}

#[test]
fn an_event_may_end_the_run_and_is_its_last_row() {
    for (direction, place, gamma) in [("up", [0.4, 0.0], TAU), ("down", [-1.6, 0.0], PI), ("both", [-1.6, 0.0], PI)] {
        let event = format!("events.periapsis={{when='x*x_dot + y*y_dot', direction='{direction}', until=true}}");
        let schemes = [(&["grid.windows=40"] as &[&str], 1e-11), (&["grid.windows=40", "scheme.form='strong'"], 1e-11)];
        for (set, most) in schemes.into_iter().chain([(&["solver.accuracy=1e-11"] as &[&str], 1e-9)]) {
            let case = shipped("kepler", &[&[event.as_str(), "grid.gamma_f=20.0"], set].concat());
            let (line, found) = run::<f64>(&case);
            assert!((line.length - gamma).abs() < most, "{direction}: {}", line.length);
            assert!((line.end().q[1] - place[0]).abs() < most && (line.end().q[2] - place[1]).abs() < most);
            let found = gammas(&found, 0);
            assert!(found.len() == 1 && (found[0] - gamma).abs() < most, "{direction}: {found:?}");
        }
    }
    // The first of several that end the run does.
    let both = [
        "events.a={when='y + 0.1', until=true}",
        "events.b={when='x + 0.2', until=true}",
        "grid.gamma_f=20.0",
        "grid.windows=40",
    ];
    let (line, _) = run::<f64>(&shipped("kepler", &both));
    assert!((line.end().q[1] + 0.2).abs() < 1e-12, "{:?}", line.end().q);
}

#[test]
fn of_two_events_in_one_step_the_first_ends_the_run() {
    for apart in [1e-2, 1e-4, 1e-8] {
        for [a, b] in [[1.0, 1.0 + apart], [1.0 + apart, 1.0]] {
            let events = format!("events={{a={{when='x - {a:?}', until=true}}, b={{when='{b:?} - x', until=true}}}}");
            let line: WorldLine = line_of(&parsed(LINE, &[&events, "grid.windows=3"]));
            assert!((line.length - 1.0).abs() < 1e-12, "{a} and {b}: {}", line.length);
        }
    }
}

/// An oscillation passes 0 at odd multiples of π/2 and rests at multiples of π. The errors that the judge tells are
/// upper bounds of the true ones, and no larger than the accuracy allows.
#[test]
fn events_have_the_errors_that_their_pairs_tell() {
    let scene = "potential={coordinates=['x'], formula='x^2/2'}\nparticle.law='newtonian'\ninitial={x=1, x_dot=0}\n\
                 grid.t_f=40\nsolver.accuracy=1e-3\n[events]\npass={when='x'}\nrest={when='x_dot'}";
    for solver in ["accuracy=1e-3", "accuracy=1e-6", "accuracy=1e-10", "tolerance=1e-4", "tolerance=1e-8"] {
        let setting = format!("solver={{{solver}}}");
        let case = parsed(scene, &[&setting]);
        let Ok(found) = studied(&case, &case.setup::<f64>(), Wanted::default()).0 else { panic!("{solver}") };
        assert_eq!((found.events.len(), found.unpaired.as_deref()), (25, None), "{solver}");
        for (k, event) in (1..).zip(&found.events) {
            let (exact, off) = (f64::from(k) * PI / 2.0, event.off.as_ref().unwrap());
            let late = (event.sample.gamma - exact).abs();
            assert!(late <= off[0], "{solver}, {k}: {late:e} {off:?}");
            assert!(off[0] <= 40.0 * found.line.error_estimate.unwrap(), "{solver}, {k}: {off:?}");
        }
    }
}

/// A particle that moves freely, x = 0.1 + 0.3 t and y = 0.7 + 0.1 t: one window is enough for it.
const FREE: &str = "potential={coordinates=['x', 'y'], formula='0'}\nparticle.law='newtonian'\n\
                    initial={x=0.1, y=0.7, x_dot=0.3, y_dot=0.1}\ngrid.t_f=30\nsolver.accuracy=1e-6\n";

fn free(event: &str, settings: &[&str]) -> Run {
    let case = parsed(&format!("{FREE}events.met={{{event}}}"), settings);
    let Ok(found) = studied(&case, &case.setup::<f64>(), Wanted::default()).0 else { panic!("{event} {settings:?}") };
    found
}

const ACCURACIES: [&str; 4] =
    ["solver.accuracy=1e-3", "solver.accuracy=1e-6", "solver.accuracy=1e-9", "solver.accuracy=1e-12"];

/// Windows as long as the motion allows do not resolve such formulas; more points of them do.
#[test]
fn formulas_that_change_faster_than_the_motion_are_met() {
    for accuracy in ACCURACIES {
        let found = free("when='sin(20*x) - 0.9', direction='up'", &[accuracy]);
        assert_eq!(found.events.len(), 28, "{accuracy}");
        for (k, event) in (1..).zip(&found.events) {
            let exact = ((0.9_f64.asin() + TAU * f64::from(k)) / 20.0 - 0.1) / 0.3;
            assert!((event.sample.gamma - exact).abs() < 1e-12, "{accuracy}, {k}");
        }
    }
}

/// The first place where such a formula changes its sign ends the run, also on a grid that does not resolve it.
#[test]
fn formulas_that_change_faster_than_the_motion_end_it_at_the_first_place() {
    let of_sine = ((0.9_f64.asin() + TAU) / 20.0 - 0.1) / 0.3;
    let of_gauss = (3.2 - 0.1 * 2.0_f64.ln().sqrt()) / 0.3;
    for (when, exact) in [
        ("sin(20*x) - 0.9", of_sine),
        ("exp(-((x - 3.3)/0.1)^2) - 0.5", of_gauss),
        ("0.1 - hypot(x - 3.3, y - 1.7666)", 10.350_372_297_228_722),
        ("1e-4 - abs(x - 3.3)", 3.1999 / 0.3),
        ("tanh((x - 3.3)/1e-3) - tanh((x - 3.31)/1e-3) - 1", 3.2 / 0.3),
    ] {
        let event = format!("when='{when}', direction='up', until=true");
        for accuracy in ACCURACIES {
            let end = free(&event, &[accuracy]).line.gamma_f();
            assert!((end - exact).abs() < 1e-7, "{when} {accuracy}: {end}");
        }
        // grid.until knows no direction.
        let exact = if when.starts_with("sin") { ((PI - 0.9_f64.asin()) / 20.0 - 0.1) / 0.3 } else { exact };
        let case = parsed(
            &FREE.replace("solver.accuracy=1e-6", "scheme={sbp='GLL16', form='weak'}\ngrid.windows=30"),
            &[&format!("grid.until=\"{when}\"")],
        );
        let end = line_of::<f64>(&case).gamma_f();
        assert!((end - exact).abs() < 1e-7, "{when}: {end}");
    }
}

/// The polynomial of a window does not follow this formula, and falls at the end where the formula grows.
#[test]
fn what_ends_a_run_is_met_once() {
    let event = "when='(x - 1.73)/(1 + (x/0.065)^2) + 0.048', direction='both', until=true";
    for start in ["-0.31", "-0.3", "-0.25"] {
        let found = free(event, &[&format!("initial.x={start}"), "initial.x_dot=1.97"]);
        assert_eq!(found.events.len(), 1, "{start}: {:?}", found.events);
    }
}

/// A slab that is passed through acts once, however thin it is, and so do many of them.
#[test]
fn thin_slabs_act_once_where_they_are_entered() {
    let y = |times: &[f64]| 3.7 + times.iter().map(|at| 0.5 * (30.0 - at)).sum::<f64>();
    let sine = |k: i32| ((0.9999_f64.asin() + TAU * f64::from(k)) / 200.0 - 0.1) / 0.3;
    let all: Vec<f64> = (3..290).map(sine).collect();
    let mut scenes: Vec<(String, Vec<f64>)> = vec![("sin(200*x) - 0.9999".to_owned(), all)];
    for width in [0.3, 0.03, 1e-3, 1e-5] {
        scenes.push((format!("{width:?}^2 - (x - 3.3)^2"), vec![(3.2 - width) / 0.3]));
    }
    for (when, times) in scenes {
        for accuracy in &ACCURACIES[1..] {
            let found = free(&format!("when='{when}', direction='up', set={{y_dot='y_dot + 0.5'}}"), &[accuracy]);
            assert_eq!(found.acting_events, times.len(), "{when} {accuracy}");
            let [end, exact] = [found.line.end().q[2], y(&times)];
            assert!((end - exact).abs() < 1e-5 * exact, "{when} {accuracy}: {end} {exact}");
        }
    }
}

/// Run and judge may have the same first window, and agree on anything in it: no event is better than the tolerance.
#[test]
fn events_of_the_first_window_have_errors() {
    for solver in ["accuracy=1e-3", "accuracy=2e-5", "tolerance=1e-4", "accuracy=1e-7"] {
        for place in [0.7, 0.4, 0.2, -0.1, -0.3] {
            let scene = format!(
                "potential={{coordinates=['x'], formula='x^2/2'}}\nparticle.law='newtonian'\ninitial={{x=1, x_dot=0}}\n\
                 grid.t_f=13.7\nsolver.accuracy=1e-3\nevents.met={{when='x - ({place:?})', direction='down'}}"
            );
            let case = parsed(&scene, &[&format!("solver={{{solver}}}")]);
            let Ok(found) = studied(&case, &case.setup::<f64>(), Wanted::default()).0 else { panic!("{solver}") };
            for (turn, event) in found.events.iter().enumerate() {
                let late = (event.sample.gamma - f64::acos(place) - TAU * turn as f64).abs();
                let off = event.off.as_ref().unwrap();
                assert!(late <= off[0], "{solver} {place}, {turn}: {late:e} {off:?}");
            }
        }
    }
}

/// A thin slab that is left where it was entered is met, or the run is doubted: its table has the event all the same.
#[test]
fn a_run_that_passes_what_ends_it_is_not_trusted() {
    let scene = "potential={coordinates=['x', 'y'], formula='0.5*x^2'}\nparticle.law='newtonian'\ngrid.t_f=14.1008\n\
                 initial={x=-0.692865, x_dot=-0.526897, y=0.288693, y_dot=-0.0735232}\nsolver.accuracy=1e-3\n\
                 events.met={when='(x + y - 0.58002)^2 - 2.72421e-11', until=true}";
    for solver in ["accuracy=1e-3", "tolerance=1.1e-5", "accuracy=1e-6", "accuracy=1e-9", "accuracy=1e-12"] {
        let case = parsed(scene, &[&format!("solver={{{solver}}}")]);
        let setup = case.setup::<f64>();
        let Ok(found) = studied(&case, &setup, Wanted::default()).0 else { continue };
        let is_right = (found.line.gamma_f() - 2.832_226_644_902_462).abs() < 1e-3;
        let grade = found.judged(&setup, false, false).verdict.grade;
        assert!(is_right || grade == Grade::Doubtful, "{solver}: {}", found.line.gamma_f());
    }
}
