//! What rounding takes from the formulas of a case: at some places of a run all rates are evaluated in 70 digits from
//! the same doubles of the state, and compared with those that the run was computed with.
//!
//! A coordinate that is far from 0 beside what it moves by, as a time in seconds of a calendar, is rounded itself, and
//! so is all that formulas make of it: both are compared with what its motion makes of a rate, and not its value.

use super::evaluated::{Evaluated, Losses, ORDINARY, ROUNDING};
use super::finding::{Finding, of_coordinate, of_formula};
use super::places::Seen;
use super::sights::Sights;
use crate::case::Case;
use crate::geometry::Start;
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::solve::{Lossy, NoSolution, Setup, Status};

/// A run to an accuracy is a march with a tolerance of about this share of it.
const OF_TOLERANCE: f64 = 1e-2;
/// A coordinate is far from 0 if it is so many times what it moves by: its rounding is more than is ordinary then.
pub(super) const FAR: f64 = ORDINARY / ROUNDING;
/// A place that has moved on by so many roundings of it is beside the surface on which it was.
const ROUNDINGS: f64 = 8.0;

/// What was found of the formulas of a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Formulas {
    /// They lose no more than rounding takes from any formula.
    Conditioned,
    /// They have no value in 70 digits, so that nothing is known.
    Unknown,
    /// One loses digits.
    Lost(Lost),
}

/// The digits that formulas lose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lost {
    /// The largest losses of q̇^a of all coordinates along the run, and of ṗ_a.
    pub(super) q_dot: Vec<f64>,
    pub(super) p_dot: Vec<f64>,
    /// The losses of ṗ_a at the start where it is nothing but rounding: all that begins there grows out of it.
    pub(super) at_start: Vec<f64>,
    /// By how much p_a is off at the start, as the metric loses digits there.
    pub(super) momenta: Vec<f64>,
    /// What is said of the largest loss: which formula, how much, and where.
    pub(super) finding: Finding,
    /// The largest share that a rate loses.
    pub(super) share: f64,
}

/// A start that has moved on by some roundings, where velocities are the first of these rates.
fn moved_on(start: &Seen, rates: &[Extended]) -> Seen {
    let on = |(&q, &rate): (&f64, &Extended)| {
        let by = ROUNDINGS * f64::EPSILON * q.abs();
        if rate == Extended::ZERO { q } else { q + by * rate.to_f64().signum() }
    };
    let q = start.q.iter().zip(rates).map(on).collect();
    Seen { q, p: start.p.clone(), set: start.set.clone(), part: 0.0 }
}

impl Formulas {
    /// Looks at the formulas of a run of `case` at these places. Returns also what rounding takes at most from
    /// what a run is certified with: the forces f_a + F_a of the Lagrangian, and K.
    pub(super) fn new<S: Real>(case: &Case, setup: &Setup<S>, sights: &Sights) -> (Self, Vec<f64>) {
        if S::IS_EXTENDED {
            return (Self::Conditioned, Vec::new());
        }
        let mut found = Largest::new(sights.places.ranges());
        let Start { q, p, q_dot } = &*setup.rough.start;
        let start = Seen { q: q.clone(), p: p.clone(), set: setup.set.clone(), part: 0.0 };
        let mut here = Evaluated::new(case, setup, &start);
        if let Some(here) = &mut here {
            found.see_start(here, &start);
            // A run that is continued has its momenta from there.
            if setup.carried.is_none() {
                found.see_velocities(here, &start, q_dot);
            }
        }
        for seen in sights.places.seen().iter().chain(sights.loudest.seen()) {
            let here = Evaluated::where_set(&mut here, (case, setup), seen);
            let Some(here) = here else { return (Self::Unknown, Vec::new()) };
            found.see(here, seen);
        }
        found.told()
    }
}

/// The formula that may be why a run of `case`, of which these places were seen, is not solved: it loses more than its
/// windows may be off by.
pub(crate) fn lost_to<S: Real>(case: &Case, setup: &Setup<S>, mut sights: Sights, why: &NoSolution) -> Option<Lossy> {
    use Status::{AccuracyNotReached, EvaluationLimit, Stalled, TooManyNodes};
    let is_short_of_it = matches!(why.status, AccuracyNotReached | EvaluationLimit | Stalled | TooManyNodes);
    let accuracy = setup.settings.accuracy.filter(|_| is_short_of_it)?.value();
    let place = |name: &String| setup.rough.geometry.names().iter().position(|other| other == name);
    let end: Vec<(usize, f64)> = why.point.iter().filter_map(|(name, value)| Some((place(name)?, *value))).collect();
    sights.places.see_ends(&setup.rough.start, &end);
    match Formulas::new(case, setup, &sights).0 {
        Formulas::Lost(Lost { finding: Finding { sentence, far, .. }, share, .. })
            if share > OF_TOLERANCE * accuracy =>
        {
            Some(Lossy { finding: sentence, is_far: far.is_some() })
        }
        _ => None,
    }
}

