//! Diagnostics of scenes in units other than 1 agree with their definitions.

use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::solve::WorldLine;
use geodesic_ivp::study::errors::{RunError, run_error};
use geodesic_ivp::study::facts::facts_of_run;
use geodesic_ivp::study::many::ManyRuns;

use crate::common::{against_reference, case, geometry, line_of, metric, parsed, setup_of, text_solved};

/// Newton's law for m = 2 in V = x² + 2y² + x²y/3.
const MOTION: &str = r#"
    potential = { coordinates = ["x", "y"], formula = "x^2 + 2*y^2 + x^2*y/3" }
    particle = { law = "newtonian", mass = 2.0 }
    initial = { t = 1.0, t_dot = 3.0, x = 0.6, y = -0.2, x_dot = 0.9, y_dot = 1.5 }
    grid = { gamma_f = 2.0, n_gamma = 41 }
    scheme.sbp = "SBP21"
"#;

fn run(set: &[&str]) -> WorldLine {
    line_of(&parsed(MOTION, set))
}

fn measured(line: &WorldLine) -> Diagnostics {
    Diagnostics::of(line, &[], &mut [], true)
}

/// ½mv² + V of q = (t, x, y, s) and dq/dγ.
fn energy(q: &[f64], q_dot: &[f64]) -> f64 {
    let (x, y) = (q[1], q[2]);
    let squared = (q_dot[1].powi(2) + q_dot[2].powi(2)) / q_dot[0].powi(2);
    squared + x * x + 2.0 * y * y + x * x * y / 3.0
}

#[test]
fn energy_is_that_of_positions_and_velocities() {
    for set in [&[] as &[&str], &["scheme.form='weak'", "grid.windows=3", "grid.n_gamma=21"]] {
        let line = run(set);
        let found = measured(&line);
        let begun = energy(&line.place.start.q, &line.place.start.q_dot);
        let of_ends = found.energy.as_ref().unwrap();
        let deltas = &of_ends.delta;
        assert!((of_ends.value - begun).abs() < 1e-13, "{of_ends:?} for {begun}");
        let q: Vec<Vec<f64>> = (0..4).map(|a| line.q(a).collect()).collect();
        let mut largest = 0.0_f64;
        // In the strong form the last node of a window has the values that are handed on.
        for k in (0..deltas.len()).filter(|k| (k + 1) % line.sbp().points() != 0) {
            let q: Vec<f64> = q.iter().map(|row| row[k]).collect();
            let q_dot: Vec<f64> = found.tangent(&line).iter().map(|row| row[k]).collect();
            let off = energy(&q, &q_dot) - begun;
            assert!((deltas[k] - off).abs() < 1e-12, "node {k}: {} for {off}", deltas[k]);
            largest = largest.max(off.abs());
        }
        assert!(largest > 1e-3, "{largest}");
        let ends = line.views().map(|view| energy(view.end.q, &line.velocities(view.end)) - begun);
        let most = ends.fold(0.0, |most: f64, off| most.max(off.abs()));
        assert!((of_ends.max_ends - most).abs() < 1e-12 && most > 1e-6, "{of_ends:?} for {most}");
    }
}

#[test]
fn what_motion_contributes_to_k_are_its_terms_but_the_largest() {
    let text = metric(&["t", "x", "y"], &[("t t", "1"), ("x x", "-4"), ("y y", "-x^2"), ("t y", "0.5")]);
    let geometry = geometry::<f64>(&text);
    // K = 9 − 4·0.25 − 4·0.01 + 2·½·3·0.1, and a pair of coordinates counts once.
    let (q, q_dot) = ([0.0, 2.0, 0.0], [3.0, 0.5, 0.1]);
    assert!((geometry.norm(&q, &q_dot) - 8.26).abs() < 1e-14);
    assert!((geometry.motion(&q, &q_dot) - (1.0 + 0.04 + 0.15)).abs() < 1e-14, "{}", geometry.motion(&q, &q_dot));
    // On a run it is the largest of all nodes.
    let line = run(&["grid.n_gamma=401", "scheme.sbp='SBP42'"]);
    let places = (0..400).map(|k| {
        let q: Vec<f64> = (0..4).map(|a| line.q(a).nth(k).unwrap()).collect();
        let q_dot: Vec<f64> = (0..4).map(|a| line.sbp().derivative_at(&line.q(a).collect::<Vec<_>>(), k)).collect();
        line.geometry().motion(&q, &q_dot)
    });
    let most = places.fold(0.0, f64::max);
    assert!((measured(&line).motion / most - 1.0).abs() < 1e-9 && most > 1.0, "{most}");
}

