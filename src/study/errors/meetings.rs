//! Where a force jumps by its formula, and where it does in doubles.
//!
//! A run meets a jump where its formula jumps in doubles. With the decimals of the case and in 70 digits it may jump
//! elsewhere: the place is rounded, and so is all that it is compared with, of which little may be left. What that
//! makes of momenta is found here.

use super::evaluated::{Evaluated, ORDINARY, PATTERNS, side};
use super::places::{Meeting, Places, Seen};
use crate::case::Case;
use crate::geometry::Start;
use crate::number::{Extended, Real};
use crate::solve::Setup;

/// A jump is looked for from so many lengths of a window before it to as many behind it, one after the other.
const REACHES: [f64; 3] = [1.0, 32.0, 1024.0];
/// In doubles it is looked for from within these parts of that: where rounding decides, each may find another place.
const PARTS: [f64; 3] = [1.0, 0.7, 0.4];
/// The way is halved so many times: to the last bit of a double that is as long.
const HALVINGS: usize = 52;

/// Around a start rates are looked at this far away, relative to each coordinate that rests, and at this part of it:
/// what is smooth changes less there, and what jumps as much.
const AROUND: f64 = ORDINARY;
const NEARER: f64 = 0.125;

/// A jump of forces: γ where it is, and by how much each momentum is off behind it.
struct Jump {
    gamma: f64,
    off: Vec<f64>,
}

/// By how much momenta are uncertain in all, in a run of `case`, since forces jump.
pub(super) fn met<S: Real>(case: &Case, setup: &Setup<S>, places: &Places) -> Vec<f64> {
    let (meetings, others) = places.met();
    let (mut all, mut here, mut jumps) = (others.to_vec(), None::<Evaluated>, Vec::<Jump>::new());
    // The shortest ones are nearest to a jump, and others around them need not be looked at.
    let mut in_order: Vec<&Meeting> = meetings.iter().collect();
    in_order.sort_by(|one, other| one.length.total_cmp(&other.length));
    for meeting in in_order {
        let &Meeting { gamma, length, .. } = meeting;
        if jumps.iter().any(|jump| (jump.gamma - gamma - 0.5 * length).abs() <= 1.5 * length) {
            continue;
        }
        let exact = Evaluated::where_set(&mut here, (case, setup), &meeting.start).filter(|_| !S::IS_EXTENDED);
        let found = exact.and_then(|here| here.misplaced(meeting));
        let off = found.as_ref().map_or_else(|| meeting.open().collect(), |jump| jump.off.clone());
        all.iter_mut().zip(off).for_each(|(all, off)| *all += off);
        jumps.extend(found);
    }
    all
}

/// By how much momenta are uncertain over `length`, since the start of a run of `case` lies at a jump of forces, up to
/// rounding, and rests there: which side of it the motion is on, rounding decides.
pub(super) fn at_start<S: Real>(case: &Case, setup: &Setup<S>, length: f64) -> Vec<f64> {
    let geometry = &setup.rough.geometry;
    let mut here = None;
    let Start { q, p, .. } = &*setup.rough.start;
    let start = Seen { q: q.clone(), p: p.clone(), set: Vec::new(), part: 0.0 };
    let at_rest = (geometry.jump().is_some() && !S::IS_EXTENDED)
        .then(|| Evaluated::where_set(&mut here, (case, setup), &start)?.jump_around(&start));
    let by = at_rest.flatten().unwrap_or_else(|| vec![0.0; q.len()]);
    by.into_iter().map(|by| by * length).collect()
}

