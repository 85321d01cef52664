//! The losses of rates are added up along a run. Roundings have no direction: the sum of N that are independent and of
//! one size is about √N times as large, and what has a direction shows in their mean.

use super::conditioning::{Lost, far};
use super::evaluated::{Evaluated, Losses, ORDINARY};
use super::places::Seen;
use super::sights::Sights;
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

/// The losses of some places, in each way in which rates are computed.
#[derive(Debug)]
struct Added {
    computed: Vec<Sums>,
    /// The largest size of each rate so far.
    sizes: Vec<f64>,
}

impl Added {
    fn new(rates: usize) -> Self {
        Self { computed: Vec::new(), sizes: vec![0.0; rates] }
    }

    /// Adds those of a place, and returns what rounding of a coordinate that is far from 0 makes of rates besides.
    /// `None` if it is no state in 70 digits.
    fn see(&mut self, here: &mut Evaluated, seen: &Seen, far: Option<usize>) -> Option<Vec<f64>> {
        let Losses { exact, computed, rounded, .. } = here.losses(seen, far)?;
        let Self { computed: sums, sizes } = self;
        sizes.iter_mut().zip(&exact).for_each(|(size, rate)| *size = size.max(rate.to_f64().abs()));
        sums.resize(sums.len().max(computed.len()), Sums::new(sizes.len()));
        sums.iter_mut().zip(computed).for_each(|(sums, losses)| sums.see(&beyond(losses, sizes), seen.part));
        Some(beyond(rounded, sizes))
    }

    /// The sum of a rate, and so many standard deviations.
    fn most(&self, k: usize, deviations: f64) -> f64 {
        let each = self.computed.iter().map(|sums| sums.mean[k].abs() + deviations * sums.squares[k].sqrt());
        each.fold(0.0, f64::max)
    }
}

/// By how much all rates of a run of `case` move its numbers: its formulas lose digits, and these are some of its
/// places. It is so long, and has so many nodes. `None` if there is no place at which that is known.
pub(super) fn added_up<S: Real>(
    (case, setup): (&Case, &Setup<S>),
    lost: &Lost,
    Sights { places, loudest }: &Sights,
    (length, nodes): (f64, usize),
) -> Option<Off> {
    let n = setup.rough.start.q.len();
    let ranges = places.ranges();
    let [mut spread, mut loud] = [(); 2].map(|()| Added::new(2 * n));
    let mut by_far = Sums::new(2 * n);
    let (mut whole, mut count, mut distinct, mut is_far) = (0.0, 0, nodes as f64, vec![false; n]);
    let mut here: Option<Evaluated> = None;
    for seen in places.seen() {
        let here = Evaluated::where_set(&mut here, (case, setup), seen)?;
        let far = far(&seen.q, &ranges);
        let Some(rounded) = spread.see(here, seen, far) else { continue };
        by_far.see(&rounded, seen.part);
        (whole, count) = (whole + seen.part, count + 1);
        if let Some(a) = far {
            // A coordinate that moves by a few of its roundings takes no more values.
            distinct = distinct.min(ranges[a] / (f64::EPSILON * seen.q[a].abs())).max(1.0);
            is_far[a] = true;
        }
    }
    loud.sizes.clone_from(&spread.sizes);
    for seen in loudest.seen() {
        let _ = loud.see(Evaluated::where_set(&mut here, (case, setup), seen)?, seen, None);
    }
    let by_nodes = |of: f64| OF_NODES * (f64::from(count) / of).sqrt();
    // Independent numbers add up by their squares.
    let of_both = OF_PLACES.hypot(by_nodes(nodes.max(1) as f64));
    let of_all = |k: usize| {
        let sum = spread.most(k, of_both) + by_nodes(distinct) * by_far.squares[k].sqrt();
        // The nodes of the loudest windows stand for themselves: others may lie in none of what is lost.
        (sum * length / whole).max(loud.most(k, OF_NODES))
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
/// doubles, and the engine begins with all digits.
fn off_at_start<S: Real>(case: &Case, setup: &Setup<S>, a: usize) -> f64 {
    let off = || (case.start::<Extended>().q[a] - Extended::from(setup.rough.start.q[a])).to_f64().abs();
    if setup.carried.is_some() || setup.settings.accuracy.is_some() { 0.0 } else { off() }
}
