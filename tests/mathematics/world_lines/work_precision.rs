//! The chart of speed against accuracy of scenes: what its rows say. No time is judged here.

use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;

use geodesic_ivp::Case;
use geodesic_ivp::action::Form;
use geodesic_ivp::case::builtin;
use geodesic_ivp::methods::{Composition, Step};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::{Setup, WorldLine, solve};
use geodesic_ivp::study::work_precision::{Arena, Budget, Family, RowStatus, measure};

/// By settings and not by time, so that a slow machine measures the same.
const BUDGET: Budget = Budget { longest: f64::INFINITY, rounds: 1, settings: 12 };

fn scene(name: &str, overrides: &[&str]) -> Case {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    Case::parse(name, builtin::text(name).unwrap(), &overrides).unwrap()
}

#[test]
#[ignore = "long: all methods run in two scenes at all their settings"]
fn every_method_arrives_and_errors_are_those_of_every_coordinate() {
    for (name, length) in [("henon-heiles", 5.0), ("kerr-inclined", 60.0)] {
        let case = scene(name, &[]);
        let arena = Arena::new(&case, Some(length)).unwrap();
        assert!(arena.length() == length && arena.reference_error() < 1e-18, "{}", arena.reference_error());
        assert_eq!(arena.coordinates(), case.coordinates());
        let separable = case.geometry::<f64>().is_separable();
        let mut families = Family::all();
        families.retain(|family| family.unsuitable(separable).is_none());
        assert_eq!(families.contains(&Family::Peer(&Composition::VERLET)), separable, "{name}");
        let measured = measure(&arena, &families, &BUDGET, &AtomicBool::new(false), &mut |_| {});
        for family in &families {
            let rows: Vec<_> = measured.rows.iter().filter(|row| row.family == *family).collect();
            let best = rows.iter().filter_map(|row| row.rank()).fold(f64::INFINITY, f64::min);
            let bound = match family {
                Family::Block(SbpName::Sbp21, _) => 3e-1,
                Family::Block(SbpName::Sbp42, _) => 1e-2,
                Family::Block(..) => 1e-2,
                Family::Elements(4) => 1e-3,
                Family::Elements(6) => 1e-6,
                Family::Peer(peer) => match (peer.about().order, peer.about().step) {
                    (Some(2), _) => 1e-1,
                    (Some(4), _) => 1e-3,
                    (Some(5), Step::Adaptive) => 1e-2,
                    _ => 1e-6,
                },
                _ => 1e-8,
            };
            assert!(best < bound, "{name} {}: {best} in {} settings", family.name(), rows.len());
            for row in rows.iter().filter(|row| row.status == RowStatus::Converged) {
                let errors = row.errors.as_ref().unwrap();
                assert_eq!(errors.q.len(), case.coordinates().len());
                assert_eq!(row.rank(), Some(errors.q.iter().copied().fold(0.0, f64::max)));
                assert!(
                    errors.delta_k < 1e3 * errors.largest() + 1e-9,
                    "{} {}: {errors:?}",
                    row.setting,
                    family.name()
                );
                assert!(row.evaluations > 0 && row.points > 0);
            }
        }
    }
}

/// A scheme on a grid is timed, and not the run to the accuracy of the case.
#[test]
fn an_accuracy_of_the_case_does_not_take_the_place_of_the_grids() {
    let arena = Arena::new(&scene("kepler-polar", &[]), Some(1.0)).unwrap();
    let budget = Budget { settings: 4, ..BUDGET };
    let families = [Family::Block(SbpName::Sbp42, Form::Weak)];
    let rows = measure(&arena, &families, &budget, &AtomicBool::new(false), &mut |_| {}).rows;
    let errors: Vec<f64> = rows.iter().filter_map(|row| row.rank()).collect();
    assert!(errors.len() >= 3 && errors.windows(2).all(|pair| pair[1] < 0.3 * pair[0]), "{errors:?}");
    let mut converged = rows.iter().filter(|row| row.status == RowStatus::Converged);
    assert!(converged.all(|row| row.setting == format!("N={}", row.points)), "{rows:?}");
}

#[test]
fn a_scene_is_charted_at_its_length() {
    let case = scene("henon-heiles", &["grid.gamma_f=20.0", "grid.until=\"x\"", "grid.windows=1"]);
    let arena = Arena::new(&case, None).unwrap();
    assert!((0.1..20.0).contains(&arena.length()), "{}", arena.length());
    let own = [Family::Block(SbpName::Sbp42, Form::Weak), Family::Elements(16)];
    let measured = measure(&arena, &own, &BUDGET, &AtomicBool::new(false), &mut |_| {});
    assert!(own.iter().all(|family| measured.rows.iter().any(|row| row.family == *family && row.rank() < Some(1e-3))));
}

#[test]
fn a_row_of_this_program_is_that_of_its_solve() {
    let length = 30.0;
    let base = scene("henon-heiles", &["grid={gamma_f=30.0,n_gamma=101}", "scheme={sbp='SBP42',form='weak'}"]);
    let arena = Arena::new(&base, Some(length)).unwrap();
    let setup: Setup = base.setup();
    let reference = ReferenceTrajectory::new(&*setup.place.geometry, &setup.place.start, length, 16).unwrap();
    assert!(arena.reference_error() < 1e-16 && arena.reference_error() > 0.0, "{:e}", arena.reference_error());
    let families = [
        Family::Block(SbpName::Sbp42, Form::Strong),
        Family::Block(SbpName::Sbp42, Form::Weak),
        Family::Elements(8),
        Family::Accuracy,
    ];
    let budget = Budget { settings: 6, ..BUDGET };
    let rows = measure(&arena, &families, &budget, &AtomicBool::new(false), &mut |_| {}).rows;
    let mut compared = BTreeSet::new();
    for row in rows.iter().filter(|row| row.status == RowStatus::Converged) {
        let value = |key: &str| row.setting.strip_prefix(key).unwrap();
        let grid =
            |nodes: &str, windows: &str| format!("grid={{gamma_f={length:?},n_gamma={nodes},windows={windows}}}");
        let settings = match &row.family {
            Family::Block(sbp, form) => {
                vec![grid(value("N="), "1"), format!("scheme={{sbp='{sbp}',form='{}'}}", form.as_str())]
            }
            Family::Elements(_) => vec![grid("8", value("windows=")), "scheme={sbp='GLL8',form='weak'}".to_owned()],
            _ => vec![
                "grid={gamma_f=30.0}".to_owned(),
                "scheme={}".to_owned(),
                format!("solver.accuracy={}", value("tol=")),
            ],
        };
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let line: WorldLine = solve(scene("henon-heiles", &settings).setup()).unwrap();
        let windows = line.windows.len();
        // An iteration of a run to an accuracy is one of a window, and evaluates all of its nodes.
        assert_eq!(row.evaluations, line.iterations.count.max(windows) * line.sbp().points(), "{row:?}");
        assert_eq!(row.points, line.nodes(), "{row:?}");
        compared.insert(families.iter().position(|family| *family == row.family));
        if row.family == Family::Accuracy {
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
