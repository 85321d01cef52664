//! Some places of a run, at which its formulas are looked at, and the places where they jump.

use crate::geometry::Start;
use crate::number::Real;
use crate::solve::WorldLine;
use crate::trajectory::Sampler;

/// So many places of each window may be kept.
const OF_WINDOW: usize = 16;
/// From so many to twice as many of a run are, spread evenly over its windows as it goes.
const KEPT: usize = 16;
/// A window in which a coordinate that goes as fast as it has gone comes no further than this share of where it has
/// been is at one place: it was cut to meet something that jumps there. Both ends are rounded, and windows are cut by
/// factors.
const ONE_PLACE: f64 = 16.0 * f64::EPSILON;
/// So many windows in which a force may jump are looked at.
const MOST_MEETINGS: usize = 16;
/// No window is cut to meet a jump that is longer than this share of the run so far.
const SHORT: f64 = 1e-8;
/// Beside a place that is reached at rest windows are shorter than this part of the mean so far, and so many of their
/// starts are kept.
const MET_SHORT: f64 = 1e-4;
const MOST_SHORT: usize = 64;

/// Some places of a run, inside its windows, with the parameters that events have set before them.
#[derive(Debug)]
pub(super) struct Places {
    /// From so many to twice as many places are kept.
    kept: usize,
    /// Every so manieth candidate is kept, of [`OF_WINDOW`] in each window.
    stride: usize,
    next: usize,
    seen: Vec<Seen>,
    /// The largest |q^a| so far, at the ends of windows, and the largest mean |dq^a/dγ| in one that is not short.
    largest: Vec<f64>,
    fastest: Vec<f64>,
    /// Short windows, and by how much what the others change of each momentum is uncertain, in all.
    meetings: Vec<Meeting>,
    met: Vec<f64>,
    /// The starts of windows that are far shorter than the others, with γ: the slowest of them.
    short: Vec<(f64, Seen)>,
}

/// A short window, in which a force may jump.
#[derive(Debug)]
pub(super) struct Meeting {
    /// The state at its start.
    pub(super) start: Seen,
    /// γ at its start, and by how much γ grows in it.
    pub(super) gamma: f64,
    pub(super) length: f64,
    /// By how much momenta change.
    pub(super) changes: Vec<f64>,
    /// The share of it that rounding moves its place by.
    pub(super) uncertain: f64,
    /// True if it was cut to meet something at one place.
    is_one_place: bool,
}

impl Meeting {
    /// By how much momenta are uncertain, if nothing else is known but whether the window was cut to meet a jump.
    pub(super) fn open(&self) -> impl Iterator<Item = f64> {
        self.changes.iter().map(|change| if self.is_one_place { self.uncertain * change.abs() } else { 0.0 })
    }

    /// The same, if a force jumps in it.
    fn size(&self) -> f64 {
        self.changes.iter().fold(0.0, |most, change| most.max(self.uncertain * change.abs()))
    }
}

/// A state in doubles, of the motion as it is computed, which is the reversed one if γ falls.
#[derive(Debug)]
pub(super) struct Seen {
    pub(super) q: Vec<f64>,
    pub(super) p: Vec<f64>,
    pub(super) set: Vec<(usize, f64)>,
    /// A part of |γ_f − γ_i|: how much of it this place stands for, beside the others.
    pub(super) part: f64,
}

impl Seen {
    /// The q^a and p_a of a sample of this part of a run, as coordinates are counted in it.
    pub(super) fn of<S: Real>(line: &WorldLine<S>, [q, p]: [Vec<S>; 2], set: &[(usize, f64)]) -> Self {
        let q = q.iter().enumerate().map(|(a, &q)| (q - line.origin_of(a)).to_f64()).collect();
        let p = p.into_iter().map(|p| line.signed(p).to_f64()).collect();
        Self { q, p, set: set.to_vec(), part: 0.0 }
    }
}

impl Default for Places {
    fn default() -> Self {
        Self::of(KEPT)
    }
}

impl Places {
    /// None yet, of which from so many to twice as many will be kept.
    pub(super) fn of(kept: usize) -> Self {
        let (seen, largest, fastest, meetings, met, short) = Default::default();
        Self { kept, stride: 1, next: 0, seen, largest, fastest, meetings, met, short }
    }

