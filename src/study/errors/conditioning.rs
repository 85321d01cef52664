//! What rounding takes from the formulas of a case: at some places of a run all rates are evaluated in 70 digits from
//! the same doubles of the state, and compared with those that the run was computed with.

use crate::case::Case;
use crate::geometry::{Geometry, GeometryText, Law, Place, Start, WrittenFormulas, WrittenRates, value_of};
use crate::number::{Extended, Real};
use crate::solve::{Setup, Status, WorldLine};
use crate::trajectory::{Sample, Sampler};

/// From so many to twice as many places of a run are kept, spread evenly over its windows as it goes.
const PLACES: usize = 16;
/// A rate may lose so many roundings of what its own numbers make of it: some tens of operations round by half a unit
/// each, and functions by a few.
const ORDINARY: f64 = 64.0 * f64::EPSILON;
/// The relative change of all numbers that shows what they make of a rate, 2^-80: with its square it is exact to the
/// digits of a double.
const CHANGE: f64 = 1.0 / (1_u128 << 80) as f64;
/// Numbers are changed with so many patterns of signs, since in one of them changes may cancel.
const PATTERNS: u32 = 8;
/// A run to an accuracy is a march with a tolerance of about this share of it.
const OF_TOLERANCE: f64 = 1e-2;
/// The first formula that loses this share of what another one loses is the one to name: those after it may use it.
const SHARE: f64 = 0.1;
/// At most so many coordinates are named.
const NAMED: usize = 3;

/// Some places of a run, inside its windows, with the parameters that events have set before them.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// Every so manieth candidate is kept, of [`PLACES`] in each window.
    stride: usize,
    next: usize,
    seen: Vec<Seen>,
}

/// A state in doubles, of the motion as it is computed, which is the reversed one if γ falls.
#[derive(Debug)]
struct Seen {
    q: Vec<f64>,
    p: Vec<f64>,
    set: Vec<(usize, f64)>,
}

impl Places {
    /// Takes the next part of a run into account, where events have `set` parameters. A part that contains the first
    /// window begins the run again.
    pub(crate) fn see<S: Real>(&mut self, part: &WorldLine<S>, set: &[(usize, f64)]) {
        let first = part.window_count - part.windows.len();
        if first == 0 {
            *self = Self { stride: 1, ..Self::default() };
        }
        if self.next >= PLACES * part.window_count {
            return;
        }
        let mut sampler = Sampler::new(part);
        while self.next < PLACES * part.window_count {
            let (window, place) = (&part.windows[self.next / PLACES - first], self.next % PLACES);
            // A node inside of the window: between nodes a coarse run may be anywhere, and at ends formulas may jump.
            let node = (2 * place + 1) * (window.points() - 1) / (2 * PLACES);
            let gamma = part.gamma_at(window.gamma_at(node.clamp(1, window.points().max(3) - 2)));
            if let Ok(Sample { q, p, .. }) = sampler.at_gamma(gamma) {
                let q = q.iter().enumerate().map(|(a, &q)| (q - part.origin_of(a)).to_f64()).collect();
                let p = p.into_iter().map(|p| part.signed(p).to_f64()).collect();
                self.seen.push(Seen { q, p, set: set.to_vec() });
            }
            self.next += self.stride;
            if self.seen.len() == 2 * PLACES {
                let mut is_even = false;
                self.seen.retain(|_| {
                    is_even = !is_even;
                    is_even
                });
                self.stride *= 2;
                self.next = self.next.next_multiple_of(self.stride);
            }
        }
    }

    /// Takes the start of a run into account, of which nothing else may be known.
    fn see_start(&mut self, start: &Start) {
        self.seen.push(Seen { q: start.q.clone(), p: start.p.clone(), set: Vec::new() });
    }

