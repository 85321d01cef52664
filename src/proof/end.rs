//! From the end of the last window back to the end of the motion, which lies just before it.
//!
//! At a distance τ ≥ 0 before the end of the window x(h − τ) = x(h) − τ f(x(h)) ± τ²/2 sup |J f|. To γ_f, τ is known.
//! To where a coordinate t has a value, τ = (t(h) − value ± τ²/2 sup |ẗ|)/ṫ(h), so that with φ = f/ṫ at the end
//!
//! ```text
//! x = x(h) − φ (t(h) − value) ± τ²/2 (sup |ẍ| + |φ| sup |ẗ|),
//! ```
//!
//! which keeps what errors of x and t have in common.

use super::ellipse::Bounds;
use super::equations::Equations;
use super::proved::Proved;
use super::set::{Differences, Set, sum_of_sizes};
use super::tables::UP;
use super::window::Prover;
use super::{Coordinate, Generator, Motion, Reason, Spread, Until};
use crate::number::ball::{Ball, Disc, OFF};
use crate::number::{Extended, Real};

/// The last window is so many times as long as motions of a set may end later than others.
const ROOM: f64 = 4.0;
/// A value is looked for up to this share of a window behind its end, so that no window is left in front of it.
const BEHIND: f64 = 1e-6;

/// The last window of a set begins so many times as far from the value as its motions may be apart.
const APART: f64 = 12.0;

/// Where a proof ends.
pub(super) enum Goal {
    /// After a length of γ, which may be shorter or longer by so much.
    Length(Extended, f64),
    /// Where an unknown has a value, in this direction and after about this length, if that is known.
    Value { unknown: usize, value: Extended, sign: f64, about: f64 },
}

impl Goal {
    /// Where a coordinate moves at a constant velocity, it has its value after a length.
    pub(super) fn new(motion: &Motion<'_>, equations: &Equations<'_>) -> Self {
        let late = motion.generators.iter().map(|generator| generator.length.abs()).sum::<f64>() * UP + motion.late;
        match motion.until {
            Until::Length(length) => Self::Length(length, late),
            Until::Value(a, value) => {
                let (way, rate) = (value - motion.start.q[a], motion.start.q_dot[a]);
                let unknown = equations.of.iter().position(|of| *of == (a, false));
                match unknown.filter(|_| motion.is_spread || !equations.is_steady(a)) {
                    Some(unknown) => {
                        let about = (way / rate).abs().to_f64();
                        Self::Value { unknown, value, sign: way.to_f64().signum(), about }
                    }
                    None => {
                        let of_start = motion.off_at_start(a) / rate.abs().to_f64() * UP;
                        Self::Length((way / rate).abs(), (late + of_start) * UP)
                    }
                }
            }
        }
    }

    /// Where an unknown is 0, in this generator.
    pub(super) fn zero(unknown: usize, sign: f64) -> Self {
        Self::Value { unknown, value: Extended::ZERO, sign, about: f64::NAN }
    }

    /// Its length and what that is off by, if it is one.
    pub(super) fn exact_length(&self) -> (Extended, f64) {
        match self {
            Self::Length(length, late) => (*length, length.to_f64() * OFF + late),
            Self::Value { .. } => (Extended::ZERO, 0.0),
        }
    }

    /// About how long the motion is.
    pub(super) fn length(&self) -> f64 {
        match self {
            Self::Length(length, late) => length.to_f64() + late,
            Self::Value { about, .. } => *about,
        }
    }

    /// Returns true if slopes on these sides lead to the value.
    pub(super) fn is_ahead(&self, sides: &[f64]) -> bool {
        match self {
            Self::Length(..) => true,
            Self::Value { unknown, sign, .. } => sides[*unknown] == *sign,
        }
    }

    /// The length of the window that begins at `reached` and should be `h` long, and whether it is the last one.
    pub(super) fn step(&self, reached: f64, h: f64) -> (f64, bool) {
        let Self::Length(length, late) = self else { return (h, false) };
        let left = *length + Extended::from(*late) - Extended::from(reached);
        let near = left.to_f64();
        // Motions of a set end in the last window, which is longer than what their ends are apart.
        if h < near * (1.0 - BEHIND) && near - h >= ROOM * late {
            return (h, false);
        }
        // The true length may be longer than these digits of it.
        (if Extended::from(near) <= left { near.next_up() } else { near }, true)
    }

