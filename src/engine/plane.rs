//! Small errors δ of a motion with one active coordinate. Its phase space is a plane, where they are known without a
//! solver.
//!
//! In the frame of the flow f = ẋ and of a partner g with ω(f, g) = 1, for the Jacobian J = (a, b; c, −a) of f and the
//! metric |f|² = f_q² + s f_p²:
//!
//! ```text
//! δ = α f + β g,   g = (−s f_p, f_q)/|f|²,   β̇ = 0,   α̇ = κ β,   κ = ((b + s c)(f_q² − s f_p²) − 4 a s f_q f_p)/|f|⁴
//! ```
//!
//! β is the change of H, α a shift along the orbit, which a change of H shears. In regular motion f is never 0, as q
//! and p do not both rest. The error of an ignorable coordinate with the rate r is integrated by parts, as ∇r·f = ṙ:
//!
//! ```text
//! ∫ ∇r·δ = [α r] − β ∫ κ r + β ∫ ∇r·g
//! ```
//!
//! Any s > 0 will do, if κ is smooth: it has poles where f_q = ±i √s f_p. With s = |b/c|, but at most (h b)², these are
//! as far away as the motion's own time or a window. Each window has its s. From s to s₁ δ is kept: α grows by
//! β f_q f_p (s₁ − s)/|f|²|f|₁².
//!
//! With friction f is no Hamiltonian flow, and the trace of J is not 0: then [`Steps`](super::steps::Steps) carry δ.

use pulp::{Simd, WithSimd};

use super::POINTS;
use super::kernel::On;
use super::local::larger;
use super::rule::Order;
use super::system::{Linear, Term};
use super::tuning::{BIAS, MARGIN};
use super::window::Solver;
use crate::number::vector::{Lanes, Level, Nodes};

/// δ in its frame.
pub(super) struct Plane<'g> {
    linear: Linear<'g, POINTS>,
    /// f at the end of the last window, and the metric's s.
    flow: [f64; 2],
    metric: f64,
    /// δ of the errors of windows, and that of rounding.
    truncation: Errors,
    rounding: Errors,
    ignorable: Vec<Ignorable>,
    /// The largest errors of ignorable coordinates so far, in their units.
    pub(super) most_ignorable: Vec<f64>,
}

/// α and β of local errors.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    /// β, which local errors only make larger.
    change: f64,
    /// The part of α that comes from β.
    shear: f64,
    /// The sum of the local errors along f, the other part of α, of either sign.
    shift: f64,
}

/// The error of an ignorable coordinate that truncation makes, and that of rounding.
#[derive(Debug, Clone, Copy, Default)]
struct Ignorable {
    /// Applies β and the shear to it.
    of_change: [f64; 2],
    /// Applies shifts to it.
    of_shift: [f64; 2],
    /// The sum of its own local errors.
    own: f64,
    /// The rate at the end of the last window.
    rate: f64,
}

impl<'g> Plane<'g> {
    /// No error at the start.
    pub(super) fn new(Solver { geometry, initial, ignorable, .. }: &Solver<'g, POINTS>) -> Self {
        let linear = Linear::new(geometry, &initial.p);
        let most_ignorable = vec![0.0; ignorable.len()];
        let ignorable = vec![Ignorable::default(); ignorable.len()];
        let [truncation, rounding] = [Errors::default(); 2];
        Self { linear, flow: [0.0; 2], metric: 1.0, truncation, rounding, ignorable, most_ignorable }
    }

    /// Goes back to the start.
    pub(super) fn begin(&mut self) {
        (self.truncation, self.rounding) = Default::default();
        self.ignorable.fill(Ignorable::default());
        self.most_ignorable.fill(0.0);
    }

    /// Carries δ over a finished window. Returns ∫ |J||x| for both unknowns: what relative errors of the values make of
    /// them by way of the slopes.
    pub(super) fn follow(&mut self, window: &Solver<'g, POINTS>) -> [f64; 2] {
        Level::Best.dispatch(On((self, window)))
    }

    /// Takes the metric of a window of length h in which |b| and |c| are at most so large, and keeps δ.
    #[inline(always)]
    fn choose_metric(&mut self, b: f64, c: f64, h: f64) {
        let (before, square) = (self.metric, self.square());
        let longest = (h * b) * (h * b);
        let metric = if longest * c > b { b / c } else { longest };
        self.metric = if metric.is_normal() { metric } else { before };
        if self.truncation.change > 0.0 && square > 0.0 {
            let [q, p] = self.flow;
            self.shear((q / square) * (p / self.square()) * (self.metric - before));
        }
    }

