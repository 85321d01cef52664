//! Every shipped scene meets its expectations, and its charges are exact where the theory says so.

use geodesic_ivp::case::Case;
use geodesic_ivp::case::builtin::{self, Group, NAMES};
use geodesic_ivp::diagnostics::ChargeDeviation;
use geodesic_ivp::diagnostics::Diagnostics;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::{Settings, WorldLine, solve};

/// Rounding errors of a charge, relative to the sum of the magnitudes of its terms; 7e-17 was seen.
const ROUNDING: f64 = 5e-16;

fn scene(name: &str, settings: &[&str]) -> Case {
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    Case::parse(name, builtin::text(name).unwrap(), &settings).unwrap()
}

fn scenes() -> impl Iterator<Item = (&'static str, Case)> {
    let names = NAMES.iter().filter(|name| builtin::group(name).is_some_and(Group::is_scene));
    // Runs with events that act are chains of solves, which `check --run` compares.
    names.map(|&name| (name, scene(name, &[]))).filter(|(_, case)| !case.has_acting_events())
}

fn solved(name: &str, case: &Case) -> WorldLine {
    solve(case.setup::<f64>()).unwrap_or_else(|failure| panic!("{name}: {failure}"))
}

/// Coordinate `name` at the end of a run.
fn end(line: &WorldLine, name: &str) -> f64 {
    line.end().q[line.geometry().names().iter().position(|other| other == name).unwrap()]
}

fn diagnostics(case: &Case, line: &WorldLine) -> Diagnostics {
    let start = &line.place.start;
    let sums = line.geometry().conserved_sums(start, || case.geometry());
    let terms: Vec<_> = sums.into_iter().map(|sum| sum.terms).collect();
    Diagnostics::of(line, &terms, &mut case.observables(), case.is_lifted())
}

/// The largest sum of the magnitudes of the terms of Σ c^a p_a = Σ c^a (g_ab D_kj q^b_j + A_a) at a node.
fn size(line: &WorldLine, charge: &ChargeDeviation) -> f64 {
    let (geometry, sbp) = (line.geometry(), line.sbp());
    let rows: Vec<Vec<f64>> = (0..geometry.dimension()).map(|a| line.q(a).collect()).collect();
    let mut largest = 0.0_f64;
    for (k, first) in (0..line.nodes()).map(|node| (node % sbp.points(), node - node % sbp.points())) {
        let q: Vec<f64> = rows.iter().map(|row| row[first + k]).collect();
        let one_form = geometry.momenta(&q, &vec![0.0; q.len()]);
        let mut sum: f64 = charge.terms.iter().map(|&(a, c)| (c * one_form[a]).abs()).sum();
        for (b, row) in rows.iter().enumerate() {
            // Ignorable coordinates are counted from the start of their window.
            let origin = if geometry.active().contains(&b) { 0.0 } else { row[first] };
            let mut slope = vec![0.0; q.len()];
            slope[b] = sbp.row(k).map(|(j, d)| (d * (row[first + j] - origin)).abs()).sum();
            let momenta = geometry.momenta(&q, &slope);
            sum += charge.terms.iter().map(|&(a, c)| (c * (momenta[a] - one_form[a])).abs()).sum::<f64>();
        }
        largest = largest.max(sum);
    }
    largest
}

#[test]
fn every_scene_meets_its_expectations() {
    let mut count = 0;
    for (name, case) in scenes() {
        let (line, expect) = (solved(name, &case), case.expect().unwrap_or_else(|| panic!("{name} has no [expect]")));
        let tolerance: f64 = case.value(expect.tolerance.as_ref().unwrap());
        assert!(tolerance <= 1e-10 && !expect.finals.is_empty(), "{name}");
        for (a, expected) in &expect.finals {
            let (found, expected) = (line.end().q[*a], case.value::<f64>(expected));
            let what = &line.geometry().names()[*a];
            assert!((found - expected).abs() <= tolerance, "{name}: {what} = {found}, expected {expected}");
        }
        count += 1;
    }
    assert!(count >= 25, "{count} scenes");
}

