//! Small errors δ of a motion with several active coordinates.
//!
//! A change of H grows steadily in regular motion, as it is a change of frequency: there local errors go along ∇H. In
//! chaotic motion δ soon points to where errors grow most, and local errors go there too. Both are carried, and the
//! larger one counts.
//!
//! δ is needed to one digit only, so it has steps of its own: several windows, or a part of one, as [`Transport`]
//! allows.

use pulp::{Simd, WithSimd};

use super::kernel::larger;
use super::rule::Order;
use super::transport::{AT_ONCE, Transport};
use super::tuning::{FIRST_STEPS, MOST_PARTS, MOST_WINDOWS, OF_STEPS};
use super::view::Place;
use super::window::Solver;
use crate::geometry::Start;
use crate::number::vector::{Level, Nodes};

/// An error, and that of rounding alone.
type Errors = [f64; 2];

/// The same for local errors along ∇H, and then for those along what has grown so far.
type Both = [f64; 4];

/// δ, step by step.
pub(super) struct Steps<'g, const N: usize> {
    transport: Transport<'g>,
    /// The inner nodes at which a window is cut into 1, 2, … steps.
    cuts: Vec<Vec<usize>>,
    nodes: Vec<f64>,
    /// D on the nodes, by rows.
    derivative: Vec<[f64; N]>,
    /// The local errors that each step of the batch adds at its end, by unknowns.
    local: Vec<[Errors; AT_ONCE]>,
    /// The part of ∫ |J||x| that each step adds.
    of_slopes: [f64; AT_ONCE],
    inverse_sizes: Vec<f64>,
    delta: Vec<Both>,
    carried: Vec<Both>,
    /// Errors of ignorable coordinates, and 1/size of these.
    ignorable: Vec<Both>,
    inverse_ignorable: Vec<f64>,
    /// δ·∇H at the last step.
    along: Errors,
    /// Length and windows of the current step so far.
    length: f64,
    windows: f64,
    /// The number of windows that a step is to have: 2, 3, … or 1/2, 1/3, … for parts of one.
    wanted: f64,
    has_begun: bool,
    /// |δ| at the end of the last batch, relative to sizes,
    pub(super) now: Errors,
    /// at this γ.
    pub(super) reached: f64,
    /// The largest |δ| so far, relative to sizes.
    pub(super) largest: f64,
}

impl<'g, const N: usize> Steps<'g, N> {
    /// No error at the start.
    pub(super) fn new(solver: &Solver<'g, N>, start: &Start) -> Self {
        let (rule, ignorable) = (&solver.rule, solver.geometry.ignorable().count());
        let (nodes, unknowns) = (rule.nodes[0].0[..rule.points()].to_vec(), 2 * solver.geometry.active().len());
        let distance = |node: usize, c: f64| (nodes[node] - c).abs();
        let nearest = |c: f64| (1..nodes.len() - 1).min_by(|&i, &j| distance(i, c).total_cmp(&distance(j, c)));
        let cuts = |parts: usize| {
            let mut cuts: Vec<_> = (1..parts).filter_map(|j| nearest(j as f64 / parts as f64)).collect();
            cuts.dedup();
            cuts
        };
        let row = |i: usize| std::array::from_fn(|j| rule.derivative_entry(i, j));
        Self {
            transport: Transport::new(solver.geometry, start),
            cuts: (1..=MOST_PARTS).map(cuts).collect(),
            derivative: (0..nodes.len()).map(row).collect(),
            nodes,
            local: vec![[[0.0; 2]; AT_ONCE]; unknowns],
            of_slopes: [0.0; AT_ONCE],
            inverse_sizes: vec![1.0; unknowns],
            delta: vec![[0.0; 4]; unknowns],
            carried: vec![[0.0; 4]; unknowns],
            ignorable: vec![[0.0; 4]; ignorable],
            inverse_ignorable: vec![0.0; ignorable],
            along: [0.0; 2],
            length: 0.0,
            windows: 0.0,
            wanted: FIRST_STEPS,
            has_begun: false,
            now: [0.0; 2],
            reached: 0.0,
            largest: 0.0,
        }
    }

    /// Goes back to the start.
    pub(super) fn begin(&mut self) {
        self.transport.count = 0;
        self.local.fill([[0.0; 2]; AT_ONCE]);
        self.delta.fill([0.0; 4]);
        self.ignorable.fill([0.0; 4]);
        (self.along, self.length, self.windows, self.wanted) = ([0.0; 2], 0.0, 0.0, FIRST_STEPS);
        (self.has_begun, self.now, self.reached, self.largest) = (false, [0.0; 2], 0.0, 0.0);
    }

