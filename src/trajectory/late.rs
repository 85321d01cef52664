//! By how much the place of a zero is open, since its formula rounds.

use super::Sampler;
use super::inside::{epsilon, of_inside};
use crate::geometry::Observable;
use crate::number::Real;
use crate::solve::{At, OfState, WorldLine, noise, rounding};

/// The part of a window from which the slope of a formula at its zero is taken.
const STEP: f64 = 1e-6;

/// Places next to each other show how a formula scatters: over a part of a window whose square is rounding it is a
/// straight line, but for rounding. They are not even, as steps of rounding are.
const NEAR: [f64; 7] = [-0.37, -0.31, -0.17, -0.06, 0.09, 0.22, 0.41];

/// The rounding of a formula at its zeros.
#[derive(Debug, Clone, Default)]
pub(super) struct Late<S> {
    /// The number of zeros so far.
    zeros: usize,
    /// The largest rounding of its values. It is looked for at the first zero, the second, the fourth and so on: from
    /// one to the next it changes as the sizes of states do.
    noise: S,
}

impl<S: Real> Late<S> {
    /// By how much γ of a zero of a formula of the solver's states is open, at this place of a window.
    pub(super) fn at<'l>(
        &mut self,
        sampler: &mut Sampler<'l, S>,
        at: &mut At<'l, S>,
        formula: OfState<'_, S>,
        (window, place): (usize, S),
    ) -> S {
        let line = sampler.line;
        let (curve, geometry, length) = (sampler.curve(window), line.geometry(), line.windows[window].length());
        self.zeros += 1;
        if self.zeros.is_power_of_two() {
            let (mut state, extents) = (curve.at(place, geometry).concat(), curve.extents(geometry));
            let off = |k: usize, value: S| rounding(value, extents[k][0], epsilon(line));
            self.noise = self.noise.max(noise(at, formula, &mut state, off));
            // What it rounds by itself scatters its values at places that are next to each other.
            let mut near = |part: f64, close: S| {
                let place = place + S::from(part) * close;
                at.value(formula, &curve.at(place, geometry).concat())
            };
            let mut close = epsilon(line).sqrt() * length;
            // On a step of rounding nothing scatters.
            while close < length && near(-0.5, close) == near(0.5, close) {
                close *= S::from(10.0);
            }
            let [first, last] = [-0.5, 0.5].map(|part| near(part, close));
            for part in NEAR {
                let straight = first + (last - first) * S::from(part + 0.5);
                let off = (near(part, close) - straight).abs();
                self.noise = self.noise.max(off + off);
            }
        }
        let mut value = |place: S| at.value(formula, &curve.at(place, geometry).concat()).abs();
        let step = S::from(STEP) * length;
        let late = self.noise * step / (value(place - step) + value(place + step)).half();
        if late <= step {
            return late;
        }
        // The slope is small there, or the formula jumps: the values tell where they are more than their own rounding.
        let extents = curve.extents(geometry);
        let off = |k: usize, value: S| rounding(value, extents[k][0], epsilon(line));
        let mut is_told = |step: S| {
            [place - step, place + step].into_iter().all(|place| {
                let mut state = curve.at(place, geometry).concat();
                let value = at.value(formula, &state).abs();
                value > noise(at, formula, &mut state, off)
            })
        };
        let (mut late, ten) = (step, S::from(10.0));
        while late < length && !is_told(late) {
            late *= ten;
        }
        let least = S::from(4.0) * epsilon(line) * line.gamma_i.abs().max(line.windows[window].gamma[1]);
        while late > least && is_told(late / ten) {
            late = late / ten;
        }
        late
    }
}

/// The same where a run ends at the zero of a formula of the solver's states.
pub(crate) fn late_at_end<S: Real>(line: &WorldLine<S>, formula: &Observable<S>) -> S {
    let Some(window) = line.windows.len().checked_sub(1) else { return S::ZERO };
    let (start, mut formula) = (&line.place.start, formula.clone());
    let norm = line.geometry().norm(&start.q, &start.q_dot);
    let of_state = &mut |q: &[S], q_dot: &[S], p: &[S]| formula.at(q, q_dot, p, norm);
    let place = (window, line.windows[window].length());
    Late::default().at(&mut Sampler::new(line), &mut At::new(line.geometry()), of_state, place)
}

/// The same of a watched formula, which is one of the states of the motion.
pub(super) fn late_at<'l, S: Real>(
    late: &mut Late<S>,
    (sampler, at): (&mut Sampler<'l, S>, &mut Option<At<'l, S>>),
    (formula, norm): (&mut Observable<S>, S),
    place: (usize, S),
) -> S {
    let line = sampler.line;
    let at = at.get_or_insert_with(|| At::new(line.geometry()));
    late.at(sampler, at, &mut of_inside(line, formula, norm), place)
}
