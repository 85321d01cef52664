//! The rates of a case as a run computes them, and in more digits.

use super::places::Seen;
use crate::case::Case;
use crate::engine::Rates;
use crate::geometry::{Geometry, GeometryText, Point, WrittenRates};
use crate::number::ball::Ball;
use crate::number::{Extended, Real};
use crate::solve::Setup;

/// A rate may lose so many roundings of what its own numbers make of it: some tens of operations round by half a unit
/// each, and functions by a few.
pub(super) const ORDINARY: f64 = 64.0 * f64::EPSILON;
/// The relative change of all numbers that shows what they make of a rate, 2^-80: with its square it is exact to the
/// digits of a double.
const CHANGE: f64 = 1.0 / (1_u128 << 80) as f64;
/// Numbers are changed with so many patterns of signs, since in one of them changes may cancel.
pub(super) const PATTERNS: u32 = 8;
/// Rounding moves a number by this share of it at most.
pub(super) const ROUNDING: f64 = 0.5 * f64::EPSILON;
/// A ball is narrow if its radius is no more than this share of a rate, a billionth of a rounding. So small a radius as
/// the second number is nothing: underflow leaves one of a rate that is 0.
const NARROW: f64 = 1e-9 * ROUNDING;
const NOTHING: f64 = 1e-150;

/// The losses of rates to rounding at a place: of q̇^a and then of ṗ_a.
pub(super) struct Losses {
    pub(super) exact: Vec<Extended>,
    /// The rates minus exact ones, in each way in which the run computes them.
    pub(super) computed: Vec<Vec<f64>>,
    /// The same in size of what a run is certified with: of the forces of the Lagrangian, and of K. As q̇^a is
    /// g^ab p_b, what g^ab is off by makes Δq̇^a of velocities, and −p_a Δq̇^a of K.
    pub(super) certified: Vec<f64>,
    /// By how much the rounding of a coordinate that is far from 0 may move each.
    pub(super) rounded: Vec<f64>,
}

impl Losses {
    pub(super) fn largest(&self) -> Vec<f64> {
        let mut all = self.rounded.clone();
        for (k, all) in all.iter_mut().enumerate() {
            *all += self.computed.iter().fold(0.0_f64, |most, off| most.max(off[k].abs()));
        }
        all
    }
}

/// The sign, 1 or −1, by which the number `k` is changed in one of [`PATTERNS`].
pub(super) fn side(k: usize, pattern: u32) -> f64 {
    // The bits of multiples of the golden ratio are as good as random.
    let is_up = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (40 + pattern) & 1 == 1;
    if is_up { 1.0 } else { -1.0 }
}

/// The rates of a case in both precisions, where events have set these parameters.
#[derive(Debug)]
pub(super) struct Evaluated {
    set: Vec<(usize, f64)>,
    text: GeometryText,
    pub(super) rough: Geometry,
    windows: Rates,
    exact: WrittenRates<Extended>,
    /// True if a grid is given: its equations are those of the Lagrangian.
    is_given: bool,
    /// The number of coordinates that are results: not s of Newton's law.
    pub(super) count: usize,
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

    pub(super) fn new<S: Real>(case: &Case, setup: &Setup<S>, Seen { q, set, .. }: &Seen) -> Option<Self> {
        let changed = if set.is_empty() { None } else { Some(case.with_parameters(set, q)?) };
        let rough = changed.as_ref().map_or_else(|| (*setup.rough.geometry).clone(), Case::geometry);
        let case = changed.as_ref().unwrap_or(case);
        Some(Self {
            set: set.clone(),
            exact: case.written_rates(setup.is_backward)?,
            text: case.geometry_text.clone(),
            count: rough.dimension() - usize::from(case.is_lifted()),
            windows: Rates::new(&rough),
            rough,
            is_given: setup.settings.accuracy.is_none(),
        })
    }

    /// The formulas and the geometry that are talked of, with the number of coordinates that are results.
    pub(super) fn named(&self) -> (&GeometryText, &Geometry, usize) {
        (&self.text, &self.rough, self.count)
    }

    /// The rates as windows compute them, in which products are rounded with sums, as they are computed at points, and
    /// by the Lagrangian: q̇^a and then ṗ_a.
    pub(super) fn computed(&mut self, Seen { q, p, .. }: &Seen) -> [Vec<f64>; 3] {
        let n = q.len();
        let Some(rates) = at_point(&self.rough, &mut self.rough.point(), [q, p]) else {
            return std::array::from_fn(|_| vec![f64::NAN; 2 * n]);
        };
        let of_lagrangian = [&rates[..n], &self.rough.forces(q, &rates[..n])].concat();
        let mut of_windows = self.windows.at(&self.rough, q, p);
        // Rates that leave the range of numbers on their way are mended at points.
        of_windows.iter_mut().zip(&rates).filter(|(own, _)| !own.is_finite()).for_each(|(own, rate)| *own = *rate);
        [of_windows, rates, of_lagrangian]
    }

    /// The rates as windows compute them, and by how much each is off, as far as 32 digits tell: 0 where they do not.
    pub(super) fn off(&mut self, Seen { q, p, .. }: &Seen) -> (Vec<f64>, Vec<f64>) {
        let rates = self.windows.at(&self.rough, q, p);
        let off = |(rate, exact): (&f64, Ball)| {
            let off = (rate - exact.hi - exact.lo).abs();
            // Where the ball is too large, 70 digits are asked at some places.
            if off > exact.rad { off } else { 0.0 }
        };
        let off = rates.iter().zip(self.exact.in_balls(q, p)).map(off).collect();
        (rates, off)
    }