    /// The error of a coordinate.
    pub(super) fn error(&self, place: Place) -> f64 {
        let both = match place {
            Place::Active(place) => &self.delta[place],
            Place::Ignorable(j) => &self.ignorable[j],
        };
        larger(both[0].abs(), both[2].abs())
    }

    /// Takes in a finished window of length `h` with its local errors; `of_slopes` is the part that rounding has in
    /// slopes.
    pub(super) fn follow(&mut self, window: &Solver<'g, N>, h: f64, local: &[Errors], of_slopes: f64) {
        for (k, inverse_size) in self.inverse_sizes.iter_mut().enumerate() {
            *inverse_size = window.unknown(k, h).inverse_size;
        }
        self.inverse_ignorable.copy_from_slice(&window.inverse_ignorable);
        self.transport.linear.is_mended = window.is_mended;
        if !self.has_begun {
            self.has_begun = true;
            self.set_point(window, 0, h, 0);
            self.transport.inverse_sizes.copy_from_slice(&self.inverse_sizes);
        }
        let mut done = 0.0;
        if self.wanted < 0.7 {
            let parts = ((1.0 / self.wanted + 0.5) as usize).clamp(2, MOST_PARTS);
            for cut in 0..self.cuts[parts - 1].len() {
                let node = self.cuts[parts - 1][cut];
                self.length += h * (self.nodes[node] - done);
                done = self.nodes[node];
                self.of_slopes[self.transport.count] = of_slopes;
                self.finish_step(window, node, h);
            }
        }
        self.length += h * (1.0 - done);
        self.windows += 1.0;
        let step = self.transport.count;
        self.of_slopes[step] = of_slopes;
        for (sums, local) in self.local.iter_mut().zip(local) {
            (0..2).for_each(|i| sums[step][i] += local[i]);
        }
        if self.windows + 0.5 > self.wanted {
            self.finish_step(window, self.nodes.len() - 1, h);
        }
    }

    /// Ends the run after a last window of length `h`.
    pub(super) fn finish(&mut self, window: &Solver<'g, N>, h: f64) {
        if self.length > 0.0 {
            self.finish_step(window, self.nodes.len() - 1, h);
        }
        self.carry();
    }

    /// Ends the current step at a node.
    fn finish_step(&mut self, window: &Solver<'g, N>, node: usize, h: f64) {
        self.set_point(window, node, h, self.transport.count + 1);
        self.transport.add_step(self.length);
        (self.length, self.windows) = (0.0, 0.0);
        if self.transport.count == AT_ONCE {
            self.carry();
        }
    }

    /// x, ẋ and ẍ of all rows, and the rates of ignorable coordinates.
    fn set_point(&mut self, window: &Solver<'g, N>, node: usize, h: f64, point: usize) {
        for row in 0..self.transport.points.len() {
            let slope = window.slope_nodes(row);
            let (first, second) = match window.system.order {
                Order::First => (slope.0[node], slope.dot(&self.derivative[node]) / h),
                Order::Second => (window.velocities[row].0[node], slope.0[node]),
            };
            let values = [window.unknown_nodes(row).0[node], first, second];
            self.transport.points[row].iter_mut().zip(values).for_each(|(points, value)| points[point] = value);
        }
        for (j, rates) in self.transport.rates.iter_mut().enumerate() {
            rates[point] = window.rate_nodes(j).0[node];
        }
    }

    /// Carries δ over the steps of the batch.
    fn carry(&mut self) {
        if self.transport.count == 0 {
            return;
        }
        let defect = self.transport.solve();
        Level::Best.dispatch(Carry(self));
        self.reached += self.transport.length();
        self.local.fill([[0.0; 2]; AT_ONCE]);
        self.transport.restart();
        // The defect grows like the 6th power of lengths.
        let change = (0.5 * OF_STEPS / defect.max(1e-12)).sqrt().cbrt().clamp(0.5, 2.0);
        self.wanted = (self.wanted * change).clamp(1.0 / MOST_PARTS as f64, MOST_WINDOWS);
    }
}

/// Carries δ over the steps of a batch.
struct Carry<'a, 'g, const N: usize>(&'a mut Steps<'g, N>);

