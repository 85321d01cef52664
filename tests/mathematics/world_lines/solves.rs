//! A solve tells its iterations, its names and branches, and how far it came.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::sbp::SbpName;
use geodesic_ivp::solve::{InitialGuess, Iterations};
use geodesic_ivp::{Solution, Status, solve};

use crate::common::{case, distance, solved, solved_in, text_solved};

#[test]
fn iterations_are_counted() {
    let numbered = |iterations: &Iterations| iterations.history.iter().zip(1..).all(|(one, k)| one.iteration == k);
    for scheme in ["scheme.sbp=SBP42", "scheme.form=weak", "scheme.sbp=SBP42 solver.system=doubled"] {
        let iterations = solved(scheme).iterations;
        assert!(iterations.count == iterations.history.len() && numbered(&iterations), "{scheme}: {iterations:?}");
        let windows = solved(&format!("{scheme} grid.windows=4")).iterations;
        assert!((4..=4 * windows.history.len()).contains(&windows.count), "{scheme}: {windows:?}");
        let more: Solution<Extended> = solved_in(&format!("{scheme} solver.digits=40"));
        let history = &more.iterations.history;
        assert!(numbered(&more.iterations) && history.len() > iterations.count, "{scheme}: {history:?}");
        // The refinement goes on from a root in double precision, and each round leaves less.
        let refined = &history[iterations.count..];
        assert!(refined.windows(2).all(|pair| pair[1].step < pair[0].step), "{scheme}: {history:?}");
    }
    assert_eq!(solved("scheme.sbp=SBP42").iterations.initial_guess, InitialGuess::Steps);
    assert_eq!(solved("scheme.sbp=SBP42 grid.n_gamma=2001").iterations.initial_guess, InitialGuess::Engine);
    assert_eq!(solved("").iterations, Iterations { initial_guess: InitialGuess::None, ..solved("").iterations });
}

#[test]
fn a_run_is_written_with_its_own_names_and_branches() {
    let text = "potential = { coordinates = ['x', 'y'], formula = 'x^2 + 2*y^2 + x^2*y/3' }\n\
                particle = { law = 'newtonian', mass = 2.0 }\n\
                initial = { t = 1.0, t_dot = 3.0, x = 0.6, y = -0.2, x_dot = 0.9, y_dot = 1.5 }\n\
                grid = { gamma_f = 2.0, n_gamma = 41, windows = 2 }\nscheme.sbp = 'SBP21'\nsolver.system = 'doubled'\n";
    let one = solved("solver.system=doubled grid.windows=2 initial.t=7.0");
    for (doubled, names) in [(one, &["t", "x"][..]), (text_solved(text), &["t", "x", "y", "s"])] {
        assert_eq!(
            (doubled.geometry().names(), doubled.digits),
            (&names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>()[..], 16)
        );
        for a in 0..names.len() {
            let (one, two): (Vec<f64>, Vec<f64>) = (doubled.q(a).collect(), doubled.backward(a).unwrap().collect());
            // Newton's method keeps equal branches equal, to the last bit; t_i is added to each by itself.
            assert!(one.len() == doubled.nodes() && distance(&one, &two) < 4e-15, "{a}");
        }
        assert_eq!(doubled.branch_distance(), 0.0);
    }
    let more: Solution<Extended> = solved_in("solver.digits=30");
    assert!(more.digits == 30 && more.backward(0).is_none() && more.branch_distance() == Extended::ZERO);
}

#[test]
fn the_certificate_is_rounding_and_not_zero() {
    for scheme in ["", "scheme.sbp=SBP42", "scheme.form=weak", "scheme.sbp=GLL8 scheme.form=weak grid.n_gamma=8"] {
        let norm = solved(scheme).gradient_norm;
        assert!(norm > 0.0 && norm < 1e-12, "{scheme}: {norm:e}");
    }
}

#[test]
fn names_of_operators_are_told_from_numbers_of_nodes() {
    let message = |name: &str| SbpName::try_from(name.to_owned()).unwrap_err();
    for name in ["GLL", "GLLx", "GLL1x", "GL16"] {
        assert!(message(name).contains(&format!("unknown operator \"{name}\"")), "{}", message(name));
    }
    assert!(message("GLL1").contains("got GLL1") && message("GLL1000").contains("got GLL1000"));
}

/// x = 0.3 + γ/10, and t = 1e150 γ overflows. A recursion knows the node, and a linear system the window.
#[test]
fn an_overflow_is_found_where_it_is() {
    for (scheme, windows, exact) in [
        ("scheme.sbp=SBP42", 1, false),
        ("scheme.sbp=SBP42 scheme.form=weak", 1, false),
        ("", 1, true),
        ("", 3, false),
        ("scheme.sbp=GLL8 scheme.form=weak", 3, false),
    ] {
        let n = if scheme.contains("GLL") { 8 } else { 31 };
        let run = format!(
            "potential={{free={{}}}} initial={{t=0.0,x=0.3,t_dot=1e150,x_dot=0.1}} \
             grid={{gamma_i=5.0,gamma_f=1e159,n_gamma={n},windows={windows}}} {scheme}"
        );
        let failure = solve::<f64>(&case(&run)).unwrap_err();
        assert_eq!(failure.status, Status::OutsideDomain, "{scheme}: {failure}");
        let (first, step) = (f64::MAX / 1e150, 1e159 / 30.0);
        let window = 1e159 / f64::from(windows);
        let within = if exact { first..first + step } else { 5.0..first + window };
        assert!(within.contains(&failure.gamma), "{scheme}, {windows}: {} for {first:e}", failure.gamma);
    }
}