#[test]
fn a_run_that_drifts_or_falls_apart_is_told() {
    let warnings = |set: &[&str]| {
        let line = run(set);
        measured(&line).warnings(&line).join("\n")
    };
    let fine = warnings(&["grid.n_gamma=401", "scheme.sbp='SBP42'"]);
    assert_eq!(fine, "");
    let set = ["grid.gamma_f=60.0", "grid.n_gamma=2001"];
    let (coarse, motion) = (warnings(&set), measured(&run(&set)).motion);
    let number = |before: &str| -> f64 {
        let rest = coarse.split(before).nth(1).unwrap_or_else(|| panic!("{coarse}"));
        rest.split([',', ' ']).next().unwrap().parse().unwrap()
    };
    let (drift, share) = (number("K drifts by "), number("K drifts by 1.9e-1, "));
    assert!((drift / share / motion - 1.0).abs() < 0.1, "{coarse}: {motion}");
    // A hundredth of what motion contributes is told, and less is not.
    let finer = ["grid.gamma_f=60.0", "grid.n_gamma=3001"];
    let norm = measured(&run(&finer)).norm;
    let largest = norm.max_ends.max(norm.max_interior);
    assert!(largest < 0.009 * motion && largest > 0.02 / motion, "{largest} and {motion}");
    assert!(!warnings(&finer).contains("K drifts"), "{}", warnings(&finer));
    let coarser = warnings(&["grid.gamma_f=60.0", "grid.n_gamma=1001"]);
    assert!(coarser.contains("K drifts by") && coarser.contains("even and odd nodes are apart"), "{coarser}");
    // "the sawtooth in NAME is …, above …, 0.01 of the amplitude", which is half of the range.
    let line = run(&["grid.gamma_f=60.0", "grid.n_gamma=1001"]);
    for told in coarser.split("the sawtooth in ").skip(1) {
        let a = line.geometry().names().iter().position(|name| told.starts_with(name.as_str())).unwrap();
        let [least, most] = [f64::min, f64::max].map(|of| line.q(a).reduce(of).unwrap());
        let above: f64 = told.split("above ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
        assert!((above / (0.005 * (most - least)) - 1.0).abs() < 0.05, "{told}: {least} to {most}");
    }
}

#[test]
fn sums_of_momenta_and_constants_are_kept_whatever_their_factors() {
    // Two masses on a spring.
    let text = r#"
        potential = { coordinates = ["x", "y"], formula = "3*(x-y)^2 + (x-y)^4" }
        particle = { law = "newtonian", masses = { x = 2.0, y = 0.5 } }
        initial = { x = 0.6, y = -0.2, x_dot = 0.9, y_dot = 1.5 }
        grid = { gamma_i = 1.5, gamma_f = 4.5, n_gamma = 31, windows = 2 }
        invariants = { momentum = "p_x + p_y", five = "5" }
    "#;
    for scheme in ["scheme={sbp='SBP42',form='weak'}", "scheme={sbp='SBP42',form='strong'}"] {
        let case = parsed(text, &[scheme]);
        let line: WorldLine = line_of(&case);
        let sums = [vec![(1, 3.0), (2, 3.0)]];
        let found = Diagnostics::of(&line, &sums, &mut case.observables(), case.is_lifted());
        let sum = &found.sums[0];
        assert!((sum.value.abs() - 3.0 * (1.8 + 0.75)).abs() < 1e-13, "{}", sum.value);
        for (what, deviation) in [
            ("interior", sum.max_interior),
            ("ends", sum.max_ends),
            ("corrected", sum.max_corrected),
            ("momentum", found.invariants[0].1.max_ends),
            ("five", found.invariants[1].1.max_ends),
            ("five", found.invariants[1].1.delta.iter().fold(0.0, |most: f64, delta| most.max(delta.abs()))),
        ] {
            assert!(deviation.abs() < 1e-12, "{scheme}, {what}: {deviation:e}");
        }
        assert!((found.invariants[0].1.value.abs() - 2.55).abs() < 1e-13 && found.invariants[1].1.value == 5.0);
        // Residuals are rounding, and not less than their own largest.
        assert!(found.max_delta_g > 0.0 && found.max_delta_g < 1e-9, "{:e}", found.max_delta_g);
        // γ does not begin at 0.
        let error = against_reference(&line);
        assert!(error.largest.iter().all(|error| *error < 0.1) && error.largest[1] > 1e-9, "{error:?}");
    }
}

#[test]
fn a_verdict_counts_errors_against_the_motion_from_its_start() {
    // x = 3 + 0.25 sin 6γ, and t = 7 + 3γ in the limit of large c.
    let one = case(
        "potential={formula={expression=\"2*(x-3)^2\"}} particle.c=1e4 scheme.sbp=SBP42 \
         initial={t=7.0,x=3.0,t_dot=3.0,x_dot=1.5} grid={gamma_f=3.0,n_gamma=601}",
    );
    // x = 3 + 2/3 sin 9γ, and t = 5 + 3γ.
    let text = r#"
        potential = { coordinates = ["x"], formula = "9*(x-3)^2/2" }
        particle.law = "newtonian"
        initial = { t = 5.0, t_dot = 3.0, x = 3.0, x_dot = 6.0 }
        grid = { gamma_f = 0.8, n_gamma = 401 }
        scheme.sbp = "SBP42"
    "#;
    for (case, sizes, [most, share]) in
        [(one, [9.0, 9.0, 3.25, 0.5], [0.0, 1e-3]), (parsed(text, &[]), [2.4, 2.4, 11.0 / 3.0, 4.0 / 3.0], [1e-4, 0.0])]
    {
        let line: WorldLine = line_of(&case);
        let error = run_error(&case.setup(), &line, &[]);
        let measured = Diagnostics::of(&line, &[], &mut [], case.is_lifted());
        let errors = facts_of_run(&line, &measured, error.as_ref(), None).errors.unwrap();
        let [t, x] = ["t", "x"].map(|name| errors.iter().find(|error| error.name == name).unwrap());
        for (found, wanted) in [t.size, t.range, x.size, x.range].into_iter().zip(sizes) {
            assert!((found - wanted).abs() < most + share * wanted, "{found} for {wanted}: {errors:?}");
        }
    }
    // An accuracy is one relative to max(1, size).
    let set = ["solver.accuracy=1e-8", "grid={gamma_f=0.8}", "scheme={}"];
    let run: WorldLine = line_of(&parsed(text, &set));
    let estimate = run.error_estimate.unwrap();
    let own = run_error(&setup_of(&run), &run, &[]);
    for error in facts_of_run(&run, &measured(&run), own.as_ref(), None).errors.unwrap() {
        let own = estimate * error.size;
        assert!((error.largest / own - 1.0).abs() < 1e-12 && error.end == error.largest, "{error:?}");
    }
    let line = text_solved(text);
    let error = against_reference(&line);
    assert!((0.0..1e-12).contains(&error.stepped_over), "{error:?}");
    let errors = facts_of_run(&line, &measured(&line), Some(&error), None).errors.unwrap();
    // The error of the reference is added, in units of the coordinate.
    let known = RunError { own: errors.iter().map(|error| 1e-3 * error.shared).collect(), ..error.clone() };
    let wider = facts_of_run(&line, &measured(&line), Some(&known), None).errors.unwrap();
    for (a, wider) in wider.iter().enumerate() {
        for (found, own) in [(wider.end, error.end[a]), (wider.largest, error.largest[a])] {
            assert!((found - own - 1e-3 * wider.shared).abs() < 1e-9 && found > own, "{wider:?}");
        }
    }
}

#[test]
fn what_a_reference_steps_over_is_the_delay_that_it_misses() {
    // A hump on the way that is far narrower than a Taylor step. A particle with v = 1 is late by ∫V dx = 0.05 √π 1e-3.
    let text = r#"
        potential = { coordinates = ["x"], formula = "0.05*exp(-((x-1.0123)/1e-3)^2)" }
        particle.law = "newtonian"
        initial = { x = 0.0, x_dot = 1.0 }
        grid = { gamma_f = 2.0, n_gamma = 24 }
        scheme = { sbp = "GLL24", form = "weak" }
    "#;
    let line = text_solved(text);
    let late = 0.05e-3 * std::f64::consts::PI.sqrt() / 2.0;
    let found = against_reference(&line).stepped_over;
    assert!((1.0..2.0).contains(&(found / late)), "{found:e} for {late:e}");
}

/// In the lift of Newton's law the nodes leave this of ẍ = −ṫ² ∂V/∂x / m, with D from the operator.
#[test]
fn what_the_equations_leave_is_an_acceleration_whatever_the_mass() {
    let masses = "particle={law='newtonian',masses={x=2.0,y=0.5}}";
    for (set, mass) in [
        (&[] as &[&str], [2.0, 2.0]),
        (&["scheme.sbp='SBP42'"], [2.0, 2.0]),
        (&[masses, "scheme.sbp='SBP42'"], [2.0, 0.5]),
    ] {
        let line = run(set);
        let found = measured(&line);
        let [x, y]: [Vec<f64>; 2] = [1, 2].map(|a| line.q(a).collect());
        let slope = |row: &[f64]| (0..row.len()).map(|k| line.sbp().derivative_at(row, k)).collect::<Vec<f64>>();
        let forces = |k: usize| [2.0 * x[k] + 2.0 * x[k] * y[k] / 3.0, 4.0 * y[k] + x[k] * x[k] / 3.0];
        let mut largest = 0.0_f64;
        for (place, row) in [&x, &y].into_iter().enumerate() {
            let second = slope(&slope(row));
            for (k, (&left, second)) in found.delta_g[place + 1].iter().zip(&second).enumerate() {
                let wanted = second + 9.0 * forces(k)[place] / mass[place];
                assert!((left - wanted).abs() < 1e-9, "{set:?}, {place}, node {k}: {left} for {wanted}");
                largest = largest.max(wanted.abs());
            }
        }
        assert!(largest > 1e-3, "at the last nodes they are no equations: {largest}");
    }
}

#[test]
fn coordinates_share_a_size_if_they_have_one_unit() {
    let shared = |masses: &str| {
        let text = format!(
            "potential = {{ coordinates = [\"x\", \"y\"], formula = \"x^2 + y^2/100\" }}\n\
             particle = {{ law = \"newtonian\", masses = {{ {masses} }} }}\n\
             initial = {{ x = 0.1, y = 7.0, x_dot = 0.0, y_dot = 0.0 }}\n\
             grid = {{ gamma_f = 1.0, n_gamma = 41 }}\nscheme.sbp = \"SBP42\""
        );
        let line = text_solved(&text);
        let errors = facts_of_run(&line, &measured(&line), Some(&against_reference(&line)), None).errors.unwrap();
        ["x", "y"].map(|name| errors.iter().find(|error| error.name == name).unwrap().shared)
    };
    let [x, y] = shared("x = 2.0, y = 2.0");
    assert!((x - 7.0).abs() < 1e-9 && (y - 7.0).abs() < 1e-9, "{x} {y}");
    let [x, y] = shared("x = 2.0, y = 0.5");
    assert!((x - 0.1).abs() < 1e-9 && (y - 7.0).abs() < 1e-9, "{x} {y}");
}

/// K is 1/2, and so is what motion contributes to it; rounding of either is none.
#[test]
fn nothing_is_stepped_over_in_vain() {
    let text = "potential = { coordinates = ['x'], formula = '1e-30*x' }\n\
                initial = { x = 0.3, t_dot = 1.0, x_dot = 0.7071067811865476 }\n\
                grid = { gamma_f = 2.0, n_gamma = 41 }\nscheme.sbp = 'SBP42'\n";
    assert_eq!(against_reference(&text_solved(text)).stepped_over, 0.0);
}

/// A force changes K, which says nothing of what a reference steps over. It belongs to the multipliers of an action.
#[test]
fn a_force_is_part_of_the_certificate_and_not_of_what_is_stepped_over() {
    for scheme in ["{ sbp = 'SBP42' }", "{ sbp = 'SBP21' }", "{ sbp = 'SBP42', form = 'weak' }"] {
        let text = format!(
            "potential = {{ coordinates = [\"x\"], formula = \"x^2\", force = {{ x = \"-0.8*x_dot\" }} }}\n\
             particle = {{ law = \"newtonian\", mass = 2.0 }}\ninitial = {{ x = 1.0, t_dot = 1.0, x_dot = 0.5 }}\n\
             grid = {{ gamma_f = 4.0, n_gamma = 81 }}\nscheme = {scheme}"
        );
        let line = text_solved(&text);
        assert!((0.0..1e-11).contains(&line.gradient_norm), "{scheme}: {:e}", line.gradient_norm);
        let error = against_reference(&line);
        assert!(error.stepped_over == 0.0 && error.largest[1] > 1e-9 && error.largest[1] < 0.1, "{scheme}: {error:?}");
    }
    // A force without work in t changes K.
    let text = "metric.coordinates = ['t', 'x']\nmetric.components = { 't t' = '1', 'x x' = '-1' }\n\
                metric.force = { x = 'x_dot' }\ninitial = { t_dot = 2.0, x = 0.0, x_dot = 0.5 }\n\
                grid = { gamma_f = 1.0, n_gamma = 41 }\nscheme.sbp = 'SBP42'";
    let line = text_solved(text);
    assert!(measured(&line).norm.max_ends > 0.1 && against_reference(&line).stepped_over == 0.0);
}

#[test]
fn a_table_of_runs_has_what_is_measured_on_each() {
    let set = vec!["scheme={sbp='SBP42',form='strong'}".to_owned()];
    let runs = ManyRuns::new("test", MOTION, &set, Vec::new()).unwrap();
    let end = runs.outcome(&runs.case(0).unwrap()).unwrap();
    let line = run(&["scheme={sbp='SBP42',form='strong'}"]);
    let found = measured(&line);
    let energy = found.energy.as_ref().unwrap().delta.iter().fold(0.0, |most: f64, delta| most.max(delta.abs()));
    for (name, value) in [
        ("max_abs_delta_q_t_last", found.charges[0].max_last),
        ("max_abs_delta_q_s_corrected", found.charges[1].max_corrected),
        ("max_abs_delta_g_interior", found.max_delta_g),
        ("max_abs_delta_energy", energy),
        ("max_abs_delta_energy_ends", found.energy.as_ref().unwrap().max_ends),
        ("gradient_norm", line.gradient_norm),
    ] {
        let (_, text) = end.maxima.iter().find(|(other, _)| other == name).unwrap_or_else(|| panic!("{name}"));
        assert_eq!(text.parse::<f64>().unwrap(), value, "{name}");
    }
    assert_eq!(end.maxima.len(), 3 * 2 + 4);
}