    /// The largest |p_a| of every coordinate.
    pub(super) fn sizes_of_momenta(&self, coordinates: usize) -> Vec<f64> {
        let largest = |a: usize| self.seen.iter().fold(0.0_f64, |size, seen| size.max(seen.p[a].abs()));
        (0..coordinates).map(largest).collect()
    }
}

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
    /// A sentence about the formula that loses most: which one, how much, and where.
    pub(super) finding: String,
    /// The largest share that a rate loses.
    pub(super) share: f64,
    /// True if it loses all of its digits: then a solve in more of them, whose guesses have 16, begins with nothing.
    pub(super) is_all: bool,
}

impl Formulas {
    /// Looks at the formulas of a run of `case` at these places.
    pub(crate) fn new<S: Real>(case: &Case, setup: &Setup<S>, places: &Places) -> Self {
        if S::IS_EXTENDED {
            return Self::Conditioned;
        }
        let mut found = Largest::new(setup.place.start.q.len());
        let mut here: Option<Evaluated> = None;
        for seen in &places.seen {
            if here.as_ref().is_none_or(|here| here.set != seen.set) {
                here = Evaluated::new(case, setup, seen);
            }
            let Some(here) = &mut here else { return Self::Unknown };
            found.see(here, seen);
        }
        found.told()
    }
}

/// A sentence about the formula that may be why a run of `case`, of which these places were seen, ended with `status`:
/// it loses more than its windows may be off by.
pub(crate) fn lost_to<S: Real>(case: &Case, setup: &Setup<S>, mut places: Places, status: Status) -> Option<String> {
    use Status::{AccuracyNotReached, EvaluationLimit, Stalled, TooManyNodes};
    let is_short_of_it = matches!(status, AccuracyNotReached | EvaluationLimit | Stalled | TooManyNodes);
    let accuracy = setup.settings.accuracy.filter(|_| is_short_of_it)?.value();
    places.see_start(&setup.rough.start);
    match Formulas::new(case, setup, &places) {
        Formulas::Lost(lost) if lost.share > OF_TOLERANCE * accuracy => Some(lost.finding),
        _ => None,
    }
}

/// The rates of a case in both precisions, where events have set these parameters.
struct Evaluated {
    set: Vec<(usize, f64)>,
    text: GeometryText,
    rough: Geometry,
    exact: WrittenRates<Extended>,
    /// True if a grid is given: its equations are those of the Lagrangian.
    is_given: bool,
    /// The number of coordinates that are results: not s of Newton's law.
    count: usize,
}

impl Evaluated {
    fn new<S: Real>(case: &Case, setup: &Setup<S>, Seen { q, set, .. }: &Seen) -> Option<Self> {
        let changed = if set.is_empty() { None } else { Some(case.with_parameters(set, q)?) };
        let rough = changed.as_ref().map_or_else(|| (*setup.rough.geometry).clone(), Case::geometry);
        let text = changed.as_ref().unwrap_or(case).geometry_text.clone();
        Some(Self {
            set: set.clone(),
            exact: WrittenRates::new(&text, setup.is_backward).ok()?,
            text,
            count: rough.dimension() - usize::from(case.is_lifted()),
            rough,
            is_given: setup.settings.accuracy.is_none(),
        })
    }

    /// The rates as they are computed, each in all ways in which it is: q̇^a and then ṗ_a.
    fn computed(&self, Seen { q, p, .. }: &Seen) -> Vec<Vec<f64>> {
        let (n, mut point) = (q.len(), self.rough.point());
        let mut rates = vec![f64::NAN; 2 * n];
        if point.evaluate(q, p).is_err() {
            return vec![rates];
        }
        (0..n).for_each(|a| rates[a] = point.q_dot(a));
        rates[n..].fill(0.0);
        self.rough.active().iter().enumerate().for_each(|(place, &a)| rates[n + a] = point.p_dot(place));
        if !self.is_given {
            return vec![rates];
        }
        let forces = self.rough.forces(q, &rates[..n]);
        let of_lagrangian = [&rates[..n], &forces].concat();
        vec![rates, of_lagrangian]
    }

