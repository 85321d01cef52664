//! Every method of `stability` and of `work-precision` is what it is called: its error falls at its order as the
//! setting is refined, in the very rows and cells that the commands write.

use geodesic_ivp::case::{Form, SbpName};
use geodesic_ivp::methods::{Peer, Step};
use geodesic_ivp::study::stability::{Arena, Cell, Method};
use geodesic_ivp::study::work_precision::{self, Budget};

use super::charted;
use crate::common::{case, shipped};

/// The errors of a method do one of these.
enum Law {
    /// They fall with an order in the step between these two, on the three finest grids above rounding.
    Order(f64, f64),
    /// They do so on all grids: where in a step the points of output lie differs from grid to grid.
    Dense(f64, f64),
    /// They follow the tolerance, and stay below so many of it.
    Tolerance(f64),
    /// They fall with the tolerance, and are below it: the run is the finer one of two, and windows do not grow beyond
    /// what is cheap, so that loose tolerances give smaller errors than asked for.
    Promise,
    /// They stay where they are: the method is wrong.
    Wrong,
}

/// Errors above this are not asymptotic, and below the other one they feel rounding.
const COARSE: f64 = 2e-3;
const ROUNDING: f64 = 1e-13;
/// In scenes t and other ignorable coordinates are far larger than 1, and steps are summed.
const ROUNDING_IN_SCENES: f64 = 1e-11;

/// The slope of the errors against the numbers of steps, or the like, on the finest `most` of these settings that are
/// neither coarse nor rounding.
fn order(errors: &[(f64, f64)], most: usize, rounding: f64) -> Option<f64> {
    let good: Vec<_> = errors.iter().filter(|(_, error)| (rounding..COARSE).contains(error)).collect();
    let finest = &good[good.len().saturating_sub(most)..];
    let mean =
        |value: &dyn Fn(&(f64, f64)) -> f64| finest.iter().map(|point| value(point)).sum::<f64>() / finest.len() as f64;
    let (x, y) = (mean(&|point| point.0.ln()), mean(&|point| point.1.ln()));
    let slope = mean(&|point| (point.0.ln() - x) * (point.1.ln() - y)) / mean(&|point| (point.0.ln() - x).powi(2));
    (finest.len() >= 2 && slope.is_finite()).then_some(-slope)
}

/// The errors of a method to compare with must do this, by what it says of itself.
fn law_of(peer: Peer) -> Law {
    let about = peer.about();
    match (about.step, about.order) {
        (Step::Adaptive, _) => Law::Tolerance(30.0),
        (_, Some(2)) => Law::Order(1.9, 2.1),
        (_, Some(order)) => {
            let order = order as f64;
            Law::Order((0.95 * order).max(order - 0.4), (1.1 * order).min(order + 1.0))
        }
        (_, None) => panic!("{peer:?} has no order"),
    }
}

/// Says what is wrong with the errors of a method, (steps or 1/tolerance, error), from cheap to dear.
fn contradiction(name: &str, law: &Law, errors: &[(f64, f64)], rounding: f64) -> Option<String> {
    let (most, range) = match *law {
        Law::Order(low, high) => (3, low..high),
        Law::Dense(low, high) => (usize::MAX, low..high),
        Law::Tolerance(_) => (usize::MAX, 0.7..1.3),
        Law::Promise => (usize::MAX, 0.3..1.3),
        Law::Wrong => (0, 0.0..0.0),
    };
    let order = order(errors, most, rounding);
    let holds = match *law {
        Law::Wrong => !errors.is_empty() && errors.iter().all(|(_, error)| *error > 0.01),
        // Where the loosest run is good to rounding no order is seen.
        Law::Promise => !errors.is_empty() && order.is_none_or(|order| range.contains(&order)),
        _ => order.is_some_and(|order| range.contains(&order)),
    };
    let is_within = |factor: f64| errors.iter().all(|(inverse, error)| *error < factor / inverse + rounding);
    let holds = holds
        && match *law {
            Law::Tolerance(factor) => is_within(factor),
            Law::Promise => is_within(1.0),
            _ => true,
        };
    (!holds).then(|| format!("{name}: order {order:?}, {errors:?}"))
}