    /// By how much half a unit in the last place of every coordinate that moves changes each of these rates, with a
    /// pattern of signs.
    pub(super) fn moved_by_rounding(&mut self, Seen { q, p, .. }: &Seen, rates: &[f64], pattern: u32) -> Vec<f64> {
        let moved = |(a, &value): (usize, &f64)| {
            if rates[a] == 0.0 { value } else { value * (1.0 + side(a, pattern) * f64::EPSILON) }
        };
        let moved: Vec<f64> = q.iter().enumerate().map(moved).collect();
        let others = self.windows.at(&self.rough, &moved, p);
        others.iter().zip(rates).map(|(other, rate)| 0.5 * (other - rate).abs()).collect()
    }

    /// The rates in 70 digits.
    pub(super) fn exact(&mut self, seen: &Seen, changed: impl Fn(usize, f64) -> Extended) -> Vec<Extended> {
        let all: Vec<Extended> =
            seen.q.iter().chain(&seen.p).enumerate().map(|(k, &value)| changed(k, value)).collect();
        let (q, p) = all.split_at(seen.q.len());
        self.exact_at(q, p)
    }

    /// The same at a state that is no double.
    pub(super) fn exact_at(&mut self, q: &[Extended], p: &[Extended]) -> Vec<Extended> {
        self.exact.at(q, p)
    }

    /// The losses of rates at a place, where a coordinate may be far from 0. `None` if this is no state in 70 digits.
    pub(super) fn losses(&mut self, seen: &Seen, far: Option<usize>) -> Option<Losses> {
        let exact = self.exact(seen, |_, value| Extended::from(value));
        if !exact.iter().all(|rate| rate.is_finite()) {
            return None;
        }
        let rounded = far.map_or_else(|| vec![0.0; exact.len()], |a| self.rounded(seen, &exact, a));
        let off = |k: usize, rate: f64| (Extended::from(rate) - exact[k]).to_f64();
        let (computed, certified) = self.lost(seen, &exact, off);
        Some(Losses { exact, computed, certified, rounded })
    }

    /// Bounds of the same from balls, at a small part of the costs, if these are narrow beside rates of these `sizes`.
    pub(super) fn losses_in_balls(&mut self, seen: &Seen, sizes: &[f64]) -> Option<Losses> {
        let balls: Vec<Ball> = self.exact.in_balls(&seen.q, &seen.p).collect();
        let is_narrow = |(ball, size): (&Ball, &f64)| ball.rad <= (NARROW * size.max(ball.hi.abs())).max(NOTHING);
        if !balls.iter().zip(sizes).all(is_narrow) {
            return None;
        }
        let exact: Vec<Extended> = balls.iter().map(|ball| Extended::from(ball.hi) + Extended::from(ball.lo)).collect();
        let off = |k: usize, rate: f64| {
            let Ball { hi, lo, rad } = balls[k];
            (rate - hi - lo).abs() + if rad > NOTHING { rad } else { 0.0 }
        };
        let (computed, certified) = self.lost(seen, &exact, off);
        Some(Losses { rounded: vec![0.0; exact.len()], exact, computed, certified })
    }

    /// What the run loses of rates at a place, in each way in which it computes them, and of what it is certified with,
    /// where a computed rate, by its place, is `off` by so much from the exact one.
    fn lost(&mut self, seen: &Seen, exact: &[Extended], off: impl Fn(usize, f64) -> f64) -> (Vec<Vec<f64>>, Vec<f64>) {
        let off = |(k, rate): (usize, f64)| {
            let off = off(k, rate);
            // A rate that is not a number has lost all.
            if off.is_nan() { exact[k].to_f64().abs() } else { off }
        };
        let ways = self.computed(seen).into_iter();
        let mut computed: Vec<Vec<f64>> = ways.map(|rates| rates.into_iter().enumerate().map(off).collect()).collect();
        let n = seen.q.len();
        let norm = computed[1][..n].iter().zip(&seen.p).map(|(off, p)| (off * p).abs()).sum();
        let certified = computed[2][n..].iter().map(|off| off.abs()).chain([norm]).collect();
        computed.truncate(if self.is_given { 3 } else { 2 });
        (computed, certified)
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
    pub(super) fn scales(&mut self, seen: &Seen, rates: &[Extended], sizes: &[f64]) -> Vec<f64> {
        let mut scales = vec![0.0_f64; rates.len()];
        for (by, pattern) in
            [CHANGE, ORDINARY].into_iter().flat_map(|by| (0..PATTERNS).map(move |pattern| (by, pattern)))
        {
            let changed = |k: usize, value: f64| {
                Extended::from(value) + Extended::from(sizes[k]) * Extended::from(by * side(k, pattern))
            };
            for ((scale, &rate), other) in scales.iter_mut().zip(rates).zip(self.exact(seen, changed)) {
                *scale = scale.max(((other - rate) / Extended::from(by)).to_f64().abs());
            }
        }
        scales.iter().zip(rates).map(|(scale, rate)| scale + rate.to_f64().abs()).collect()
    }
}

/// The rates at a point, q̇^a and then ṗ_a; `None` outside of the domain.
pub(super) fn at_point(geometry: &Geometry, point: &mut Point<f64>, [q, p]: [&[f64]; 2]) -> Option<Vec<f64>> {
    point.evaluate(q, p).ok()?;
    let n = q.len();
    let mut rates = vec![0.0; 2 * n];
    (0..n).for_each(|a| rates[a] = point.q_dot(a));
    geometry.active().iter().enumerate().for_each(|(place, &a)| rates[n + a] = point.p_dot(place));
    Some(rates)
}
