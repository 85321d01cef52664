//! What is measured in one coordinate: the bound, scales, the distance from Newton's mechanics, and warnings.

use geodesic_ivp::diagnostics::{Diagnostics, NEGLIGIBLE};

use crate::common::{case, g00, reference, solved};

fn measures(overrides: &str) -> Diagnostics {
    Diagnostics::new(&solved(overrides))
}

fn warnings(overrides: &str) -> String {
    let solution = solved(overrides);
    Diagnostics::new(&solution).warnings(&solution).join("\n")
}

/// V = 2x², so that ω = 2: a harmonic oscillation, as c is large.
const OSCILLATION: &str = "potential={formula={expression=\"2*x^2\"}} particle.c=1e4";

#[test]
fn a_motion_that_is_not_newtons_is_told_and_the_c_it_names_mends_it() {
    let trap = format!("grid={{t_f={},n_gamma=2001}}", std::f64::consts::TAU);
    for (formula, [t_dot, x, x_dot], c, grid) in [
        ("x^2/2-3", [2.0, 1.0, 0.6], 20.0, "grid.n_gamma=101"),
        ("0.3*x", [0.5, 1.0, 0.4], 20.0, "grid.n_gamma=101"),
        ("x^4-x", [1.5, 1.0, -1.0], 20.0, "grid.n_gamma=101"),
        ("x^2/2-1e6", [2.0, 1.0, 0.6], 3e3, "grid.n_gamma=101"),
        ("x^2/2", [1.0, 0.9, 0.0], 1.0, &trap),
    ] {
        let run = |c: f64| {
            solved(&format!(
                "potential={{formula={{expression=\"{formula}\"}}}} scheme.sbp=SBP42 {grid} particle.c={c:?} \
                 initial={{t=0.0,x={x:?},t_dot={t_dot:?},x_dot={x_dot:?}}}"
            ))
        };
        let solution = run(c);
        let found = Diagnostics::new(&solution).of_x.unwrap();
        let mended = found.c().unwrap();
        let better = run(mended);
        let deviation = Diagnostics::new(&better).of_x.unwrap().deviation;
        assert!((0.98..1.001).contains(&(deviation / NEGLIGIBLE)), "{formula}: {deviation:e} with c = {mended}");
        if grid == trap {
            let warning = found.newtonian_warning().unwrap();
            assert!(warning.contains("Newton") && warning.contains(&format!("particle.c = {mended} ")), "{warning}");
            assert_eq!(Diagnostics::new(&better).of_x.unwrap().newtonian_warning(), None);
            let ends = [&solution, &better].map(|line| line.end_state().x);
            assert!(
                (ends[0] - 0.5527).abs() < 1e-4 && (ends[1] - 0.9).abs() < 1e-5,
                "Newton's law gives 0.9: {ends:?}"
            );
        }
    }
    let free = measures("potential={free={}} initial.x_dot=0.9").of_x.unwrap();
    assert_eq!(free.deviation, 0.0, "free motion is Newton's, however fast");
}

#[test]
fn the_scales_of_an_oscillation_are_its_own() {
    // In γ its frequency is ω ṫ = 6, and its amplitude is 0.25 in any case.
    let grid = "grid={gamma_f=3.0,n_gamma=601} scheme.sbp=SBP42";
    let initial = "initial={t=0.0,x=0.0,t_dot=3.0,x_dot=1.5}";
    let scales = measures(&format!("{OSCILLATION} {initial} {grid}"));
    let (reach, scales) = (scales.reaches[1], scales.of_x.unwrap());
    for (got, want) in [
        (reach.least, -0.25),
        (reach.most, 0.25),
        (0.5 * (reach.most - reach.least), 0.25),
        (scales.x_dot, 1.5),
        (scales.omega, 6.0),
        (scales.step(), 6.0 * 3.0 / 600.0),
        (scales.g00, 1.0),
    ] {
        assert!((got / want - 1.0).abs() < 1e-3, "{got} for {want}: {scales:?}");
    }
}

