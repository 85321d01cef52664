//! The estimate of memory grows with everything that is asked for as the rows do that have to be kept.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::solve::{Setup, bytes_needed};

use crate::common::shipped;

/// A number in `f64` and in extended precision.
const NUMBER: f64 = 8.0;
const EXTENDED: f64 = 32.0;

fn near(found: f64, wanted: f64) -> bool {
    (found - wanted).abs() < 1e-6 * wanted.abs()
}

fn setup<S: Real>(name: &str, n: u32, windows: u32, rest: &str) -> Setup<S> {
    let grid = [format!("grid.n_gamma={n}"), format!("grid.windows={windows}")];
    shipped(name, &grid.iter().map(String::as_str).chain(rest.split_whitespace()).collect::<Vec<_>>()).setup()
}

#[test]
fn of_nodes_windows_and_samples() {
    for name in ["quartic", "henon-heiles", "two-bodies"] {
        let strong = "scheme={sbp='SBP21',form='strong'}";
        let coordinates = setup::<f64>(name, 100, 1, strong).place.start.q.len() as f64;
        let bytes = |n, windows, samples| bytes_needed(&setup::<f64>(name, n, windows, strong), false, samples);
        let small = bytes(100, 1, 0);
        // The program itself comes on top, and windows have their own nodes unless a few are kept at a time.
        assert!((1e6..2e7).contains(&small), "{small}");
        assert_eq!(bytes_needed(&setup::<f64>(name, 100, 1001, strong), true, 0), bytes(100, 6, 0));
        assert_eq!(bytes_needed(&setup::<f64>(name, 1000, 1001, strong), true, 0), bytes(1000, 1, 0));
        // There are the value, its derivative, the momentum and residuals of every coordinate, and rows of the metric.
        let of_nodes = (bytes(100_100, 1, 0) - small) / 1e5 / NUMBER;
        assert!((5.0..30.0).contains(&(of_nodes / coordinates)), "{name}: {of_nodes}");
        // 1000 more windows of 100 nodes have their ends, multipliers and measures besides.
        let of_windows = (bytes(100, 1001, 0) - small) / 1e3 / NUMBER - 100.0 * of_nodes;
        assert!((10.0..100.0).contains(&(of_windows / coordinates)), "{name}: {of_windows}");
        // γ and lists of q, dq/dγ and p of a sample.
        let of_samples = (bytes(100, 1, 1000) - small) / 1e3;
        let least = (1.0 + 3.0 * coordinates) * NUMBER;
        assert!(of_samples > least && of_samples < 3.0 * least, "{name}: {of_samples}");
        let wide = |n| bytes_needed(&setup::<Extended>(name, n, 1, strong), false, 0);
        assert!(near((wide(100_100) - wide(100)) / 1e5, of_nodes * EXTENDED), "{name}");
        // What is added by a sample and by a node does not depend on the others.
        let both = bytes(100_100, 1, 1000) - small;
        assert!(near(both, 1e5 * of_nodes * NUMBER + 1e3 * of_samples), "{name}");
    }
}

/// A recursion has no linear system. A banded one has at least as many diagonals as the stencil, and fields by fields
/// in blocks for each.
#[test]
fn of_linear_systems() {
    for name in ["quartic", "henon-heiles", "two-bodies"] {
        let of_nodes = |rest: &str| {
            let of = |n| bytes_needed(&setup::<f64>(name, n, 1, rest), false, 0);
            (of(100_100) - of(100)) / 1e5 / NUMBER
        };
        let strong = of_nodes("scheme={sbp='SBP21',form='strong'}");
        let block = 4.0 * (setup::<f64>(name, 100, 1, "scheme.sbp=SBP21").place.geometry.active().len() as f64).powi(2);
        for (rest, order) in [
            ("scheme={sbp='SBP21',form='weak'}", 2.0),
            ("scheme={sbp='SBP42',form='strong'}", 4.0),
            ("scheme={sbp='SBP63',form='strong'}", 6.0),
            ("scheme={sbp='SBP84',form='weak'}", 8.0),
        ] {
            let banded = of_nodes(rest) - strong;
            assert!((0.5..25.0).contains(&(banded / order / block)), "{name} {rest}: {banded}");
            let doubled = of_nodes(&format!("{rest} solver.system=doubled")) - strong;
            let least = if name == "quartic" { 10.0 } else { 2.0 };
            assert!((least..100.0).contains(&(doubled / banded)), "{name} {rest}: {doubled} and {banded}");
        }
    }
}
