//! Symmetries of the continuum that the discretisation keeps.

use crate::common::{distance, solved};
use geodesic_ivp::diagnostics::Diagnostics;

const SCHEMES: [&str; 8] = [
    "scheme.sbp=SBP21",
    "scheme.sbp=SBP42",
    "scheme.sbp=SBP21 solver.system=doubled",
    "scheme.sbp=SBP42 solver.system=doubled",
    "scheme={sbp=\"SBP21\",form=\"weak\"}",
    "scheme={sbp=\"SBP42\",form=\"weak\"}",
    "scheme={sbp=\"SBP21\",form=\"weak\"} solver.system=doubled",
    "scheme={sbp=\"SBP42\",form=\"weak\"} solver.system=doubled",
];

#[test]
fn the_free_particle_conserves_all_three_charges() {
    let starts = ["initial={t=7.0,x=2.0,t_dot=3.0,x_dot=-0.5}", "initial={t=0.0,x=-0.3,t_dot=0.2,x_dot=5.0}"];
    for overrides in SCHEMES.into_iter().chain(starts) {
        let diagnostics = Diagnostics::new(&solved(&format!("potential={{free={{}}}} {overrides}")));
        let free = diagnostics.of_x.unwrap().free_particle.expect("V = 0");
        let also_at_the_last_node = diagnostics.charges[0].delta.iter().all(|d| d.abs() < 1e-13);
        assert!(also_at_the_last_node || overrides.starts_with("initial"), "{overrides}");
        assert!(free[0].max(free[1]) < 1e-13, "{overrides}: {free:?}");
    }
    for other in ["[0.5]", "[1.0,0.5]", "[0,0,0.5]", "[0,0,0,0,0.5]"] {
        let found =
            Diagnostics::new(&solved(&format!("potential={{polynomial={{coefficients={other}}}}}"))).of_x.unwrap();
        assert!(found.free_particle.is_none(), "{other}");
    }
}

#[test]
fn a_shift_of_the_initial_time_shifts_t_and_no_other_digit() {
    for scheme in SCHEMES {
        let here = solved(scheme);
        let later = solved(&format!("initial.t=1000000.0 {scheme}"));
        assert_eq!(here.x(), later.x(), "{scheme}");
        assert_eq!(here.elapsed(), later.elapsed(), "{scheme}");
        assert_eq!(here.multipliers(), later.multipliers(), "{scheme}");
        assert!(here.t().zip(later.t()).all(|(a, b)| (b - a - 1e6).abs() < 1e-9), "{scheme}");
        let (a, b) = (Diagnostics::new(&here), Diagnostics::new(&later));
        assert_eq!(a.charges[0].delta, b.charges[0].delta, "{scheme}");
    }
}

#[test]
fn a_shift_of_gamma_changes_gamma_only() {
    for scheme in SCHEMES {
        let here = solved(scheme);
        let there = solved(&format!("grid.gamma_i=-2.0 grid.gamma_f=-1.0 {scheme}"));
        assert_eq!(here.x(), there.x(), "{scheme}");
        assert_eq!(there.gamma().next(), Some(-2.0));
    }
}

#[test]
fn the_length_of_the_tangent_is_a_choice_of_gamma() {
    for scheme in SCHEMES {
        let unit = solved(scheme);
        for s in [2.0_f64, 0.3, 7.0] {
            let scaled = format!("initial.t_dot={s:?} initial.x_dot={:?} grid.gamma_f={:?} {scheme}", 0.1 * s, 1.0 / s);
            let scaled = solved(&scaled);
            assert!(distance(unit.x(), scaled.x()) < 1e-12, "{scheme}, s = {s}");
            assert!(distance(unit.elapsed(), scaled.elapsed()) < 1e-12, "{scheme}, s = {s}");
        }
    }
}
