//! Values between the nodes, by the scheme's own interpolation.
//!
//! On an equidistant grid that is the quintic Hermite polynomial of each interval, for t, x and w* each with its own first
//! two derivatives at both ends, which the geodesic equations give. Its error O(Δγ⁶) is below that of the nodes for every
//! operator, and dx/dγ does not suffer from nodes of x that alternate about a smooth curve. In a spectral element it is the
//! polynomial through all nodes, which is what the operator differentiates. dt/dγ is Q_t/g00 everywhere. Nothing here
//! integrates anything: samples are as accurate as the nodes they stand between.

use crate::geodesic::{acceleration, acceleration_slope};
use crate::scalar::{Real, sum};
use crate::solve::Solution;

/// The world-line at one value of γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<S = f64> {
    /// γ.
    pub gamma: S,
    /// t.
    pub t: S,
    /// x.
    pub x: S,
    /// dt/dγ.
    pub t_dot: S,
    /// dx/dγ.
    pub x_dot: S,
}

/// A value that lies outside the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutsideRun<S> {
    /// First and last value of the run.
    pub range: (S, S),
}

/// A function and its first two derivatives by γ.
type Jet<S> = [S; 3];

/// Interpolates one solution.
#[derive(Debug)]
pub struct Sampler<'a, S = f64> {
    solution: &'a Solution<S>,
    /// t from the start of the window, x and w* on the nodes.
    nodes: [Vec<Jet<S>>; 3],
    /// Weights of barycentric interpolation; none on an equidistant grid.
    barycentric: Option<Vec<S>>,
}

impl<'a, S: Real> Sampler<'a, S> {
    /// Prepares the nodes of `solution`.
    pub fn new(solution: &'a Solution<S>) -> Self {
        let last = solution.sbp.points() - 1;
        let q_t = solution.end.q_t;
        let mut nodes = [0; 3].map(|_| Vec::with_capacity(solution.x.len()));
        for (view, window) in solution.views().zip(&solution.windows) {
            // It is w* at all nodes; in the strong form Dx is not at the last one.
            let mut x_dot = view.derivative(view.x, view.start.x);
            x_dot[last] = window.end.1;
            for ((&x, &w), &elapsed) in view.x.iter().zip(&x_dot).zip(view.elapsed) {
                let g = solution.metric.at(x);
                let (t_dot, force) = (q_t / g.g00, acceleration(q_t, g.g00, g.first));
                nodes[0].push([elapsed, t_dot, -t_dot * g.first * w / g.g00]);
                nodes[1].push([x, w, force]);
                nodes[2].push([w, force, acceleration_slope(q_t, g.g00, g.first, g.second) * w]);
            }
        }
        let barycentric = (!solution.sbp.is_equidistant()).then(|| {
            let nodes: Vec<S> = (0..=last).map(|k| solution.sbp.node(k) / solution.window_length()).collect();
            let weight = |j: usize| {
                let others = nodes.iter().enumerate().filter(|(k, _)| *k != j);
                S::ONE / others.fold(S::ONE, |product, (_, &node)| product * (nodes[j] - node))
            };
            (0..=last).map(weight).collect()
        });
        Self { solution, nodes, barycentric }
    }

    /// A run that ends at a physical time ends there to all but a few of its digits, and so does what is asked for.
    fn slack(&self) -> S {
        const SPARE_DIGITS: u32 = 4;
        S::from_decimal(&format!("1e-{}", self.solution.digits - SPARE_DIGITS)).unwrap_or(S::EPSILON)
    }

    /// The world-line at `gamma`.
    ///
    /// # Errors
    /// [`OutsideRun`] beyond the ends by more than rounding.
    pub fn at_gamma(&self, gamma: S) -> Result<Sample<S>, OutsideRun<S>> {
        let Solution { gamma_i, length, .. } = *self.solution;
        let from_start =
            within(gamma - gamma_i, length, self.slack()).ok_or(OutsideRun { range: (gamma_i, gamma_i + length) })?;
        let window_length = self.solution.window_length();
        let window = ((from_start / window_length).to_f64() as usize).min(self.solution.windows.len() - 1);
        let place = from_start - S::from(window as f64) * window_length;
        let last = self.solution.sbp.points() - 1;
        let k = partition(last, |k| self.solution.sbp.node(k) <= place);
        Ok(Sample { gamma, ..self.between(window, k, place) })
    }

