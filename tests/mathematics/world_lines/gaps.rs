//! What hides between the nodes of a run on a given grid is found, and what the nodes follow is no reason to doubt it.

use geodesic_ivp::case::{Case, builtin};
use geodesic_ivp::diagnostics::gaps::Gaps;
use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve;
use geodesic_ivp::solve::WorldLine;

use crate::common::{parsed, shipped};
use crate::random_scenes::random::Random;

/// Grids of about a hundred nodes: operator, form, nodes of a window, windows.
const GRIDS: [(&str, &str, usize, usize); 7] = [
    ("SBP21", "strong", 65, 1),
    ("SBP42", "weak", 100, 1),
    ("SBP63", "strong", 40, 3),
    ("SBP84", "weak", 80, 1),
    ("GLL8", "weak", 8, 12),
    ("GLL16", "strong", 16, 6),
    ("GLL32", "weak", 32, 4),
];

/// This is known of the error of a run, which may itself come from a solve that has seen nothing.
const ERRORS: [Option<f64>; 4] = [None, Some(1e-15), Some(1e-6), Some(2.0)];

fn grid((sbp, form, nodes, windows): (&str, &str, usize, usize)) -> String {
    format!(
        "grid = {{ gamma_f = 64.0, n_gamma = {nodes}, windows = {windows} }}\n\
         scheme = {{ sbp = \"{sbp}\", form = \"{form}\" }}\nparticle.c = 3.0\n"
    )
}

/// V = height exp(−(d/width)²) on the line, where d is the distance from `place`.
fn on_a_line(height: f64, width: f64, place: f64, [x, x_dot]: [f64; 2], grid: &str) -> Case {
    let text = format!(
        "potential.formula.expression = \"{height:?}*exp(-((x-({place:?}))/{width:?})^2)\"\n\
         initial = {{ t = 0.0, x = {x:?}, t_dot = 1.0, x_dot = {x_dot:?} }}\n{grid}"
    );
    parsed(&text, &[])
}

fn gaps_of<S: Real>(case: &Case, error: Option<f64>) -> Option<Gaps> {
    let line: WorldLine<S> = solve(case).ok()?;
    Some(Gaps::new(&line, &case.geometry(), error))
}

/// A ridge or a bump of this height and width across the way in x, or in x and y, on a grid; and its place in x.
fn barrier(random: &mut Random, is_of_x: bool, is_bump: bool, grid: &str) -> (Case, f64, f64) {
    let (width, height) = (random.scale(1e-6, 0.05), random.between(-3.0, 5.0));
    // Away from the ends of the run by more than its width.
    let (way, x_dot) = (1.0 + 60.0 * random.between(0.0, 1.0), random.between(0.3, 0.9));
    if is_of_x {
        let place = x_dot * way - 0.6;
        return (on_a_line(height, width, place, [-0.6, x_dot], grid), place, width);
    }
    let (angle, y, tilt) = (random.between(-0.7, 0.7), random.between(-0.5, 0.5), random.between(-0.8, 0.8));
    let [vx, vy] = [0.6 * angle.cos(), 0.6 * angle.sin()];
    let [a, b] = [-0.6 + way * vx, y + way * vy];
    let square = match is_bump {
        false => format!("({:?}*(x-({a:?}))+({:?})*(y-({b:?})))^2", tilt.cos(), tilt.sin()),
        true => format!("(x-({a:?}))^2+(y-({b:?}))^2"),
    };
    let text = format!(
        "potential = {{ coordinates = [\"x\", \"y\"], formula = \"{height:?}*exp(-({square})/{width:?}^2)\" }}\n\
         initial = {{ x = -0.6, y = {y:?}, t_dot = 1.0, x_dot = {vx:?}, y_dot = {vy:?} }}\n{grid}"
    );
    (parsed(&text, &[]), a, width)
}

#[test]
fn barriers_between_the_nodes_are_found() {
    let (mut random, mut found) = (Random(0x51_7cc1_b727_220a), 0);
    for run in 0..350 {
        let grid = grid(GRIDS[run % GRIDS.len()]);
        let (case, place, width) = barrier(&mut random, run < 210, run % 2 == 1, &grid);
        // A node in the barrier may leave no solution.
        let Ok(line): Result<WorldLine, _> = solve(&case) else { continue };
        let passes = line.end().q[1] > place;
        for error in ERRORS {
            let gaps = Gaps::new(&line, &case.geometry(), error);
            assert_eq!(gaps.count, line.nodes() - line.windows.len());
            assert!(gaps.unresolved > 0, "{}: {gaps:?}", case.to_toml());
            let first = gaps.first.unwrap();
            let names: Vec<&str> = first.coordinates.iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(names[..], ["t", "x", "y"][..if run < 210 { 2 } else { 3 }]);
            assert!(first.gamma[0] < first.gamma[1]);
            if run < 210 && passes && gaps.unresolved == 1 {
                let [from, to] = first.coordinates[1].1;
                assert!(from - width < place && place < to + width, "{place}: {first:?}");
            }
        }
        found += 1;
    }
    assert!(found > 290, "{found}");
}