    /// The length of the window until just behind the value, if this window passes it. Motions of a set pass it one
    /// after the other, and all of them in one window: if it ends a little before that, it has to be longer.
    pub(super) fn passed(&self, set: &Set, proved: &Proved) -> Option<f64> {
        let h = proved.h;
        self.passed_within(set, proved, [0.0, h * (1.0 + BEHIND)]).or_else(|| {
            let Self::Value { unknown: k, value, sign, .. } = *self else { return None };
            let left = (value - Extended::from(set.start[k]) - Extended::from(set.centre[k])).to_f64();
            let on_way = |h| sign * way(&proved.modes[k], proved.h, h);
            let (missing, rate) = (sign * left - on_way(h), (on_way(h) - on_way(0.99 * h)) / (0.01 * h));
            let apart = proved.added.epsilon[k];
            let is_near = rate > 0.0 && missing < APART * apart;
            is_near.then(|| h + (missing + 4.0 * apart) / rate)
        })
    }

    /// The same, if it is passed between these two places.
    pub(super) fn passed_within(&self, set: &Set, proved: &Proved, [from, to]: [f64; 2]) -> Option<f64> {
        let Self::Value { unknown: k, value, sign, .. } = *self else { return None };
        let left = (value - Extended::from(set.start[k]) - Extended::from(set.centre[k])).to_f64();
        // What is missing after a length of the window.
        let missing = |h: f64| sign * (left - way(&proved.modes[k], proved.h, h));
        let (mut low, mut high) = (from, to);
        if missing(high) > 0.0 {
            return None;
        }
        while high - low > 2.0 * f64::EPSILON * high {
            let middle = 0.5 * (low + high);
            (low, high) = if missing(middle) > 0.0 { (middle, high) } else { (low, middle) };
        }
        let size = set.size(k, proved.sizes[k]);
        let rate = (way(&proved.modes[k], proved.h, high) - way(&proved.modes[k], proved.h, 0.99 * high)).abs();
        // All of a set have passed then, and not much more: the way back has to stay inside of the window.
        let margin = (1.5 * proved.added.epsilon[k] + 16.0 * f64::EPSILON * size) * 0.01 * high / rate;
        Some(high * (1.0 + 4.0 * f64::EPSILON) + margin)
    }
}

/// The way of an unknown after a part `h` of a window of this length, but for rounding.
pub(super) fn way(modes: &[f64], length: f64, h: f64) -> f64 {
    let x = 2.0 * h / length - 1.0;
    let (mut before, mut here, mut sum) = (1.0, x, modes[0] * (1.0 + x));
    for (k, mode) in modes.iter().enumerate().skip(1) {
        let next = ((2 * k + 1) as f64 * x * here - k as f64 * before) / (k + 1) as f64;
        sum += mode * (next - before) / (2 * k + 1) as f64;
        (before, here) = (here, next);
    }
    0.5 * length * sum
}

/// The unknowns at the end of the motion, and γ − γ_i there, with their radii.
pub(super) struct End {
    pub(super) unknowns: Vec<(Extended, f64)>,
    /// The unknowns at the ends of the motions of a set.
    pub(super) spreads: Vec<Spread>,
    pub(super) gamma: (Extended, f64),
    /// True if it is where an unknown has a value.
    pub(super) is_at_value: bool,
}

impl End {
    /// The end of a motion without unknowns, after a length of γ.
    pub(super) fn after(gamma: (Extended, f64)) -> Self {
        Self { unknowns: Vec::new(), spreads: Vec::new(), gamma, is_at_value: false }
    }

    /// From the set at the end of the last window, which ends after `reached` and has these bounds on its ellipse.
    pub(super) fn new(
        prover: &mut Prover<'_>,
        set: &Set,
        goal: &Goal,
        (reached, h): (Extended, f64),
        bounds: &Bounds,
        generators: &[Generator],
    ) -> Result<Self, Reason> {
        let slopes = prover.ellipse.slopes_around(&prover.equations, &set.start, &set.sizes());
        // |ẍ| = |J f|.
        let bends = growths(&prover.equations, bounds, &bounds.slope);
        let back = Back::new(set, goal, (reached, h), &slopes, &bends).ok_or(Reason::Short)?;
        let unknowns: Vec<(Extended, f64)> =
            (0..set.start.len()).map(|k| back.unknown(set, k, &slopes, &bends)).collect();
        let gamma = back.gamma(set, reached, &slopes, &bends);
        let at_value = || (0..set.start.len()).filter_map(|k| back.at_value(set, k, &slopes, &bends));
        let spreads = match &set.differences {
            Some(_) if back.along.is_some() => at_value().map(|spread| of_starts(spread, generators.len())).collect(),
            Some(differences) => {
                let growths = growths(&prover.equations, bounds, &differences.within);
                let spread =
                    |k: usize| back.spread((set, differences), k, (slopes[k], bends[k], growths[k]), generators);
                (0..set.start.len()).map(spread).collect()
            }
            None => at_value().collect(),
        };
        let is_known = |(value, radius): &(Extended, f64)| value.is_finite() && radius.is_finite();
        if unknowns.iter().chain([&gamma]).all(is_known) {
            Ok(Self { unknowns, spreads, gamma, is_at_value: back.along.is_some() })
        } else {
            Err(Reason::Lost)
        }
    }
}

