//! The chart of speed against accuracy: what its rows say. Nothing here depends on how fast the machine is.

use std::collections::BTreeSet;
use std::time::Instant;

use geodesic_ivp::case::{Case, Form, SbpName};
use geodesic_ivp::engine::Handed;
use geodesic_ivp::methods::{Output, PEERS, Peer, Problem, Setting, Step};
use geodesic_ivp::solve::{Setup, WorldLine, solve};
use geodesic_ivp::study::work_precision::{
    Arena, Budget, Method, OUTPUTS, Progress, Row, RowErrors, RowStatus, drift, measure,
};

use crate::common::{case, g00, norm_of, parsed, reference, shipped};

/// By settings and not by time, so that a slow machine measures the same.
const BUDGET: Budget = Budget { longest: f64::INFINITY, rounds: 1, settings: 12 };

fn rows_of(arena: &Arena, families: &[Method], budget: &Budget) -> Vec<Row> {
    let measured = measure(arena, families, budget, &mut |_| {});
    assert!(!measured.interrupted);
    measured.rows
}

/// The best result of every method is below its bound; rows that have converged tell the errors of every coordinate.
fn every_method_arrives(case: &Case, length: f64, bound: impl Fn(&Method) -> f64) {
    let arena = Arena::new(case, Some(length)).unwrap();
    assert!(arena.length() == length && arena.reference_error() < 1e-18, "{}", arena.reference_error());
    assert_eq!(arena.coordinates(), case.coordinates());
    let separable = case.geometry::<f64>().is_separable();
    let mut families = Method::timed();
    families.retain(|family| family.unsuitable(separable).is_none());
    assert_eq!(families.contains(&Method::Peer(Peer::Verlet)), separable);
    let measured = rows_of(&arena, &families, &BUDGET);
    for family in &families {
        let rows: Vec<_> = measured.iter().filter(|row| row.method == *family).collect();
        let best = rows.iter().filter_map(|row| row.rank()).fold(f64::INFINITY, f64::min);
        assert!(best < bound(family), "{}: {best} in {} settings", family.label(), rows.len());
        for row in rows.iter().filter(|row| row.status == RowStatus::Converged) {
            let errors = row.errors.as_ref().unwrap();
            assert_eq!(errors.q.len(), case.coordinates().len());
            assert_eq!(row.rank(), Some(errors.q.iter().copied().fold(0.0, f64::max)));
            // K depends on x and w, which are as accurate as x; a node of the strong form is less so.
            assert!(errors.delta_k < 1e3 * errors.largest() + 1e-9, "{} {}: {errors:?}", family.label(), row.setting);
            assert!(row.points > 0 && row.seconds_min <= row.seconds_median);
            assert_counted(row);
        }
    }
}

/// A row has the points of its grid, and their evaluations.
fn assert_counted(row: &Row) {
    let number =
        |key: &str| -> Option<usize> { row.setting.split(key).nth(1)?.split_whitespace().next()?.parse().ok() };
    let points = match (&row.method, number("N="), number("windows="), number("steps=")) {
        (_, Some(nodes), ..) => nodes,
        (Method::Elements(nodes) | Method::March(nodes), None, Some(windows), _) => windows * nodes,
        (_, None, None, Some(steps)) => steps,
        _ => row.points,
    };
    assert_eq!(row.points, points, "{} {}", row.method.label(), row.setting);
    let evaluations = match &row.method {
        Method::Peer(peer) if peer.name() == "RK4" => 4 * points..4 * points + 1,
        // A recursion, which does not iterate.
        Method::Block(SbpName::Sbp21, Form::Strong) => points..points + 1,
        _ => 1..usize::MAX,
    };
    assert!(evaluations.contains(&row.evaluations), "{} {}", row.method.label(), row.setting);
}

#[test]
fn every_method_arrives_in_one_coordinate() {
    every_method_arrives(&case("grid.gamma_f=4.0"), 4.0, |family| match family {
        Method::Block(SbpName::Sbp21, _) => 1e-2,
        Method::Block(SbpName::Sbp42, _) => 1e-3,
        Method::Block(..) => 1e-4,
        Method::March(4) => 1e-5,
        Method::Peer(peer) => match peer.about().order {
            Some(2) => 1e-2,
            Some(5) => 1e-3,
            Some(4) => 1e-5,
            _ if peer.name() == "Gauss 4" => 1e-8,
            _ => 1e-10,
        },
        _ => 1e-10,
    });
}

