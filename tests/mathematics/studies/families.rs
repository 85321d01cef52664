//! Families of what a search finds: on closed forms, around folds, and to where they end; and searches from several
//! starts.

use std::f64::consts::PI;

use geodesic_ivp::Case;
use geodesic_ivp::study::find::{Ended, Family, find, find_each, follow, solutions};
use geodesic_ivp::study::many::ManyRuns;

use crate::common::{parsed, shipped};

fn followed(name: &str, unknowns: &str, from: &str, to: f64) -> Family {
    let case = shipped(name, &[&format!("find.unknowns={unknowns}"), from]);
    follow(&case, case.find.as_ref().unwrap(), to, &mut |_| {}).unwrap_or_else(|none| panic!("{none}"))
}

/// λ = 8a²/cosh²a and ẋ = 4a tanh a: the curve turns back where ẋ = 4.
#[test]
fn brats_equation_is_followed_around_its_fold() {
    let unknowns = "[\"initial.x_dot\", \"parameters.lambda\"]";
    let family = followed("bratu", unknowns, "parameters.lambda=0.5", 4.0);
    assert_eq!(family.ended, Ended::Back);
    let of_a = |x_dot: f64| {
        let (mut low, mut high) = (0.0_f64, 20.0_f64);
        for _ in 0..200 {
            let a = 0.5 * (low + high);
            if 4.0 * a * a.tanh() < x_dot { low = a } else { high = a }
        }
        8.0 * low * low / low.cosh().powi(2)
    };
    for member in &family.members {
        let [x_dot, lambda] = member.values[..] else { panic!("{member:?}") };
        // dλ/dẋ is bounded on the curve.
        assert!((of_a(x_dot) - lambda).abs() <= 1e-9, "{x_dot} {lambda} {}", of_a(x_dot));
    }
    let folds: Vec<_> = family.members.iter().filter(|member| member.is_fold).collect();
    assert_eq!(folds.len(), 1);
    assert!((folds[0].values[1] - 3.513_830_719_125_161).abs() < 1e-11, "{:?}", folds[0]);
    let (off, error) = ((folds[0].values[0] - 4.0).abs(), folds[0].errors[0]);
    assert!(off <= error && error < 1e-5, "{off:e} of {error:e}");
    let last = &family.members[family.members.len() - 1];
    assert!(last.values[1] == 0.5 && last.values[0] > 4.0, "{last:?}");
}

/// However rough runs are, the fold is seen, and the way back ends where it began.
#[test]
fn a_fold_of_rough_runs_is_not_missed() {
    let case = ["find.unknowns=[\"initial.x_dot\", \"parameters.lambda\"]", "parameters.lambda=2.5"];
    for accuracy in ["solver.accuracy=1e-9", "solver.accuracy=1e-7"] {
        let case = shipped("bratu", &[&case[..], &[accuracy]].concat());
        let family = follow(&case, case.find.as_ref().unwrap(), 4.0, &mut |_| {}).unwrap();
        assert_eq!(family.ended, Ended::Back, "{accuracy}");
        assert!(family.members.len() < 300, "{}", family.members.len());
    }
}

/// Orbits that return keep doing so, and their multipliers come with them.
#[test]
fn lyapunov_orbits_are_followed() {
    let unknowns = "[\"initial.y_dot\", \"grid.t_f\", \"initial.x\"]";
    let family = followed("lyapunov-orbit", unknowns, "initial.x=0.8234", 0.81);
    assert_eq!(family.ended, Ended::AtEnd);
    let last = &family.members[family.members.len() - 1];
    assert_eq!(last.values[2], 0.81);
    for member in &family.members {
        assert!(member.residual < 1e-10, "{member:?}");
        assert!(member.multipliers.as_ref().unwrap().values[0].re > 500.0, "{member:?}");
    }
    // Larger orbits take longer.
    assert!(family.members.windows(2).all(|pair| pair[0].values[1] < pair[1].values[1]));
}

#[test]
fn searches_from_several_starts_say_which_solutions_are_the_same() {
    let text = r#"
        potential = { coordinates = ["x"], formula = "0" }
        particle.law = "newtonian"
        initial = { x = 0.0, x_dot = 1.0 }
        grid.t_f = 1.0
        solver.accuracy = 1e-12
        find = { unknowns = ["initial.x_dot"], meet = ["x^2 - 4"] }
    "#;
    let axis = "initial.x_dot=-3:3:7".parse().unwrap();
    let starts = ManyRuns::new("starts", text, &[], vec![axis]).unwrap();
    let searches = find_each(&starts, &|| {});
    let found: Vec<Option<usize>> = solutions(&searches);
    assert_eq!(found, [Some(1), Some(1), Some(1), None, Some(2), Some(2), Some(2)]);
    assert!(searches[3].found().is_none(), "nothing depends on it at 0");
    assert!((searches[6].found().unwrap().values[0] - 2.0).abs() < 1e-12);
    assert!(parsed(text, &[]).find.is_some());
}

/// The long way round passes the place opposite to its start, where all great circles from there meet again.
#[test]
fn the_long_way_round_a_sphere_passes_a_conjugate_point() {
    let short = shipped("great-circle", &[]);
    let round = "find.meet=[\"latitude - 35.68*degree\", \"longitude - 139.69*degree + 2*pi\"]";
    let long = shipped("great-circle", &["parameters.north=3.7", "grid.gamma_f=4.7", round]);
    let geodesic = |case: &Case| {
        let found = find(case, case.find.as_ref().unwrap(), false, &mut |_| {}).unwrap_or_else(|none| panic!("{none}"));
        found.geodesic.unwrap()
    };
    let (short, long) = (geodesic(&short), geodesic(&long));
    assert_eq!(short.conjugate, Some(Vec::new()));
    assert!((short.length + long.length - 2.0 * PI).abs() < 1e-12, "{short:?} {long:?}");
    let conjugate = long.conjugate.unwrap();
    assert!(conjugate.len() == 1 && (conjugate[0] - PI).abs() < 1e-6, "{conjugate:?}");
}
