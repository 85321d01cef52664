//! The drift of K over a million units of γ: quartic base case, 4·10⁶ windows of 20 nodes and of length ¼, to rounding.
//! K itself is rounded to 4e-16.
//!
//! ```text
//! cargo run --release --example drift [windows]
//! ```

use std::ops::ControlFlow;
use std::time::Instant;

use geodesic_ivp::engine::{Engine, Failure};
use geodesic_ivp::geometry::geodesic::InitialData;
use geodesic_ivp::geometry::metric::Metric;
use geodesic_ivp::geometry::potential::Potential;

fn main() -> Result<(), Failure> {
    let windows = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(4_000_000_usize);
    let metric = Metric::new(Potential::quartic(0.5), 1.0, 1.0);
    let initial = InitialData { t: 0.0, x: 1.0, t_dot: 1.0, x_dot: 0.1 };
    let (start, constants) = (initial.start(&metric), initial.invariants(&metric));
    let mut engine =
        Engine::equal(metric.scene(), &start, 0.25 * windows as f64, windows, 20).map_err(Failure::OutsideDomain)?;
    let (mut worst, begun) = (0.0_f64, Instant::now());
    engine.run(|window| {
        let (x, w) = (window.end().positions()[1], window.end().momenta()[0]);
        let delta = constants.q_t * constants.q_t / metric.g00(x) - w * w - constants.k;
        worst = worst.max(delta.abs());
        if (window.index + 1).is_multiple_of((windows / 8).max(1)) {
            println!("gamma {:>9}: dK {delta:+.2e}", window.gamma + window.length);
        }
        ControlFlow::Continue(())
    })?;
    let (sweeps, seconds) = (engine.sweeps() as f64 / windows as f64, begun.elapsed().as_secs_f64());
    println!("max |dK| over {windows} windows {worst:.2e}; {sweeps:.2} sweeps a window, {seconds:.2} s");
    Ok(())
}