#[test]
fn the_advice_on_the_step_is_enough_and_not_too_much() {
    let run = |n: usize| {
        let initial = "initial={t=0.0,x=0.0,t_dot=1.0,x_dot=1.0}";
        warnings(&format!("{OSCILLATION} {initial} grid={{gamma_f=20.0,n_gamma={n}}} scheme.sbp=SBP42"))
    };
    // Half of the limit 1.372 of SBP42, with ω = 2, is 58.3 intervals.
    assert!(!run(62).contains("half the limit"), "{}", run(62));
    let found = run(41);
    let factor = found.split("by a factor of ").nth(1).unwrap_or_else(|| panic!("{found}"));
    let factor: f64 = factor.split(' ').next().unwrap().parse().unwrap();
    assert!((factor - 20.0 * 2.0 / 40.0 / 0.686).abs() < 0.06, "{found}");
}

#[test]
fn a_horizon_is_near_where_g00_is_small() {
    // x = sin²θ at γ = θ + sin θ cos θ, where g00 = cos²θ.
    let fall = |root: f64| {
        let gamma_f = root.acos() + root * (1.0 - root * root).sqrt();
        let falls = "potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0";
        warnings(&format!("{falls} grid.gamma_f={gamma_f:?} solver.accuracy=1e-9"))
    };
    assert!(fall(0.09).contains("g00 falls to 8.1e-3 c^2") && fall(0.09).contains("near a horizon"), "{}", fall(0.09));
    assert_eq!(fall(0.11), "");
}

/// Numbers near 1e10 are 1.9e-6 apart.
#[test]
fn printed_numbers_are_told_only_where_they_spoil_the_accuracy() {
    let gamma = "grid={gamma_i=1e10,gamma_f=10000000001.0}";
    let time = "initial={t=1e10,x=1.0,t_dot=1.0,x_dot=0.1}";
    for (run, told) in [
        (format!("{gamma} solver.accuracy=1e-8"), "gamma is near 1.0e10"),
        (format!("{gamma} initial={{t=0.0,x=1.0,t_dot=1.0,x_dot=1e-3}} solver.accuracy=1e-8"), "it is slow"),
        (format!("{gamma} initial={{t=0.0,x=1e4,t_dot=1.0,x_dot=0.1}} solver.accuracy=1e-10"), "x is large"),
        (format!("{time} grid.gamma_f=1.0 solver.accuracy=1e-8"), "t is near 1.0e10"),
        (format!("{time} grid.gamma_f=1e4 solver.accuracy=1e-8"), "the run is long"),
        ("initial.t=1e3 solver.accuracy=1e-6".to_owned(), "the accuracy is low"),
        ("solver.accuracy=1e-12".to_owned(), "t is small"),
    ] {
        let found = warnings(&format!("potential={{linear={{alpha=1e-9}}}} {run}"));
        assert_eq!(found.contains("near 1.0e10"), told.contains("near"), "{run}: {told}, {found}");
        assert!(!told.contains("near") || found.contains(told), "{run}: {found}");
    }
}

#[test]
fn a_drift_of_k_counts_against_the_speed_in_every_unit() {
    // The same motion, ten times as fast in γ: K and ẋ² are a hundred times as large.
    for (n, drifts) in [(2001, true), (6001, false)] {
        let slow = format!("grid={{gamma_f=100.0,n_gamma={n}}}");
        let fast = format!("grid={{gamma_f=10.0,n_gamma={n}}} initial={{t=0.0,x=1.0,t_dot=10.0,x_dot=1.0}}");
        let [one, other] = [&slow, &fast].map(|overrides| measures(overrides));
        assert!((100.0 * one.norm.max_interior / other.norm.max_interior - 1.0).abs() < 1e-6, "{n}");
        let share = one.norm.max_interior / one.of_x.unwrap().x_dot.powi(2);
        assert_eq!(share > 0.1, drifts, "{n}: {share}");
        for overrides in [slow, fast] {
            assert_eq!(warnings(&overrides).contains("K drifts"), drifts, "{overrides}: {}", warnings(&overrides));
        }
        assert!(drifts || other.norm.max_interior > 0.2, "so that another size would be exceeded");
    }
}

#[test]
fn what_rests_needs_no_larger_c() {
    let rest = "potential={formula={expression=\"x^2/2-3\"}} particle.c=20.0 \
                initial={t=0.0,x=0.0,t_dot=1.0,x_dot=0.0} scheme.sbp=SBP42";
    let found = measures(rest).of_x.unwrap();
    assert!(found.c().is_none() && found.deviation == 0.0, "{found:?}");
}

