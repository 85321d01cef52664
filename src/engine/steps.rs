//! Small errors δ of a motion with several active coordinates.
//!
//! A change of H grows steadily in regular motion, as it is a change of frequency: there local errors go along ∇H. In
//! chaotic motion δ soon points to where errors grow most, and local errors go there too. Both are carried, and the
//! larger one counts. Rounding errors have random signs: some samples of what they come to are carried as well.
//!
//! δ is needed to one digit only, so it has steps of its own: several windows, or a part of one, as [`Transport`]
//! allows.

use pulp::{Simd, WithSimd};

use super::POINTS;
use super::between::Kink;
use super::local::larger;
use super::rule::Order;
use super::transport::{AT_ONCE, Transport};
use super::tuning::{BIAS, FIRST_STEPS, MARGIN, MOST_PARTS, MOST_WINDOWS, OF_SAMPLES, OF_SLOPES, OF_STEPS};
use super::window::Solver;
use crate::number::Noise;
use crate::number::vector::{Level, Nodes};

/// An error of truncation, and that of rounding.
pub(super) type Errors = [f64; 2];

/// Number of samples of rounding errors.
const SAMPLES: usize = 6;

/// δ for local errors along ∇H, for those along what has grown so far, and samples for those of random signs.
type Deltas = [f64; 2 + SAMPLES];

const NO_ERROR: Deltas = [0.0; 2 + SAMPLES];

/// The errors that a run has come to, relative to sizes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Total {
    /// |δ| with rounding, its largest component, and that of rounding alone,
    pub(super) now: Errors,
    /// at this γ.
    pub(super) reached: f64,
    /// The largest |δ| so far.
    pub(super) largest: f64,
}

impl Total {
    /// The same with what `now` has come to in the largest error. An error that is no number, or beyond the range of
    /// numbers, is infinite: nothing is known of it.
    pub(super) fn grown(self) -> Self {
        let now = self.now.map(|error| if error.is_finite() { error } else { f64::INFINITY });
        Self { now, largest: self.largest.max(now[0]), ..self }
    }
}

/// δ, step by step.
pub(super) struct Steps<'g> {
    transport: Transport<'g>,
    /// The inner nodes at which a window is cut into 1, 2, … steps.
    cuts: Vec<Vec<usize>>,
    nodes: Vec<f64>,
    /// D on the nodes, by rows.
    derivative: Vec<[f64; POINTS]>,
    /// The local errors that each step of the batch adds at its end, by unknowns.
    local: Vec<[Errors; AT_ONCE]>,
    /// Number of windows of each step.
    windows_of: [f64; AT_ONCE],
    inverse_sizes: Vec<f64>,
    delta: Vec<Deltas>,
    carried: Vec<Deltas>,
    /// Errors of ignorable coordinates, the local ones that each step adds, and 1/size of these.
    ignorable: Vec<Deltas>,
    local_ignorable: Vec<[f64; AT_ONCE]>,
    inverse_ignorable: Vec<f64>,
    /// The largest errors of these so far, in their units.
    pub(super) most_ignorable: Vec<f64>,
    /// δ·∇H of the first of them at the last step.
    along: f64,
    noise: Noise,
    /// Length and windows of the current step so far.
    length: f64,
    windows: f64,
    /// The number of windows that a step is to have: 2, 3, … or 1/2, 1/3, … for parts of one.
    wanted: f64,
    has_begun: bool,
    /// True if the window before had a kink in it.
    is_behind_kink: bool,
    pub(super) total: Total,
}