    /// Takes the next part of a run into account, where events have `set` parameters. A part that contains the first
    /// window begins the run again.
    pub(super) fn see<S: Real>(&mut self, part: &WorldLine<S>, set: &[(usize, f64)]) {
        let first = part.window_count - part.windows.len();
        if first == 0 {
            let met = vec![0.0; part.geometry().dimension()];
            let largest = part.joint(0).q.iter().map(|q| q.to_f64().abs()).collect();
            let fastest = vec![0.0; met.len()];
            *self = Self { met, largest, fastest, ..Self::of(self.kept) };
        }
        self.see_met(part, set);
        if self.next >= OF_WINDOW * part.window_count {
            return;
        }
        let mut sampler = Sampler::new(part);
        while self.next < OF_WINDOW * part.window_count {
            let (index, place) = (self.next / OF_WINDOW - first, self.next % OF_WINDOW);
            let window = &part.windows[index];
            // A node inside of the window: between nodes a coarse run may be anywhere, and at ends formulas may jump.
            let node = (2 * place + 1) * (window.points() - 1) / (2 * OF_WINDOW);
            let state = sampler.inside(index, node.clamp(1, window.points().max(3) - 2));
            self.seen.push(Seen { part: window.length().to_f64(), ..Seen::of(part, state, set) });
            self.next += self.stride;
            if self.seen.len() == 2 * self.kept {
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

    /// Where a force jumps it acts from somewhere in a window on: what it does there is uncertain, for as much of the
    /// window as rounding moves the place.
    fn see_met<S: Real>(&mut self, part: &WorldLine<S>, set: &[(usize, f64)]) {
        let (geometry, first) = (part.geometry(), part.window_count - part.windows.len());
        for (index, window) in part.windows.iter().enumerate() {
            let (start, end) = (part.joint(index), part.joint(index + 1));
            let [from, to] = window.gamma.map(S::to_f64);
            let (h, is_short) = (to - from, to - from <= SHORT * to);
            let (mut uncertain, mut is_one_place) = (0.0_f64, false);
            for (a, (&before, &behind)) in start.q.iter().zip(end.q).enumerate() {
                let moved = (behind - before).to_f64().abs();
                self.largest[a] = self.largest[a].max(behind.to_f64().abs());
                if !is_short {
                    self.fastest[a] = self.fastest[a].max(moved / h);
                }
                let (fastest, largest) = (self.fastest[a], self.largest[a]);
                let is_active = geometry.depends_on(a) || geometry.active().contains(&a);
                if is_short && is_active && fastest > 0.0 {
                    // At one place the coordinate may turn.
                    let is_here = fastest * h <= ONE_PLACE * largest;
                    let way = if is_here { moved } else { fastest * h };
                    is_one_place |= is_here;
                    // It is rounded by half a unit, and so is the place that it is compared with.
                    uncertain = uncertain.max((f64::EPSILON * largest / way).min(1.0));
                }
            }
            let state = || Seen { part: h, ..Seen::of(part, [start.q.to_vec(), start.p.to_vec()], set) };
            if h * ((first + index) as f64) < MET_SHORT * from {
                self.see_short(geometry.active(), (part.gamma_at(window.gamma[0]).to_f64(), state()));
            }
            if uncertain > 0.0 {
                let changes = end.p.iter().zip(start.p).map(|(&to, &from)| part.signed(to - from).to_f64()).collect();
                self.meet(Meeting { start: state(), gamma: from, length: h, changes, uncertain, is_one_place });
            }
        }
    }

    /// Keeps the starts of short windows, at which a coordinate moves least.
    fn see_short(&mut self, active: &[usize], short: (f64, Seen)) {
        self.short.push(short);
        if self.short.len() > MOST_SHORT {
            let least = |(_, seen): &(f64, Seen)| active.iter().fold(f64::INFINITY, |p, &a| p.min(seen.p[a].abs()));
            let fastest = (0..self.short.len())
                .max_by(|&one, &other| least(&self.short[one]).total_cmp(&least(&self.short[other])));
            self.short.swap_remove(fastest.unwrap_or_default());
        }
    }

    /// Keeps the windows whose changes are most uncertain.
    fn meet(&mut self, meeting: Meeting) {
        self.meetings.push(meeting);
        if self.meetings.len() > MOST_MEETINGS {
            let least = (0..self.meetings.len())
                .min_by(|&one, &other| self.meetings[one].size().total_cmp(&self.meetings[other].size()));
            let least = self.meetings.swap_remove(least.unwrap_or_default());
            self.met.iter_mut().zip(least.open()).for_each(|(met, open)| *met += open);
        }
    }

    /// Takes the start of a run into account, of which nothing else may be known but where some coordinates were in the
    /// end: as a place with the momenta of the start, which is as good as any to look at formulas.
    pub(super) fn see_ends(&mut self, Start { q, p, .. }: &Start, end: &[(usize, f64)]) {
        let mut at = q.clone();
        end.iter().for_each(|&(a, value)| at[a] = value);
        self.seen.extend([q.clone(), at].map(|q| Seen { q, p: p.clone(), set: Vec::new(), part: 0.0 }));
    }

    /// The places.
    pub(super) fn seen(&self) -> &[Seen] {
        &self.seen
    }

    /// By how much every coordinate moves from the first of them to the others.
    pub(super) fn ranges(&self) -> Vec<f64> {
        let Some((first, rest)) = self.seen.split_first() else { return Vec::new() };
        let range = |a: usize| rest.iter().fold(0.0_f64, |range, seen| range.max((seen.q[a] - first.q[a]).abs()));
        (0..first.q.len()).map(range).collect()
    }

    /// The largest |p_a| of every coordinate.
    pub(super) fn sizes_of_momenta(&self, coordinates: usize) -> Vec<f64> {
        let largest = |a: usize| self.seen.iter().fold(0.0_f64, |size, seen| size.max(seen.p[a].abs()));
        (0..coordinates).map(largest).collect()
    }

    /// The starts of windows that are far shorter than the others, with γ.
    pub(super) fn short(&self) -> impl Iterator<Item = &(f64, Seen)> {
        self.short.iter()
    }

    /// The sizes of all q^a, as they have been so far, and of all p_a, in a state; 1 where nothing is known.
    pub(super) fn sizes(&self, Seen { q, p, .. }: &Seen) -> impl Iterator<Item = f64> {
        let momenta = self.sizes_of_momenta(q.len());
        let known = |size: f64| if size > 0.0 { size } else { 1.0 };
        let positions = q.iter().enumerate().map(|(a, q)| self.largest.get(a).map_or(q.abs(), |far| far.max(q.abs())));
        let momenta = p.iter().zip(momenta).map(|(p, size)| size.max(p.abs()));
        positions.chain(momenta).map(known).collect::<Vec<_>>().into_iter()
    }

    /// The windows in which forces may jump at places that are rounded, and by how much each momentum is uncertain
    /// since there are more of them.
    pub(super) fn met(&self) -> (&[Meeting], &[f64]) {
        (&self.meetings, &self.met)
    }
}
