//! The weak form of the action: Q_t exact at every node, a superconvergent end, and honest failures.

use std::sync::atomic::AtomicBool;

use crate::common::{case, distance, solved, solved_in};
use geodesic_ivp::case::{Form, SbpName};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::Extended;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::study::convergence::{Convergence, Quantity, sweep};
use geodesic_ivp::{Solution, Status, solve};

struct Base {
    overrides: &'static str,
    t_final: &'static str,
    x_final: &'static str,
}

/// N = 32, by an independent 100-digit program.
const BASES: [Base; 4] = [
    Base {
        overrides: "potential={linear={alpha=0.25}} scheme={sbp=\"SBP21\",form=\"weak\"}",
        t_final: "0.9971151097491775694816452255460214429408422759436342700996604437438565",
        x_final: "0.9760506286084057869098407081411635942717323384864257857066539974205039",
    },
    Base {
        overrides: "potential={linear={alpha=0.25}} scheme={sbp=\"SBP42\",form=\"weak\"}",
        t_final: "0.9971295993901089008257494036375933267547323126000895638992924643570107",
        x_final: "0.9760463906031115168135012742823952779111278544575222284281250875527799",
    },
    Base {
        overrides: "scheme={sbp=\"SBP21\",form=\"weak\"}",
        t_final: "1.467845286957429771520660850602670890688684833211762959588645421829265",
        x_final: "0.1596526768674696838987378748942589779532047506668670139211550540460584",
    },
    Base {
        overrides: "scheme={sbp=\"SBP42\",form=\"weak\"}",
        t_final: "1.468634332210151836834497911415784056947360675161369518713478914900886",
        x_final: "0.1597777821251707290446712152081763128093268780064538857655034129040739",
    },
];

const SYSTEMS: [&str; 2] = ["solver.system=physical-limit", "solver.system=doubled"];

fn read<S: Arithmetic>(text: &str) -> S {
    S::from_decimal(text).unwrap()
}

/// The ends are those of the independent program; all that is zero in theory is below `zero`, at every node.
fn assert_exact<S: Arithmetic>(name: &str, base: &Base, solution: &Solution<S>, close: S, zero: S) {
    let diagnostics = Diagnostics::new(solution);
    assert_eq!(solution.form, Form::Weak);
    assert!(solution.multipliers().is_none(), "{name}: no multipliers");
    assert!((solution.end_state().t - read(base.t_final)).abs() < close, "{name}: t = {:?}", solution.end_state().t);
    assert!((solution.end_state().x - read(base.x_final)).abs() < close, "{name}: x = {:?}", solution.end_state().x);
    let charge = &diagnostics.charges[0];
    assert_eq!(charge.delta, charge.corrected, "{name}: nothing to correct");
    assert_eq!(charge.delta.len(), 32);
    assert!(charge.delta.iter().all(|d| d.abs() < zero), "{name}: ΔQ_t at all nodes");
    // Another application of D costs a factor of N.
    let of_derivative = S::from(32.0) * zero;
    assert!(diagnostics.delta_g.iter().flatten().all(|g| g.abs() < of_derivative), "{name}: ΔG");
    assert!(diagnostics.max_delta_g < of_derivative, "{name}");
    assert!(solution.gradient_norm < zero && solution.branch_distance() < zero, "{name}");
    // The checks can fail: the same numbers by plain D are not zero.
    let plain = solution.sbp().derivative(solution.elapsed())[0] - diagnostics.q_dot[0][0];
    assert!(plain.abs().to_f64() > 1e-7, "{name}: the regularisation is at work");
}

#[test]
fn the_charge_is_exact_at_every_node() {
    for base in BASES {
        let [limit, doubled] = SYSTEMS.map(|system| solved(&format!("{} {system}", base.overrides)));
        for (solution, system) in [(&limit, SYSTEMS[0]), (&doubled, SYSTEMS[1])] {
            // ε|t|/h at N = 32 with room for the operator's row sum and g00.
            assert_exact(&format!("{} {system}", base.overrides), &base, solution, 1e-11, 32.0 * 8.0 * f64::EPSILON);
        }
        assert!(distance(limit.x(), doubled.x()) < 1e-12 && distance(limit.elapsed(), doubled.elapsed()) < 1e-12);
        assert!((limit.end_state().x_dot - doubled.end_state().x_dot).abs() < 1e-11);
        assert!((limit.end_state().q_t - doubled.end_state().q_t).abs() < 1e-15);
    }
}

#[test]
fn zero_in_forty_and_sixty_digits() {
    for base in BASES {
        for system in SYSTEMS {
            for (digits, close, zero) in [(40, "1e-39", "1e-36"), (60, "1e-59", "1e-55")] {
                let name = format!("{} {system} solver.digits={digits}", base.overrides);
                assert_exact::<Extended>(&name, &base, &solved_in(&name), read(close), read(zero));
            }
        }
    }
}