/// The methods whose errors in the atlas of a world-line of this length do not do what they should.
fn contradicted(
    arena: &Arena,
    methods: Vec<Method>,
    length: f64,
    law: impl Fn(&Method) -> Law,
    rounding: f64,
) -> String {
    let spacings: Vec<f64> = STEPS.iter().rev().map(|steps| length / steps).collect();
    let atlas = charted(arena, methods.clone(), &[length], &spacings);
    let contradicted = methods.iter().filter_map(|method| {
        let mut errors: Vec<(f64, f64)> = atlas
            .cells
            .iter()
            .filter(|cell| cell.method == *method)
            .filter_map(|Cell { n_gamma, numbers, setting, .. }| {
                let errors = numbers.as_ref()?.errors.as_ref()?;
                let steps = if method.is_adaptive() { 1.0 / setting } else { (*n_gamma)? as f64 - 1.0 };
                // Whatever looser accuracy is asked for, it is that of 1e-4.
                if matches!(method, Method::Accuracy | Method::Tolerance) && steps < 1e4 {
                    return None;
                }
                Some((steps, errors.iter().copied().fold(0.0, f64::max)))
            })
            .collect();
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        contradiction(&method.label(), &law(method), &errors, rounding)
    });
    contradicted.collect::<Vec<_>>().join("\n")
}

/// The errors of a method of the atlas must do this.
fn law_of_method(method: &Method) -> Law {
    match method {
        Method::Block(SbpName::Sbp21, _) => Law::Order(1.9, 2.1),
        Method::Block(SbpName::Sbp42, _) => Law::Order(2.8, 3.3),
        Method::Block(SbpName::Sbp63, _) => Law::Order(3.6, 4.6),
        Method::Block(..) => Law::Order(4.6, 5.9),
        Method::Windows(SbpName::Sbp21, Form::Strong) => Law::Order(1.9, 2.3),
        Method::Windows(SbpName::Sbp21, Form::Weak) => Law::Order(1.9, 2.1),
        Method::Windows(..) => Law::Order(2.8, 3.3),
        // This is the order of the nodes inside; with sixteen of them rounding comes before the order is reached.
        Method::Elements(nodes) => Law::Order(*nodes as f64 - 2.5, *nodes as f64 + 1.5),
        Method::Unregularised(_) => Law::Wrong,
        Method::Peer(peer) => law_of(*peer),
        Method::Accuracy | Method::Tolerance => Law::Promise,
        Method::March(_) | Method::Other(_) => unreachable!("not charted"),
    }
}

const STEPS: [f64; 18] = [
    4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0, 192.0, 256.0, 384.0, 512.0, 1024.0, 2048.0, 4096.0,
];

#[test]
fn every_method_of_the_atlas_has_its_order() {
    let arena = Arena::new(&case(""), &[4.0]).unwrap();
    assert_eq!(contradicted(&arena, Method::charted(), 4.0, law_of_method, ROUNDING), "");
}