#[test]
fn a_run_that_stops_early_says_where_in_its_own_gamma() {
    for (what, status) in [
        ("solver.accuracy=1e-10 grid={gamma_i=5e4,gamma_f=1e9}", Status::TooManyNodes),
        ("solver.accuracy=1e-10 grid={gamma_i=5e4,t_f=1e9}", Status::TooManyNodes),
        ("solver.accuracy=1e-15 grid={gamma_i=5e4,gamma_f=6e4}", Status::AccuracyNotReached),
    ] {
        let failure = solve::<f64>(&case(what)).unwrap_err();
        assert_eq!(failure.status, status, "{what}: {failure}");
        assert!((5e4..6e4).contains(&failure.gamma), "{what}: {}", failure.gamma);
        if status == Status::TooManyNodes {
            // As many nodes as a thousandth of the run has, a thousand times.
            let short = solved("solver.accuracy=1e-10 grid={gamma_i=0.0,gamma_f=1e3}");
            let per_unit = short.x().len() as f64 / if what.contains("t_f") { short.duration() } else { 1e3 };
            assert!((0.5..2.0).contains(&(failure.needed / 1e9 / per_unit)), "{what}: {}", failure.needed);
        }
    }
}

#[test]
fn numbers_in_messages_are_neither_noise_nor_long() {
    let falls = "potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0 grid.gamma_f=5.0 scheme.sbp=SBP42";
    let mut failure = solve::<f64>(&case(falls)).unwrap_err();
    for (gamma, text) in [(0.0, "0.000000"), (1.5e-7, "1.500000e-7"), (0.25, "0.250000"), (2.5e12, "2.500000e12")] {
        failure.gamma = gamma;
        let message = failure.to_string();
        let found = message.split("gamma = ").nth(1).unwrap_or_else(|| panic!("{message}"));
        let found = found.trim_end_matches('.').split([',', ' ', ':', ';']).next().unwrap();
        assert_eq!(found, text, "{message}");
    }
    assert!(failure.to_string().len() < 1000 && Extended::IS_EXTENDED);
}

#[test]
fn the_last_node_is_at_the_end_to_the_last_bit() {
    // A share of these, so many times, is not the whole.
    for windows in [49, 98, 103, 107] {
        assert_ne!(f64::from(windows) * (1.0 / f64::from(windows)), 1.0);
        for scheme in ["", "scheme.sbp=GLL4 scheme.form=weak"] {
            let n = if scheme.is_empty() { 9 } else { 4 };
            let run = format!("potential={{free={{}}}} grid={{gamma_f=1.0,n_gamma={n},windows={windows}}} {scheme}");
            let solution = solved(&run);
            assert_eq!(solution.gamma().last(), Some(1.0), "{run}");
            assert_eq!(solution.windows.last().unwrap().gamma[1], solution.length, "{run}");
        }
    }
}

/// A relative step is one of x and of w, each in units of its own size.
#[test]
fn the_step_of_an_iteration_is_relative_to_what_it_changes() {
    let far = "potential={formula={expression=\"(x-1e3)^2/2\"}} particle.c=100.0 grid={gamma_f=3.0,n_gamma=21} \
               initial={t=0.0,x=1001.0,t_dot=1.0,x_dot=0.0} scheme.sbp=SBP42";
    let history = solved(far).iterations.history;
    // |x| ≤ 1001 and |w| ≤ 1.
    for one in history.iter().filter(|one| one.step > 0.0) {
        assert!(one.damping == 1.0 && one.relative_step >= 0.99 * one.step / 1001.0, "{one:?}");
        assert!(one.relative_step <= 1.01 * one.step, "{one:?}");
    }
}

#[test]
fn a_refinement_keeps_to_its_limit_of_iterations() {
    for scheme in ["scheme.sbp=SBP42 solver.system=doubled", "scheme.form=weak solver.system=doubled"] {
        let first = solved(scheme).iterations.count;
        let run = format!("{scheme} solver.digits=60");
        let whole: Solution<Extended> = solved_in(&run);
        let rounds = whole.iterations.history.len() - first;
        assert!(rounds >= 3 && first <= rounds, "{scheme}: {first} and {rounds}");
        for most in first..=rounds + 1 {
            match solve::<Extended>(&case(&format!("{run} solver.max_iterations={most}"))) {
                // At the limit a residual that is rounding is good enough.
                Ok(solution) => {
                    assert_eq!(solution.iterations.history.len(), first + rounds.min(most), "{scheme}, {most}");
                    assert!(most + 1 >= rounds, "{scheme}, {most}");
                }
                Err(failure) => {
                    assert!(
                        most < rounds && failure.status == Status::PrecisionNotReached,
                        "{scheme}, {most}: {failure}"
                    );
                    assert_eq!(failure.iterations.history.len(), first + most, "{scheme}, {most}");
                }
            }
        }
    }
}
