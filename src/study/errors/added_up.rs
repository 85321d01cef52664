//! The losses of rates are added up along a run. Roundings have no direction: the sum of N that are independent and of
//! one size is about √N times as large, and what has a direction shows in their mean.

use super::conditioning::{Evaluated, Losses, Lost, ORDINARY, far};
use super::places::Places;
use crate::case::Case;
use crate::number::{Extended, Real};
use crate::solve::{Off, Setup};

/// A sum of independent numbers is hardly ever more than so many standard deviations from its mean: that of the places
/// which are looked at, and that of the nodes of a run.
const OF_PLACES: f64 = 2.0;
const OF_NODES: f64 = 3.0;

/// The sums of one kind of losses, each times its part of the run, and of their squares.
#[derive(Debug, Clone)]
struct Sums {
    mean: Vec<f64>,
    squares: Vec<f64>,
}

impl Sums {
    fn new(rates: usize) -> Self {
        Self { mean: vec![0.0; rates], squares: vec![0.0; rates] }
    }

    fn see(&mut self, losses: &[f64], part: f64) {
        for ((mean, square), loss) in self.mean.iter_mut().zip(&mut self.squares).zip(losses) {
            *mean += part * loss;
            *square += (part * loss).powi(2);
        }
    }
}

/// By how much all rates of a run of `case` move its numbers: its formulas lose digits, and these are some of its
/// places. It is so long, and has so many nodes. `None` if there is no place at which that is known.
pub(super) fn added_up<S: Real>(
    (case, setup): (&Case, &Setup<S>),
    lost: &Lost,
    places: &Places,
    (length, nodes): (f64, usize),
) -> Option<Off> {
    let n = setup.rough.start.q.len();
    let ranges = places.ranges();
    let (mut computed, mut rounded): (Vec<Sums>, _) = (Vec::new(), Sums::new(2 * n));
    let mut sizes = vec![0.0_f64; 2 * n];
    let (mut whole, mut count, mut distinct, mut is_far) = (0.0, 0, nodes as f64, vec![false; n]);
    let mut here: Option<Evaluated> = None;
    for seen in places.seen() {
        let here = Evaluated::where_set(&mut here, (case, setup), seen)?;
        let far = far(&seen.q, &ranges);
        let Some(Losses { exact, computed: here, rounded: by, .. }) = here.losses(seen, far) else {
            continue;
        };
        sizes.iter_mut().zip(&exact).for_each(|(size, rate)| *size = size.max(rate.to_f64().abs()));
        computed.resize(computed.len().max(here.len()), Sums::new(2 * n));
        computed.iter_mut().zip(here).for_each(|(sums, losses)| sums.see(&beyond(losses, &sizes), seen.part));
        rounded.see(&beyond(by, &sizes), seen.part);
        (whole, count) = (whole + seen.part, count + 1);
        if let Some(a) = far {
            // A coordinate that moves by a few of its roundings takes no more values.
            distinct = distinct.min(ranges[a] / (f64::EPSILON * seen.q[a].abs())).max(1.0);
            is_far[a] = true;
        }
    }
    let by_nodes = |of: f64| OF_NODES * (f64::from(count) / of).sqrt();
    // Independent numbers add up by their squares.
    let of_both = OF_PLACES.hypot(by_nodes(nodes.max(1) as f64));
    let of_computed = |sums: &Sums, k: usize| sums.mean[k].abs() + of_both * sums.squares[k].sqrt();
    let of_all = |k: usize| {
        let most = computed.iter().fold(0.0_f64, |most, sums| most.max(of_computed(sums, k)));
        (most + by_nodes(distinct) * rounded.squares[k].sqrt()) * length / whole
    };
    let of = |largest: &[f64], first: usize| {
        let each = largest.iter().enumerate().map(|(a, &largest)| if largest > 0.0 { of_all(first + a) } else { 0.0 });
        each.collect::<Vec<f64>>()
    };
    let mut off = Off { q: of(&lost.q_dot, 0), p: of(&lost.p_dot, n) };
    let far = (0..n).filter(|&a| is_far[a]);
    far.for_each(|a| off.q[a] += off_at_start(case, setup, a));
    off.p.iter_mut().zip(&lost.at_start).for_each(|(off, rate)| *off += length * rate);
    off.p.iter_mut().zip(&lost.momenta).for_each(|(off, momentum)| *off += momentum);
    (whole > 0.0).then_some(off)
}

/// The losses that are more than is ordinary for rates of these sizes.
fn beyond(losses: Vec<f64>, sizes: &[f64]) -> Vec<f64> {
    let each = losses.into_iter().zip(sizes);
    each.map(|(loss, size)| if loss.abs() <= ORDINARY * size { 0.0 } else { loss }).collect()
}

/// By how much a coordinate is off at the start, as its decimals have no double. A run that is continued has begun at
/// doubles.
fn off_at_start<S: Real>(case: &Case, setup: &Setup<S>, a: usize) -> f64 {
    let off = || (case.start::<Extended>().q[a] - Extended::from(setup.rough.start.q[a])).to_f64().abs();
    if setup.carried.is_some() { 0.0 } else { off() }
}
