//! Windows: every operator, form, system and precision, laid end to end.

use crate::common::{distance, g00, solved, solved_in};
use geodesic_ivp::Solution;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::trajectory::Sampler;

const OPERATORS: [(&str, usize); 6] =
    [("SBP21", 40), ("SBP42", 40), ("SBP63", 40), ("SBP84", 40), ("GLL8", 8), ("GLL16", 16)];

fn run(sbp: &str, n: usize, windows: usize, more: &str) -> String {
    format!("scheme.sbp={sbp} grid.n_gamma={n} grid.windows={windows} grid.gamma_f=5.0 {more}")
}

#[test]
fn every_combination_keeps_q_t_and_the_two_systems_agree() {
    for (sbp, n) in OPERATORS {
        for form in ["strong", "weak"] {
            let with = |system: &str| solved(&run(sbp, n, 10, &format!("scheme.form={form} solver.system={system}")));
            let (limit, doubled) = (with("physical-limit"), with("doubled"));
            // The doubled system of SBP84 is ill-conditioned on so short a window: a digit goes to that.
            let (zero_doubled, apart) = if sbp == "SBP84" { (1e-10, 1e-9) } else { (1e-12, 1e-10) };
            for (solution, zero) in [(&limit, 1e-12), (&doubled, zero_doubled)] {
                let diagnostics = Diagnostics::new(solution);
                let charge = &diagnostics.charges[0];
                assert!([charge.max_interior, charge.max_corrected, charge.max_ends].iter().all(|off| *off < zero));
                assert!(diagnostics.max_delta_g < 1e-8, "{sbp} {form}");
                assert!(solution.gradient_norm < 1e-10, "{sbp} {form}");
            }
            let (x, t) = (distance(limit.x(), doubled.x()), (limit.end_state().t - doubled.end_state().t).abs());
            assert!(x < apart && t < apart, "{sbp} {form}: the systems differ by {x:e} and {t:e}");
        }
    }
}

#[test]
fn a_window_continues_where_the_one_before_ends() {
    for form in ["strong", "weak"] {
        let whole = solved(&run("SBP42", 40, 2, &format!("scheme.form={form}")));
        let first = solved(&format!("scheme.sbp=SBP42 grid.n_gamma=40 grid.gamma_f=2.5 scheme.form={form}"));
        assert_eq!(&whole.x()[..40], first.x());
        let end = first.end_state();
        let t_dot = end.q_t / g00(first.geometry(), end.x);
        let second = solved(&format!(
            "scheme.sbp=SBP42 grid.n_gamma=40 grid.gamma_f=2.5 scheme.form={form} \
             initial={{t={:?},x={:?},t_dot={t_dot:?},x_dot={:?}}}",
            end.t, end.x, end.x_dot
        ));
        assert!(distance(&whole.x()[40..], second.x()) < 1e-13, "{form}");
        assert!((whole.end_state().t - second.end_state().t).abs() < 1e-13, "{form}");
    }
    // In the strong form (Dx)_N is not the velocity to continue with, and it would show.
    let solution = solved(&run("SBP42", 40, 2, ""));
    let diagnostics = Diagnostics::new(&solution);
    assert!((diagnostics.q_dot[1][39] + solution.joint(1).p[1]).abs() > 1e-5);
}

#[test]
fn times_add_up_over_many_windows() {
    let solution: Solution =
        solved("scheme.sbp=GLL4 grid.n_gamma=4 grid.windows=20000 scheme.form=weak potential={free={}}");
    assert_eq!(solution.windows.len(), 20_000);
    assert!((solution.end_state().t - 1.0).abs() < 4.0 * f64::EPSILON, "{:e}", solution.end_state().t - 1.0);
    assert!((solution.end_state().x - 1.1).abs() < 1e-12);
}

#[test]
fn rest_in_an_equilibrium_is_a_solution_everywhere() {
    for (sbp, n) in OPERATORS {
        for form in ["strong", "weak"] {
            let rest = format!("initial.x=0.0 initial.x_dot=0.0 {}", run(sbp, n, 2, &format!("scheme.form={form}")));
            let solution = solved(&rest);
            assert!(solution.x().iter().all(|&x| x == 0.0), "{sbp} {form}");
            assert!((solution.end_state().t - 5.0).abs() < 1e-13, "{sbp} {form}: {}", solution.end_state().t);
            let extended = solved_in::<Extended>(&format!("{rest} solver.digits=40"));
            assert!((extended.end_state().t.to_f64() - 5.0).abs() < 1e-15, "{sbp} {form}");
        }
    }
}

#[test]
fn a_run_that_rounding_ends_early_says_so() {
    // Stiff closures on a short range: the residual is at its rounding level while t still moves by 1e-7.
    let overrides = "scheme.sbp=SBP84 grid={gamma_f=0.2,n_gamma=30}";
    let doubled = solved(&format!("{overrides} solver.system=doubled"));
    let limit = solved(overrides);
    let difference = distance(doubled.elapsed(), limit.elapsed());
    let warnings = Diagnostics::new(&doubled).warnings(&doubled);
    let warned = warnings.iter().any(|warning| warning.contains("digits are certain"));
    assert!(difference < 1e-10 || warned, "the systems differ by {difference:e}: {warnings:?}");
    assert!(Diagnostics::new(&limit).warnings(&limit).is_empty());
}

#[test]
fn the_last_time_can_be_sampled_in_every_precision() {
    for digits in [16, 17, 40] {
        let overrides = format!("scheme.sbp=GLL8 grid={{t_f=2.0,windows=3,n_gamma=8}} solver.digits={digits}");
        let two = Extended::from(2.0);
        assert!(digits == 16 || Sampler::new(&solved_in::<Extended>(&overrides)).at_value(0, two).is_ok(), "{digits}");
        assert!(digits != 16 || Sampler::new(&solved(&overrides)).at_value(0, 2.0).is_ok());
    }
}
