//! Forty digits and more: what is exact in theory is zero to the digits asked for.

use std::sync::atomic::AtomicBool;

use crate::common::{case, distance, solved_in};
use geodesic_ivp::case::{Case, Form, SbpName, builtin};
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::study::convergence::{Convergence, Quantity, sweep};
use geodesic_ivp::{Solution, Status, solve};

fn read(text: &str) -> Extended {
    Extended::from_decimal(text).unwrap()
}

struct Base {
    overrides: &'static str,
    t_final: &'static str,
    x_final: &'static str,
    delta_e_last: &'static str,
}

/// N = 32, by an independent 100-digit program (t, x) and as published (ΔE).
const BASES: [Base; 4] = [
    Base {
        overrides: "potential={linear={alpha=0.25}} scheme.sbp=SBP21",
        t_final: "0.9971335746291577636846554134796076309812725357198337858600296866346344",
        x_final: "0.9761916056480037954022088281977935687917616513511737365080920827969218",
        delta_e_last: "1.70339476621e-3",
    },
    Base {
        overrides: "potential={linear={alpha=0.25}} scheme.sbp=SBP42",
        t_final: "0.9971296071048166056825284999699712220043206004729274817222058196096819",
        x_final: "0.9760470232028565253567171045240423727682659409234750400869547831689843",
        delta_e_last: "1.004786223e-6",
    },
    Base {
        overrides: "scheme.sbp=SBP21",
        t_final: "1.468801423064326110333148834749417048967845333815025203765032107249465",
        x_final: "0.1601801643661407023957676285707798759114176062382472041078852253897226",
        delta_e_last: "5.93454699655e-2",
    },
    Base {
        overrides: "scheme.sbp=SBP42",
        t_final: "1.468700371197799309103860409960511578224397674620524406615090445406213",
        x_final: "0.1597852677469550743207985667503222881839771174173329340661003120892074",
        delta_e_last: "5.78416591035e-3",
    },
];

const SYSTEMS: [&str; 2] = ["solver.system=physical-limit", "solver.system=doubled"];

/// Everything that is zero in theory is below `zero`; the last nodes, which are not, stay where they are.
fn assert_exact(name: &str, solution: &Solution<Extended>, zero: &str) {
    let (zero, diagnostics) = (read(zero), Diagnostics::new(solution));
    assert!(diagnostics.charges[0].max_interior < zero, "{name}: interior ΔQ_t");
    assert!(diagnostics.charges[0].max_corrected < zero, "{name}: corrected ΔQ_t");
    assert!(diagnostics.max_delta_g < zero, "{name}: interior ΔG");
    assert!(solution.multipliers().unwrap()[..4].iter().all(|lambda| lambda.abs() < zero), "{name}: λ1 … λ4");
    assert!(solution.gradient_norm < zero, "{name}: gradient {:?}", solution.gradient_norm);
    assert!(solution.branch_distance() < zero, "{name}: branches");
    // The checks can fail.
    assert!(diagnostics.charges[0].last.abs() > read("1e-7"), "{name}: the last node stands alone");
    let last = solution.x().len() - 1;
    assert!(diagnostics.delta_g[1][last].abs() > read("1e-7"), "{name}: ΔG at the last node");
}

#[test]
fn the_base_cases_in_40_digits() {
    for base in BASES {
        for system in SYSTEMS {
            let name = format!("{} {system}", base.overrides);
            let solution = solved_in::<Extended>(&format!("{name} solver.digits=40"));
            assert!(
                (solution.end_state().t - read(base.t_final)).abs() < read("1e-39"),
                "{name}: {:?}",
                solution.end_state().t
            );
            assert!(
                (solution.end_state().x - read(base.x_final)).abs() < read("1e-39"),
                "{name}: {:?}",
                solution.end_state().x
            );
            let last = Diagnostics::new(&solution).charges[0].last.to_f64();
            let published: f64 = base.delta_e_last.parse().unwrap();
            assert!((last / published - 1.0).abs() < 1e-9, "{name}: {last} against {published}");
            assert_exact(&name, &solution, "1e-36");
        }
    }
}

#[test]
fn the_base_cases_in_60_digits() {
    for base in BASES {
        for system in SYSTEMS {
            let name = format!("{} {system}", base.overrides);
            let solution = solved_in::<Extended>(&format!("{name} solver.digits=60"));
            assert!(
                (solution.end_state().t - read(base.t_final)).abs() < read("1e-59"),
                "{name}: {:?}",
                solution.end_state().t
            );
            assert!(
                (solution.end_state().x - read(base.x_final)).abs() < read("1e-59"),
                "{name}: {:?}",
                solution.end_state().x
            );
            assert_exact(&name, &solution, "1e-55");
        }
    }
}