#[test]
fn every_method_of_the_atlas_has_its_order_in_scenes() {
    let is_high = |method: &Method| matches!(method, Method::Elements(16)) || method.label() == "Gauss 8";
    // On a short orbit around a hole methods of high order go from coarse to rounding at once.
    let all =
        [("henon-heiles", 15.0, None), ("kerr-inclined", 40.0, Some(false)), ("kerr-inclined", 160.0, Some(true))];
    for (name, length, high) in all {
        let case = shipped(name, &[]);
        let is_separable = case.geometry::<f64>().is_separable();
        let methods: Vec<Method> =
            Method::charted().into_iter().filter(|method| method.unsuitable(is_separable).is_none()).collect();
        assert_eq!(methods.iter().any(|method| method.label() == "Verlet"), is_separable);
        let methods = methods.into_iter().filter(|method| high.is_none_or(|high| is_high(method) == high)).collect();
        let arena = Arena::new(&case, &[length]).unwrap();
        let law = |method: &Method| match method {
            // Few grids of high orders are both asymptotic and above rounding: errors may still fall faster, and around
            // a hole, whose singularity is near, more slowly.
            Method::Elements(16) => Law::Order(if is_separable { 12.5 } else { 8.0 }, 17.5),
            Method::Block(SbpName::Sbp84, _) => Law::Order(4.4, 6.0),
            Method::Peer(peer) if peer.about().order == Some(16) => {
                Law::Order(if is_separable { 15.0 } else { 12.0 }, 26.0)
            }
            _ => law_of_method(method),
        };
        assert_eq!(contradicted(&arena, methods, length, law, ROUNDING_IN_SCENES), "", "{name} {length}");
    }
}

#[test]
fn every_method_of_the_chart_has_its_order() {
    // By settings and not by time, so that a slow machine measures the same.
    let budget = Budget { longest: f64::INFINITY, rounds: 1, settings: 12 };
    let families = Method::timed();
    let is_spectral = |family: &Method| match family {
        Method::Peer(peer) => peer.about().step == Step::Iterated,
        _ => matches!(family, Method::Elements(_) | Method::March(_)),
    };
    let (spectral, others): (Vec<_>, Vec<_>) = families.iter().cloned().partition(is_spectral);
    let mut rows = Vec::new();
    // On a short run windows of many nodes would have nothing but rounding.
    for (length, families) in [("40.0", spectral), ("4.0", others)] {
        let arena = work_precision::Arena::new(&case(&format!("grid.gamma_f={length}")), None).unwrap();
        rows.extend(work_precision::measure(&arena, &families, &budget, &mut |_| {}).rows);
    }
    let contradicted = families.iter().filter_map(|family| {
        let law = match family {
            Method::Block(sbp, form) => law_of_method(&Method::Block(*sbp, *form)),
            // 2n - 2 at the ends of windows and, as amplitudes shift the phase of a long run, one more. With many nodes
            // rounding comes before the order is reached.
            Method::Elements(nodes) => Law::Order((2.0 * *nodes as f64 - 3.5).min(17.0), 2.0 * *nodes as f64 - 0.5),
            // n + 1 between the ends, unless the errors at the ends are larger still.
            Method::March(nodes) => Law::Dense((*nodes as f64).min(11.0), 2.0 * *nodes as f64 - 0.5),
            // Between the ends of the steps of Gauss the order is that of its polynomials.
            Method::Peer(peer) if peer.about().step == Step::Iterated => {
                let order = peer.about().order.unwrap() as f64;
                Law::Dense((order / 2.0).min(11.0), order + 0.5)
            }
            Method::Peer(peer) => law_of(*peer),
            Method::Accuracy | Method::Tolerance => Law::Promise,
            _ => unreachable!("not timed"),
        };
        let errors: Vec<(f64, f64)> = rows
            .iter()
            .filter(|row| row.method == *family)
            .filter_map(|row| {
                let number = |key: &str| {
                    let value = row.setting.split(key).nth(1)?.split_whitespace().next()?;
                    value.parse::<f64>().ok()
                };
                let count = ["steps=", "windows=", "N="].into_iter().find_map(number);
                Some((count.or_else(|| number("tol=").map(f64::recip))?, row.errors.as_ref()?.largest()))
            })
            // Whatever looser accuracy is asked for, it is that of 1e-4.
            .filter(|(count, _)| !matches!(family, Method::Accuracy | Method::Tolerance) || *count > 9e3)
            // On the ends of windows errors are smaller by far than between them.
            .filter(|(count, _)| !matches!(law, Law::Dense(..)) || count % work_precision::OUTPUTS as f64 != 0.0)
            .collect();
        contradiction(&family.label(), &law, &errors, ROUNDING)
    });
    assert_eq!(contradicted.collect::<Vec<_>>().join("\n"), "");
}