/// The first coordinate whose rounding is more than is ordinary beside what it moves by. One that rests is not rounded.
pub(super) fn far(q: &[f64], ranges: &[f64]) -> Option<usize> {
    let is_far = |(q, &range): (&f64, &f64)| range > 0.0 && q.abs() > FAR * range;
    q.iter().zip(ranges).position(is_far)
}

/// The largest losses along a run.
struct Largest {
    /// By how much coordinates move.
    ranges: Vec<f64>,
    lost: Vec<f64>,
    sizes: Vec<f64>,
    /// The largest losses of what a run is certified with.
    certified: Vec<f64>,
    /// The losses of ṗ_a at the start where it is nothing but rounding, whether q^a rests there, and by how much p_a is
    /// off there.
    at_start: Vec<f64>,
    rests: Vec<bool>,
    momenta: Vec<f64>,
    /// The largest loss at the start as a share, with what is said of it.
    of_start: (f64, Finding),
    /// The largest loss as a share of its rate, with what is said of it.
    worst: (f64, Finding),
    is_seen: bool,
}

impl Largest {
    fn new(ranges: Vec<f64>) -> Self {
        let zeros = || vec![0.0; 2 * ranges.len()];
        let certified = vec![0.0; ranges.len() + 1];
        let at_start = vec![0.0; ranges.len()];
        let (rests, momenta) = (vec![false; ranges.len()], at_start.clone());
        let [worst, of_start] = [(); 2].map(|()| (0.0, Finding::default()));
        let (lost, sizes) = (zeros(), zeros());
        Self { lost, sizes, certified, at_start, rests, momenta, of_start, worst, is_seen: false, ranges }
    }

    /// Looks whether the momenta at the start are those of its velocities: what the metric loses there stays.
    fn see_velocities(&mut self, here: &mut Evaluated, start: &Seen, q_dot: &[f64]) {
        let (n, exact) = (start.q.len(), here.exact(start, |_, value| Extended::from(value)));
        let mut off: Vec<f64> =
            exact[..n].iter().zip(q_dot).map(|(exact, u)| (*exact - Extended::from(*u)).to_f64()).collect();
        off[here.count..].fill(0.0);
        let largest = q_dot[..here.count].iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        if !off.iter().any(|off| off.abs() > ORDINARY * largest) {
            return;
        }
        let numbers: Vec<f64> = start.q.iter().chain(&start.p).copied().collect();
        let scales = here.scales(start, &exact, &numbers);
        let shares = off.iter().zip(&scales).map(|(off, scale)| off.abs() / scale);
        let share = shares.fold(0.0, larger);
        if share > ORDINARY {
            let [moved, still] = [&off, &vec![0.0; n]].map(|u| here.rough.momenta(&start.q, u));
            self.momenta = moved.iter().zip(still).map(|(moved, still)| (moved - still).abs()).collect();
            self.of_start = (share, of_formula(here.named(), &start.q, &exact[..n], share));
        }
    }

    /// Looks whether a force at the start is nothing but rounding. Both marches begin with it, so that nothing that
    /// they differ by tells what it grows to.
    fn see_start(&mut self, here: &mut Evaluated, start: &Seen) {
        let (n, Some(found)) = (start.q.len(), here.losses(start, None)) else { return };
        let numbers: Vec<f64> = start.q.iter().chain(&start.p).copied().collect();
        let losses = found.largest();
        // On the surface of a jump, which constants of more digits are beside, rounding takes the side alone. The run
        // has that of where it goes.
        let leaves = if here.rough.has_jumps() { here.losses(&moved_on(start, &found.exact), None) } else { None };
        let is_lost = |a: usize| {
            let is_lost = |exact: Extended, loss: f64| loss > 0.0 && exact.to_f64().abs() <= loss;
            let beside = |of: &Losses| is_lost(of.exact[n + a], of.largest()[n + a]);
            is_lost(found.exact[n + a], losses[n + a]) && leaves.as_ref().is_none_or(beside)
        };
        for a in 0..here.count.min(self.at_start.len()) {
            if is_lost(a) {
                self.at_start[a] = losses[n + a];
                self.rests[a] = found.exact[a].to_f64() == 0.0;
                let scales = here.scales(start, &found.exact, &numbers);
                let share = losses[n + a] / scales[n + a];
                let finding = of_formula(here.named(), &start.q, &found.exact[..n], 1.0);
                if share > self.of_start.0 {
                    self.of_start = (share, finding);
                }
            }
        }
    }

