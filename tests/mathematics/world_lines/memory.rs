//! The estimate of memory grows with everything that is asked for as the rows do that have to be kept.

use geodesic_ivp::number::Extended;
use geodesic_ivp::solve::Arithmetic;
use geodesic_ivp::solve::{Setup, bytes_needed};

use crate::common::{case, shipped};

/// A number in `f64` and in extended precision.
const NUMBER: f64 = 8.0;
const EXTENDED: f64 = 32.0;

fn near(found: f64, wanted: f64) -> bool {
    (found - wanted).abs() < 1e-6 * wanted.abs()
}

#[test]
fn of_one_coordinate() {
    let bytes = |set: &str, one_window, samples| bytes_needed(&Setup::<f64>::from(&case(set)), one_window, samples);
    let grid = |n: u32, windows: u32, rest: &str| format!("grid.n_gamma={n} grid.windows={windows} {rest}");
    let small = bytes(&grid(100, 1, ""), false, 0);
    // γ, t, x, charges and residuals of a node; γ and lists of q, dq/dγ and p of a sample.
    let of_nodes = bytes(&grid(100_100, 1, ""), false, 0) - small;
    assert!((10.0..30.0).contains(&(of_nodes / 1e5 / NUMBER)), "{of_nodes}");
    let of_samples = bytes(&grid(100, 1, ""), false, 100_000) - small;
    assert!((10.0..20.0).contains(&(of_samples / 1e5 / NUMBER)), "{of_samples}");
    // The program itself comes on top, and windows have their own nodes unless one is kept at a time.
    assert!((1e6..2e7).contains(&small), "{small}");
    // 1000 more windows of 100 nodes have their ends, multipliers and measures besides.
    let of_windows = bytes(&grid(100, 1001, ""), false, 0) - small - of_nodes;
    assert!((20.0..100.0).contains(&(of_windows / 1e3 / NUMBER)), "{of_windows}");
    assert_eq!(bytes(&grid(100, 1001, ""), true, 0), small);
    let wide = bytes_needed(&Setup::<Extended>::from(&case(&grid(100_100, 1, ""))), false, 0)
        - bytes_needed(&Setup::<Extended>::from(&case(&grid(100, 1, ""))), false, 0);
    assert!(near(wide, of_nodes * EXTENDED / NUMBER), "{wide}");
    // A recursion has no linear system. A banded one has at least as many diagonals as the stencil, in blocks of 2 × 2.
    let system =
        |rest: &str| bytes(&grid(100_100, 1, rest), false, 0) - bytes(&grid(100, 1, rest), false, 0) - of_nodes;
    assert_eq!(system("scheme.form=strong"), 0.0);
    for (rest, order) in [
        ("scheme.form=weak", 2.0),
        ("scheme.sbp=SBP42", 4.0),
        ("scheme.sbp=SBP63", 6.0),
        ("scheme.sbp=SBP84 scheme.form=weak", 8.0),
    ] {
        let banded = system(rest) / 1e5;
        assert!(banded > 2.0 * order * NUMBER && banded < 30.0 * order * NUMBER, "{rest}: {banded}");
        let doubled = system(&format!("{rest} solver.system=doubled")) / 1e5;
        assert!(doubled > 10.0 * banded && doubled < 100.0 * banded, "{rest}: {doubled} and {banded}");
    }
}

#[test]
fn of_scenes() {
    fn setup<S: Arithmetic>(name: &str, n: u32, windows: u32, rest: &str) -> Setup<S> {
        shipped(name, &[&format!("grid.n_gamma={n}"), &format!("grid.windows={windows}"), rest]).setup()
    }
    for name in ["henon-heiles", "two-bodies"] {
        let strong = "scheme={sbp='SBP21',form='strong'}";
        let coordinates = setup::<f64>(name, 100, 1, strong).place.start.q.len() as f64;
        let bytes = |n, windows, samples| bytes_needed(&setup::<f64>(name, n, windows, strong), false, samples);
        let small = bytes(100, 1, 0);
        assert!((1e6..2e7).contains(&small), "{small}");
        // There are the value, its derivative, the momentum and residuals of every coordinate, and rows of the metric.
        let of_nodes = (bytes(100_100, 1, 0) - small) / 1e5 / NUMBER;
        assert!((5.0..30.0).contains(&(of_nodes / coordinates)), "{name}: {of_nodes}");
        let of_windows = (bytes(100, 1001, 0) - small) / 1e3 / NUMBER - 100.0 * of_nodes;
        assert!((10.0..100.0).contains(&(of_windows / coordinates)), "{name}: {of_windows}");
        let of_samples = (bytes(100, 1, 1000) - small) / 1e3;
        assert!(of_samples > (1.0 + 3.0 * coordinates) * NUMBER, "{name}: {of_samples}");
        assert!(of_samples < 3.0 * (1.0 + 3.0 * coordinates) * NUMBER, "{name}: {of_samples}");
        let wide = |n| bytes_needed(&setup::<Extended>(name, n, 1, strong), false, 0);
        assert!(near((wide(100_100) - wide(100)) / 1e5, of_nodes * EXTENDED), "{name}");
        // What is added by a sample and by a node does not depend on the others.
        let both = bytes(100_100, 1, 1000) - small;
        assert!(near(both, 1e5 * of_nodes * NUMBER + 1e3 * of_samples), "{name}");
        // Fields by fields in blocks, for each diagonal.
        let active = setup::<f64>(name, 100, 1, strong).place.geometry.active().len() as f64;
        let weak = |n| bytes_needed(&setup::<f64>(name, n, 1, "scheme={sbp='SBP42',form='weak'}"), false, 0);
        let banded = (weak(100_100) - weak(100)) / 1e5 / NUMBER - of_nodes;
        assert!((2.0..100.0).contains(&(banded / (4.0 * active * active))), "{name}: {banded}");
    }
}