/// A number with the columns of so many directions of starts alone: the others are in its radius.
fn of_starts(Spread { value, mut columns, radius, slack }: Spread, many: usize) -> Spread {
    let others = columns.split_off(many.min(columns.len()));
    Spread { value, columns, radius: (radius + sum_of_sizes(&others)) * UP, slack }
}

/// Bounds of |J z| where z is within these.
fn growths(equations: &Equations<'_>, bounds: &Bounds, z: &[f64]) -> Vec<f64> {
    let mut growths = vec![0.0; bounds.slope.len()];
    for (entry, jacobian) in equations.entries.iter().zip(&bounds.jacobian) {
        growths[entry.row] += jacobian * z[entry.column] * UP;
    }
    growths
}

/// The middle of the set of an unknown.
fn middle(set: &Set, k: usize) -> Extended {
    Extended::from(set.start[k]) + Extended::from(set.centre[k])
}

/// The way back.
struct Back {
    /// The unknown that has a value at the end, if it is one.
    along: Option<usize>,
    /// τ, or t(h) − value in the middle; and a bound of τ.
    by: Extended,
    most: f64,
    /// What the decimals of the end are off by.
    off: f64,
    /// By how much a motion of the set may end earlier or later.
    late: f64,
}

impl Back {
    /// From the end of a window of length `h`, which ends after `reached`. `None` if the value is not known to be
    /// passed, or not known to be passed once.
    fn new(set: &Set, goal: &Goal, (reached, h): (Extended, f64), slopes: &[Disc], bends: &[f64]) -> Option<Self> {
        Some(match *goal {
            Goal::Length(length, late) => {
                let tau = reached - length;
                // The length of the case is off, too.
                let most = ((tau.abs() + length * Extended::from(OFF)).to_f64() + late) * UP + 1e-300;
                Self { along: None, by: tau, most, off: length.to_f64() * OFF, late }
            }
            Goal::Value { unknown, value, sign, .. } => {
                let by = middle(set, unknown) - value;
                let rate = slopes[unknown].re.abs() - slopes[unknown].rad;
                let off = value.abs().to_f64() * OFF;
                let gap = set.radii()[unknown] + off;
                let beyond = by.to_f64() * sign - gap * UP;
                let most = 2.0 * (by.to_f64().abs() + gap) / rate * UP;
                // Over so long ṫ stays above half of what it is at the end.
                let is_passed = rate > 0.0 && beyond >= 0.0 && most <= h && most * bends[unknown] <= 0.5 * rate;
                is_passed.then_some(Self { along: Some(unknown), by, most, off, late: 0.0 })?
            }
        })
    }

    fn unknown(&self, set: &Set, k: usize, slopes: &[Disc], bends: &[f64]) -> (Extended, f64) {
        match self.at_value(set, k, slopes, bends) {
            Some(spread) if self.along == Some(k) => return (spread.value, spread.radius),
            Some(spread) => return (spread.value, spread.reach()),
            None => {}
        }
        let (middle, slope) = (middle(set, k), slopes[k]);
        let off = slope.size() * (self.off + self.late);
        let rad = set.radii()[k] + self.most * slope.rad + off + 0.5 * self.most * self.most * bends[k];
        (middle - Extended::from(slope.re) * self.by, rad * UP)
    }