#[test]
fn how_far_a_motion_is_from_newtons_is_told_in_per_cent() {
    // From rest at 0 with V = −x/2 and c = 1: g00 = 1 − x, and v²/g00 = g00 ẋ²/Q_t² = x at x, as K is 1.
    let falls = "potential={linear={alpha=-0.5}} initial.x=0.0 initial.x_dot=0.0 grid={gamma_f=1.0,n_gamma=41}";
    for scheme in ["", "scheme.sbp=SBP42", "scheme.sbp=SBP42 scheme.form=weak"] {
        let overrides = format!("{falls} {scheme}");
        let (solution, found) = (solved(&overrides), measures(&overrides));
        let (x, w) = (solution.end_state().x, solution.end_state().x_dot);
        let own = 2.0 * w * w * (1.0 - x);
        assert!(
            (found.of_x.unwrap().deviation / own - 1.0).abs() < 1e-6,
            "{scheme}: {:?} for {own}",
            found.of_x.unwrap()
        );
        assert!((own / (2.0 * x) - 1.0).abs() < 2e-3, "{scheme}: {own} at {x}");
        let warning = found.of_x.unwrap().newtonian_warning().unwrap();
        let percent: f64 = warning.split("up to ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((percent - 100.0 * own).abs() < 0.006, "{warning}");
    }
}

#[test]
fn windows_in_which_something_may_hide_are_told() {
    let mut solution = solved("");
    for (count, told) in [(None, false), (Some(0), false), (Some(3), true)] {
        solution.windows_unproved = count;
        let warnings = Diagnostics::new(&solution).warnings(&solution).join("\n");
        assert_eq!(warnings.contains("in 3 of the steps"), told, "{count:?}: {warnings}");
    }
}

#[test]
fn rounding_of_k_is_no_drift() {
    // K is 1e4, and the motion contributes 1e-12 to it.
    let slow = "potential={formula={expression=\"x^2/2\"}} particle.c=100.0 scheme.sbp=SBP42 \
                initial={t=0.0,x=1e-6,t_dot=1.0,x_dot=0.0} grid={gamma_f=6.0,n_gamma=201}";
    let found = measures(slow);
    assert!(found.norm.max_interior > 0.1 * found.of_x.unwrap().x_dot.powi(2), "{found:?}");
    assert!(!warnings(slow).contains("K drifts"), "{}", warnings(slow));
}

#[test]
fn warnings_name_what_is_wrong_and_leave_good_runs_alone() {
    for good in ["", "scheme.sbp=SBP42", "scheme.form=weak", "grid.gamma_f=100.0 grid.n_gamma=2001 scheme.sbp=SBP42"] {
        assert_eq!(warnings(good), "", "{good}");
    }
    let sawtooth = warnings("grid.gamma_f=100.0 grid.n_gamma=2001");
    assert!(
        sawtooth.contains("even and odd nodes are apart") && sawtooth.contains("K drifts by 4.63e-1"),
        "{sawtooth}"
    );
    assert!(warnings("grid.gamma_f=32.0 grid.n_gamma=65").contains("half the limit of SBP21"));
    let strong = Diagnostics::new(&solved("initial.x=1.5 grid.n_gamma=200"));
    assert!(
        strong.of_x.unwrap().newtonian_warning().is_some_and(|warning| warning.contains("not the motion of Newton"))
    );
    // The drift of a light particle with c = 10 is measured by the speed and not by K = 100.
    let slow = "potential={formula={expression=\"x^2/2\"}} particle.c=10.0 grid.gamma_f=100.0 grid.n_gamma=301";
    assert!(warnings(slow).contains("K drifts by"), "{}", warnings(slow));
    let spacelike = case("initial.x_dot=1.4142").warnings().join("\n");
    assert!(spacelike.contains("nearly spacelike: K = 3.8") && case("").warnings().is_empty(), "{spacelike}");
}

/// The exact form is one of the continuum; the grid comes to it.
#[test]
fn the_bound_is_kept_if_and_only_if_k_is_not_negative() {
    let bound = |overrides: &str| measures(overrides).of_x.unwrap();
    for (overrides, kept) in [("", true), ("initial.x_dot=1.4142", true), ("initial.x_dot=1.5", false)] {
        let [coarse, fine] = [101, 201].map(|n| bound(&format!("{overrides} scheme.sbp=SBP42 grid.n_gamma={n}")));
        assert!(coarse.is_kept() == kept && fine.is_kept() == kept, "{overrides}");
        let [coarse, fine] = [coarse.defect().abs(), fine.defect().abs()];
        assert!(fine < 1e-5 && fine < coarse / 6.0, "{overrides}: {coarse} {fine}");
    }
    let solution = solved("scheme.sbp=SBP42 grid.n_gamma=512");
    let fine = Diagnostics::new(&solution).of_x.unwrap();
    let exact = fine.h_bvp_bound - 0.5 * solution.norm();
    assert!(fine.h_bvp <= fine.h_bvp_bound && (fine.h_bvp - exact).abs() < 1e-6, "{fine:?} against {exact}");
    // It is that of the run and not of γ.
    let late = bound("grid={gamma_i=3.0,gamma_f=5.0,n_gamma=201} scheme.sbp=SBP42 initial.t=7.0");
    assert!(late.defect().abs() < 1e-5 && late.is_kept(), "{late:?}");
    assert!(bound("potential={free={}}").defect().abs() < 1e-14);
    let spacelike = bound("scheme.sbp=SBP42 potential={free={}} initial.x_dot=1.5");
    assert!(spacelike.h_bvp > spacelike.h_bvp_bound);
    // With K = 0 the bound is met, so that rounding alone may exceed it.
    for k in 0..20 {
        let speed = 1e4 * (1.0 + 0.0371 * f64::from(k));
        let null = format!("initial={{t=0.0,x=0.3,t_dot={speed},x_dot={speed}}} grid.n_gamma=60");
        assert!(bound(&format!("potential={{free={{}}}} {null}")).is_kept(), "{speed}");
    }
}

/// The acceleration that the world-line has with time as its parameter, by central differences of the reference.
#[test]
fn the_share_of_the_acceleration_is_the_one_derived() {
    let overrides = "grid.n_gamma=1001 scheme.sbp=SBP42";
    let (geometry, start) = (case(overrides).geometry(), case(overrides).start());
    let reference = reference(&geometry, &start, 1.0);
    let mut largest = 0.0_f64;
    for k in 0..=1000 {
        let gamma = f64::from(k) / 1000.0;
        let (here, h) = (reference.at(gamma), 1e-4);
        let velocity = |gamma: f64| {
            let point = reference.at(gamma.clamp(0.0, 1.0));
            (point.q_dot[1] / point.q_dot[0], point.q[0])
        };
        let ((v0, t0), (v1, t1)) = (velocity(gamma - h), velocity(gamma + h));
        // V′ = 2x³, and Newton's acceleration is −V′.
        let newton = -2.0 * here.q[1].powi(3);
        let share = 1.0 - (v1 - v0) / (t1 - t0) / newton;
        let derived = 2.0 * velocity(gamma).0.powi(2) / g00(&geometry, here.q[1]);
        if (1..1000).contains(&k) && newton.abs() > 0.05 {
            assert!((share - derived).abs() < 1e-5, "{share} and {derived} at {gamma}");
        }
        largest = largest.max(derived);
    }
    let found = Diagnostics::new(&solved(overrides)).of_x.unwrap().deviation;
    assert!((found / largest - 1.0).abs() < 1e-5, "{found} and {largest}");
}

/// Nothing depends on t, so that a start at another time ends at another time, and where it did.
#[test]
fn events_and_invariants_do_not_change_the_time_of_the_start() {
    let start = "initial={t=0.7,x=-0.271,t_dot=1.23,x_dot=-0.232} particle.c=3.0 grid={t_f=3.0} solver.accuracy=1e-10";
    let plain = solved(start);
    for with in ["events.e.when=x-5", "invariants.e=\"x\"", "plot={x=\"t\",y=\"x\"}", "grid.until=x-5"] {
        let other = solved(&format!("{start} {with}"));
        for a in 0..2 {
            let [one, two] = [&plain, &other].map(|line| line.end().q[a]);
            assert!((one - two).abs() < 1e-9, "{with}: {one} {two}");
        }
        assert_eq!(other.end().q[0], 3.0, "{with}");
    }
}
