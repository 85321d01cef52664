//! One window: the fixed-point iteration on its nodes, and the update of the state.

use pulp::Simd;

use super::State;
use super::force::{Force, evaluate, evaluate_apart};
use super::guess::Guess;
use super::product::{dot, plain_dot, product, product_apart};
use super::tables::Tables;
use super::view::NodeValues;
use crate::number::vector::{
    Nodes, Twofold, abs, extremes, largest, multiply_add, product_error, two_product, two_sum, vectors, vectors_mut,
};

/// The most evaluations in one window when every length is to be tried; convergent iterations take ten.
pub(super) const MOST_EVALUATIONS: usize = 60;

/// The arrays of one window.
#[derive(Debug, Clone)]
pub(super) struct Window<const P: usize> {
    /// X = line + rest: the free motion, and the rest.
    pub(super) x: Nodes<P>,
    pub(super) line: Nodes<P>,
    pub(super) rest: Nodes<P>,
    /// a(X) and u(X); at the start of a window still those of the previous one.
    pub(super) a: Nodes<P>,
    pub(super) u: Nodes<P>,
}

/// How accurately to solve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Precision {
    /// The error of X relative to its size; 0 iterates to rounding.
    pub(super) tolerance: f64,
    /// Whether to evaluate the forces once more in twofold precision.
    pub(super) refine: bool,
    /// The most evaluations.
    pub(super) most: usize,
}

impl Precision {
    /// Whether the state is to be updated as if in twice the precision.
    #[inline(always)]
    fn is_twofold(self) -> bool {
        self.refine || self.tolerance == 0.0
    }
}

/// A window that was solved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solved {
    pub(super) end: State,
    pub(super) evaluations: usize,
    /// The least and the largest u.
    pub(super) u: [f64; 2],
    /// Legendre modes of a and u of high degree, and the largest |a|, |u|, if the window was judged.
    pub(super) tail: [f64; 2],
    pub(super) largest: [f64; 2],
}

impl Solved {
    /// From `start`, after the free motion of x and the updates of t, x and w.
    #[inline(always)]
    fn new(start: &State, free: (f64, f64), [dt, dx, dw]: [(f64, f64); 3], evaluations: usize) -> Self {
        let end = State {
            t: start.t.plus_update(dt),
            x: start.x.plus_update(free).plus_update(dx),
            w: start.w.plus_update(dw),
        };
        Self { end, evaluations, u: [0.0; 2], tail: [0.0; 2], largest: [0.0; 2] }
    }
}

/// 1.5 times the power of two in (4 v, 8 v].
#[inline(always)]
fn unit(v: f64) -> f64 {
    f64::from_bits(v.to_bits() & 0x7ff0_0000_0000_0000) * 12.0
}

impl<const P: usize> Window<P> {
    pub(super) fn new() -> Self {
        Self { x: Nodes::ZERO, line: Nodes::ZERO, rest: Nodes::ZERO, a: Nodes::ZERO, u: Nodes::ZERO }
    }

    /// Whether no number of what was computed last is infinite or NaN.
    pub(super) fn is_finite(&self) -> bool {
        [&self.x, &self.a, &self.u].into_iter().flat_map(|nodes| nodes.0).all(f64::is_finite)
    }

