//! Some places of a run, at which its formulas are looked at, and the places where they jump.

use crate::geometry::Start;
use crate::number::Real;
use crate::solve::WorldLine;
use crate::trajectory::{Sample, Sampler};

/// From so many to twice as many places of a run are kept, spread evenly over its windows as it goes.
const PLACES: usize = 16;
/// A window in which a coordinate that goes as fast as it has gone comes no further than this share of where it has
/// been is at one place: it was cut to meet something that jumps there. Both ends are rounded, and windows are cut by
/// factors.
const ONE_PLACE: f64 = 16.0 * f64::EPSILON;
/// No window is at one place that is longer than this share of the run so far: a coordinate may hardly have moved.
const SHORT: f64 = 1e-8;

/// Some places of a run, inside its windows, with the parameters that events have set before them.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// Every so manieth candidate is kept, of [`PLACES`] in each window.
    stride: usize,
    next: usize,
    seen: Vec<Seen>,
    /// The largest |q^a| so far, at the ends of windows, and the largest mean |dq^a/dγ| in one that is not short.
    largest: Vec<f64>,
    fastest: Vec<f64>,
    /// By how much windows at one place have changed each momentum, in all.
    met: Vec<f64>,
}

/// A state in doubles, of the motion as it is computed, which is the reversed one if γ falls.
#[derive(Debug)]
pub(super) struct Seen {
    pub(super) q: Vec<f64>,
    pub(super) p: Vec<f64>,
    pub(super) set: Vec<(usize, f64)>,
}

impl Places {
    /// Takes the next part of a run into account, where events have `set` parameters. A part that contains the first
    /// window begins the run again.
    pub(crate) fn see<S: Real>(&mut self, part: &WorldLine<S>, set: &[(usize, f64)]) {
        let first = part.window_count - part.windows.len();
        if first == 0 {
            let met = vec![0.0; part.geometry().dimension()];
            let largest = part.joint(0).q.iter().map(|q| q.to_f64().abs()).collect();
            let fastest = vec![0.0; met.len()];
            *self = Self { stride: 1, met, largest, fastest, ..Self::default() };
        }
        self.see_met(part);
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

    /// Where a force jumps it acts from somewhere in a window of one place on: all that it does there is uncertain.
    fn see_met<S: Real>(&mut self, part: &WorldLine<S>) {
        let geometry = part.geometry();
        for (index, window) in part.windows.iter().enumerate() {
            let (start, end) = (part.joint(index), part.joint(index + 1));
            let [from, to] = window.gamma.map(S::to_f64);
            let (h, is_short) = (to - from, to - from <= SHORT * to);
            let mut is_here = false;
            for (a, (&before, &behind)) in start.q.iter().zip(end.q).enumerate() {
                self.largest[a] = self.largest[a].max(behind.to_f64().abs());
                if !is_short {
                    self.fastest[a] = self.fastest[a].max((behind - before).to_f64().abs() / h);
                }
                let (fastest, room) = (self.fastest[a], ONE_PLACE * self.largest[a]);
                let is_active = geometry.depends_on(a) || geometry.active().contains(&a);
                is_here |= is_short && is_active && fastest > 0.0 && fastest * h <= room;
            }
            if is_here {
                let changes = end.p.iter().zip(start.p).map(|(&to, &from)| (to - from).to_f64().abs());
                self.met.iter_mut().zip(changes).for_each(|(met, change)| *met += change);
            }
        }
    }

    /// Takes the start of a run into account, of which nothing else may be known but where some coordinates were in the
    /// end: as a place with the momenta of the start, which is as good as any to look at formulas.
    pub(super) fn see_ends(&mut self, Start { q, p, .. }: &Start, end: &[(usize, f64)]) {
        let mut at = q.clone();
        end.iter().for_each(|&(a, value)| at[a] = value);
        self.seen.extend([q.clone(), at].map(|q| Seen { q, p: p.clone(), set: Vec::new() }));
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

    /// By how much each momentum is uncertain since forces jump at places that are rounded.
    pub(super) fn met(&self) -> &[f64] {
        &self.met
    }
}
