//! What rounding takes from the formulas of a case: at some places of a run all rates are evaluated in 70 digits from
//! the same doubles of the state, and compared with those that the run was computed with.
//!
//! A coordinate that is far from 0 beside what it moves by, as a time in seconds of a calendar, is rounded itself, and
//! so is all that formulas make of it: both are compared with what its motion makes of a rate, and not its value.

use super::finding::{Finding, of_coordinate, of_formula};
use super::places::{Places, Seen};
use crate::case::Case;
use crate::engine::Rates;
use crate::geometry::{Geometry, GeometryText, Start, WrittenRates};
use crate::number::norm::larger;
use crate::number::{Extended, Real};
use crate::solve::{Lossy, NoSolution, Setup, Status};

/// A rate may lose so many roundings of what its own numbers make of it: some tens of operations round by half a unit
/// each, and functions by a few.
pub(super) const ORDINARY: f64 = 64.0 * f64::EPSILON;
/// The relative change of all numbers that shows what they make of a rate, 2^-80: with its square it is exact to the
/// digits of a double.
const CHANGE: f64 = 1.0 / (1_u128 << 80) as f64;
/// Numbers are changed with so many patterns of signs, since in one of them changes may cancel.
const PATTERNS: u32 = 8;
/// A run to an accuracy is a march with a tolerance of about this share of it.
const OF_TOLERANCE: f64 = 1e-2;
/// Rounding moves a number by this share of it at most.
const ROUNDING: f64 = 0.5 * f64::EPSILON;
/// A coordinate is far from 0 if it is so many times what it moves by: its rounding is more than is ordinary then.
pub(super) const FAR: f64 = ORDINARY / ROUNDING;

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

impl Formulas {
    /// Looks at the formulas of a run of `case` at these places. Returns also what rounding takes at most from
    /// what a run is certified with: the forces f_a + F_a of the Lagrangian, and K.
    pub(super) fn new<S: Real>(case: &Case, setup: &Setup<S>, places: &Places) -> (Self, Vec<f64>) {
        if S::IS_EXTENDED {
            return (Self::Conditioned, Vec::new());
        }
        let mut found = Largest::new(places.ranges());
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
        for seen in places.seen() {
            let here = Evaluated::where_set(&mut here, (case, setup), seen);
            let Some(here) = here else { return (Self::Unknown, Vec::new()) };
            found.see(here, seen);
        }
        found.told()
    }
}

/// The formula that may be why a run of `case`, of which these places were seen, is not solved: it loses more than its
/// windows may be off by.
pub(crate) fn lost_to<S: Real>(case: &Case, setup: &Setup<S>, mut places: Places, why: &NoSolution) -> Option<Lossy> {
    use Status::{AccuracyNotReached, EvaluationLimit, Stalled, TooManyNodes};
    let is_short_of_it = matches!(why.status, AccuracyNotReached | EvaluationLimit | Stalled | TooManyNodes);
    let accuracy = setup.settings.accuracy.filter(|_| is_short_of_it)?.value();
    let place = |name: &String| setup.rough.geometry.names().iter().position(|other| other == name);
    let end: Vec<(usize, f64)> = why.point.iter().filter_map(|(name, value)| Some((place(name)?, *value))).collect();
    places.see_ends(&setup.rough.start, &end);
    match Formulas::new(case, setup, &places).0 {
        Formulas::Lost(Lost { finding: Finding { sentence, far, .. }, share, .. })
            if share > OF_TOLERANCE * accuracy =>
        {
            Some(Lossy { finding: sentence, is_far: far.is_some() })
        }
        _ => None,
    }
}

/// The losses of rates to rounding at a place: of q̇^a and then of ṗ_a.
pub(super) struct Losses {
    pub(super) exact: Vec<Extended>,
    /// The rates minus exact ones, in each way in which the run computes them.
    pub(super) computed: Vec<Vec<f64>>,
    /// The same in size of what a run is certified with: of the forces of the Lagrangian, and of K. As q̇^a is
    /// g^ab p_b, what g^ab is off by makes Δq̇^a of velocities, and −p_a Δq̇^a of K.
    certified: Vec<f64>,
    /// By how much the rounding of a coordinate that is far from 0 may move each.
    pub(super) rounded: Vec<f64>,
}

