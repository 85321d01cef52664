//! Runs to an accuracy, timed, with their true errors.
//!
//! Five motions: Hénon–Heiles to γ = 1000, the quartic well to 1 and to 1000, an orbit around a black hole to 2000 and
//! an inclined one around a rotating hole to 400. Each is run bare, with the promise, and with everything: promised,
//! certified, and all nodes kept. A time is the least of many runs with one engine. Errors are those of the end,
//! relative to the largest value that a coordinate has on the way, against ends that a Taylor method gives in 40
//! digits.
//!
//! ```text
//! cargo bench --bench engine [-- NAME [MODE]]
//! ```

use std::ops::ControlFlow;
use std::time::Instant;

use geodesic_ivp::case::{Case, builtin};
use geodesic_ivp::engine::{Accuracy, Engine, Failure};
use geodesic_ivp::geometry::{Geometry, Start};

/// Runs of which the fastest counts, and seconds that they may take.
const RUNS: usize = 200;
const PATIENCE: f64 = 0.3;

/// A motion: its name, its case, its length in γ, and coordinates at the end by their places.
type Scene = (&'static str, &'static str, f64, &'static [(usize, f64)]);

const SCENES: [Scene; 5] = [
    ("henon-heiles", "henon-heiles", 1000.0, &[(1, -0.020_869_654_947_295_594), (2, -0.381_630_841_346_697_4)]),
    ("quartic-1", "quartic", 1.0, &[(1, 0.159_778_018_885_407_24), (0, 1.468_634_756_955_731)]),
    ("quartic-1000", "quartic", 1000.0, &[(1, -0.022_376_294_624_142_45), (0, 1_547.193_683_282_507_2)]),
    (
        "schwarzschild",
        "schwarzschild-orbit",
        2000.0,
        &[(1, 17.262_243_544_431_858), (0, 2_303.946_208_190_368), (2, 54.491_637_278_880_26)],
    ),
    (
        "kerr",
        "kerr-inclined",
        400.0,
        &[
            (1, 11.318_948_036_563_88),
            (2, 1.940_975_857_800_152_8),
            (0, 509.040_671_596_835_9),
            (3, 25.444_827_068_220_135),
        ],
    ),
];

fn geometry_and_start(&(_, case, ..): &Scene) -> (Geometry, Start) {
    let case = Case::parse(case, builtin::text(case).expect("it is built in"), &[]).expect("it is valid");
    (case.geometry(), case.start())
}

/// A kind of runs.
type Mode = (&'static str, fn(f64) -> Accuracy, bool);

/// The kinds of runs: their names, what they are told of an accuracy, and whether they are certified and stored.
const MODES: [Mode; 4] = [
    ("local", Accuracy::Local, false),
    ("estimated", Accuracy::Estimated, false),
    ("promised", Accuracy::Promised, false),
    ("everything", Accuracy::Promised, true),
];

/// A run as it was the last time, and the least time of all.
struct Measured {
    seconds: f64,
    windows: usize,
    sweeps: usize,
    /// The error at the end, relative to sizes.
    error: f64,
    estimate: Option<f64>,
}

fn measure(scene: &Scene, accuracy: f64, (_, wanted, is_complete): Mode) -> Result<Measured, Failure> {
    let ((geometry, start), &(.., length, exact)) = (geometry_and_start(scene), scene);
    let mut engine = Engine::accurate(&geometry, &start, length, wanted(accuracy)).expect("it is inside");
    let mut sizes: Vec<f64> = start.q.iter().map(|q| q.abs()).collect();
    let (mut kept, mut windows, mut sweeps, mut end) = (Vec::new(), 0, 0, start.q.clone());
    let mut run = |engine: &mut Engine<'_>| {
        engine.rewind();
        engine.run(|mut window| {
            if window.index == 0 {
                (windows, sweeps) = (0, 0);
                kept.clear();
            }
            (windows, sweeps) = (windows + 1, sweeps + window.sweeps);
            if is_complete {
                kept.extend(window.gradient_norm());
                let nodes = window.nodes();
                (0..start.q.len()).for_each(|a| kept.extend_from_slice(nodes.q(a)));
                (0..geometry.active().len()).for_each(|place| kept.extend_from_slice(nodes.p(place)));
            }
            end = window.end().positions();
            sizes.iter_mut().zip(&end).for_each(|(size, q)| *size = size.max(q.abs()));
            ControlFlow::Continue(())
        })
    };
    run(&mut engine)?;
    let (begun, mut seconds) = (Instant::now(), f64::INFINITY);
    for _ in 0..RUNS {
        let one = Instant::now();
        run(&mut engine)?;
        seconds = seconds.min(one.elapsed().as_secs_f64());
        if begun.elapsed().as_secs_f64() > PATIENCE {
            break;
        }
    }
    let error = exact.iter().map(|&(a, q)| (end[a] - q).abs() / sizes[a]).fold(0.0, f64::max);
    Ok(Measured { seconds, windows, sweeps, error, estimate: engine.error_estimate() })
}

fn table(scene: &Scene, modes: &[&Mode]) {
    for accuracy in [1e-4, 1e-6, 1e-9, 1e-12] {
        for &&mode in modes {
            print!("{:<14} {accuracy:.0e} {:<10} ", scene.0, mode.0);
            match measure(scene, accuracy, mode) {
                Ok(Measured { seconds, windows, sweeps, error, estimate }) => {
                    let estimate = estimate.map_or(String::new(), |estimate| format!("  estimate {estimate:.1e}"));
                    let (time, sweeps) = (1e6 * seconds, sweeps as f64 / windows as f64);
                    println!("{time:>9.2} us {windows:>5} windows {sweeps:>5.1} sweeps  error {error:.1e}{estimate}");
                }
                Err(failure) => println!("{failure:?}"),
            }
        }
    }
}

fn main() {
    let mut names = std::env::args().skip(1).filter(|argument| !argument.starts_with('-'));
    let [scene, mode] = std::array::from_fn(|_| names.next());
    let is_asked = |name: &str, asked: &Option<String>| asked.as_ref().is_none_or(|asked| name.contains(asked));
    let modes: Vec<&Mode> = MODES.iter().filter(|(name, ..)| is_asked(name, &mode)).collect();
    SCENES.iter().filter(|(name, ..)| is_asked(name, &scene)).for_each(|scene| table(scene, &modes));
}
