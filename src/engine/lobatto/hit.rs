//! The window that ends at a given time.

use super::attempt::{Attempt, Task};
use super::force::Force;
use super::walk::{Length, Walk};
use super::window::{MOST_EVALUATIONS, Precision, Solved};
use super::{State, Statistics};
use crate::geometry::geodesic::acceleration;
use crate::number::vector::Twofold;

/// Steps towards the end time: Newton's method takes four, bisection to the last bit sixty.
const MOST_STEPS: usize = 80;

/// The remainder counts as rounding below this share of t, and of the window.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// The remainder, as a share of the accuracy, where the iteration does not go to rounding, as at a kink.
const NOISE: f64 = 0.01;

impl Attempt<'_> {
    /// How much of the requested time is left at `state`.
    pub(super) fn lack(&self, duration: f64, state: &State) -> f64 {
        ((self.start.t + Twofold::from(duration)) - state.t).hi
    }

    /// The length, and the window, at whose end t has the requested value, to the last bit.
    ///
    /// # Errors
    /// The last length that was tried, and the state at its end, if there is none, as where t jumps.
    ///
    /// t grows with γ, so the window `too_long` is an upper bound. Newton's method runs inside the bracket found so
    /// far, on windows that are solved to rounding: with the tolerance of the march the end would depend on where the
    /// iteration began. The final remainder is a rounding error of γ, and is compensated by the motion at the end
    /// itself.
    pub(super) fn hit<const P: usize, F: Force>(
        &self,
        walk: &mut Walk<P, F>,
        Task { length, precision, .. }: Task,
        too_long: Solved,
        start: &State,
        statistics: &mut Statistics,
        duration: f64,
    ) -> Result<(Length, Solved), (Twofold, State)> {
        let goal = self.start.t + Twofold::from(duration);
        let to_rounding = Precision { tolerance: 0.0, most: MOST_EVALUATIONS, ..precision };
        let size = (goal - self.start.t).hi.abs().max(1.0);
        let rounding = ROUNDING * goal.hi.abs().max(duration.abs());
        let (mut below, mut above) = (0.0, length.h.hi);
        let (mut length, mut solved) = (length, too_long);
        for step in 0..MOST_STEPS {
            let lack = self.lack(duration, &solved.end);
            let g = self.metric.at(solved.end.x.hi);
            let left = lack * (g.g00 / self.q_t);
            let is_narrow = above - below <= ROUNDING * above;
            let is_near = is_narrow && lack.abs() <= NOISE * self.accuracy * size;
            if is_near || lack.abs() <= rounding || left.abs() <= ROUNDING * length.h.hi {
                let (h, left) = (length.h + Twofold::from(left), Twofold::from(left));
                let a = Twofold::from(acceleration(self.q_t, g.g00, g.first));
                solved.end.x = solved.end.x + left * (solved.end.w + (left * a).half());
                solved.end.w = solved.end.w + left * a;
                solved.end.t = goal;
                return Ok((Length::exactly(h, self.q_t), solved));
            }
            if is_narrow {
                break;
            }
            if lack * duration > 0.0 {
                below = below.max(length.h.hi);
            } else {
                above = above.min(length.h.hi);
                walk.reject(length);
            }
            let mut next = length.h + Twofold::from(left);
            // Far away the slope at the end says little; Newton's method is still tried.
            if !(next.hi > below && next.hi < above) || step % 8 == 7 {
                next = Twofold::from(0.5 * (below + above));
            }
            loop {
                length = Length::exactly(next, self.q_t);
                let mut solve = |precision: Precision| walk.solve(length, start, precision, statistics);
                if let Some(found) = solve(to_rounding).or_else(|| solve(precision)) {
                    solved = found;
                    break;
                }
                above = next.hi;
                next = Twofold::from(0.5 * (below + above));
                if above - below <= ROUNDING * above {
                    return Err((length.h, solved.end));
                }
            }
        }
        Err((length.h, solved.end))
    }
}