/// The smooth cases, many of them on grids as coarse as they can be, and the hard ones.
#[test]
fn nothing_hides_in_the_shipped_cases() {
    let mut looked_at = 0;
    for name in builtin::NAMES.iter() {
        let case = shipped(name, &[]);
        // Three million nodes.
        if case.settings.accuracy.is_some() || *name == "long-run" {
            continue;
        }
        let found = match case.settings.is_extended() {
            true => gaps_of::<Extended>(&case, Some(1e-12)),
            false => gaps_of::<f64>(&case, Some(1e-12)),
        };
        // Two of them have no solution.
        let Some(gaps) = found else { continue };
        assert!(gaps.unresolved == 0 && gaps.first.is_none() && gaps.reason().is_none(), "{name}: {gaps:?}");
        assert!(gaps.count > 30, "{name}");
        looked_at += 1;
    }
    assert!(looked_at >= 45, "{looked_at}");
}

/// A hill that is four times as wide as the distance of the nodes, and its tails, which change by many orders of
/// magnitude.
#[test]
fn a_hill_that_the_nodes_follow_is_no_reason_to_doubt() {
    for grid in
        [("SBP42", "strong", 401, 1), ("SBP84", "weak", 401, 1), ("GLL16", "weak", 16, 40), ("GLL32", "strong", 32, 20)]
    {
        for (height, width) in [(0.02, 0.4), (-0.05, 0.5), (3.0, 0.7)] {
            let case = on_a_line(height, width, 5.0, [-0.6, 0.6], &self::grid(grid));
            for error in [None, Some(1e-10), Some(1e-3)] {
                let gaps = gaps_of::<f64>(&case, error).unwrap();
                assert_eq!(gaps.unresolved, 0, "{grid:?} {height} {width}: {gaps:?}");
            }
        }
    }
}

/// In more than 16 digits the formulas are enclosed in double precision.
#[test]
fn a_barrier_is_found_in_any_precision_and_system() {
    let grid = grid(("SBP42", "strong", 65, 1));
    for setting in ["solver.digits=30", "solver.system=\"doubled\""] {
        let place = 2.3;
        let text = on_a_line(5.0, 1e-3, place, [-0.6, 0.6], &grid).to_toml();
        let case = parsed(&text, &[setting]);
        let gaps = match case.settings.is_extended() {
            true => gaps_of::<Extended>(&case, None),
            false => gaps_of::<f64>(&case, None),
        };
        assert_eq!(gaps.unwrap().unresolved, 1, "{setting}");
    }
    let text = format!(
        "potential = {{ coordinates = [\"x\", \"y\"], formula = \"exp(-((x-2.3)/1e-3)^2)\" }}\n\
         initial = {{ x = -0.6, y = 0.0, t_dot = 1.0, x_dot = 0.6, y_dot = 0.1 }}\nsolver.system = \"doubled\"\n{grid}"
    );
    let case = parsed(&text, &[]);
    assert_eq!(gaps_of::<f64>(&case, None).unwrap().unresolved, 1);
}

/// The largest height at which a feature is explained, where every height above is too large.
fn critical(unresolved: impl Fn(f64) -> usize) -> f64 {
    let (mut below, mut above) = (1e-24_f64, 1e3_f64);
    assert!(unresolved(below) == 0 && unresolved(above) > 0);
    while above > 1.001 * below {
        let height = (below * above).sqrt();
        if unresolved(height) == 0 { below = height } else { above = height }
    }
    below
}

/// A push at a place moves what comes after it by the force, times how long it acts, times the way that is left.
#[test]
fn what_may_hide_counts_with_the_length_of_its_gap_and_of_the_run() {
    let explained = |length: f64, nodes: usize, x_dot: f64, error: f64| {
        let grid = format!(
            "grid = {{ gamma_f = {length:?}, n_gamma = {nodes} }}\nscheme = {{ sbp = \"SBP42\" }}\nparticle.c = 3.0\n"
        );
        // Two fifths behind the seventh node.
        let place = x_dot * length * 7.4 / (nodes - 1) as f64 - 0.6;
        critical(|height| {
            let case = on_a_line(height, 1e-5, place, [-0.6, x_dot], &grid);
            gaps_of::<f64>(&case, Some(error)).map_or(1, |gaps| gaps.unresolved)
        })
    };
    let first = explained(64.0, 65, 0.01, 1e-6);
    for (what, other, factor) in [
        ("a larger error", explained(64.0, 65, 0.01, 1e-4), 100.0),
        ("a shorter run", explained(16.0, 17, 0.01, 1e-6), 4.0),
        ("shorter gaps", explained(16.0, 65, 0.04, 1e-6), 16.0),
    ] {
        assert!((other / first / factor - 1.0).abs() < 0.05, "{what}: {other:e} and {first:e}");
    }
}