    /// α grows by so much of β.
    #[inline(always)]
    fn shear(&mut self, by: f64) {
        for errors in [&mut self.truncation, &mut self.rounding] {
            errors.shear += errors.change * by;
        }
    }

    /// |f|² at the end of the last window.
    #[inline(always)]
    fn square(&self) -> f64 {
        let [q, p] = self.flow;
        q * q + self.metric * p * p
    }

    /// Adds the local errors of position and momentum at the end of the window, with the signs that make |β|, and then
    /// |α|, grow most, and those of rounding, whose signs are random.
    pub(super) fn add(&mut self, truncation: [f64; 2], rounding: [f64; 2]) {
        let ([q, p], square) = (self.flow, self.square());
        if square > 0.0 {
            let change = |[position, momentum]: [f64; 2]| q.abs() * momentum + p.abs() * position;
            let shift =
                |[position, momentum]: [f64; 2]| (q.abs() * position + self.metric * p.abs() * momentum) / square;
            self.truncation.change += change(truncation);
            self.truncation.shift += shift(truncation);
            let add = |sum: &mut f64, error: f64| *sum += error * part_of_random(*sum / error.max(f64::MIN_POSITIVE));
            add(&mut self.rounding.change, change(rounding));
            add(&mut self.rounding.shift, shift(rounding));
        }
        for j in 0..self.ignorable.len() {
            self.most_ignorable[j] = larger(self.most_ignorable[j], self.error(Err(j))[0]);
        }
    }

    /// The error of a coordinate at the end of the window, by [`Solver::place`], and what of it rounding alone makes.
    pub(super) fn error(&self, place: Result<usize, usize>) -> [f64; 2] {
        let [truncation, rounding] = if let Err(j) = place {
            let Ignorable { of_change, of_shift, own, .. } = self.ignorable[j];
            let [truncation, rounding] = [0, 1].map(|i| of_change[i].abs() + of_shift[i].abs());
            [truncation + own, rounding]
        } else {
            let ([q, p], square) = (self.flow, self.square());
            [self.truncation, self.rounding].map(|errors| {
                let across = if square > 0.0 { errors.change * self.metric * p / square } else { 0.0 };
                let error = (errors.shear * q - across).abs() + errors.shift * q.abs();
                // Without a frame nothing is known of δ.
                if square.is_finite() { error } else { f64::INFINITY }
            })
        };
        [truncation + rounding, rounding]
    }
}

/// Carries δ over a window.
impl WithSimd for On<(&mut Plane<'_>, &Solver<'_, POINTS>)> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> [f64; 2] {
        let On((plane, window)) = self;
        let h = window.length;
        let Linear { registers, unknowns, .. } = &mut plane.linear;
        for k in 0..2 {
            registers[unknowns[k]] = Lanes::new(s, window.unknown_nodes(k)).nodes();
        }
        plane.linear.evaluate(s, window.is_mended);
        let Linear { registers, rows, order, .. } = &plane.linear;
        let is_second = *order == Order::Second;
        let (a, b) = if is_second {
            (Lanes::splat(s, 0.0), Lanes::splat(s, 1.0))
        } else {
            (entry(s, registers, rows, [0, 0]), entry(s, registers, rows, [0, 1]))
        };
        let c = entry(s, registers, rows, [usize::from(!is_second), 0]);
        let (q, p) = match order {
            Order::First => (Lanes::new(s, window.slope_nodes(0)), Lanes::new(s, window.slope_nodes(1))),
            Order::Second => (Lanes::new(s, window.unknown_nodes(1)), Lanes::new(s, window.slope_nodes(0))),
        };
        let weights = Lanes::new(s, &window.rule.weights);
        let gain = h * magnitude(s, window, &plane.linear, 0).dot(weights);
        let gains =
            if is_second { [h * gain, gain] } else { [gain, h * magnitude(s, window, &plane.linear, 1).dot(weights)] };
        let (largest_b, largest_c) = (b.abs().largest(), c.abs().largest());
        plane.choose_metric(largest_b, largest_c, h);
        plane.flow = [q.last(), p.last()];
        // At rest everything stays as it is.
        if plane.square() <= 0.0 {
            return gains;
        }
        let metric = plane.metric;
        let inverse = q.mul_add(q, p * p * metric).recip();
        let kappa =
            (c.scale_add(metric, b) * (q * q - p * p * metric) - a * q * p * (4.0 * metric)) * inverse * inverse;
        let before = [plane.truncation.shear, plane.rounding.shear];
        plane.shear(h * kappa.dot(weights));
        let errors = [plane.truncation, plane.rounding];
        for j in 0..plane.ignorable.len() {
            let rate = Lanes::new(s, window.rate_nodes(j));
            let Linear { registers, rates, .. } = &plane.linear;
            let by_q = entry(s, registers, rates, [j, 0]);
            let by_p = entry(s, registers, rates, [j, 1]);
            let across = (by_p * q - by_q * p * metric) * inverse;
            let of_change = h * (across - kappa * rate).dot(weights);
            let error = &mut plane.ignorable[j];
            for (i, Errors { change, shear, shift }) in errors.into_iter().enumerate() {
                error.of_change[i] += shear * rate.last() - before[i] * error.rate + change * of_change;
                error.of_shift[i] += shift * (rate.last() - error.rate);
            }
            error.own += MARGIN * window.ignorable_errors[j];
            error.rate = rate.last();
        }
        gains
    }
}