#[test]
#[ignore = "long: all methods run in two scenes at all their settings"]
fn every_method_arrives_in_scenes() {
    for (name, length) in [("henon-heiles", 5.0), ("kerr-inclined", 60.0)] {
        every_method_arrives(&shipped(name, &[]), length, |family| match family {
            Method::Block(SbpName::Sbp21, _) => 3e-1,
            Method::Block(..) => 1e-2,
            Method::Elements(4) => 1e-3,
            Method::Elements(6) => 1e-6,
            Method::Peer(peer) => match (peer.about().order, peer.about().step) {
                (Some(2), _) => 1e-1,
                (Some(4), _) => 1e-3,
                (Some(5), Step::Adaptive) => 1e-2,
                _ => 1e-6,
            },
            _ => 1e-8,
        });
    }
}

#[test]
fn what_fails_has_its_status_and_no_rank() {
    let arena = Arena::new(&case("grid.gamma_f=300.0"), None).unwrap();
    let families = [Method::Peer(Peer::Gauss(2)), Method::Peer(Peer::Rk4)];
    let rows = rows_of(&arena, &families, &BUDGET);
    let statuses: Vec<&str> = rows.iter().map(|row| row.status.as_str()).collect();
    for status in ["converged", "inaccurate", "not-converged"] {
        assert!(statuses.contains(&status), "{status}: {statuses:?}");
    }
    for row in &rows {
        assert_eq!(row.rank().is_some(), row.status == RowStatus::Converged, "{row:?}");
    }
}

#[test]
fn a_case_is_charted_at_its_length() {
    let arena = Arena::new(&case("grid={t_f=3.0,n_gamma=32}"), None).unwrap();
    assert!((arena.length() - 2.0).abs() < 0.5, "{}", arena.length());
    let case = shipped("henon-heiles", &["grid.gamma_f=20.0", "grid.until=\"x\"", "grid.windows=1"]);
    let arena = Arena::new(&case, None).unwrap();
    assert!((0.1..20.0).contains(&arena.length()), "{}", arena.length());
    let own = [Method::Block(SbpName::Sbp42, Form::Weak), Method::Elements(16)];
    let rows = rows_of(&arena, &own, &BUDGET);
    assert!(own.iter().all(|family| rows.iter().any(|row| row.method == *family && row.rank() < Some(1e-3))));
}

#[test]
fn along_a_run_runge_kutta_drifts_and_windows_do_not() {
    let arena = Arena::new(&case("grid.gamma_f=100.0"), None).unwrap();
    assert!(arena.reference_error() < 1e-20, "{:e}", arena.reference_error());
    let families = [Method::Peer(Peer::Rk4), Method::Peer(Peer::Verlet), Method::March(16)];
    let points = drift(&arena, &families);
    let growth = |family: &Method| {
        let of = |from: f64, to: f64| {
            let part = points.iter().filter(|p| p.method == *family && (from..to).contains(&p.gamma));
            part.map(|point| point.errors.delta_k).fold(0.0, f64::max)
        };
        of(80.0, 101.0) / of(0.0, 20.0)
    };
    assert!(
        growth(&families[0]) > 2.0 && growth(&families[1]) < 1.5,
        "{} {}",
        growth(&families[0]),
        growth(&families[1])
    );
    let windows = points.iter().filter(|point| point.method == families[2]);
    assert!(windows.map(|point| point.errors.delta_k).fold(0.0, f64::max) < 1e-13);
}

