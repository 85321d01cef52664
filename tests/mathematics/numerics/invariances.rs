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
    for scheme in SCHEMES {
        let solution = solved(&format!("potential={{free={{}}}} {scheme}"));
        let diagnostics = Diagnostics::new(&solution);
        let free = diagnostics.of_x.unwrap().free_particle.expect("V = 0");
        assert!(diagnostics.charges[0].delta.iter().all(|d| d.abs() < 1e-13), "{scheme}: also at the last node");
        assert!(free.max_abs_delta_q_x < 1e-13, "{scheme}: {free:?}");
        assert!(free.max_abs_delta_q_eta < 1e-13, "{scheme}: {free:?}");
    }
    assert!(Diagnostics::new(&solved("")).of_x.unwrap().free_particle.is_none());
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

#[test]
fn velocity_is_another_way_to_give_x_dot() {
    let by_tangent = solved("initial.t_dot=4.0 initial.x_dot=0.4");
    let by_velocity = solved("initial={t=0.0,x=1.0,t_dot=4.0,velocity=0.1}");
    assert_eq!(by_tangent.x(), by_velocity.x());
}

#[test]
fn only_v_over_m_c_squared_matters() {
    // g00 = c² + 2V/m: doubling V and m changes nothing; x → x, t → t/c, V → c²V rescales time.
    let unit = solved("");
    let heavy = solved("potential.quartic.kappa=1.0 particle.mass=2.0");
    assert!(distance(unit.x(), heavy.x()) < 1e-14);
    let fast = solved("potential.quartic.kappa=4.5 particle.c=3.0 initial.t_dot=0.3333333333333333");
    assert!(distance(unit.x(), fast.x()) < 1e-13);
    let scaled: Vec<f64> = fast.elapsed().iter().map(|t| 3.0 * t).collect();
    assert!(distance(unit.elapsed(), &scaled) < 1e-13);
}

#[test]
fn a_run_can_end_at_a_physical_time() {
    for scheme in SCHEMES {
        let solution = solved(&format!("grid={{t_f=5.0,n_gamma=128}} initial.t=0.5 {scheme}"));
        assert!((solution.end_state().t - 5.0).abs() < 1e-11, "{scheme}: {}", solution.end_state().t);
        let by_gamma = format!("grid={{gamma_f={:?},n_gamma=128}} initial.t=0.5 {scheme}", solution.gamma_f());
        assert!((solved(&by_gamma).end_state().x - solution.end_state().x).abs() < 1e-10, "{scheme}");
    }
}

#[test]
fn tiny_units_of_length_are_as_good_as_any() {
    // x -> s x, V -> s² V(x/s) and c -> s c leave the motion as it is: no tolerance may be absolute.
    for scheme in SCHEMES {
        let unit = solved(&format!(
            "grid.n_gamma=64 potential={{formula={{expression=\"1-cos(x)\"}}}} particle.c=10.0 {scheme}"
        ));
        let s = 2.0_f64.powi(-30);
        let small = solved(&format!(
            "grid.n_gamma=64 potential={{formula={{expression=\"s^2*(1-cos(x/s))\",parameters={{s={s:?}}}}}}} \
             particle.c={:?} initial.x={s:?} initial.x_dot={:?} {scheme}",
            10.0 * s,
            0.1 * s
        ));
        let back: Vec<f64> = small.x().iter().map(|x| x / s).collect();
        assert!(distance(unit.x(), &back) < 1e-12, "{scheme}: {}", distance(unit.x(), &back));
        assert!(distance(unit.elapsed(), small.elapsed()) < 1e-12, "{scheme}");
    }
}

#[test]
fn a_physical_time_is_reached_wherever_gamma_starts() {
    for gamma_i in ["0.0", "1e6", "1e8"] {
        let solution = solved(&format!("grid={{t_f=5.0,n_gamma=128,gamma_i={gamma_i}}}"));
        assert!((solution.end_state().t - 5.0).abs() < 1e-12, "gamma_i = {gamma_i}: {}", solution.end_state().t);
    }
}