impl Evaluated {
    /// By how much the rate of each momentum jumps if coordinates that rest are moved by rounding. `None` if it does
    /// not.
    fn jump_around(&mut self, start: &Seen) -> Option<Vec<f64>> {
        let n = start.q.len();
        let rates = self.exact(start, |_, value| Extended::from(value));
        let rests: Vec<bool> = (0..n).map(|a| rates[a] == Extended::ZERO).collect();
        let mut change = |share: f64| {
            let mut most = vec![0.0_f64; n];
            for pattern in 0..PATTERNS {
                let mut moved = |sign: f64| {
                    self.exact(start, |k, value| {
                        let by = if k < n && rests[k] { sign * side(k, pattern) * share } else { 0.0 };
                        Extended::from(value) * (Extended::ONE + Extended::from(by))
                    })
                };
                let [one, other] = [1.0, -1.0].map(&mut moved);
                for (most, (one, other)) in most.iter_mut().zip(one[n..].iter().zip(&other[n..])) {
                    *most = most.max((*one - *other).to_f64().abs());
                }
            }
            most
        };
        let [further, nearer] = [AROUND, AROUND * NEARER].map(&mut change);
        let jumps = |(far, near): (&f64, &f64)| *far > 0.0 && *near > 0.5 * far;
        let by: Vec<f64> = further.iter().zip(&nearer).map(|pair| if jumps(pair) { *pair.0 } else { 0.0 }).collect();
        by.iter().any(|&by| by > 0.0).then_some(by)
    }

    /// By how much each momentum is off behind the jump next to this window. `None` if there is none.
    fn misplaced(&mut self, meeting: &Meeting) -> Option<Jump> {
        let Meeting { start, gamma, length, .. } = meeting;
        let n = start.q.len();
        let along = self.exact(start, |_, value| Extended::from(value));
        if !along.iter().all(|rate| rate.is_finite()) {
            return None;
        }
        let mut exact = |at: f64| {
            let moved = |k: usize, value: f64| Extended::from(value) + Extended::from(at) * along[k];
            self.exact(start, moved)[n..].iter().map(|rate| rate.to_f64()).collect::<Vec<f64>>()
        };
        let found = REACHES.iter().find_map(|reach| {
            let reach = reach * length;
            jump([-reach, length + reach], &mut exact).map(|(place, by)| (reach, place, by))
        });
        let (reach, place, by) = found?;
        let mut rough = |at: f64| {
            let moved = |(k, value): (usize, &f64)| value + at * along[k].to_f64();
            let all: Vec<f64> = start.q.iter().chain(&start.p).enumerate().map(moved).collect();
            let (q, p) = (all[..n].to_vec(), all[n..].to_vec());
            self.computed(&Seen { q, p, set: start.set.clone(), part: 0.0 })[0][n..].to_vec()
        };
        let misplaced = PARTS.iter().map(|part| {
            let ends = [place - part * reach, place + part * reach];
            jump(ends, &mut rough).map_or(reach, |(other, _)| (other - place).abs())
        });
        let misplaced = misplaced.fold(0.0, f64::max);
        let off = by.iter().zip(meeting.open()).map(|(by, open)| (by.abs() * misplaced).max(open)).collect();
        Some(Jump { gamma: gamma + place, off })
    }
}

/// Where rates jump on this way, and by how much each does; `None` if they change smoothly.
fn jump([from, to]: [f64; 2], rates: &mut dyn FnMut(f64) -> Vec<f64>) -> Option<(f64, Vec<f64>)> {
    let (before, behind) = (rates(from), rates(to));
    let change = |one: &[f64], other: &[f64]| other.iter().zip(one).map(|(b, a)| b - a).collect::<Vec<f64>>();
    let by = change(&before, &behind);
    // The force jumps in one place or in several at once: the momentum whose rate changes most tells where.
    let (a, most) = by.iter().map(|by| by.abs()).enumerate().max_by(|(_, one), (_, other)| one.total_cmp(other))?;
    let (mut place, mut last) = (from, to);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (place + last);
        let is_behind = (rates(middle)[a] - before[a]).abs() > 0.5 * most;
        *(if is_behind { &mut last } else { &mut place }) = middle;
    }
    // Just at the place it may have half of its height.
    let here = (rates(last)[a] - rates(place)[a]).abs();
    (most > 0.0 && here >= 0.25 * most && here.is_finite()).then_some((0.5 * (place + last), by))
}
