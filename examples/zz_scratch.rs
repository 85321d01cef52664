use geodesic_ivp::{Case, Solution, solve};
use std::time::Instant;
fn main() {
    for o in [
        vec!["grid.gamma_f=1000.0", "grid.windows=2000"],
        vec!["grid.gamma_f=1.0", "grid.windows=2"],
        vec!["grid.gamma_f=1000.0", "solver.accuracy=1e-8"],
        vec!["grid.gamma_f=1000.0", "solver.accuracy=1e-4"],
        vec!["grid.gamma_f=1.0", "solver.accuracy=1e-8"],
    ] {
        let o: Vec<String> = o.iter().map(|s| s.to_string()).collect();
        let case = Case::parse("q", include_str!("../cases/quartic-windows.toml"), &o).unwrap();
        let mut best = f64::MAX;
        let first = {
            let s = Instant::now();
            let _: Solution = solve(&case).unwrap();
            s.elapsed().as_secs_f64()
        };
        for _ in 0..60 {
            let s = Instant::now();
            let r: Solution = solve(&case).unwrap();
            best = best.min(s.elapsed().as_secs_f64());
            std::hint::black_box(r);
        }
        println!("{o:?}: first {:.3} ms best {:.3} ms", first * 1e3, best * 1e3);
    }
}