/// As much is explained of the same motion in other units.
#[test]
fn what_may_hide_in_a_scene_counts_in_the_units_of_its_coordinates() {
    // `mass` scales V and with it p, `shift` the size of x, of which an error is a share, and `unit` all lengths.
    let explained = |mass: f64, shift: f64, t: f64, unit: f64| {
        critical(|height| {
            let text = format!(
                "potential = {{ coordinates = [\"x\", \"y\"], \
                 formula = \"{:?}*exp(-((x-({:?}))/{:?})^2)\" }}\n\
                 particle = {{ law = \"newtonian\", mass = {mass:?} }}\n\
                 initial = {{ t = {t:?}, x = {:?}, y = 0.0, x_dot = {:?}, y_dot = {:?} }}\n\
                 grid = {{ gamma_f = 64.0, n_gamma = 65 }}\nscheme.sbp = \"SBP42\"\n",
                unit * unit * mass * height,
                unit * (shift + 0.074),
                unit * 1e-5,
                unit * shift,
                unit * 0.01,
                unit * 0.001
            );
            let case = parsed(&text, &[]);
            gaps_of::<f64>(&case, Some(1e-6)).map_or(1, |gaps| gaps.unresolved)
        })
    };
    let first = explained(1.0, 0.0, 0.0, 1.0);
    for (what, other, factor) in [
        ("a mass", explained(4.0, 0.0, 0.0, 1.0), 1.0),
        ("a coordinate of 1000 in place of 0.64", explained(1.0, 1000.0, 0.0, 1.0), 1000.0 / 0.64),
        ("a late start", explained(1.0, 0.0, 1e6, 1.0), 1.0),
        ("a small unit", explained(1.0, 0.0, 0.0, 1e-9), 1.0),
        ("a large unit", explained(1.0, 0.0, 0.0, 1e9), 1.0),
    ] {
        assert!((other / first / factor - 1.0).abs() < 0.05, "{what}: {other:e} and {first:e}");
    }
}

/// x = cos(γ − 0.3) turns at 1 between nodes at 0.995, and no node comes as far as the hump.
#[test]
fn what_hides_beyond_the_nodes_where_a_path_turns_is_found() {
    let start = "t = 0.0, t_dot = 1.0, x = 0.955336489125606, x_dot = 0.29552020666134";
    let rest = "particle.c = 100.0\ngrid = { gamma_f = 4.0, n_gamma = 21 }\nscheme.sbp = \"SBP42\"";
    let formula = "x^2/2 + 0.01*exp(-((x-0.9985)/1e-4)^2)";
    for (potential, more) in [
        (format!("potential.formula.expression = \"{formula}\""), ""),
        (
            format!("potential = {{ coordinates = ['x', 'y'], formula = '{formula} + y^2/2' }}"),
            ", y = 0.0, y_dot = 0.1",
        ),
    ] {
        let case = parsed(&format!("{potential}\ninitial = {{ {start}{more} }}\n{rest}"), &[]);
        let gaps = gaps_of::<f64>(&case, Some(1e-6)).unwrap();
        let first = gaps.first.as_ref().unwrap_or_else(|| panic!("{gaps:?}"));
        assert!(gaps.unresolved == 1 && (first.gamma[0] - 0.2).abs() < 1e-12, "{gaps:?}");
        assert!(first.coordinates[1].1.iter().all(|x| (0.99..0.9965).contains(x)), "{gaps:?}");
    }
}

/// What hides does not hang on the order of the coordinates, nor on the origin of those that nothing depends on.
#[test]
fn the_order_of_coordinates_and_origins_do_not_count() {
    // A metric that couples velocities, with a ridge between two nodes.
    let component = |pair: &str, height: f64| match pair {
        "t t" => format!("9 + {height:?}*exp(-((x-0.074)/1e-5)^2)"),
        "x x" => "-1 - y^2/4".to_owned(),
        "y y" => "-1 - x^2/3".to_owned(),
        _ => "x*y/5".to_owned(),
    };
    let explained = |order: [&str; 3], t: f64| {
        critical(|height| {
            let names = order.map(|name| format!("\"{name}\"")).join(", ");
            let metric =
                ["t t", "x x", "y y", "x y"].map(|pair| format!("\"{pair}\" = \"{}\"", component(pair, height)));
            let text = format!(
                "metric = {{ coordinates = [{names}], components = {{ {} }} }}\n\
                 initial = {{ t = {t:?}, x = 0.0, y = 0.3, t_dot = 1.0, x_dot = 0.01, y_dot = 0.001 }}\n\
                 grid = {{ gamma_f = 64.0, n_gamma = 65 }}\nscheme.sbp = \"SBP42\"\n",
                metric.join(", ")
            );
            let case = parsed(&text, &[]);
            gaps_of::<f64>(&case, Some(1e-6)).map_or(1, |gaps| gaps.unresolved)
        })
    };
    let first = explained(["t", "x", "y"], 0.0);
    let other = explained(["y", "t", "x"], 1e6);
    assert!((other / first - 1.0).abs() < 0.05, "{other:e} and {first:e}");
}