impl<const N: usize> WithSimd for Carry<'_, '_, N> {
    type Output = ();

    /// The four errors of an unknown make a vector without more ado.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for step in 0..self.0.transport.count {
            self.0.carry_step(step);
        }
    }
}

impl<const N: usize> Steps<'_, N> {
    #[inline(always)]
    fn carry_step(&mut self, step: usize) {
        let Self { transport, delta, carried, ignorable, .. } = self;
        let n = delta.len();
        for (k, carried) in carried.iter_mut().enumerate() {
            *carried = combined([0.0; 4], transport.row(k), step, delta);
        }
        self.now = [0.0; 2];
        for (i, error) in ignorable.iter_mut().enumerate() {
            *error = combined(*error, transport.row(n + i), step, delta);
            self.now = largest(self.now, error, self.inverse_ignorable[i]);
        }
        // As δ·∇H is conserved, its sign is that of the step before.
        let sign = self.along.map(|along| 1.0_f64.copysign(along));
        self.along = [0.0; 2];
        for k in 0..n {
            let gradient = transport.gradient(k, step + 1);
            let of_slopes = self.of_slopes[step] * transport.gain(k, step);
            let local = self.local[k][step].map(|local| local + of_slopes);
            let [all, rounding, all_along, rounding_along] = carried[k];
            let direction = |own: f64, sign: f64| if gradient == 0.0 { own } else { sign * gradient };
            let along = |own: f64, sign: f64| if own == 0.0 { sign * gradient } else { own };
            let directions = [
                direction(all, sign[0]),
                direction(rounding, sign[1]),
                along(all_along, sign[0]),
                along(rounding_along, sign[1]),
            ];
            delta[k] = std::array::from_fn(|i| carried[k][i] + local[i % 2].copysign(directions[i]));
            (0..2).for_each(|i| self.along[i] += delta[k][i] * gradient);
            if k < n / 2 {
                self.now = largest(self.now, &delta[k], self.inverse_sizes[k]);
            }
        }
        self.largest = larger(self.largest, self.now[0]);
    }
}

/// sum + Σ_j Φ_j δ_j, with a row of Φ.
#[inline(always)]
fn combined(sum: Both, row: &[Nodes<AT_ONCE>], step: usize, delta: &[Both]) -> Both {
    row.iter().zip(delta).fold(sum, |sum, (entry, delta)| {
        let entry = entry.0[step];
        std::array::from_fn(|i| entry * delta[i] + sum[i])
    })
}

/// The largest errors so far, relative to sizes.
#[inline(always)]
fn largest(so_far: Errors, both: &Both, inverse_size: f64) -> Errors {
    let of = |i: usize| larger(both[i].abs(), both[i + 2].abs()) * inverse_size;
    [larger(so_far[0], of(0)), larger(so_far[1], of(1))]
}

#[cfg(test)]
mod tests {
    use super::Steps;
    use crate::engine::tests::{Pair, kerr, lifted};

    /// δ is what a second motion is off by, which begins a little beside the first one, in ignorable coordinates too.
    #[test]
    fn deviation_is_that_of_a_second_motion() {
        let stars = lifted("(x^2 + y^2)/2 + x^2*y - y^3/3", &["x", "y"], &[0.1, 0.0], &[0.0, 0.5]);
        for ((geometry, start), unit) in [(stars, 0.5), (kerr(), 1.0)] {
            let mut pair = Pair::new(&geometry, &start);
            let mut steps = Steps::<16>::new(&pair.first, &start);
            let deviation = vec![1e-6, -2e-6, 1e-7, 3e-7];
            steps.delta = deviation.iter().map(|&delta| [delta, 0.0, delta, 0.0]).collect();
            pair.begin_second(deviation);
            for step in 0..48 {
                let h = unit * [1.0, 3.0, 0.3, 2.0][step % 4];
                pair.advance(h);
                steps.follow(&pair.first, h, &[[0.0; 2]; 4], 0.0);
                if step == 47 {
                    steps.finish(&pair.first, h);
                }
            }
            let known = pair.deviation().into_iter().chain(pair.ignorable.iter().copied());
            for ([found, ..], known) in steps.delta.iter().chain(&steps.ignorable).zip(known) {
                assert!((found - known).abs() < 0.03 * known.abs() + 1e-7, "{found:e} {known:e}");
            }
        }
    }
}
