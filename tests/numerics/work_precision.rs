//! The chart of speed against accuracy: what its rows say. No time is judged here.

use std::sync::atomic::AtomicBool;

use geodesic_ivp::case::SbpName;
use geodesic_ivp::methods::{Composition, Gauss, Rk4};
use geodesic_ivp::study::work_precision::{Arena, Budget, Family, RowStatus, drift, measure};

use super::common::case;

/// By settings and not by time, so that a slow machine measures the same.
const BUDGET: Budget = Budget { longest: f64::INFINITY, rounds: 1, settings: 12 };

#[test]
fn every_method_arrives_and_errors_are_those_of_the_method() {
    let arena = Arena::new(&case("grid.gamma_f=4.0"), None).unwrap();
    assert!(arena.length() == 4.0 && arena.reference_error() < 1e-18);
    let families = Family::all();
    let measured = measure(&arena, &families, &BUDGET, &AtomicBool::new(false), &mut |_| {});
    assert!(!measured.interrupted);
    for family in &families {
        let rows: Vec<_> = measured.rows.iter().filter(|row| row.family == *family).collect();
        let best = rows.iter().filter_map(|row| row.rank()).fold(f64::INFINITY, f64::min);
        let bound = match family {
            Family::Block(SbpName::Sbp21, _) => 1e-2,
            Family::Block(SbpName::Sbp42, _) => 1e-3,
            Family::Block(..) => 1e-4,
            Family::March(4) => 1e-5,
            Family::Peer(peer) => match peer.about().order {
                Some(2) => 1e-2,
                Some(5) => 1e-3,
                Some(4) => 1e-5,
                _ if peer.name() == "Gauss 4" => 1e-8,
                _ => 1e-10,
            },
            _ => 1e-10,
        };
        assert!(best < bound, "{}: {best} in {} settings", family.name(), rows.len());
        for row in rows.iter().filter(|row| row.status == RowStatus::Converged) {
            let errors = row.errors.as_ref().unwrap();
            // K depends on x and w, which are as accurate as x; a node of the strong form is less so.
            assert!(errors.delta_k < 1e3 * errors.largest() + 1e-9, "{} {}: {errors:?}", family.name(), row.setting);
            assert!(row.evaluations > 0 && row.points > 0 && row.seconds_min <= row.seconds_median);
        }
    }
}

#[test]
fn what_fails_has_its_status_and_no_rank() {
    let arena = Arena::new(&case("grid.gamma_f=300.0"), None).unwrap();
    let families = [Family::Peer(&Gauss { stages: 2 }), Family::Peer(&Rk4)];
    let measured = measure(&arena, &families, &BUDGET, &AtomicBool::new(false), &mut |_| {});
    let statuses: Vec<&str> = measured.rows.iter().map(|row| row.status.as_str()).collect();
    for status in ["converged", "inaccurate", "not-converged"] {
        assert!(statuses.contains(&status), "{status}: {statuses:?}");
    }
    for row in &measured.rows {
        assert_eq!(row.rank().is_some(), row.status == RowStatus::Converged, "{row:?}");
    }
}

#[test]
fn a_case_that_ends_at_a_time_is_charted_at_its_length() {
    let arena = Arena::new(&case("grid={t_f=3.0,n_gamma=32}"), None).unwrap();
    assert!((arena.length() - 2.0).abs() < 0.5, "{}", arena.length());
    let cancelled = measure(&arena, &[Family::Peer(&Rk4)], &BUDGET, &AtomicBool::new(true), &mut |_| {});
    assert!(cancelled.interrupted && cancelled.rows.is_empty());
}

#[test]
fn along_a_run_runge_kutta_drifts_and_windows_do_not() {
    let arena = Arena::new(&case("grid.gamma_f=100.0"), None).unwrap();
    let families = [Family::Peer(&Rk4), Family::Peer(&Composition::VERLET), Family::March(16)];
    let points = drift(&arena, &families, &AtomicBool::new(false));
    let growth = |family: &Family| {
        let of = |from: f64, to: f64| {
            let part = points.iter().filter(|p| p.family == *family && (from..to).contains(&p.gamma));
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
    let windows = points.iter().filter(|point| point.family == families[2]);
    assert!(windows.map(|point| point.errors.delta_k).fold(0.0, f64::max) < 1e-13);
}