    /// Takes the losses at a place into account. Returns the rates that lose more than is ordinary beside what they
    /// are, of which `count` coordinates are results: not s of Newton's law.
    fn take(&mut self, count: usize, found: &Losses) -> Vec<usize> {
        self.is_seen = true;
        let (losses, Losses { exact, certified, .. }, n) = (found.largest(), found, self.ranges.len());
        self.certified.iter_mut().zip(certified).for_each(|(most, off)| *most = larger(*most, *off));
        let sizes = self.sizes.iter_mut().zip(exact);
        sizes.for_each(|(size, rate)| *size = size.max(rate.to_f64().abs()));
        let is_more = |k: &usize| k % n < count && losses[*k] > ORDINARY * self.sizes[*k];
        (0..2 * n).filter(is_more).collect()
    }

    fn see(&mut self, here: &mut Evaluated, seen: &Seen) {
        let (n, far) = (seen.q.len(), far(&seen.q, &self.ranges));
        // Balls of 32 digits tell of most formulas that they lose no more than is ordinary.
        let in_balls = if far.is_none() { here.losses_in_balls(seen, &self.sizes) } else { None };
        if in_balls.is_some_and(|found| self.take(here.count, &found).is_empty()) {
            return;
        }
        // A place that is no state in 70 digits shows nothing.
        let Some(found) = here.losses(seen, far) else { return };
        let large = self.take(here.count, &found);
        if large.is_empty() {
            return;
        }
        let (losses, Losses { exact, .. }) = (found.largest(), &found);
        let mut numbers: Vec<f64> = seen.q.iter().chain(&seen.p).copied().collect();
        let of_values = here.scales(seen, exact, &numbers);
        let of_motion = far.map(|a| {
            numbers[a] = self.ranges[a];
            here.scales(seen, exact, &numbers)
        });
        let scales = of_motion.as_ref().unwrap_or(&of_values);
        for k in large {
            if losses[k] <= ORDINARY * scales[k] {
                continue;
            }
            self.lost[k] = self.lost[k].max(losses[k]);
            let share = losses[k] / scales[k];
            if share > self.worst.0 {
                let far = far.filter(|_| losses[k] <= ORDINARY * of_values[k]);
                let finding = far.map_or_else(
                    || of_formula(here.named(), &seen.q, &exact[..n], share),
                    |a| of_coordinate(&here.rough.names()[a], seen.q[a], share),
                );
                self.worst = (share, finding);
            }
        }
    }

    fn told(self) -> (Formulas, Vec<f64>) {
        // Where a coordinate moves and is pushed later, the rounding at the start is one of many.
        let n = self.at_start.len();
        let mut at_start = self.at_start;
        for (a, loss) in at_start.iter_mut().enumerate() {
            if !self.rests[a] && self.sizes[n + a] > 2.0 * *loss {
                *loss = 0.0;
            }
        }
        let (of_start, of_start_finding) = self.of_start;
        let momenta = self.momenta;
        let is_of_start = self.worst.0 == 0.0 && at_start.iter().chain(&momenta).any(|loss| *loss > 0.0);
        let (share, finding) = if is_of_start { (of_start, of_start_finding) } else { self.worst };
        let formulas = match (self.is_seen, share) {
            (false, _) => Formulas::Unknown,
            (true, 0.0) => Formulas::Conditioned,
            (true, share) => {
                let (q_dot, p_dot) = self.lost.split_at(self.lost.len() / 2);
                let [q_dot, p_dot] = [q_dot, p_dot].map(<[f64]>::to_vec);
                Formulas::Lost(Lost { q_dot, p_dot, at_start, momenta, finding, share })
            }
        };
        (formulas, self.certified)
    }
}