impl<'g> Steps<'g> {
    /// No error at the start.
    pub(super) fn new(solver: &Solver<'g, POINTS>) -> Self {
        let (rule, ignorable) = (&solver.rule, solver.geometry.ignorable().count());
        let (nodes, unknowns) = (rule.nodes[0].0[..rule.points()].to_vec(), 2 * solver.geometry.active().len());
        let distance = |node: usize, c: f64| (nodes[node] - c).abs();
        let nearest = |c: f64| (1..nodes.len() - 1).min_by(|&i, &j| distance(i, c).total_cmp(&distance(j, c)));
        let cuts = |parts: usize| {
            let mut cuts: Vec<_> = (1..parts).filter_map(|j| nearest(j as f64 / parts as f64)).collect();
            cuts.dedup();
            cuts
        };
        // D̄ − H⁻¹E_0
        let with_start = rule.derivative();
        let penalty = |i: usize, j: usize| if (i, j) == (0, 0) { rule.weights.0[0].recip() } else { 0.0 };
        let row = |i: usize| std::array::from_fn(|j| with_start[j].0[i] - penalty(i, j));
        Self {
            transport: Transport::new(solver.geometry, &solver.initial.p),
            cuts: (1..=MOST_PARTS).map(cuts).collect(),
            derivative: (0..nodes.len()).map(row).collect(),
            nodes,
            local: vec![[[0.0; 2]; AT_ONCE]; unknowns],
            windows_of: [1.0; AT_ONCE],
            inverse_sizes: vec![1.0; unknowns],
            delta: vec![NO_ERROR; unknowns],
            carried: vec![NO_ERROR; unknowns],
            ignorable: vec![NO_ERROR; ignorable],
            local_ignorable: vec![[0.0; AT_ONCE]; ignorable],
            inverse_ignorable: vec![0.0; ignorable],
            most_ignorable: vec![0.0; ignorable],
            along: 0.0,
            noise: Noise::default(),
            length: 0.0,
            windows: 0.0,
            wanted: FIRST_STEPS,
            has_begun: false,
            is_behind_kink: false,
            total: Total::default(),
        }
    }

    /// Goes back to the start.
    pub(super) fn begin(&mut self) {
        self.transport.count = 0;
        self.local.fill([[0.0; 2]; AT_ONCE]);
        self.local_ignorable.fill([0.0; AT_ONCE]);
        self.delta.fill(NO_ERROR);
        self.ignorable.fill(NO_ERROR);
        self.most_ignorable.fill(0.0);
        (self.along, self.noise) = (0.0, Noise::default());
        (self.length, self.windows, self.wanted) = (0.0, 0.0, FIRST_STEPS);
        (self.has_begun, self.is_behind_kink, self.total) = (false, false, Total::default());
    }

    /// The error of a coordinate, by [`Solver::place`].
    pub(super) fn error(&self, place: Result<usize, usize>) -> f64 {
        size(place.map_or_else(|j| &self.ignorable[j], |place| &self.delta[place]))[0]
    }

    /// Takes in a finished window with its local errors. One with a kink is a step of its own, and so are those that
    /// come near to it: rates on both sides of it are no smooth function.
    pub(super) fn follow(&mut self, window: &Solver<'g, POINTS>, local: &[Errors], done: f64, kink: Kink) {
        let h = window.length;
        if kink.is_inside() && self.length > 0.0 {
            self.finish_step(window, 0, self.windows);
        }
        if std::mem::replace(&mut self.is_behind_kink, kink.is_inside()) {
            self.set_point(window, 0, self.transport.count);
        }
        for (inverse_size, row) in self.inverse_sizes.iter_mut().zip(&window.rows) {
            *inverse_size = row.size.for_sums(done);
        }
        for (inverse_size, way) in self.inverse_ignorable.iter_mut().zip(&window.ways) {
            *inverse_size = way.of_way(done);
        }
        self.transport.is_mended = window.is_mended;
        if !self.has_begun {
            self.has_begun = true;
            self.set_point(window, 0, 0);
        }
        for (inverse_size, row) in self.transport.inverse_sizes.iter_mut().zip(&window.rows) {
            *inverse_size = row.size.inverse;
        }
        let mut done = 0.0;
        let parts = if self.wanted < 0.7 { ((1.0 / self.wanted + 0.5) as usize).clamp(2, MOST_PARTS) } else { 1 };
        let part = 1.0 / parts as f64;
        for cut in 0..self.cuts[parts - 1].len() {
            let node = self.cuts[parts - 1][cut];
            self.length += h * (self.nodes[node] - done);
            done = self.nodes[node];
            self.finish_step(window, node, part);
        }
        self.length += h * (1.0 - done);
        self.windows += 1.0;
        let step = self.transport.count;
        for (sums, local) in self.local.iter_mut().zip(local) {
            let [truncation, rounding] = &mut sums[step];
            (*truncation, *rounding) = (*truncation + local[0], rounding.hypot(local[1]));
        }
        for (sums, error) in self.local_ignorable.iter_mut().zip(&window.ignorable_errors) {
            sums[step] += MARGIN * error;
        }
        if self.windows + 0.5 > self.wanted || kink != Kink::Far {
            self.finish_step(window, self.nodes.len() - 1, part * self.windows);
        }
    }