/// 200 evaluations in each of 100 intervals, of which there are ten a unit of γ, by a whole number of steps in each, or
/// by a tolerance that costs about as much.
#[test]
fn along_a_run_all_methods_get_about_the_same_budget() {
    let arena = Arena::new(&case("grid.gamma_f=10.0"), None).unwrap();
    let points = drift(&arena, &Method::timed());
    let mut drawn: Vec<&Method> = points.iter().map(|point| &point.method).collect();
    drawn.dedup();
    assert_eq!(drawn.len(), 14, "{drawn:?}");
    for family in drawn {
        let own: Vec<_> = points.iter().filter(|point| point.method == *family).collect();
        assert!(own.is_sorted_by(|a, b| a.gamma < b.gamma), "{family:?}");
        assert!((own[own.len() - 1].gamma - 10.0).abs() < 1e-12 && (own[0].gamma - 0.1).abs() < 1e-12, "{family:?}");
        let setting = &own[0].setting;
        let (tolerance, work) = setting.split_once(", ").map_or((None, setting.as_str()), |(a, b)| (Some(a), b));
        let step = if let Method::Peer(peer) = family { Some(peer.about().step) } else { None };
        assert_eq!(tolerance.is_some_and(|one| one.starts_with("tol=1e-")), step == Some(Step::Adaptive), "{setting}");
        let Some(work) = work.strip_suffix(" evaluations a unit of gamma") else {
            assert!(work.starts_with("tol="), "{setting}");
            continue;
        };
        let within = match (family.label().as_str(), step) {
            ("RK4" | "Verlet", _) => 2000.0..2001.0,
            ("DOP853", _) => 400.0..2500.0,
            (_, Some(Step::Adaptive)) => 0.0..f64::INFINITY,
            _ => 1300.0..2700.0,
        };
        assert!(within.contains(&work.parse::<f64>().unwrap()), "{family:?}: {work}");
    }
}

#[test]
fn errors_of_a_row_are_those_of_the_states_and_decide_its_status() {
    let case = case("initial={t=2.0,x=1.0,t_dot=1.3,x_dot=0.4} grid.gamma_f=8.0");
    let (geometry, start) = (case.geometry::<f64>(), case.start::<f64>());
    let reference = reference(&geometry, &start, 8.0);
    let (arena, q_t, k) = (Arena::new(&case, None).unwrap(), start.p[0], norm_of(&geometry, &start));
    assert!(arena.reference_error() > 0.0);
    let budget = Budget { settings: 4, ..BUDGET };
    let rows = rows_of(&arena, &[Method::Peer(Peer::Verlet)], &budget);
    let mut large = false;
    for row in &rows {
        let steps: usize = row.setting.strip_prefix("steps=").unwrap().parse().unwrap();
        let problem = Problem { space: geometry.clone().into(), start: start.clone(), length: 8.0, g00: case.g00() };
        let output = Output::even(OUTPUTS);
        let states = Peer::Verlet.run(&problem, &output, Setting::steps(steps)).unwrap().states;
        let (mut errors, mut sizes, mut delta_k) = ([0.0_f64; 2], [0.0_f64; 2], 0.0_f64);
        for (gamma, state) in output.gamma(8.0).zip(states.iter()) {
            let exact = reference.at(gamma);
            let off = [state.q[0] - exact.q[0], state.q[1] - exact.q[1]];
            errors = [errors[0].max(off[0].abs()), errors[1].max(off[1].abs())];
            sizes = [sizes[0].max(exact.q[0].abs()), sizes[1].max(exact.q[1].abs())];
            delta_k = delta_k.max((q_t * q_t / g00(&geometry, state.q[1]) - state.p[1] * state.p[1] - k).abs());
        }
        let found = row.errors.as_ref().unwrap();
        for (found, wanted) in found.q.iter().zip(errors).chain([(&found.delta_k, delta_k)]) {
            assert!((found - wanted).abs() < 1e-6 * wanted + 1e-11, "{}: {found} for {wanted}", row.setting);
        }
        let is_good = errors[0] <= 0.1 * sizes[0] && errors[1] <= 0.1 * sizes[1];
        assert_eq!(row.status == RowStatus::Converged, is_good, "{}: {errors:?} of {sizes:?}", row.setting);
        large |= is_good && errors[0] > 0.1 / sizes[0];
    }
    assert!(large, "an error counts relative to the size");
}

