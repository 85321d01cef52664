//! The drift of K over a million units of γ: quartic base case, 4·10⁶ windows of 20 nodes and of length ¼, to rounding.
//! K itself is rounded to 4e-16.
//!
//! ```text
//! cargo run --release --example drift [windows]
//! ```

use std::ops::ControlFlow;
use std::time::Instant;

use geodesic_ivp::Case;
use geodesic_ivp::case::builtin;
use geodesic_ivp::engine::Engine;
use geodesic_ivp::geometry::{Geometry, Start};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let windows = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(4_000_000_usize);
    let case = Case::parse("quartic", builtin::text("quartic").ok_or("it is built in")?, &[])?;
    let (geometry, start): (Geometry, Start) = (case.geometry(), case.start());
    let norm = geometry.norm(&start.q, &start.q_dot);
    let mut point = geometry.point();
    let mut engine = Engine::equal(&geometry, &start, 0.25 * windows as f64, windows, 20)?;
    let (mut worst, begun) = (0.0_f64, Instant::now());
    engine.run(|window| {
        let (x, w) = (window.end().positions()[1], window.end().momenta()[0]);
        // A point of the run is inside the domain.
        let _ = point.evaluate(&[0.0, x], &[start.p[0], w]);
        let delta = start.p[0] * point.q_dot(0) - w * w - norm;
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