    /// Ends the run after its last window.
    pub(super) fn finish(&mut self, window: &Solver<'g, POINTS>) {
        if self.length > 0.0 {
            self.finish_step(window, self.nodes.len() - 1, self.windows);
        }
        self.carry();
    }

    /// Ends the current step, of so many windows, at a node.
    fn finish_step(&mut self, window: &Solver<'g, POINTS>, node: usize, windows: f64) {
        self.set_point(window, node, self.transport.count + 1);
        self.windows_of[self.transport.count] = windows;
        self.transport.add_step(self.length);
        (self.length, self.windows) = (0.0, 0.0);
        if self.transport.count == AT_ONCE {
            self.carry();
        }
    }

    /// x, ẋ and ẍ of all rows, and the rates of ignorable coordinates.
    fn set_point(&mut self, window: &Solver<'g, POINTS>, node: usize, point: usize) {
        for row in 0..self.transport.points.len() {
            let slope = window.slope_nodes(row);
            let (first, second) = match window.system.order {
                Order::First => (slope.0[node], slope.dot(&self.derivative[node]) / window.length),
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
        Level::Best.dispatch(&mut *self);
        self.total.reached += self.transport.length();
        self.local.fill([[0.0; 2]; AT_ONCE]);
        self.local_ignorable.fill([0.0; AT_ONCE]);
        self.transport.restart();
        // The defect grows like the 6th power of lengths.
        let change = (0.5 * OF_STEPS / defect.max(1e-12)).sqrt().cbrt().clamp(0.5, 2.0);
        self.wanted = (self.wanted * change).clamp(1.0 / MOST_PARTS as f64, MOST_WINDOWS);
    }
}

/// Carries δ over the steps of a batch.
impl WithSimd for &mut Steps<'_> {
    type Output = ();

    /// The errors of an unknown make a vector without more ado.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for step in 0..self.transport.count {
            self.carry_step(step);
        }
    }
}

impl Steps<'_> {
    #[inline(always)]
    fn carry_step(&mut self, step: usize) {
        let Self { transport, delta, carried, ignorable, .. } = self;
        let n = delta.len();
        for (k, carried) in carried.iter_mut().enumerate() {
            *carried = combined(NO_ERROR, transport.row(k), step, delta);
        }
        let mut now = [0.0; 2];
        for (i, error) in ignorable.iter_mut().enumerate() {
            *error = combined(*error, transport.row(n + i), step, delta);
            error[..2].iter_mut().for_each(|error| *error += self.local_ignorable[i][step].copysign(*error));
            self.most_ignorable[i] = larger(self.most_ignorable[i], size(error)[0]);
            now = largest(now, error, self.inverse_ignorable[i]);
        }
        // As δ·∇H is conserved, its sign is that of the step before.
        let sign = 1.0_f64.copysign(self.along);
        self.along = 0.0;
        for k in 0..n {
            let [truncation, rounding] = self.local[k][step];
            let rounding = rounding.hypot(OF_SLOPES * transport.gain(k, step, self.windows_of[step]));
            let (gradient, carried) = (transport.gradient(k, step + 1), &carried[k]);
            let along = sign * gradient;
            let directions =
                [if gradient == 0.0 { carried[0] } else { along }, if carried[1] == 0.0 { along } else { carried[1] }];
            let (signs, bias) = (self.noise.signs::<SAMPLES>(), BIAS.copysign(along));
            delta[k] = std::array::from_fn(|i| match i {
                0 | 1 => carried[i] + truncation.copysign(directions[i]),
                _ => carried[i] + rounding * (signs[i - 2] + bias),
            });
            self.along += delta[k][0] * gradient;
            if k < n / 2 {
                now = largest(now, &delta[k], self.inverse_sizes[k]);
            }
        }
        self.total = Total { now, ..self.total }.grown();
    }
}

