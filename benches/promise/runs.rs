//! Runs to an accuracy, and their errors beside references.

use geodesic_ivp::engine::{Accuracy, Engine, Failure};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::sbp::SbpOperator;

/// A run of more windows is given up.
const MOST_WINDOWS: usize = 400_000;

/// A finished run: γ of the nodes of every window, and all coordinates there.
pub(crate) struct Run {
    windows: Vec<(f64, f64)>,
    /// By windows, coordinates and nodes.
    values: Vec<f64>,
    pub(crate) restarts: usize,
    /// The error that it expects.
    pub(crate) estimate: f64,
}

/// Runs to an accuracy; otherwise the reason of the refusal.
pub(crate) fn run(
    geometry: &Geometry,
    start: &Start,
    length: f64,
    wanted: Accuracy,
    points: usize,
) -> Result<Run, String> {
    let refused = |failure: Failure| format!("{failure:?}").split('(').next().unwrap_or_default().to_owned();
    let mut engine = Engine::accurate(geometry, start, length, wanted, points).map_err(|_| "NoStart".to_owned())?;
    let mut run = Run { windows: Vec::new(), values: Vec::new(), restarts: 0, estimate: 0.0 };
    loop {
        match engine.next() {
            Ok(Some(mut window)) => {
                run.windows.push((window.gamma, window.length));
                let origin = window.start().positions();
                let nodes = window.nodes();
                for (a, &origin) in origin.iter().enumerate() {
                    let origin = if geometry.active().contains(&a) { 0.0 } else { origin };
                    run.values.extend(nodes.q(a).iter().map(|q| origin + q));
                }
            }
            Ok(None) => break,
            Err(Failure::BeginAgain) => {
                engine.begin_again();
                run.windows.clear();
                run.values.clear();
                run.restarts += 1;
            }
            Err(failure) => return Err(refused(failure)),
        }
        if run.windows.len() > MOST_WINDOWS {
            return Err("TooLong".to_owned());
        }
    }
    // Such a run is doubtful, and promises nothing.
    if engine.unproved() > 0 {
        return Err("Unproved".to_owned());
    }
    run.estimate = engine.error_estimate().unwrap_or(0.0);
    Ok(run)
}

/// Gauss–Lobatto nodes on [0, 1], and their barycentric weights.
fn lobatto(n: usize) -> (Vec<f64>, Vec<f64>) {
    let operator = SbpOperator::<f64>::gauss_lobatto(n, 1.0);
    let nodes: Vec<f64> = (0..n).map(|k| operator.node(k)).collect();
    let weight = |i: usize| (0..n).filter(|&j| j != i).map(|j| 0.25 / (nodes[i] - nodes[j])).product();
    let weights = (0..n).map(weight).collect();
    (nodes, weights)
}

/// The coordinates of a run at γ, which must not decrease from call to call.
struct Interpolation<'r> {
    run: &'r Run,
    nodes: Vec<f64>,
    weights: Vec<f64>,
    window: usize,
}

impl<'r> Interpolation<'r> {
    fn new(run: &'r Run, points: usize) -> Self {
        let (nodes, weights) = lobatto(points);
        Self { run, nodes, weights, window: 0 }
    }

    fn at(&mut self, gamma: f64, values: &mut [f64]) {
        let windows = &self.run.windows;
        while self.window + 1 < windows.len() && gamma > windows[self.window + 1].0 {
            self.window += 1;
        }
        let (n, (start, h)) = (self.nodes.len(), windows[self.window]);
        let c = (gamma - start) / h;
        for (a, value) in values.iter_mut().enumerate() {
            let own = &self.run.values[(self.window * self.run.values.len() / windows.len()) + a * n..][..n];
            let (mut above, mut below) = (0.0, 0.0);
            for i in 0..n {
                // The first value is taken out, so that rounding is that of the differences.
                let part = self.weights[i] / (c - self.nodes[i]);
                above += part * (own[i] - own[0]);
                below += part;
            }
            *value = own[0] + above / below;
            if let Some(i) = self.nodes.iter().position(|&node| node == c) {
                *value = own[i];
            }
        }
    }
}