/// The doubled system has many more unknowns and is solved to fewer digits.
#[test]
fn the_doubled_system_has_the_same_world_lines() {
    let is_short = |case: &Case| {
        let Settings { n_gamma, windows, accuracy, .. } = case.settings();
        accuracy.is_none() && windows * n_gamma <= 640 && case.t_f::<f64>().is_none()
    };
    let short = scenes().filter(|(_, case)| is_short(case));
    let mut count = 0;
    for (name, limit) in short {
        let doubled = scene(name, &["solver.system=doubled"]);
        let [limit, doubled] = [&limit, &doubled].map(|case| solved(name, case));
        assert!(doubled.is_doubled() && doubled.branch_distance() < 1e-9, "{name}: {:e}", doubled.branch_distance());
        for (a, (one, two)) in limit.end().q.iter().zip(&doubled.end().q).enumerate() {
            assert!((one - two).abs() < 1e-9, "{name}: coordinate {a}, {one} and {two}");
        }
        count += 1;
    }
    assert!(count >= 8, "{count} scenes");
}

#[test]
fn thirty_digits_are_those_of_an_independent_program() {
    let case = scene("two-bodies", &["solver.digits=30"]);
    let line = solve(case.setup::<Extended>()).unwrap();
    let expected = ["10.00077734349101245021", "-1.184365796405131464447", "-0.2718780678649561785177"];
    for (found, expected) in line.end().q.iter().zip(expected) {
        let error = (*found - Extended::from_decimal(expected).unwrap()).abs().to_f64();
        assert!(error < 1e-20, "{expected} is missed by {error:e}");
    }
    let momenta = vec![(1, Extended::ONE), (2, Extended::ONE)];
    let diagnostics = Diagnostics::of(&line, &[momenta], &mut [], false);
    for charge in diagnostics.charges.iter().chain(&diagnostics.sums) {
        assert!(charge.max_interior.to_f64() < 1e-34, "{:?}: {:e}", charge.terms, charge.max_interior.to_f64());
    }
}

#[test]
fn charges_and_conserved_sums_are_exact_to_the_rounding_of_their_terms() {
    // Windows for an accuracy differ in length; what their charges are worth is tested elsewhere.
    for (name, case) in scenes().filter(|(_, case)| case.settings().accuracy.is_none()) {
        let line = solved(name, &case);
        let diagnostics = diagnostics(&case, &line);
        let ignorable = line.geometry().ignorable().count();
        assert_eq!(diagnostics.charges.len(), ignorable, "{name}");
        for charge in diagnostics.charges.iter().chain(&diagnostics.sums) {
            let (change, size) = (charge.max_interior, size(&line, charge));
            assert!(
                change <= ROUNDING * size,
                "{name}: {:?} changes by {change:e}, its terms are {size:e}",
                charge.terms
            );
            assert!(charge.max_corrected <= ROUNDING * size, "{name}: {:?} with its multiplier", charge.terms);
        }
    }
}

#[test]
fn the_sums_that_are_conserved_are_found() {
    for (name, expected) in
        [("two-bodies", 1), ("three-bodies", 2), ("pleiades", 2), ("kepler", 0), ("henon-heiles", 0)]
    {
        let case = scene(name, &[]);
        assert_eq!(diagnostics(&case, &solved(name, &case)).sums.len(), expected, "{name}");
    }
}

#[test]
fn a_damped_oscillator_loses_what_the_force_takes() {
    let case = scene("damped-oscillator", &[]);
    let line = solved("damped-oscillator", &case);
    let [balance] = diagnostics(&case, &line).work[..] else { panic!("the force acts on t alone") };
    assert_eq!(line.geometry().names()[balance.coordinate], "t");
    assert!(balance.defect.abs() < 1e-14, "{:e}", balance.defect);
    // x = exp(-t/10) (cos(w t) + sin(w t)/(10 w)), v = -exp(-t/10) sin(w t)/w.
    let w = 0.99_f64.sqrt();
    let (sin, cos) = (10.0 * w).sin_cos();
    let (x, v) = ((-1.0_f64).exp() * (cos + sin / (10.0 * w)), -(-1.0_f64).exp() * sin / w);
    let lost = (x * x + v * v - 1.0) / 2.0;
    assert!((balance.work - lost).abs() < 1e-13, "{} and {lost}", balance.work);
}