/// sum + Σ_j Φ_j δ_j, with a row of Φ.
#[inline(always)]
fn combined(sum: Deltas, row: &[Nodes<AT_ONCE>], step: usize, delta: &[Deltas]) -> Deltas {
    row.iter().zip(delta).fold(sum, |sum, (entry, delta)| {
        let entry = entry.0[step];
        std::array::from_fn(|i| entry * delta[i] + sum[i])
    })
}

/// The largest errors so far, relative to sizes.
#[inline(always)]
fn largest(so_far: Errors, deltas: &Deltas, inverse_size: f64) -> Errors {
    let of = size(deltas);
    [larger(so_far[0], of[0] * inverse_size), larger(so_far[1], of[1] * inverse_size)]
}

/// |δ| with rounding, and that of rounding alone.
#[inline(always)]
fn size(deltas: &Deltas) -> Errors {
    let [along, grown, samples @ ..] = deltas;
    let rounding = OF_SAMPLES * samples.iter().map(|sample| sample * sample).sum::<f64>().sqrt();
    [larger(along.abs(), grown.abs()) + rounding, rounding]
}

#[cfg(test)]
mod tests {
    use super::{SAMPLES, Steps};
    use crate::engine::between::Kink;
    use crate::engine::tests::{Pair, advance, kerr, lifted};

    /// δ is what a second motion is off by, which begins a little beside the first one, in ignorable coordinates too.
    #[test]
    fn deviation_is_that_of_a_second_motion() {
        let stars = lifted("(x^2 + y^2)/2 + x^2*y - y^3/3", &["x", "y"], &[0.1, 0.0], &[0.0, 0.5]);
        for ((geometry, start), unit) in [(stars, 0.5), (kerr(), 1.0)] {
            let mut pair = Pair::new(&geometry, &start);
            let mut steps = Steps::new(&pair.first);
            let beside = [1e-6, -2e-6, 1e-7, 3e-7];
            steps.delta = beside.map(|delta| [delta; 2 + SAMPLES]).to_vec();
            pair.run(&beside, unit, 48, |pair, _| steps.follow(&pair.first, &[[0.0; 2]; 4], 0.5, Kink::Far));
            steps.finish(&pair.first);
            let known = pair.deviation().chain(pair.ignorable.iter().copied());
            for ([found, ..], known) in steps.delta.iter().chain(&steps.ignorable).zip(known) {
                assert!((found - known).abs() < 0.03 * known.abs() + 1e-7, "{found:e} {known:e}");
            }
        }
    }

    /// Where neighbours neither separate nor meet, rounding errors of n windows add up to some √n of them.
    #[test]
    fn rounding_adds_up_like_a_random_walk() {
        let (geometry, start) = lifted("(x^2 + y^2)/2", &["x", "y"], &[1.0, 0.0], &[0.0, 1.0]);
        for count in [16, 64, 256] {
            let mut pair = Pair::new(&geometry, &start);
            let mut steps = Steps::new(&pair.first);
            for _ in 0..count {
                advance(&mut pair.first, 0.5);
                steps.follow(&pair.first, &[[0.0, 1e-9]; 4], 0.5, Kink::Far);
            }
            steps.finish(&pair.first);
            let error = [0, 1].map(|place| steps.error(Ok(place))).into_iter().fold(0.0, f64::max);
            let ratio = error / (1e-9 * f64::from(count).sqrt());
            assert!((1.0..4.0).contains(&ratio), "{count}: {ratio}");
        }
    }
}