#[test]
fn irrational_formulas_in_60_digits() {
    for text in
        [include_str!("../../../cases/pendulum-60-digits.toml"), include_str!("../../../cases/morse-60-digits.toml")]
    {
        for sbp in ["SBP21", "SBP42"] {
            for system in SYSTEMS {
                let overrides = [format!("scheme.sbp={sbp}"), system.to_owned()];
                let case = Case::parse("formula", text, &overrides).unwrap();
                let name = format!("{:?} {sbp} {system}", case.title());
                assert_exact(&name, &solve(&case).unwrap(), "1e-55");
            }
        }
    }
}

#[test]
fn the_most_digits_there_are() {
    for base in BASES {
        for system in SYSTEMS {
            let name = format!("{} {system}", base.overrides);
            let solution = solved_in::<Extended>(&format!("{name} solver.digits=70"));
            assert_exact(&name, &solution, "1e-65");
            // The second-order form of the action loses N² units of the last place, and says so.
            let warnings = Diagnostics::new(&solution).warnings(&solution);
            let warned = warnings.iter().any(|warning| warning.contains("of 70 digits"));
            assert!(system == SYSTEMS[0] && !warned || system == SYSTEMS[1], "{name}: {warnings:?}");
        }
    }
}

#[test]
fn extended_precision_confirms_f64() {
    for base in BASES {
        let (short, long) = (solved_in::<f64>(base.overrides), solved_in::<Extended>(base.overrides));
        assert!((short.end_state().t - long.end_state().t.to_f64()).abs() < 1e-14, "{}", base.overrides);
        assert!((short.end_state().x - long.end_state().x.to_f64()).abs() < 1e-14, "{}", base.overrides);
    }
}

#[test]
fn a_case_number_is_the_decimal_that_is_written() {
    let digits = "solver.digits=60 scheme.sbp=SBP42";
    let tenth = solved_in::<Extended>(digits);
    // The f64 next to a tenth is another number …
    let double = solved_in::<Extended>(&format!(
        "initial.x_dot=0.1000000000000000055511151231257827021181583404541015625 {digits}"
    ));
    let difference = distance(tenth.x(), double.x()).to_f64();
    assert!(difference > 1e-18 && difference < 1e-16, "{difference}");
    // … and an eighth is the same in both.
    let written = ["0.125", "12.5e-2", "0.12500000000000000000000000000"].map(|eighth| {
        let kappa = format!("potential.quartic.kappa={eighth} {digits}");
        solved_in::<Extended>(&kappa).end_state().x
    });
    assert!(written[0] == written[1] && written[1] == written[2]);
    // A velocity of one tenth with a tangent of three is an ẋ of three tenths.
    let velocity = solved_in::<Extended>(&format!("initial={{t=0,x=1,t_dot=3,velocity=0.1}} {digits}"));
    let x_dot = solved_in::<Extended>(&format!("initial={{t=0,x=1,t_dot=3,x_dot=0.3}} {digits}"));
    assert!((velocity.end_state().x - x_dot.end_state().x).abs() < read("1e-60"));
}

#[test]
fn more_digits_than_asked_for_are_kept() {
    let long = "0.10000000000000000000000000000000000000000000000000000000000000001";
    let written = case(&format!("initial.x_dot={long} solver.digits=40"));
    assert!(written.to_toml().contains(&format!("x_dot = {long}")), "{}", written.to_toml());
    assert_eq!(Case::parse("again", &written.to_toml(), &[]).unwrap(), written);
    assert!(written != case("solver.digits=40"));
    for (digits, valid) in [("15", false), ("16", true), ("70", true), ("71", false), ("0", false)] {
        let overrides = [format!("solver.digits={digits}")];
        assert_eq!(Case::parse("digits", crate::common::QUARTIC, &overrides).is_ok(), valid, "{digits}");
    }
}

#[test]
fn a_physical_time_is_reached_to_all_digits() {
    for digits in [20, 40, 60] {
        for system in SYSTEMS {
            let overrides = format!("grid={{t_f=5.0,n_gamma=64}} scheme.sbp=SBP42 {system} solver.digits={digits}");
            let off = (solved_in::<Extended>(&overrides).end_state().t - read("5")).abs();
            assert!(off <= read(&format!("1e-{}", digits - 1)), "{system}, {digits} digits: {off:?}");
        }
    }
}