    /// An unknown where another one has a value, with what is left of the columns of the set; `None` at a length.
    fn at_value(&self, set: &Set, k: usize, slopes: &[Disc], bends: &[f64]) -> Option<Spread> {
        let along = self.along?;
        let (middle, curved) = (middle(set, k), 0.5 * self.most * self.most);
        if along == k {
            let columns = vec![0.0; set.errors.columns[k].len()];
            return Some(Spread { value: middle - self.by, columns, radius: self.off, slack: f64::INFINITY });
        }
        let phi = slopes[k] / slopes[along];
        let [own, other] = [k, along].map(|i| &set.errors.columns[i]);
        let of_columns: Vec<f64> = own.iter().zip(other).map(|(own, other)| own - phi.re * other).collect();
        let rounded = f64::EPSILON * (sum_of_sizes(own) + phi.size() * sum_of_sizes(other));
        let gap = self.by.to_f64().abs() + set.radii()[along];
        let of_box = set.errors.rest[k] + phi.size() * set.errors.rest[along] + phi.rad * gap * UP;
        let rest = phi.size() * self.off + curved * (bends[k] + phi.size() * bends[along]);
        let radius = (rounded + of_box + rest) * UP;
        let value = middle - Extended::from(phi.re) * self.by;
        Some(Spread { value, columns: of_columns, radius, slack: f64::INFINITY })
    }

    /// An unknown at the ends of the motions of a set, which end after lengths.
    ///
    /// Two of them end at τ and τ′, where x(h − τ) − x′(h − τ′) = η(h) − τ η̇ + (τ′ − τ) ẋ′, with rates in between.
    fn spread(
        &self,
        (set, differences): (&Set, &Differences),
        k: usize,
        (slope, bend, growth): (Disc, f64, f64),
        generators: &[Generator],
    ) -> Spread {
        let (own, others) = set.errors.columns[k].split_at(set.errors.generators);
        let columns: Vec<f64> =
            own.iter().zip(generators).map(|(own, generator)| own + slope.re * generator.length).collect();
        let rounded = 4.0 * f64::EPSILON * (sum_of_sizes(own) + slope.size() * self.late);
        let of_box = set.errors.rest[k] + self.most * slope.rad + slope.size() * self.off;
        let radius = sum_of_sizes(others) + of_box + 0.5 * self.most * self.most * bend + rounded;
        let apart = sum_of_sizes(&differences.set.columns[k][differences.set.generators..]) + differences.set.rest[k];
        let slack = apart + self.most * growth + self.late * (slope.rad + self.most * bend) + rounded;
        let value = middle(set, k) - Extended::from(slope.re) * self.by;
        Spread { value, columns, radius: radius * UP, slack: slack * UP }
    }

    fn gamma(&self, set: &Set, reached: Extended, slopes: &[Disc], bends: &[f64]) -> (Extended, f64) {
        let Some(along) = self.along else { return (reached - self.by, self.off + self.late) };
        let inverse = Disc::of(Ball::exact(1.0)) / slopes[along];
        let curved = 0.5 * self.most * self.most * bends[along];
        let rad = inverse.size() * (set.radii()[along] + self.off + curved) + inverse.rad * self.by.to_f64().abs() * UP;
        (reached - self.by * Extended::from(inverse.re), rad * UP)
    }
}

/// Where a coordinate is that moves at a constant velocity, after a length with a radius.
pub(super) fn moved(start: Extended, rate: Extended, (gamma, radius): (Extended, f64)) -> (Extended, f64) {
    let off = (start.abs() + (rate * gamma).abs()).to_f64() * OFF + rate.abs().to_f64() * radius;
    (start + rate * gamma, off * UP)
}

/// The coordinates after a length of γ, in their order, with the values of unknowns there.
pub(super) fn coordinates(
    motion: &Motion<'_>,
    equations: &Equations<'_>,
    gamma: (Extended, f64),
    unknowns: &[(Extended, f64)],
) -> Vec<Coordinate> {
    let results = motion.results();
    let unknowns = unknowns.iter().zip(&equations.of);
    let positions = unknowns.filter(|(_, (coordinate, is_momentum))| !is_momentum && *coordinate < results);
    let found = positions.map(|(&(value, radius), &(coordinate, _))| Coordinate {
        coordinate,
        value,
        radius,
        is_steady: false,
    });
    let steady = equations.steady.iter().filter(|a| **a < results).map(|&a| {
        let (value, radius) = moved(motion.start.q[a], motion.start.q_dot[a], gamma);
        Coordinate { coordinate: a, value, radius: (radius + motion.off_at_start(a)) * UP, is_steady: true }
    });
    let mut all: Vec<Coordinate> = found.chain(steady).collect();
    all.sort_by_key(|coordinate| coordinate.coordinate);
    all
}

#[cfg(test)]
mod tests;
