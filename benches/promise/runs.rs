//! Runs to an accuracy, and their errors beside references.

use geodesic_ivp::engine::{Accuracy, Dense, Engine, Failure};
use geodesic_ivp::geometry::{Geometry, Start};

/// A run of more windows is given up.
const MOST_WINDOWS: usize = 400_000;

/// A finished run.
#[derive(Default)]
pub(crate) struct Run {
    /// γ, length and motion of every window.
    windows: Vec<(f64, f64, Dense)>,
    /// The places of nodes in a window, and all coordinates there, by windows, coordinates and nodes.
    fractions: Vec<f64>,
    values: Vec<f64>,
    pub(crate) restarts: usize,
    /// The error that it expects.
    pub(crate) estimate: f64,
}

impl Run {
    /// Runs to an accuracy; otherwise the reason of the refusal.
    pub(crate) fn new(geometry: &Geometry, start: &Start, length: f64, wanted: Accuracy) -> Result<Self, String> {
        let mut engine = Engine::accurate(geometry, start, length, wanted).map_err(|_| "NoStart".to_owned())?;
        let mut run = Self::default();
        loop {
            match engine.next() {
                Ok(Some(mut window)) => {
                    run.windows.push((window.gamma, window.length, window.dense()));
                    let origin = window.start().positions();
                    let nodes = window.nodes();
                    run.fractions = nodes.fractions().to_vec();
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
                Err(failure) => return Err(format!("{failure:?}").split('(').next().unwrap_or_default().to_owned()),
            }
            if run.windows.len() > MOST_WINDOWS {
                return Err("TooLong".to_owned());
            }
        }
        // Such a run is doubtful, and promises nothing.
        if engine.unresolved() > 0 {
            return Err("Unproved".to_owned());
        }
        run.estimate = engine.error_estimate().unwrap_or(0.0);
        Ok(run)
    }

    /// The largest differences from the first reference, and of the two references there, relative to sizes, which grow
    /// with the ways from `origin`.
    pub(crate) fn errors(
        &self,
        references: [&Self; 2],
        origin: &[f64],
        mut sizes: Vec<f64>,
        momenta: usize,
    ) -> [f64; 2] {
        let (n, points, mut places) = (origin.len(), self.fractions.len(), [0; 2]);
        let (mut error, mut doubt) = (0.0_f64, 0.0_f64);
        for ((gamma, h, _), values) in self.windows.iter().zip(self.values.chunks(n * points)) {
            for (i, c) in self.fractions.iter().enumerate() {
                let gamma = gamma + h * c;
                let [one, two] = [0, 1].map(|k| references[k].at(gamma, &mut places[k], n, momenta));
                for a in 0..n {
                    if sizes[a] > 0.0 {
                        sizes[a] = sizes[a].max((one[a] - origin[a]).abs());
                        error = error.max((values[a * points + i] - one[a]).abs() / sizes[a]);
                        doubt = doubt.max((two[a] - one[a]).abs() / sizes[a]);
                    }
                }
            }
        }
        [error, doubt]
    }

    /// The coordinates at γ, in the window at `place` or one behind it.
    fn at(&self, gamma: f64, place: &mut usize, coordinates: usize, momenta: usize) -> Vec<f64> {
        while self.windows.get(*place + 1).is_some_and(|next| gamma > next.0) {
            *place += 1;
        }
        let (start, h, dense) = &self.windows[*place];
        let (mut q, mut p) = (vec![0.0; coordinates], vec![0.0; momenta]);
        dense.at((gamma - start) / h, &mut q, &mut p);
        q
    }
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