impl Losses {
    fn largest(&self) -> Vec<f64> {
        let mut all = self.rounded.clone();
        for (k, all) in all.iter_mut().enumerate() {
            *all += self.computed.iter().fold(0.0_f64, |most, off| most.max(off[k].abs()));
        }
        all
    }
}

/// The rates of a case in both precisions, where events have set these parameters.
pub(super) struct Evaluated {
    set: Vec<(usize, f64)>,
    text: GeometryText,
    rough: Geometry,
    windows: Rates,
    exact: WrittenRates<Extended>,
    /// True if a grid is given: its equations are those of the Lagrangian.
    is_given: bool,
    /// The number of coordinates that are results: not s of Newton's law.
    count: usize,
}

impl Evaluated {
    /// The rates where events have set parameters as at this place: `here`, or others if they were set anew.
    pub(super) fn where_set<'h, S: Real>(
        here: &'h mut Option<Self>,
        (case, setup): (&Case, &Setup<S>),
        seen: &Seen,
    ) -> Option<&'h mut Self> {
        if here.as_ref().is_none_or(|here| here.set != seen.set) {
            *here = Self::new(case, setup, seen);
        }
        here.as_mut()
    }

    fn new<S: Real>(case: &Case, setup: &Setup<S>, Seen { q, set, .. }: &Seen) -> Option<Self> {
        let changed = if set.is_empty() { None } else { Some(case.with_parameters(set, q)?) };
        let rough = changed.as_ref().map_or_else(|| (*setup.rough.geometry).clone(), Case::geometry);
        let text = changed.as_ref().unwrap_or(case).geometry_text.clone();
        Some(Self {
            set: set.clone(),
            exact: WrittenRates::new(&text, setup.is_backward).ok()?,
            text,
            count: rough.dimension() - usize::from(case.is_lifted()),
            windows: Rates::new(&rough),
            rough,
            is_given: setup.settings.accuracy.is_none(),
        })
    }

    /// The formulas and the geometry that are talked of, with the number of coordinates that are results.
    fn named(&self) -> (&GeometryText, &Geometry, usize) {
        (&self.text, &self.rough, self.count)
    }

    /// The rates as windows compute them, in which products are rounded with sums, as they are computed at points, and
    /// by the Lagrangian: q̇^a and then ṗ_a.
    pub(super) fn computed(&mut self, Seen { q, p, .. }: &Seen) -> [Vec<f64>; 3] {
        let (n, mut point) = (q.len(), self.rough.point());
        let mut rates = vec![f64::NAN; 2 * n];
        if point.evaluate(q, p).is_err() {
            return [rates.clone(), rates.clone(), rates];
        }
        (0..n).for_each(|a| rates[a] = point.q_dot(a));
        rates[n..].fill(0.0);
        self.rough.active().iter().enumerate().for_each(|(place, &a)| rates[n + a] = point.p_dot(place));
        let of_lagrangian = [&rates[..n], &self.rough.forces(q, &rates[..n])].concat();
        let mut of_windows = self.windows.at(&self.rough, q, p);
        // What leaves the range of numbers on its way is mended at points.
        of_windows.iter_mut().zip(&rates).filter(|(own, _)| !own.is_finite()).for_each(|(own, rate)| *own = *rate);
        [of_windows, rates, of_lagrangian]
    }

    /// The rates in 70 digits.
    pub(super) fn exact(&mut self, seen: &Seen, changed: impl Fn(usize, f64) -> Extended) -> Vec<Extended> {
        let all: Vec<Extended> =
            seen.q.iter().chain(&seen.p).enumerate().map(|(k, &value)| changed(k, value)).collect();
        let (q, p) = all.split_at(seen.q.len());
        self.exact.at(q, p)
    }

    /// The losses of rates at a place, where a coordinate may be far from 0. `None` if this is no state in 70 digits.
    pub(super) fn losses(&mut self, seen: &Seen, far: Option<usize>) -> Option<Losses> {
        let exact = self.exact(seen, |_, value| Extended::from(value));
        if !exact.iter().all(|rate| rate.is_finite()) {
            return None;
        }
        let off = |(rate, exact): (f64, &Extended)| {
            let off = (Extended::from(rate) - *exact).to_f64();
            // What is not a number has lost all.
            if off.is_nan() { exact.to_f64().abs() } else { off }
        };
        let mut computed: Vec<Vec<f64>> =
            self.computed(seen).into_iter().map(|rates| rates.into_iter().zip(&exact).map(off).collect()).collect();
        let n = seen.q.len();
        let norm = computed[1][..n].iter().zip(&seen.p).map(|(off, p)| (off * p).abs()).sum();
        let certified = computed[2][n..].iter().map(|off| off.abs()).chain([norm]).collect();
        computed.truncate(if self.is_given { 3 } else { 2 });
        let rounded = far.map_or_else(|| vec![0.0; exact.len()], |a| self.rounded(seen, &exact, a));
        Some(Losses { exact, computed, certified, rounded })
    }

    /// By how much the rounding of a coordinate changes each rate: by its derivative, as a jump that is next to the
    /// place is met by windows of its own.
    fn rounded(&mut self, seen: &Seen, rates: &[Extended], coordinate: usize) -> Vec<f64> {
        let changed = |k: usize, value: f64| {
            let value = Extended::from(value);
            if k == coordinate { value * (Extended::ONE + Extended::from(CHANGE)) } else { value }
        };
        let others = self.exact(seen, changed);
        let change = |(&other, &rate): (&Extended, &Extended)| {
            ((other - rate) / Extended::from(CHANGE)).to_f64().abs() * ROUNDING
        };
        others.iter().zip(rates).map(change).collect()
    }

    /// The size of each rate with all that changes of its numbers by a share of these `sizes` make of it: very small
    /// ones, and such as rounding makes, which may pass a jump. The side of it that a place is on says nothing of a
    /// formula.
    fn scales(&mut self, seen: &Seen, rates: &[Extended], sizes: &[f64]) -> Vec<f64> {
        let mut scales = vec![0.0_f64; rates.len()];
        for (by, pattern) in
            [CHANGE, ORDINARY].into_iter().flat_map(|by| (0..PATTERNS).map(move |pattern| (by, pattern)))
        {
            let changed = |k: usize, value: f64| {
                // The bits of multiples of the golden ratio are as good as random.
                let is_up = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (40 + pattern) & 1 == 1;
                let change = Extended::from(sizes[k]) * Extended::from(by);
                Extended::from(value) + if is_up { change } else { -change }
            };
            for ((scale, &rate), other) in scales.iter_mut().zip(rates).zip(self.exact(seen, changed)) {
                *scale = scale.max(((other - rate) / Extended::from(by)).to_f64().abs());
            }
        }
        scales.iter().zip(rates).map(|(scale, rate)| scale + rate.to_f64().abs()).collect()
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
        for a in 0..here.count.min(self.at_start.len()) {
            let exact = found.exact[n + a].to_f64().abs();
            if losses[n + a] > 0.0 && exact <= losses[n + a] {
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

    fn see(&mut self, here: &mut Evaluated, seen: &Seen) {
        let (n, far) = (seen.q.len(), far(&seen.q, &self.ranges));
        // A place that is no state in 70 digits shows nothing.
        let Some(found) = here.losses(seen, far) else { return };
        self.is_seen = true;
        let (losses, Losses { exact, certified, .. }) = (found.largest(), &found);
        self.certified.iter_mut().zip(certified).for_each(|(most, off)| *most = larger(*most, *off));
        let mut numbers: Vec<f64> = seen.q.iter().chain(&seen.p).copied().collect();
        let sizes = self.sizes.iter_mut().zip(exact);
        sizes.for_each(|(size, rate)| *size = size.max(rate.to_f64().abs()));
        // s of Newton's law is no result.
        let is_more = |k: &usize| k % n < here.count && losses[*k] > ORDINARY * self.sizes[*k];
        let large: Vec<usize> = (0..2 * n).filter(is_more).collect();
        if large.is_empty() {
            return;
        }
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
        // Of what moves and is pushed later, the rounding at the start is one of many.
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