#[test]
fn a_method_is_drawn_on_its_own_curve() {
    for peer in PEERS {
        let family = Method::Peer(peer);
        assert_eq!(family.curve().1, peer.about().curve, "{peer:?}");
        assert!(!family.is_own() && !family.is_certified());
    }
    assert!(Method::March(8).is_own() && !Method::March(8).is_certified());
    for certified in [Method::Block(SbpName::Sbp21, Form::Weak), Method::Elements(8), Method::Accuracy] {
        assert!(certified.is_own() && certified.is_certified(), "{}", certified.name());
    }
}

#[test]
fn times_are_those_of_single_runs_in_all_rounds() {
    let arena = Arena::new(&case("grid.gamma_f=1.0"), None).unwrap();
    let budget = Budget { rounds: 5, settings: 4, ..BUDGET };
    let (start, mut rounds) = (Instant::now(), Vec::new());
    let families = [Method::Peer(Peer::Rk4), Method::Peer(Peer::Verlet)];
    let rows = measure(&arena, &families, &budget, &mut |progress| {
        if let Progress::Round(done, all) = progress {
            rounds.push((done, all));
        }
    })
    .rows;
    // Every row has been run once at least, and runs that take the same time five times are none.
    let sum: f64 = rows.iter().map(|row| row.seconds_min).sum();
    assert!(sum > 0.0 && sum < start.elapsed().as_secs_f64(), "{rows:?}");
    assert!(rows.iter().any(|row| row.seconds_min < row.seconds_median), "{rows:?}");
    assert_eq!(rounds, [(1, 5), (2, 5), (3, 5), (4, 5), (5, 5)]);
}

/// However often a short run is repeated, its time is that of one: many fit into what all of them take.
#[test]
fn the_time_of_a_setting_is_that_of_one_run() {
    let arena = Arena::new(&case("grid.gamma_f=1.0"), None).unwrap();
    let budget = Budget { longest: 0.1, rounds: 201, settings: 2 };
    let start = Instant::now();
    let rows = rows_of(&arena, &[Method::Peer(PEERS[0])], &budget);
    let all = start.elapsed().as_secs_f64();
    let sum: f64 = rows.iter().map(|row| row.seconds_median).sum();
    assert!(rows.len() == 2 && sum > 0.0 && 3.0 * budget.rounds as f64 * sum < all, "{sum} of {all}");
}

/// A circular orbit with r = 4 and dφ/dγ = 1/16 from t = 100 and φ = 1000 on.
fn orbit() -> Arena {
    let text = r#"
        metric.coordinates = ["t", "r", "phi"]
        metric.components = { "t t" = "9 - 0.5/r", "r r" = "-1", "phi phi" = "-r^2" }
        initial = { t = 100.0, t_dot = 1.0, r = 4.0, phi = 1000.0, r_dot = 0.0, phi_dot = 0.0625 }
        grid = { gamma_f = 8.0, n_gamma = 33 }
        scheme.sbp = "SBP42"
    "#;
    Arena::new(&parsed(text, &[]), None).unwrap()
}

/// Ignorable coordinates count from the start, and active ones from zero.
#[test]
fn sizes_of_scenes() {
    let arena = orbit();
    for (name, size) in [("t", 8.0), ("r", 4.0), ("phi", 0.5)] {
        let a = arena.coordinates().iter().position(|other| other == name).unwrap();
        assert!((arena.sizes[a] - size).abs() < 1e-12, "{name}: {}", arena.sizes[a]);
    }
}

#[test]
fn a_result_is_near_in_all_coordinates_and_has_a_finite_k() {
    let arena = orbit();
    let sizes = &arena.sizes;
    let status = |a: usize, share: f64, delta_k: f64| {
        let mut q = vec![0.0; sizes.len()];
        q[a] = share * sizes[a];
        arena.judge(&RowErrors { q, delta_k })
    };
    for a in 0..sizes.len() {
        assert_eq!(status(a, 0.09, 1e9), RowStatus::Converged);
        assert_eq!([status(a, 0.11, 0.0), status(a, f64::NAN, 0.0)], [RowStatus::Inaccurate; 2]);
        assert_eq!([f64::NAN, f64::INFINITY].map(|k| status(a, 0.0, k)), [RowStatus::Inaccurate; 2]);
    }
}