    /// X, u and a on the n nodes; γ is counted in `unit`s.
    pub(super) fn nodes(&self, n: usize, unit: Twofold) -> NodeValues<'_> {
        NodeValues { x: &self.x.0[..n], u: &self.u.0[..n], a: &self.a.0[..n], unit: unit.hi }
    }

    /// Adds what the window is judged by: of a and of u the larger one of two Legendre modes, given the rows that take
    /// nodal values to them, and the largest value.
    #[inline(always)]
    pub(super) fn judge<S: Simd>(&self, s: S, rows: &[Nodes<P>; 2], solved: Solved) -> Solved {
        let mut judged = solved;
        for k in 0..2 {
            let v = if k == 0 { &self.a.0 } else { &self.u.0 };
            judged.tail[k] = plain_dot(s, &rows[0].0, v).abs().max(plain_dot(s, &rows[1].0, v).abs());
            judged.largest[k] = largest(s, v);
        }
        judged
    }

    /// The window from `start`; `None` if it does not converge or does not stay inside g00 > 0.
    #[inline(always)]
    pub(super) fn solve<S: Simd, F: Force>(
        &mut self,
        s: S,
        t: &Tables<P>,
        force: &mut F,
        start: &State,
        guess: Guess<'_, P>,
        precision: Precision,
    ) -> Option<Solved> {
        let evaluations = self.iterate(s, t, force, start, guess, precision)?;
        // g00 > 0 where u has the sign of Q_t. (Q_t = 0 leaves u = 0 and a = 0: free motion.)
        let (least, most) = extremes(s, &self.u.0);
        let inside = least > 0.0 || most < 0.0 || (least == 0.0 && most == 0.0);
        let solved = Solved { u: [least, most], ..self.update(s, t, force, start, precision, evaluations) };
        // A NaN anywhere ends up in the state.
        (inside && (solved.end.x.hi + solved.end.w.hi + solved.end.t.hi).is_finite()).then_some(solved)
    }

    /// Solves X = x + h c w + h² A² a(X) and leaves a(X), u(X); the number of evaluations.
    #[inline(always)]
    fn iterate<S: Simd, F: Force>(
        &mut self,
        s: S,
        t: &Tables<P>,
        force: &mut F,
        start: &State,
        guess: Guess<'_, P>,
        precision: Precision,
    ) -> Option<usize> {
        let mut low = self.free_line(s, t, start, precision);
        if self.guess(s, t, &low, guess) {
            self.parabola(s, t, force, start);
        }
        let mut known = 0;
        // To rounding it would save too few evaluations.
        if F::MAY_BE_DEAR && precision.tolerance > 0.0 && force.is_dear() {
            let guess = self.rest;
            match self.newton(s, t, force, &low, start, precision) {
                Ok(evaluations) => return Some(evaluations),
                Err(evaluations) => (known, self.rest) = (evaluations, guess),
            }
        }
        let mut last = f64::INFINITY;
        let mut evaluations = 0;
        let mut near = false;
        loop {
            let change = self.advance(s);
            let scale = self.scale(t, start);
            let (wanted, noise) = (precision.tolerance * scale, 4.0 * f64::EPSILON * scale);
            // a and u of the previous X are good enough, if the step by which u was found left nothing either.
            let is_first = evaluations == 1;
            if near && change <= wanted && (is_first || last * last <= wanted * scale) && wanted > noise {
                return Some(known + evaluations);
            }
            evaluate(s, force, &self.x.0, &mut self.a.0, &mut self.u.0, near);
            evaluations += 1;
            // The error of X is change · rate. At the level of rounding the rate cannot be seen, so one more iteration
            // is made: stopping early would be an error with the same sign in every window.
            let converged = evaluations > 1 && change <= wanted;
            if converged || evaluations > 2 && (change * change <= wanted * last || last <= noise) {
                return Some(known + evaluations);
            }
            if known + evaluations >= precision.most || !change.is_finite() {
                return None;
            }
            if !near && precision.tolerance == 0.0 {
                // The rounding of h² A² moves K by 6e-21 a window.
                product_apart(s, &low.0, &t.force_lo[..t.columns], &self.a.0, &mut self.rest.0);
                low.0 = self.rest.0;
            }
            last = if near { change } else { f64::INFINITY };
            near = true;
            product(s, &low.0, &t.force[..t.columns], &self.a.0, &mut self.rest.0);
        }
    }

    /// The free line x + h c w as `line` + what is returned, to twice the precision: X = line + (low + h² A² a), where
    /// the bracket is small and X is the only number that is rounded at the size of x. (Dropping the rounding error of
    /// h c w alone moves K by 1e-19 a window.)
    #[inline(always)]
    fn free_line<S: Simd>(&mut self, s: S, t: &Tables<P>, start: &State, precision: Precision) -> Nodes<P> {
        let mut rounded_off = Nodes::<P>::ZERO;
        let (x0, x0_lo) = (s.splat_f64s(start.x.hi), s.splat_f64s(start.x.lo));
        let (w0, w0_lo) = (s.splat_f64s(start.w.hi), s.splat_f64s(start.w.lo));
        {
            let (hc, hc_lo) = (vectors::<S>(&t.line), vectors::<S>(&t.line_lo));
            let (line, low) = (vectors_mut::<S>(&mut self.line.0), vectors_mut::<S>(&mut rounded_off.0));
            for i in 0..low.len() {
                if !precision.is_twofold() {
                    (line[i], low[i]) = (multiply_add(s, hc[i], w0, x0), x0_lo);
                    continue;
                }
                let p = s.mul_f64s(hc[i], w0);
                let (sum, error) = two_sum(s, x0, p);
                let error = s.add_f64s(error, product_error(s, hc[i], w0, p));
                line[i] = sum;
                let rest = multiply_add(s, hc_lo[i], w0, multiply_add(s, hc[i], w0_lo, x0_lo));
                low[i] = s.add_f64s(error, rest);
            }
        }
        rounded_off
    }

    /// X = line + rest; the largest change of X.
    #[inline(always)]
    fn advance<S: Simd>(&mut self, s: S) -> f64 {
        let mut change = s.splat_f64s(0.0);
        let (x, line, rest) = (vectors_mut::<S>(&mut self.x.0), vectors::<S>(&self.line.0), vectors::<S>(&self.rest.0));
        for i in 0..x.len() {
            let y = s.add_f64s(line[i], rest[i]);
            change = s.max_f64s(change, abs(s, s.sub_f64s(y, x[i])));
            x[i] = y;
        }
        s.reduce_max_f64s(change)
    }

    /// Leaves the guess in `rest`; whether it is none, or useless.
    #[inline(always)]
    fn guess<S: Simd>(&mut self, s: S, t: &Tables<P>, low: &Nodes<P>, guess: Guess<'_, P>) -> bool {
        let seen;
        let mut matrix = &t.guess;
        match &guess {
            Guess::Parabola => return true,
            Guess::Same => seen = largest(s, &self.a.0),
            Guess::Continued { from, values } => {
                product_apart(s, &[0.0; P], &from.modes[..t.columns], &values.0, &mut self.a.0);
                matrix = &t.force;
                seen = from.factor * largest(s, &values.0);
                from.apply(s, t, &mut self.a);
            }
        }
        product(s, &low.0, &matrix[..t.columns], &self.a.0, &mut self.rest.0);
        // Beyond half a turn polynomials are useless: with the largest force seen before, |rest| would be half of this.
        seen > 0.0 && largest(s, &self.rest.0) > t.length.hi * t.length.hi * seen
    }

    /// Leaves the parabola through the start in `rest`.
    #[inline(always)]
    fn parabola<S: Simd, F: Force>(&mut self, s: S, t: &Tables<P>, force: &mut F, start: &State) {
        self.x.0 = [start.x.hi; P];
        evaluate_apart(s, force, &self.x.0, [&mut self.a.0, &mut self.u.0], false);
        let (rest, a) = (vectors_mut::<S>(&mut self.rest.0), vectors::<S>(&self.a.0));
        let parabola = vectors::<S>(&t.parabola);
        for i in 0..rest.len() {
            rest[i] = s.mul_f64s(parabola[i], a[i]);
        }
    }

    /// The size of X; the last term is for a start from rest at x = 0.
    #[inline(always)]
    pub(super) fn scale(&self, t: &Tables<P>, start: &State) -> f64 {
        start.x.hi.abs() + (t.length.hi * start.w.hi).abs() + self.rest.0[t.points - 1].abs()
    }

    /// The update of (t, x, w), the only place where rounding errors would add up over the windows.
    #[inline(always)]
    fn update<S: Simd, F: Force>(
        &self,
        s: S,
        t: &Tables<P>,
        force: &mut F,
        start: &State,
        precision: Precision,
        evaluations: usize,
    ) -> Solved {
        let h = t.length;
        let (p, error) = two_product::<S>(h.hi, start.w.hi);
        let free = (p, error + (h.lo * start.w.hi + h.hi * start.w.lo));
        if !precision.is_twofold() {
            let (a, u) = (&self.a.0, &self.u.0);
            let dt = (plain_dot(s, &t.weights, u), 0.0);
            let dx = (plain_dot(s, &t.position_weights, a), 0.0);
            let dw = (plain_dot(s, &t.weights, a), 0.0);
            return Solved::new(start, free, [dt, dx, dw], evaluations);
        }
        let (mut da, mut du) = (Nodes::<P>::ZERO, Nodes::<P>::ZERO);
        if precision.refine && force.refines() {
            let mut x_lo = Nodes::<P>::ZERO;
            let (x, line, rest) = (vectors::<S>(&self.x.0), vectors::<S>(&self.line.0), vectors::<S>(&self.rest.0));
            let low = vectors_mut::<S>(&mut x_lo.0);
            for i in 0..low.len() {
                // What the rounding of line + rest to X left over, whichever is larger.
                let seen = s.sub_f64s(x[i], line[i]);
                low[i] = s.add_f64s(s.sub_f64s(line[i], s.sub_f64s(x[i], seen)), s.sub_f64s(rest[i], seen));
            }
            force.refine(s, [&self.x.0, &x_lo.0], [&self.a.0, &self.u.0], [&mut da.0, &mut du.0]);
        }
        let largest = [largest(s, &self.a.0), largest(s, &self.u.0)];
        let (big_a, big_u) = (unit(h.hi * largest[0]), unit(h.hi * largest[1]));
        let (b, position) = ([&t.weights, &t.weights_lo], [&t.position_weights, &t.position_weights_lo]);
        let dw = dot(s, b, &self.a.0, &da.0, big_a);
        let dx = dot(s, position, &self.a.0, &da.0, t.length_unit * big_a);
        let dt = dot(s, b, &self.u.0, &du.0, big_u);
        Solved::new(start, free, [dt, dx, dw], evaluations)
    }
}
