//! A run that is judged by a finer one.

use geodesic_ivp::engine::{Accuracy, Engine, Failure};
use geodesic_ivp::geometry::{Geometry, Start};

use crate::common::shipped;

/// The end of a run, and the engine at its end.
fn ended<'g>(geometry: &'g Geometry, start: &Start, length: f64, wanted: Accuracy) -> (Vec<f64>, Engine<'g>) {
    let mut engine = Engine::accurate(geometry, start, length, wanted).unwrap();
    let mut end = Vec::new();
    engine.run(|window| (end = window.end().positions(), std::ops::ControlFlow::Continue(())).1).unwrap();
    (end, engine)
}

/// The largest distance of two ends, relative to sizes.
fn apart(one: &[f64], other: &[f64], sizes: &[f64]) -> f64 {
    one.iter().zip(other).zip(sizes).map(|((one, other), size)| (one - other).abs() / size).fold(0.0, f64::max)
}

/// With windows a thousand times better, the end is off by no more than is said; and what is said is no more than 300
/// times as much, as a hundredth of the tolerance is what it cannot be less than.
#[test]
fn what_a_hundredth_of_the_tolerance_changes_bounds_the_error() {
    for (name, length) in
        [("henon-heiles", 100.0), ("kepler", 20.0), ("schwarzschild-orbit", 1000.0), ("quartic", 30.0)]
    {
        let case = shipped(name, &[]);
        let (geometry, start): (Geometry, Start) = (case.geometry(), case.start());
        let (known, _) = ended(&geometry, &start, length, Accuracy::Local(1e-15));
        for accuracy in [1e-4, 1e-6, 1e-8, 1e-10] {
            for wanted in [Accuracy::Promised(accuracy), Accuracy::Estimated(accuracy)] {
                let (end, engine) = ended(&geometry, &start, length, wanted);
                let (off, said) = (apart(&end, &known, &engine.sizes()), engine.error_estimate().unwrap());
                assert!(off <= said, "{name} {wanted:?}: {off:e} {said:e}");
                assert!(said <= accuracy || !wanted.is_promised(), "{name} {wanted:?}: {said:e}");
            }
        }
    }
}

/// In chaos two runs part: what is said stays a number, and says until where digits are good.
#[test]
fn runs_in_chaos_part_and_say_where() {
    let case =
        shipped("henon-heiles", &["initial.x=0.0", "initial.y=-0.25", "initial.y_dot=0.0", "initial.x_dot=0.42"]);
    let (geometry, start): (Geometry, Start) = (case.geometry(), case.start());
    let (_, engine) = ended(&geometry, &start, 2000.0, Accuracy::Estimated(1e-10));
    let (said, [three, six, nine]) = (engine.error_estimate().unwrap(), engine.good_until());
    assert!(said > 0.1 && said < 10.0, "{said:e}");
    assert!(0.0 < nine && nine < six && six < three && three < 2000.0, "{three} {six} {nine}");
    // Until there the runs agree with a better one, and a promise is not kept.
    for (until, digits) in [(three, 3), (six, 6), (nine, 9)] {
        let [(end, engine), (known, _)] =
            [1e-10, 1e-13].map(|tolerance| ended(&geometry, &start, until, Accuracy::Estimated(tolerance)));
        assert!(apart(&end, &known, &engine.sizes()) <= 10.0_f64.powi(-digits), "{digits}");
    }
    let mut promised = Engine::accurate(&geometry, &start, 2000.0, Accuracy::Promised(1e-8)).unwrap();
    let failure = promised.run(|_| std::ops::ControlFlow::Continue(())).unwrap_err();
    assert!(failure == Failure::Accuracy && promised.reachable().unwrap() > 1e-8, "{failure:?}");
    assert!(promised.place().0 < 2000.0);
}