/// The entry of the Jacobian in a row and a column, which may be 0.
#[inline(always)]
fn entry<S: Simd>(s: S, registers: &[Nodes<POINTS>], terms: &[Term], [row, column]: [usize; 2]) -> Lanes<S, POINTS> {
    let mut sum = Lanes::splat(s, 0.0);
    for term in terms {
        if term.row == row && term.column == column {
            sum = Lanes::new(s, &registers[term.register]).scale_add(term.factor, sum);
        }
    }
    sum
}

/// Σ |J||x| of a row.
#[inline(always)]
fn magnitude<S: Simd>(s: S, window: &Solver<'_, POINTS>, linear: &Linear<'_, POINTS>, row: usize) -> Lanes<S, POINTS> {
    let mut sum = Lanes::splat(s, 0.0);
    for term in &linear.rows {
        if term.row == row {
            let x = Lanes::new(s, window.unknown_nodes(term.column)).abs();
            sum = (Lanes::new(s, &linear.registers[term.register]) * term.factor).abs().mul_add(x, sum);
        }
    }
    sum
}

/// The part of a random error by which a sum of such errors grows, which is `so_far` times as large: squares add up,
/// and a part of them has one sign.
#[inline(always)]
fn part_of_random(so_far: f64) -> f64 {
    so_far.hypot(1.0) - so_far + BIAS
}

#[cfg(test)]
mod tests {
    use super::Plane;
    use crate::engine::tests::{Pair, advance, lifted, schwarzschild, well};

    /// δ is what a second motion is off by, which begins a little beside the first one, also where windows differ in
    /// length.
    #[test]
    fn deviation_is_that_of_a_second_motion() {
        let scenes = [(well(), 0.2), (schwarzschild(), 4.0), (lifted("1 - cos(x)", &["x"], &[1.0], &[0.3]), 0.5)];
        for ((geometry, start), unit) in &scenes {
            let mut pair = Pair::new(geometry, start);
            let mut plane = Plane::new(&pair.first);
            advance(&mut pair.first, 2.0 * unit);
            plane.follow(&pair.first);
            // δ = β g
            let ([q, p], square) = (plane.flow, plane.square());
            plane.truncation.change = 1e-6 * square / q.hypot(plane.metric * p);
            let beside = [-plane.metric * p, q].map(|g| plane.truncation.change * g / square);
            pair.run(&beside, *unit, 40, |pair, window| {
                plane.follow(&pair.first);
                let close = |a: f64, b: f64| (a - b).abs() < 1e-3 * b.abs() + 3e-8;
                let ignorable = pair.ignorable.iter().enumerate().map(|(j, &off)| (Err(j), off));
                for (place, off) in pair.deviation().take(1).map(|off| (Ok(0), off)).chain(ignorable) {
                    let [found, _] = plane.error(place);
                    assert!(close(found, off.abs()), "{window}, {place:?}: {found:e} {off:e}");
                }
            });
        }
    }
}