#[test]
fn the_end_has_the_order_of_the_interior() {
    let swept = |digits: &str, n_gamma: &[usize]| -> Convergence<Extended> {
        let case = case(&format!("scheme.form=weak {digits}"));
        sweep(
            &case,
            &[(SbpName::Sbp21, Form::Weak), (SbpName::Sbp42, Form::Weak)],
            n_gamma,
            &AtomicBool::new(false),
            &|_| {},
        )
        .unwrap()
    };
    let convergence = swept("solver.digits=30", &[129, 257, 513]);
    let sbp42 = convergence.points.iter().find(|p| p.sbp == SbpName::Sbp42 && p.n_gamma == 257).unwrap();
    let errors = sbp42.errors.as_ref().unwrap();
    assert!((errors.at_end[1] / 2.806e-11 - 1.0).abs() < 1e-3, "{errors:?}");
    assert!((errors.at_end[0] / 8.353e-11 - 1.0).abs() < 1e-3, "{errors:?}");
    assert!(errors.charges_last[0] < 1e-25, "{errors:?}");
    let convergence = swept("solver.digits=30", &[1025, 2049, 4097]);
    for slope in convergence.slopes((0, usize::MAX)) {
        assert_eq!(slope.form, Form::Weak);
        let fit = slope.fit.as_ref().unwrap();
        let order = match (slope.sbp, slope.quantity) {
            (SbpName::Sbp21, _) => 2.0,
            (_, Quantity::EPS_T_FINAL | Quantity::EPS_X_FINAL) => 4.0,
            _ => 3.0,
        };
        assert!((fit.slope - order).abs() < 0.05, "{:?} {:?}: {}", slope.sbp, slope.quantity, fit.slope);
    }
}

#[test]
fn what_is_handed_on_continues_the_trajectory() {
    // w_N belongs to the trajectory as x_N does, and is as accurate.
    let solution = solved("scheme={sbp=\"SBP42\",form=\"weak\"} grid.n_gamma=257");
    let diagnostics = Diagnostics::new(&solution);
    assert!((solution.end_state().x_dot + 1.416_825_598_093_154_3).abs() < 1e-9, "{}", solution.end_state().x_dot);
    assert!(diagnostics.norm.max_ends < 1e-9, "{}", diagnostics.norm.max_ends);
    assert!((diagnostics.q_dot[1][256] - solution.end_state().x_dot).abs() < 1e-11);
}

#[test]
fn long_runs_in_one_block() {
    let run = "grid.gamma_f=100.0 grid.n_gamma=2001";
    let [limit, doubled] = SYSTEMS.map(|s| solved(&format!("{run} scheme={{sbp=\"SBP42\",form=\"weak\"}} {s}")));
    let diagnostics = Diagnostics::new(&limit);
    assert!(diagnostics.norm.max_interior < 1e-3 && diagnostics.norm.max_ends < 1e-6);
    assert!(diagnostics.charges[0].max_interior < 1e-11);
    assert!(distance(limit.x(), doubled.x()) < 1e-7, "{}", distance(limit.x(), doubled.x()));
    // SBP21 is fragile here: whatever comes is a critical point or a failure with its reason.
    for system in SYSTEMS {
        match solve::<f64>(&case(&format!("{run} scheme.form=weak {system}"))) {
            Ok(solution) => assert!(solution.gradient_norm < 1e-10, "{system}"),
            Err(failure) => {
                assert!(failure.status != Status::Converged && !failure.advice().is_empty(), "{system}");
                assert!(failure.residual.is_finite() && (0.0..=100.0).contains(&failure.gamma), "{system}");
            }
        }
    }
}

#[test]
fn a_horizon_is_one_in_the_weak_form_too() {
    let text = include_str!("../../../cases/hard/horizon.toml");
    for sbp in ["SBP21", "SBP42"] {
        for system in SYSTEMS {
            let overrides = ["scheme.form=weak", system, &format!("scheme.sbp={sbp}")].map(str::to_owned);
            let case = geodesic_ivp::Case::parse("horizon", text, &overrides).unwrap();
            let failure = solve::<f64>(&case).expect_err("the case is designed to fail");
            assert_eq!(failure.status, Status::OutsideDomain, "{sbp} {system}: {failure}");
        }
    }
}

#[test]
fn a_hundred_thousand_nodes() {
    for (sbp, accuracy) in [("SBP21", 1e-9), ("SBP42", 1e-12)] {
        let solution = solved(&format!("grid.n_gamma=100000 scheme={{sbp=\"{sbp}\",form=\"weak\"}}"));
        assert!(
            (solution.end_state().x - 0.159_778_018_885_407_25).abs() < accuracy,
            "{sbp}: {}",
            solution.end_state().x
        );
        assert!((solution.end_state().t - 1.468_634_756_955_731).abs() < accuracy, "{sbp}: {}", solution.end_state().t);
        assert!(solution.gradient_norm < 1e-9, "{sbp}: {}", solution.gradient_norm);
    }
}