/// A scheme on a grid is timed, and not the run to the accuracy of the case.
#[test]
fn an_accuracy_of_the_case_does_not_take_the_place_of_the_grids() {
    let arena = Arena::new(&shipped("kepler-polar", &[]), Some(1.0)).unwrap();
    let budget = Budget { settings: 4, ..BUDGET };
    let families = [Method::Block(SbpName::Sbp42, Form::Weak)];
    let rows = rows_of(&arena, &families, &budget);
    let errors: Vec<f64> = rows.iter().filter_map(|row| row.rank()).collect();
    assert!(errors.len() >= 3 && errors.windows(2).all(|pair| pair[1] < 0.3 * pair[0]), "{errors:?}");
    let mut converged = rows.iter().filter(|row| row.status == RowStatus::Converged);
    assert!(converged.all(|row| row.setting == format!("N={}", row.points)), "{rows:?}");
}

#[test]
fn a_row_of_this_program_is_that_of_its_solve() {
    let length = 30.0;
    let base = shipped("henon-heiles", &["grid={gamma_f=30.0,n_gamma=101}", "scheme={sbp='SBP42',form='weak'}"]);
    let arena = Arena::new(&base, Some(length)).unwrap();
    let reference = reference(&base.geometry(), &base.start(), length);
    assert!(arena.reference_error() < 1e-16 && arena.reference_error() > 0.0, "{:e}", arena.reference_error());
    let families = [
        Method::Block(SbpName::Sbp42, Form::Strong),
        Method::Block(SbpName::Sbp42, Form::Weak),
        Method::Elements(8),
        Method::Accuracy,
    ];
    let budget = Budget { settings: 6, ..BUDGET };
    let rows = rows_of(&arena, &families, &budget);
    let mut compared = BTreeSet::new();
    for row in rows.iter().filter(|row| row.status == RowStatus::Converged) {
        let value = |key: &str| row.setting.strip_prefix(key).unwrap();
        let grid =
            |nodes: &str, windows: &str| format!("grid={{gamma_f={length:?},n_gamma={nodes},windows={windows}}}");
        let settings = match &row.method {
            Method::Block(sbp, form) => {
                vec![grid(value("N="), "1"), format!("scheme={{sbp='{sbp}',form='{}'}}", form.as_str())]
            }
            Method::Elements(_) => vec![grid("8", value("windows=")), "scheme={sbp='GLL8',form='weak'}".to_owned()],
            _ => vec![
                "grid={gamma_f=30.0}".to_owned(),
                "scheme={}".to_owned(),
                format!("solver.accuracy={}", value("tol=")),
            ],
        };
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        // Methods are compared from the doubles of the start.
        let setup = Setup { dropped: Handed::default(), ..shipped("henon-heiles", &settings).setup() };
        let line: WorldLine = solve(&setup).unwrap();
        let windows = line.windows.len();
        // An iteration of a run to an accuracy is one of a window, and evaluates all of its nodes.
        assert_eq!(row.evaluations, line.iterations.count.max(windows) * line.sbp().points(), "{row:?}");
        assert_eq!(row.points, line.nodes(), "{row:?}");
        compared.insert(families.iter().position(|family| *family == row.method));
        if row.method == Method::Accuracy {
            assert!(windows > 1);
            assert!(row.rank() < Some(value("tol=").parse::<f64>().unwrap() * 30.0), "{row:?}");
            continue;
        }
        let q: Vec<Vec<f64>> = (0..4).map(|a| line.q(a).collect()).collect();
        let mut largest = [0.0_f64; 4];
        for mark in 1..=10 {
            let exact = reference.at(length * mark as f64 / 10.0);
            let here: Vec<f64> = match windows {
                1 => q.iter().map(|row| row[(line.nodes() - 1) / 10 * mark]).collect(),
                _ => line.joint(windows / 10 * mark).q.to_vec(),
            };
            largest = std::array::from_fn(|a| largest[a].max((here[a] - exact.q[a]).abs()));
        }
        for (found, wanted) in row.errors.as_ref().unwrap().q.iter().zip(largest) {
            assert!((found - wanted).abs() < 1e-6 * wanted + 1e-9, "{row:?}: {found} for {wanted}");
        }
    }
    assert!(compared.len() == families.len(), "{compared:?} of {}", rows.len());
}
