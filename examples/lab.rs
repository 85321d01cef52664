use geodesic_ivp::case::{SceneCase, builtin};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::lobatto::flow::{Flow, FlowView};
use std::ops::ControlFlow;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let text = builtin::text(&a[1]).map(str::to_owned).unwrap_or_else(|| std::fs::read_to_string(&a[1]).unwrap());
    let case = SceneCase::parse("lab", &text, &[]).unwrap();
    let (geometry, start): (Geometry, Start) = (case.geometry(), case.start());
    let length: f64 = a[2].parse().unwrap();
    let accuracy: f64 = a[3].parse().unwrap();
    let runs: usize = a[4].parse().unwrap();
    let bare = a.get(5).is_some();
    let mut least = f64::INFINITY;
    let mut stats = None;
    let mut setup = f64::INFINITY;
    for _ in 0..runs {
        let now = Instant::now();
        let flow = Flow::new(&geometry);
        let flow = if bare { flow } else { flow.certified() };
        setup = setup.min(now.elapsed().as_secs_f64());
        let go_on = &mut |_: &FlowView<'_>| ControlFlow::Continue(());
        let out = flow.run(&start, length, &mut [], accuracy, go_on).unwrap();
        least = least.min(now.elapsed().as_secs_f64());
        stats = Some(out.statistics);
    }
    println!("{} {} {}: {:.1} us setup {:.1} {:?}", a[1], length, accuracy, least * 1e6, setup * 1e6, stats.unwrap());
}