    /// The rates in 70 digits.
    fn exact(&mut self, seen: &Seen, changed: impl Fn(usize, f64) -> Extended) -> Vec<Extended> {
        let all: Vec<Extended> =
            seen.q.iter().chain(&seen.p).enumerate().map(|(k, &value)| changed(k, value)).collect();
        let (q, p) = all.split_at(seen.q.len());
        self.exact.at(q, p)
    }

    /// The size of each rate with all that relative changes of its numbers make of it: very small ones, and such as
    /// rounding makes, which may pass a jump. The side of it that a place is on says nothing of a formula.
    fn scales(&mut self, seen: &Seen, rates: &[Extended]) -> Vec<f64> {
        let mut scales = vec![0.0_f64; rates.len()];
        for (by, pattern) in
            [CHANGE, ORDINARY].into_iter().flat_map(|by| (0..PATTERNS).map(move |pattern| (by, pattern)))
        {
            let changed = |k: usize, value: f64| {
                // The bits of multiples of the golden ratio are as good as random.
                let is_up = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (40 + pattern) & 1 == 1;
                let change = Extended::from(value) * Extended::from(by);
                Extended::from(value) + if is_up { change } else { -change }
            };
            for ((scale, &rate), other) in scales.iter_mut().zip(rates).zip(self.exact(seen, changed)) {
                *scale = scale.max(((other - rate) / Extended::from(by)).to_f64().abs());
            }
        }
        scales.iter().zip(rates).map(|(scale, rate)| scale + rate.to_f64().abs()).collect()
    }
}

/// The largest losses along a run.
struct Largest {
    lost: Vec<f64>,
    sizes: Vec<f64>,
    /// The largest loss as a share of its rate, the sentence about it, and whether all digits are lost.
    worst: (f64, String, bool),
    is_seen: bool,
}

impl Largest {
    fn new(coordinates: usize) -> Self {
        let zeros = || vec![0.0; 2 * coordinates];
        Self { lost: zeros(), sizes: zeros(), worst: (0.0, String::new(), false), is_seen: false }
    }

    fn see(&mut self, here: &mut Evaluated, seen: &Seen) {
        let (n, exact) = (seen.q.len(), here.exact(seen, |_, value| Extended::from(value)));
        // A place that is no state in 70 digits shows nothing.
        if !exact.iter().all(|rate| rate.is_finite()) {
            return;
        }
        self.is_seen = true;
        let mut losses = vec![0.0_f64; 2 * n];
        for computed in here.computed(seen) {
            for ((loss, rate), exact) in losses.iter_mut().zip(computed).zip(&exact) {
                let off = (Extended::from(rate) - *exact).to_f64().abs();
                // What is not a number has lost all.
                *loss = loss.max(if off.is_nan() { exact.to_f64().abs() } else { off });
            }
        }
        let sizes = self.sizes.iter_mut().zip(&exact);
        sizes.for_each(|(size, rate)| *size = size.max(rate.to_f64().abs()));
        // s of Newton's law is no result.
        let is_more = |k: &usize| k % n < here.count && losses[*k] > ORDINARY * self.sizes[*k];
        let large: Vec<usize> = (0..2 * n).filter(is_more).collect();
        if large.is_empty() {
            return;
        }
        let scales = here.scales(seen, &exact);
        for k in large {
            if losses[k] <= ORDINARY * scales[k] {
                continue;
            }
            self.lost[k] = self.lost[k].max(losses[k]);
            let share = losses[k] / scales[k];
            if share > self.worst.0 {
                let (finding, is_all) = finding(here, seen, &exact[..n], share);
                self.worst = (share, finding, is_all);
            }
        }
    }

    fn told(self) -> Formulas {
        if !self.is_seen {
            return Formulas::Unknown;
        }
        if self.worst.0 == 0.0 {
            return Formulas::Conditioned;
        }
        let (q_dot, p_dot) = self.lost.split_at(self.lost.len() / 2);
        Formulas::Lost(Lost {
            q_dot: q_dot.to_vec(),
            p_dot: p_dot.to_vec(),
            finding: self.worst.1,
            share: self.worst.0,
            is_all: self.worst.2,
        })
    }
}