#[test]
fn the_reference_has_the_digits_asked_for() {
    for (potential, t, x, x_dot) in [
        (
            "potential={linear={alpha=0.25}}",
            "0.997129598504376989402741",
            "0.976046390793498338329943",
            "-0.148570533876599546619321996",
        ),
        ("", "1.46863475695573088737134", "0.15977801888540724822026", "-1.41682559809315428413482"),
    ] {
        let (geometry, start) = (case(potential).geometry::<Extended>(), case(potential).start::<Extended>());
        for digits in [20, 40, 70] {
            let reference = ReferenceTrajectory::new(&geometry, &start, Extended::ONE, digits).unwrap();
            let end = reference.at(Extended::ONE);
            for (got, published) in [(end.q[0], t), (end.q[1], x), (end.q_dot[1], x_dot)] {
                let last = if digits == 20 { "1e-19" } else { "1e-23" };
                assert!((got - read(published)).abs() < read(last), "{potential}: {got:?}");
            }
            let estimate = reference.error_estimate();
            let unit = 10.0_f64.powi(-(digits as i32));
            assert!(estimate < 10.0 * unit, "{digits} digits: estimated error {estimate}");
            // K = Q_t²/g00 − ẋ² judges it independently.
            let (k, norm) = (geometry.norm(&end.q, &end.q_dot), geometry.norm(&start.q, &start.q_dot));
            assert!((k - norm).abs().to_f64() < 100.0 * unit, "{digits} digits");
        }
    }
}

#[test]
#[ignore = "long: a quarter of a million nodes in 40 digits"]
fn the_slope_of_sbp42_goes_on_below_the_rounding_of_f64() {
    let grids = [512, 8192, 65_536, 262_144];
    let sweep = |overrides: &str| -> Convergence<Extended> {
        sweep(&case(overrides), &[(SbpName::Sbp42, Form::Strong)], &grids, &AtomicBool::new(false), &|_| {}).unwrap()
    };
    let convergence = sweep("solver.digits=40");
    assert!(convergence.reference.error_estimate < 1e-38);
    for slope in convergence.slopes((0, usize::MAX)) {
        assert_eq!(slope.plateau_from, None, "{:?}", slope.quantity);
        let fit = slope.fit.as_ref().unwrap();
        assert!((fit.slope - 3.0).abs() < 0.02, "{:?}: {}", slope.quantity, fit.slope);
        assert!((fit.local_slopes[2] - 3.0).abs() < 2e-3, "{:?}: {:?}", slope.quantity, fit.local_slopes);
    }
    let finest = convergence.points.last().unwrap().errors.clone().unwrap();
    assert!(Quantity::EPS_X_FINAL.of(&finest) < 1e-16 && Quantity::EPS_T_FINAL.of(&finest) < 1e-16, "{finest:?}");
}

#[test]
fn a_refinement_that_cannot_succeed_is_not_a_result() {
    // Even and odd nodes have parted: the critical point exists, but its Hessian says little about its neighbourhood.
    let overrides =
        "grid.gamma_f=200.0 grid.n_gamma=2001 solver.system=doubled solver.digits=70 solver.max_iterations=40";
    match solve::<Extended>(&case(overrides)) {
        Ok(solution) => assert!(solution.gradient_norm < read("1e-60"), "{:?}", solution.gradient_norm),
        Err(failure) => assert!(failure.status != Status::Converged && !failure.advice().is_empty()),
    }
}

/// Where rounding keeps corrections above the digits asked for, a run ends with those that there are.
#[test]
fn the_last_digits_are_those_of_the_type() {
    let set = "scheme={sbp='SBP84',form='weak'} grid={gamma_f=10.0,n_gamma=401} solver.digits=70";
    let solution = solved_in::<Extended>(set);
    let last = solution.iterations.history.last().unwrap().relative_step;
    assert!(last > 1e-71 && last < 1e-66, "{last:e}");
    assert!(solution.gradient_norm.to_f64() < 1e-64, "{:?}", solution.gradient_norm);

    let text = builtin::text("schwarzschild-orbit").unwrap();
    let set = "grid={gamma_f=400.0,n_gamma=401,windows=1} scheme={sbp='SBP84',form='weak'} solver.digits=70";
    let set: Vec<String> = set.split(' ').map(str::to_owned).collect();
    let line = solve::<Extended>(&Case::parse("orbit", text, &set).unwrap().setup()).unwrap();
    let last = line.iterations.history.last().unwrap().relative_step;
    assert!(last > 1e-71 && last < 1e-66, "{last:e}");
}
