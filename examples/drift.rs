//! The drift of K over a million units of γ: quartic base case, 20 nodes, 4·10⁶ windows of ¼, to rounding.
//!
//! ```text
//! cargo run --release --example drift [windows]
//! ```

use std::ops::ControlFlow;
use std::time::Instant;

use geodesic_ivp::engine::lobatto::{March, MarchFailure, State, Twofold, WeakRule, WindowView};
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::Potential;

/// K − K_i in double-double, Q_t = 2, V = x⁴/2.
fn delta_k(state: &State) -> f64 {
    let square = state.x * state.x;
    let k = Twofold::from(4.0) / (square * square + Twofold::ONE) - state.w * state.w;
    (k - (Twofold::from(2.0) - Twofold::from(0.1) * Twofold::from(0.1))).hi
}

fn main() -> Result<(), MarchFailure> {
    let windows = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(4_000_000_usize);
    let metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
    let rule = WeakRule::new(20);
    let start = State { t: 0.0.into(), x: 1.0.into(), w: 0.1.into() };
    let mut worst = 0.0_f64;
    let mut see = |view: &WindowView<'_>| {
        let delta = delta_k(&view.end);
        worst = worst.max(delta.abs());
        if (view.index + 1).is_multiple_of((windows / 8).max(1)) {
            println!("gamma {:>9}: dK {delta:+.2e}", view.gamma.hi + 0.25);
        }
        ControlFlow::Continue(())
    };
    let begun = Instant::now();
    let marched = March::new(&metric, 2.0, &rule, 0.25.into()).run(start, windows, &mut see)?;
    let seconds = begun.elapsed().as_secs_f64();
    let evaluations = marched.statistics.evaluations as f64 / windows as f64;
    println!("max |dK| over {windows} windows {worst:.2e}; {evaluations:.2} evaluations a window, {seconds:.2} s");
    Ok(())
}