    /// The world-line at the time `t`.
    ///
    /// # Errors
    /// [`OutsideRun`] before t_i or after t_N.
    pub fn at_time(&self, t: S) -> Result<Sample<S>, OutsideRun<S>> {
        let Solution { t_i, windows, sbp, .. } = self.solution;
        let duration = self.solution.duration();
        let range = if duration < S::ZERO { (*t_i + duration, *t_i) } else { (*t_i, *t_i + duration) };
        let elapsed = within(t - *t_i, duration, self.slack()).ok_or(OutsideRun { range })?;
        // Time runs forwards or backwards, but not both.
        let reached = |value: S, goal: S| if duration < S::ZERO { value >= goal } else { value <= goal };
        let window = partition(windows.len(), |window| reached(windows[window].start.t, elapsed));
        let elapsed = elapsed - windows[window].start.t;
        let (first, last) = (window * sbp.points(), sbp.points() - 1);
        let k = partition(last, |k| reached(self.nodes[0][first + k][0], elapsed));
        let (mut low, mut high) = (sbp.node(k), sbp.node(k + 1));
        let excess = |sample: &Sample<S>| (sample.t - *t_i - windows[window].start.t) - elapsed;
        // Newton's method from the start of the interval, kept inside it.
        let mut here = low;
        let mut sample = self.between(window, k, here);
        for _ in 0..100 {
            let excess = excess(&sample);
            if reached(excess, S::ZERO) {
                low = here
            } else {
                high = here
            }
            let next = here - excess / sample.t_dot;
            let next = if next > low && next < high { next } else { (low + high).half() };
            let step = (next - here).abs();
            if excess == S::ZERO || step <= S::EPSILON * self.solution.window_length() {
                break;
            }
            (here, sample) = (next, self.between(window, k, next));
        }
        Ok(Sample { t, ..sample })
    }

    /// The world-line at `gamma` behind the start of a window, in the interval behind its node k.
    fn between(&self, window: usize, k: usize, gamma: S) -> Sample<S> {
        let Solution { sbp, windows, .. } = self.solution;
        let nodes = window * sbp.points()..(window + 1) * sbp.points();
        let value = |jets: &Vec<Jet<S>>| {
            let jets = &jets[nodes.clone()];
            match &self.barycentric {
                Some(weights) => self.lagrange(weights, jets, gamma),
                None => hermite(jets[k], jets[k + 1], sbp.interval(k), gamma - sbp.node(k)),
            }
        };
        let [t, x, x_dot] = self.nodes.each_ref().map(value);
        let t_dot = self.solution.end.q_t / self.solution.metric.at(x).g00;
        let from_start = S::from(window as f64) * self.solution.window_length() + gamma;
        Sample {
            gamma: self.solution.gamma_i + from_start,
            t: self.solution.t_i + (windows[window].start.t + t),
            x,
            t_dot,
            x_dot,
        }
    }

    /// The polynomial through the values on all nodes.
    fn lagrange(&self, weights: &[S], jets: &[Jet<S>], gamma: S) -> S {
        let distance = |k: usize| gamma - self.solution.sbp.node(k);
        if let Some(k) = (0..jets.len()).find(|&k| distance(k) == S::ZERO) {
            return jets[k][0];
        }
        let factor = |k: usize| weights[k] / distance(k);
        sum((0..jets.len()).map(|k| factor(k) * jets[k][0])) / sum((0..jets.len()).map(factor))
    }
}

/// `value` between 0 and `end` (which may be negative), moved there if it lies outside by no more than that share.
fn within<S: Real>(value: S, end: S, share: S) -> Option<S> {
    let slack = share * end.abs();
    let (low, high) = if end < S::ZERO { (end, S::ZERO) } else { (S::ZERO, end) };
    let inside = value >= low - slack && value <= high + slack;
    inside.then(|| {
        if value < low {
            low
        } else if value > high {
            high
        } else {
            value
        }
    })
}

/// The last interval 0 … `intervals` − 1 whose first node satisfies `reached`, which holds up to some node.
fn partition(intervals: usize, reached: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, intervals);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if reached(middle) { low = middle } else { high = middle }
    }
    low
}

/// The quintic Hermite polynomial on [0, `h`] at `s`.
fn hermite<S: Real>([f0, d0, c0]: Jet<S>, [f1, d1, c1]: Jet<S>, h: S, s: S) -> S {
    let number = |n: f64| S::from(n);
    let (change, d0, d1, c0, c1) = (f1 - f0, h * d0, h * d1, h * h * c0.half(), h * h * c1.half());
    // In powers of s/h; the c are half the second derivatives.
    let cubic = number(10.0) * change - number(6.0) * d0 - number(4.0) * d1 - number(3.0) * c0 + c1;
    let quartic = number(-15.0) * change + number(8.0) * d0 + number(7.0) * d1 + number(3.0) * c0 - number(2.0) * c1;
    let quintic = number(6.0) * change - number(3.0) * (d0 + d1) - c0 + c1;
    let s = s / h;
    f0 + s * (d0 + s * (c0 + s * (cubic + s * (quartic + s * quintic))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quintics_are_interpolated_exactly() {
        let f = |x: f64| 1.0 - 2.0 * x + x.powi(2) / 3.0 + x.powi(3) - x.powi(4) / 7.0 + 0.3 * x.powi(5);
        let d = |x: f64| -2.0 + 2.0 * x / 3.0 + 3.0 * x.powi(2) - 4.0 * x.powi(3) / 7.0 + 1.5 * x.powi(4);
        let c = |x: f64| 2.0 / 3.0 + 6.0 * x - 12.0 * x.powi(2) / 7.0 + 6.0 * x.powi(3);
        let jet = |x: f64| [f(x), d(x), c(x)];
        let (a, h) = (0.4, 0.7);
        for k in 0..=10 {
            let s = h * f64::from(k) / 10.0;
            assert!((hermite(jet(a), jet(a + h), h, s) - f(a + s)).abs() < 1e-14, "at {s}");
        }
    }
}