/// The largest differences of a run from the reference, and of the two references there, relative to sizes so far.
pub(crate) fn errors(
    run: &Run,
    points: usize,
    references: [(&Run, usize); 2],
    origin: &[f64],
    sizes: &[f64],
) -> [f64; 2] {
    let (nodes, _) = lobatto(points);
    let n = origin.len();
    let [mut first, mut second] = references.map(|(reference, points)| Interpolation::new(reference, points));
    let (mut one, mut two, mut sizes) = (vec![0.0; n], vec![0.0; n], sizes.to_vec());
    let (mut error, mut doubt) = (0.0_f64, 0.0_f64);
    for (window, &(gamma, h)) in run.windows.iter().enumerate() {
        for (i, c) in nodes.iter().enumerate() {
            first.at(gamma + h * c, &mut one);
            second.at(gamma + h * c, &mut two);
            for a in 0..n {
                if sizes[a] > 0.0 {
                    sizes[a] = sizes[a].max((one[a] - origin[a]).abs());
                    error = error.max((run.values[(window * n + a) * points + i] - one[a]).abs() / sizes[a]);
                    doubt = doubt.max((two[a] - one[a]).abs() / sizes[a]);
                }
            }
        }
    }
    [error, doubt]
}

/// T, the time in which a small error changes, or the length of the run if that is shorter, and the sizes of
/// coordinates at the start, as the engine defines them.
pub(crate) fn time_and_sizes(geometry: &Geometry, start: &Start, length: f64) -> (f64, Vec<f64>) {
    let (active, mut point) = (geometry.active(), geometry.point());
    let m = active.len();
    let mut jacobian = vec![0.0; 4 * m * m];
    point.jacobian(&start.q, &start.p, |row, column, value| jacobian[row * 2 * m + column] = value);
    let entry = |i: usize, j: usize| jacobian[i * 2 * m + j];
    let square = |i: usize, j: usize| (0..2 * m).map(|k| entry(i, k) * entry(k, j)).sum::<f64>();
    let pairs = (0..2 * m).flat_map(|i| (0..2 * m).map(move |j| (i, j)));
    let rate = (0.5 * pairs.map(|(i, j)| (square(i, j) * square(j, i)).abs()).sum::<f64>()).powf(0.25);
    let time = if rate * length > 1.0 { 1.0 / rate } else { length };
    let inverse = |k: usize| entry(k, m + k);
    let own = |k: usize| start.q[active[k]].abs().max(start.q_dot[active[k]].abs() * time);
    let mut sizes = vec![0.0; start.q.len()];
    for k in 0..m {
        let same = (0..m).filter(|&j| (inverse(j) - inverse(k)).abs() <= 1e-12 * inverse(k).abs());
        sizes[active[k]] = same.map(own).fold(0.0, f64::max);
    }
    // An ignorable one has the size of its way in T, or of what the sizes of the others make of that.
    let mut rates = |place: usize, step: f64| {
        let (mut q, mut p, a) = (start.q.clone(), start.p.clone(), active[place % m]);
        let momentum = (sizes[a] / (time * inverse(place % m).abs())).max(p[a].abs());
        if place < m {
            q[a] += step * sizes[a]
        } else {
            p[a] += step * momentum
        }
        let _ = point.evaluate(&q, &p);
        (0..q.len()).map(|a| point.q_dot(a)).collect::<Vec<_>>()
    };
    let slopes: Vec<_> = (0..2 * m).map(|place| [rates(place, 1e-6), rates(place, -1e-6)]).collect();
    for a in geometry.ignorable() {
        let changes = slopes.iter().map(|[more, less]| 0.5e6 * (more[a] - less[a]).abs());
        sizes[a] = time * changes.fold(start.q_dot[a].abs(), f64::max);
    }
    (time, sizes)
}
