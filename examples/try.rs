use geodesic_ivp::{Case, solve};
fn main() {
    let text = std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap();
    let sets: Vec<String> = std::env::args().skip(2).collect();
    for system in ["physical-limit", "doubled"] {
        let mut s = sets.clone();
        s.push(format!("solver.system={system}"));
        let case = match Case::parse("c", &text, &s) { Ok(c) => c, Err(e) => { println!("{e}"); return } };
        let t0 = std::time::Instant::now();
        match solve(&case) {
            Ok(s) => {
                println!("{system}: t={:?} x={:?} grad={:.1e} lambda={:?} end={:?} its={} {:?} dist={:.1e}", s.t().last().unwrap(), s.x.last().unwrap(), s.gradient_norm, s.multipliers, s.end, s.history.len(), t0.elapsed(), s.branch_distance());
                for r in &s.history { println!("   {r:?}"); }
            }
            Err(e) => println!("{system}: {e} {:?}\n {:?}", t0.elapsed(), e.history),
        }
    }
}