/// A sentence about the formula that loses most at a place, where rates lose this share, and whether all digits are
/// lost.
fn finding(here: &Evaluated, Seen { q, .. }: &Seen, q_dot: &[Extended], share: f64) -> (String, bool) {
    let names = here.rough.names();
    let active = (0..here.count).filter(|a| here.rough.depends_on(*a) || here.rough.active().contains(a));
    let shown: Vec<String> = active.take(NAMED).map(|a| format!("{} = {:.4}", names[a], q[a])).collect();
    let place = if shown.is_empty() { String::new() } else { format!(" near {}", shown.join(", ")) };
    let (name, share) = named(here, q, q_dot).unwrap_or_else(|| ("that the motion follows from".to_owned(), share));
    let digits = (-f64::EPSILON.log10() + share.min(1.0).log10()).round();
    let is_all = share >= SHARE;
    let many = if is_all { "all of its digits".to_owned() } else { format!("{digits} of its 16 digits") };
    (format!("the formula {name} loses {many} to rounding{place}"), is_all)
}

/// The name of the formula that loses most at a place, as it stands in the case, and the share that it loses.
fn named(here: &Evaluated, q: &[f64], q_dot: &[Extended]) -> Option<(String, f64)> {
    let text = &here.text;
    let share = |rough: f64, exact: Extended| {
        let off = (Extended::from(rough) - exact).to_f64().abs();
        if off == 0.0 { 0.0 } else { (off / exact.to_f64().abs()).min(1.0) }
    };
    let parameter = |(name, _): &(String, String)| {
        let rough = value_of::<f64>(name, &text.parameters).ok()?;
        Some((format!("of the parameter {name}"), share(rough, value_of(name, &text.parameters).ok()?)))
    };
    let mut found: Vec<(String, f64)> = text.parameters.iter().filter_map(parameter).collect();
    // Newton's forces have velocities by t.
    let pace = if text.law() == Some(Law::Newtonian) { q_dot[0] } else { Extended::ONE };
    let q_dot: Vec<Extended> = q_dot.iter().map(|&rate| rate / pace).collect();
    let rough_rates: Vec<f64> = q_dot.iter().map(|rate| rate.to_f64()).collect();
    let q_exact: Vec<Extended> = q.iter().map(|&q| Extended::from(q)).collect();
    let rough = WrittenFormulas::<f64>::new(text).ok()?.at(q, &rough_rates);
    let exact = WrittenFormulas::<Extended>::new(text).ok()?.at(&q_exact, &q_dot);
    for ((place, rough), (_, exact)) in rough.into_iter().zip(exact) {
        let shares = rough.into_iter().zip(exact).map(|(rough, exact)| share(rough, exact));
        found.push((name_of(&place, text), shares.fold(0.0, f64::max)));
    }
    let most = found.iter().fold(0.0_f64, |most, (_, share)| most.max(*share));
    found.into_iter().find(|(_, share)| *share > 0.0 && *share >= SHARE * most)
}

/// The name of a formula as it stands in a case.
fn name_of(place: &Place, text: &GeometryText) -> String {
    let coordinate = |a: usize| text.coordinates.get(a).cloned().unwrap_or_default();
    match place {
        Place::Component([a, b]) => format!("of the component \"{} {}\"", coordinate(*a), coordinate(*b)),
        Place::Definition(name) => format!("of the definition {name}"),
        Place::Parameter(name) => format!("of the parameter {name}"),
        Place::OneForm(a) => format!("one_form.{}", coordinate(*a)),
        Place::Force(a) => format!("force.{}", coordinate(*a)),
        Place::Conformal => "conformal".to_owned(),
        Place::Potential => "of the potential".to_owned(),
        Place::Mass(Some(a)) => format!("of the mass of {}", coordinate(*a)),
        Place::Mass(None) => "of the mass".to_owned(),
        Place::SpeedOfLight => "of c".to_owned(),
    }
}
