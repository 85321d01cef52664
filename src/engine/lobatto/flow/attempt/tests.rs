//! The decisions of one march along a world-line.

use super::{FlowState, Request, Twofold, Walk};
use crate::engine::lobatto::flow::{rule, tests::geometries};
use crate::geometry::Start;

#[test]
fn nobody_looks_beyond_the_end_of_a_run() {
    let geometry = &geometries()[0];
    let start = Start { q: vec![0.0, 0.5, -0.3], q_dot: vec![1.0, 0.0, 0.0], p: vec![2.0, 0.0, 0.0] };
    let ahead = |length: f64, part: f64| {
        let request = Request {
            start: FlowState::new(&start, geometry.active()),
            q_dot: &start.q_dot,
            momenta: &start.p,
            length,
            target: None,
            accuracy: 1e-6,
            certify: false,
        };
        let mut walk = Walk::new(geometry, &request, rule::coarse());
        let mut here = walk.begin(1.0);
        here.gamma = Twofold::from(part * length);
        [walk.ahead(&here), here.first]
    };
    let [near, first] = ahead(1024.0, 1.0 - 1.0 / 4096.0);
    assert!(near == 0.25 && first > 0.25 && first < 100.0, "{first}");
    assert_eq!(ahead(1024.0, 0.5), [first; 2]);
}
