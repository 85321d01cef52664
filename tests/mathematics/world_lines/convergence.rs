//! Sweeps of scenes: the errors of every coordinate fall at the order of the scheme.

use std::sync::atomic::AtomicBool;

use geodesic_ivp::Case;
use geodesic_ivp::action::Form;
use geodesic_ivp::case::builtin;
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::study::convergence::{Convergence, ConvergencePoint, Quantity, Sweep, SweepError};

fn scene(name: &str, overrides: &[&str]) -> Case {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    Case::parse(name, builtin::text(name).unwrap(), &overrides).unwrap()
}

fn swept(case: &Case, sbp: SbpName, form: Form, n_gamma: &[usize]) -> Convergence {
    Sweep::new(case, &[(sbp, form)], n_gamma).unwrap().run(&AtomicBool::new(false), &|_, _| {})
}

#[test]
fn errors_of_every_coordinate_have_the_order_of_the_scheme() {
    let kerr = scene("kerr-inclined", &["grid.gamma_f=60.0", "grid.windows=1"]);
    let henon = scene("henon-heiles", &["grid.gamma_f=4.0", "grid.windows=1"]);
    for case in [kerr, henon] {
        for (sbp, form, at_end, l2, n_gamma) in [
            (SbpName::Sbp21, Form::Strong, 2.0, 2.0, [128, 256, 512]),
            (SbpName::Sbp42, Form::Strong, 3.0, 3.0, [256, 512, 1024]),
            (SbpName::Sbp42, Form::Weak, 4.0, 3.0, [128, 256, 512]),
        ] {
            let convergence = swept(&case, sbp, form, &n_gamma);
            assert_eq!(convergence.coordinates, case.coordinates());
            let slopes = convergence.slopes((0, usize::MAX));
            assert_eq!(slopes.len(), 2 * case.coordinates().len());
            for slope in slopes {
                let a = slope.quantity.coordinate().unwrap();
                let Some(fit) = &slope.fit else {
                    // With Newton's law t is γ, exactly.
                    assert_eq!(case.coordinates()[a], "t", "{slope:?}");
                    assert!(case.is_lifted());
                    continue;
                };
                let order = if slope.quantity.is_at_end() { at_end } else { l2 };
                assert!(fit.slope > order - 0.3, "{} {sbp} {form:?}: {fit:?}", slope.name);
            }
            for point in &convergence.points {
                let errors = point.errors.as_ref().unwrap();
                assert_eq!(errors.charges_last.len(), convergence.charges.len());
                let largest = errors.charges_last.iter().copied().fold(0.0, f64::max);
                assert_eq!(largest < 1e-10, form == Form::Weak, "{sbp} {form:?}: {largest}");
            }
        }
    }
}

#[test]
fn the_largest_error_is_the_largest_of_the_coordinates() {
    let case = scene("henon-heiles", &["grid.gamma_f=4.0", "grid.windows=1"]);
    let convergence = swept(&case, SbpName::Sbp21, Form::Strong, &[64]);
    let errors = convergence.points[0].errors.as_ref().unwrap();
    let all = Quantity::all(case.coordinates().len());
    for (largest, at_end) in [(Quantity::LARGEST_FINAL, true), (Quantity::LARGEST_L2, false)] {
        let of = all.iter().filter(|quantity| quantity.is_at_end() == at_end).map(|quantity| quantity.of(errors));
        assert_eq!(largest.of(errors), of.fold(0.0, f64::max));
    }
}

#[test]
fn a_sweep_ends_where_the_run_ends() {
    let until = scene("henon-heiles", &["grid.gamma_f=20.0", "grid.until=\"x\"", "grid.windows=1"]);
    let convergence = swept(&until, SbpName::Gll(16), Form::Weak, &[200]);
    let x = until.coordinates().iter().position(|name| name == "x").unwrap();
    assert!(convergence.reference.end[x].abs() < 1e-12, "{:?}", convergence.reference);
    assert!(convergence.reference.gamma_final < 20.0);
    assert!(convergence.points[0].errors.as_ref().unwrap().at_end[x] < 1e-12);
    let timed = scene("kerr-inclined", &["grid={t_f=50.0}"]);
    let convergence = swept(&timed, SbpName::Gll(16), Form::Weak, &[200]);
    assert!((convergence.reference.end[0] - 50.0).abs() < 1e-12, "{:?}", convergence.reference);
}

/// The grids are swept, and not the run to the accuracy.
#[test]
fn an_accuracy_of_the_case_does_not_take_the_place_of_the_grids() {
    let n_gamma = [64, 128];
    let [with, without] = ["solver.accuracy=1e-9", "grid.windows=1"].map(|key| {
        let case = scene("henon-heiles", &["grid.gamma_f=4.0", key]);
        swept(&case, SbpName::Sbp42, Form::Weak, &n_gamma).points
    });
    let errors = |points: &[ConvergencePoint]| points.iter().map(|point| point.errors.clone()).collect::<Vec<_>>();
    assert!(with.iter().all(|point| point.errors.is_some()));
    assert_eq!(errors(&with), errors(&without));
    assert_eq!(with.iter().map(|point| point.n_gamma).collect::<Vec<_>>(), n_gamma);
}

#[test]
fn what_cannot_be_swept_is_refused() {
    let case = scene("henon-heiles", &[]);
    let refused = |sbp, n: usize| Sweep::<f64>::new(&case, &[(sbp, Form::Weak)], &[n]).err();
    assert!(matches!(refused(SbpName::Sbp42, 7), Some(SweepError::Grid(message)) if message.contains("at least 8")));
    assert!(matches!(refused(SbpName::Sbp42, usize::MAX / 2), Some(SweepError::Grid(_))));
}

#[test]
fn errors_count_against_the_motion_from_its_own_start() {
    // x = 2 cos(γ − 1.5) over a quarter of its period, and t = 5 + 3 (γ − 1.5).
    let text = r#"
        potential = { coordinates = ["x"], formula = "9*x^2/2" }
        particle.law = "newtonian"
        initial = { t = 5.0, t_dot = 3.0, x = 0.0, x_dot = 6.0 }
        grid = { gamma_i = 1.5, gamma_f = "1.5 + pi/18", n_gamma = 33 }
        scheme.sbp = "SBP21"
    "#;
    let case = Case::parse("test", text, &[]).unwrap();
    let convergence = swept(&case, SbpName::Sbp21, Form::Strong, &[33]);
    let place = |name: &str| convergence.coordinates.iter().position(|other| other == name).unwrap();
    let (reference, point) = (&convergence.reference, &convergence.points[0]);
    let length = std::f64::consts::PI / 18.0;
    assert!((reference.gamma_final - 1.5 - length).abs() < 1e-14, "{reference:?}");
    assert!((reference.end[place("t")] - 5.0 - 3.0 * length).abs() < 1e-13, "{reference:?}");
    println!("{:?} {:?}", convergence.coordinates, reference);
    assert!((reference.sizes[place("t")] - 3.0 * length).abs() < 1e-13, "{reference:?}");
    assert!((reference.sizes[place("x")] - 2.0 / 3.0).abs() < 1e-13, "{reference:?}");
    assert!((point.delta_gamma - length / 32.0).abs() < 1e-15 && point.n_gamma == 33, "{point:?}");
}