#[test]
fn invariants_that_are_no_charges_are_kept_as_well_as_the_scene_is_resolved() {
    for (name, at_most) in [
        ("kepler", 1e-11),
        ("kepler-eccentric", 1e-11),
        ("kerr-inclined", 1e-9),
        ("kerr-mino", 1e-11),
        ("kerr-photon", 1e-8),
    ] {
        let case = scene(name, &[]);
        let [(_, invariant)] = &diagnostics(&case, &solved(name, &case)).invariants[..] else { panic!("{name}") };
        let most = invariant.delta.iter().fold(0.0_f64, |most, delta| most.max(delta.abs()));
        assert!(most < at_most, "{name}: {most:e}");
    }
}

/// Runs a scene with other settings and compares its end.
fn ends_at(name: &str, settings: &[&str], expected: &[(&str, f64)], tolerance: f64) {
    let line = solved(name, &scene(name, settings));
    for (what, value) in expected {
        let found = end(&line, what);
        assert!((found - value).abs() < tolerance, "{name} {settings:?}: {what} = {found}, expected {value}");
    }
}

#[test]
fn published_numbers_are_met() {
    // The proper time of a fall from rest at r = 10 to the horizon.
    let horizon = ["grid={gamma_f=33.700869851892335, windows=24}"];
    ends_at("schwarzschild-plunge", &horizon, &[("r", 2.0)], 1e-12);
    // Rays meet again behind the middle of the fish-eye.
    ends_at("fish-eye", &["grid.gamma_f=pi"], &[("x", -0.3 / 0.25), ("y", -0.4 / 0.25)], 1e-12);
    // Half of the angle from one closest approach to the next.
    let apoapsis = ["grid={gamma_f=400.0, until='r_dot', windows=60}"];
    ends_at("schwarzschild-orbit", &apoapsis, &[("r", 20.0), ("phi", 10.05516801017532 / 2.0)], 1e-8);
    // A periodic orbit without rotation, closed after two radial periods.
    let periodic = [
        "metric.parameters={a=0.0}",
        "initial={r=16.10951922293899, p_t=0.962903137831754211, p_phi=-3.9, r_dot=0.0}",
        "grid.gamma_f=659.87971966032057",
    ];
    ends_at("kerr-periodic", &periodic, &[("r", 16.10951922293899)], 1e-9);
    let turns = end(&solved("kerr-periodic", &scene("kerr-periodic", &periodic)), "phi") / std::f64::consts::TAU;
    assert!((turns - turns.round()).abs() < 1e-10, "{turns} turns");
    // The innermost stable circular orbits.
    for (a, r) in [(0.0_f64, 6.0_f64), (0.9, 2.320883041761887), (-0.9, 8.717352279606489)] {
        let root = (1.0 - 3.0 / r + 2.0 * a * r.powf(-1.5)).sqrt();
        let energy = (1.0 - 2.0 / r + a * r.powf(-1.5)) / root;
        let momentum = r.sqrt() * (1.0 - 2.0 * a * r.powf(-1.5) + a * a / (r * r)) / root;
        assert!((energy - (1.0 - 2.0 / (3.0 * r)).sqrt()).abs() < 1e-14);
        let settings = [
            format!("metric.parameters={{a={a:?}}}"),
            format!("initial={{r={r:?}, p_t={energy:?}, p_phi={:?}, r_dot=0.0}}", -momentum),
            "grid={gamma_f=100.0, windows=40}".to_owned(),
        ];
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        ends_at("kerr-periodic", &settings, &[("r", r)], 1e-9);
    }
}
