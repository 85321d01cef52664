//! The defect of a run between its nodes: by how much the polynomial that it is in a window misses the equations.
//!
//! In a spectral element the rates on the nodes, f(y_k), are the slopes of a polynomial, and its integral from the
//! start of the window is the motion. Between the nodes the slope of the polynomial and the rates at its place differ:
//! little where the window resolves the motion, and by all that a feature does which lies between two nodes.
//!
//! An interpolation of degree n − 1 on the Lobatto nodes is off by a smooth factor times (1 − z²) P′_{n−1}(z), which is
//! extremal at the zeros of P_{n−1}, one in every gap. There it is (n − 1) P_{n−2}(z), whose size is about
//! (sin θ)^{1/2} at z = cos θ: largest in the middle of the window, where the gaps are widest. So the two zeros next to
//! the middle are looked at: collocation makes the defect nowhere less by chance, and nowhere is more room to hide.

use std::collections::BTreeMap;

use super::verdict::Reason;
use crate::geometry::{Motion, OnNodes, Point, shared};
use crate::number::norm::{larger, max_abs};
use crate::number::{Real, sum};
use crate::sbp::gll::LobattoRule;
use crate::sbp::legendre::{Family, approximate_node, legendre};
use crate::solve::{WindowNodes, WorldLine};

/// Windows of fewer nodes have not four modes that tell how fast they fall off.
const LEAST_POINTS: usize = 5;
/// A motion by less than this share of the place is rounding of it, as in the warnings.
const AT_REST: f64 = 1e4;
/// A mode that is left out shows twice: as itself, and as what it looks like on the nodes.
const FORESEEN: f64 = 2.0;

/// The largest defect of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Defect {
    /// The largest h |slope − rate| of a coordinate, relative to its motion in the window; NaN if it is no number.
    pub most: f64,
    /// γ there.
    pub gamma: f64,
    /// For every coordinate the place where what a gap does to it is largest, of those where the modes of the slopes do
    /// not foresee it.
    unforeseen: Vec<Option<Unforeseen>>,
}

/// What the modes do not foresee.
#[derive(Debug, Clone, PartialEq)]
struct Unforeseen {
    gamma: f64,
    /// The coordinates there.
    q: Vec<f64>,
    /// By how much the gap moves the coordinate: its length times the defect of the rate.
    moved: f64,
}

/// The two places in a window of n nodes, as weights of the slopes on the nodes.
struct Places<S> {
    places: [Weights<S>; 2],
    /// For each Legendre coefficient but the first its weights of the nodes.
    modes: Vec<Vec<S>>,
}

/// A place: its fraction of the window and that of its gap, and the weights that interpolate there, and integrate up to
/// there, a function on the nodes.
struct Weights<S> {
    fraction: S,
    gap: f64,
    values: Vec<S>,
    integrals: Vec<S>,
}

impl<S: Real> Places<S> {
    fn new(points: usize) -> Self {
        let rule: LobattoRule<S> = LobattoRule::new(points);
        let m = points - 1;
        let at_nodes: Vec<Vec<S>> = rule.nodes.iter().map(|&z| legendre(m, z)).collect();
        // The rule does not integrate P_m² exactly, so the factor of the last coefficient is another one.
        let mode = |j: usize, k: usize| {
            let norm = if k < m { 2 * k + 1 } else { m };
            S::from(norm as f64).half() * rule.weights[j] * at_nodes[j][k]
        };
        let place = |root: usize| {
            let z = approximate_node(Family::Gauss, m, root);
            let gap = rule.nodes.windows(2).map(|ends| [ends[0].to_f64(), ends[1].to_f64()]);
            let gap = gap.filter(|[low, high]| *low <= z && z < *high).map(|[low, high]| 0.5 * (high - low)).sum();
            let z = S::from(z);
            let p = legendre(m + 1, z);
            // The integral from −1 of P_k, half of which is that on [0, 1].
            let integral = |k: usize| {
                if k == 0 { (S::ONE + z).half() } else { (p[k + 1] - p[k - 1]).half() / S::from((2 * k + 1) as f64) }
            };
            let weights = |of: &dyn Fn(usize) -> S| -> Vec<S> {
                (0..points).map(|j| sum((0..points).map(|k| mode(j, k) * of(k)))).collect()
            };
            let (values, integrals) = (weights(&|k| p[k]), weights(&integral));
            Weights { fraction: (S::ONE + z).half(), gap, values, integrals }
        };
        let middle = m / 2;
        let modes = (1..points).map(|k| (0..points).map(|j| mode(j, k)).collect()).collect();
        Self { places: [place(middle - 1), place(middle)], modes }
    }

    /// What the modes of a function on the nodes leave out, if these go on to fall off as the last four do. If they do
    /// not fall off, it is no more than all of them together: what is constant on the nodes leaves nothing out.
    fn left_out(&self, values: &[S]) -> S {
        let modes: Vec<S> = self.modes.iter().map(|mode| weighed(mode, values).abs()).collect();
        let all = sum(modes.iter().copied());
        let [third, second, first, last] = *modes.last_chunk().expect("there are four modes");
        let (before, now) = (third + second, first + last);
        // The sum of now r + now r² + … for r = now/before, and of what stands on the nodes.
        let rest = now * before / (before - now);
        if now < before && rest < all { rest } else { all }
    }
}

/// Σ weight_j value_j.
fn weighed<S: Real>(weights: &[S], values: &[S]) -> S {
    sum(weights.iter().zip(values).map(|(&weight, &value)| weight * value))
}

impl Defect {
    /// Looks at the windows of a run that are spectral elements.
    pub(super) fn new<S: Real>(line: &WorldLine<S>) -> Option<Self> {
        let mut tables: BTreeMap<usize, Places<S>> = BTreeMap::new();
        let (mut motion, mut point, mut room) = (Motion::new(line.geometry()), line.geometry().point(), Vec::new());
        let mut found: Option<Self> = None;
        // The units of coordinates where windows start.
        let starts: Vec<Vec<S>> =
            (0..line.q.len()).map(|a| line.views().map(|view| view.start.q[a]).collect()).collect();
        let units = line.geometry().diagonals(&starts.iter().map(Vec::as_slice).collect::<Vec<_>>());
        for (index, view) in line.views().enumerate() {
            let points = view.window.points();
            if view.window.is_equidistant() || points < LEAST_POINTS {
                continue;
            }
            let found = found
                .get_or_insert_with(|| Self { unforeseen: vec![None; line.geometry().dimension()], ..Self::default() });
            let places = tables.entry(points).or_insert_with(|| Places::new(points));
            let units: Vec<S> = units.iter().map(|row| row[index]).collect();
            found.see(line, (&view, &units), places, (&mut motion, &mut room, &mut point));
        }
        found
    }

    /// Joins the defects of a part of a run, and of the next one.
    pub(super) fn followed_by(mut self, next: Self) -> Self {
        self.note(next.most, next.gamma);
        for (one, next) in self.unforeseen.iter_mut().zip(next.unforeseen) {
            if let Some(next) = next {
                keep(one, next);
            }
        }
        self
    }

    fn note(&mut self, defect: f64, gamma: f64) {
        if defect > self.most || (defect.is_nan() && !self.most.is_nan()) {
            (self.most, self.gamma) = (defect, gamma);
        }
    }

    fn see<S: Real>(
        &mut self,
        line: &WorldLine<S>,
        (view, units): (&WindowNodes<'_, S>, &[S]),
        places: &Places<S>,
        (motion, room, point): (&mut Motion<S>, &mut Vec<Vec<S>>, &mut Point<S>),
    ) {
        let (geometry, length) = (line.geometry(), view.window.length());
        let (n, active, increments) = (geometry.dimension(), geometry.active(), view.increments());
        let ways: Vec<f64> = increments[..n].iter().map(|row| max_abs(row).to_f64()).collect();
        let slopes = Slopes::new(view, increments, active, (motion, room));
        // t and x of the paper have units of their own.
        let is_of_x = geometry.c_squared.is_some();
        let shared = if is_of_x { ways.clone() } else { shared(units, &ways) };
        // Nobody asks a run to an accuracy what its modes foresee: windows were chosen by them.
        let modes = line.accuracy.is_none().then(|| slopes.along(|row| places.left_out(row)));
        for Weights { fraction, gap, values, integrals } in &places.places {
            let here = slopes.along(|row| length * weighed(integrals, row));
            let slope = slopes.along(|row| weighed(values, row));
            let gamma = line.gamma_at(view.window.gamma[0] + *fraction * length).to_f64();
            let gap = gap * length.to_f64().abs();
            let [rates, foreseen] = slopes.off([&here, &slope], modes.as_deref(), length, point);
            let q = |a: usize| (line.origin_of(a) + view.start.q[a] + here[a]).to_f64();
            for a in 0..n {
                let rounding = AT_REST * S::EPSILON.to_f64() * q(a).abs().max(ways[a]);
                if rates[a] == 0.0 || shared[a] <= rounding {
                    continue;
                }
                self.note(length.to_f64().abs() * rates[a] / shared[a], gamma);
                let is_foreseen = modes.is_none() || rates[a] <= FORESEEN * foreseen[a];
                if !is_foreseen {
                    let q = (0..n).map(q).collect();
                    keep(&mut self.unforeseen[a], Unforeseen { gamma, q, moved: gap * rates[a] });
                }
            }
        }
    }

    /// The reason to doubt a run on a given grid whose coordinates, with these names, are off by at most `errors`. The
    /// first of them are `results`.
    pub(super) fn doubt(
        &self,
        names: &[String],
        results: usize,
        errors: Option<&[f64]>,
        remedy: &str,
    ) -> Option<Reason> {
        let is_explained = |a: usize, moved: f64| errors.is_none_or(|errors| moved <= errors[a]) && moved.is_finite();
        let found = self.unforeseen[..results].iter().enumerate().find_map(|(a, unforeseen)| {
            unforeseen.as_ref().filter(|unforeseen| !is_explained(a, unforeseen.moved)).map(|found| (a, found))
        });
        let (a, Unforeseen { gamma, q, moved }) = found?;
        let place: Vec<String> = names.iter().zip(q).map(|(name, q)| format!("{name} = {q:.6}")).collect();
        let finding = format!(
            "between the nodes the motion does not follow its equations: near gamma = {gamma:.6}, with {}, one gap \
             moves {} by {moved:.1e}, which is more than its error and than the highest modes of the window foresee",
            place.join(", "),
            names[a]
        );
        Some(Reason::new(finding, remedy))
    }
}

/// Keeps what moves a coordinate most; what is no number comes first.
fn keep(one: &mut Option<Unforeseen>, next: Unforeseen) {
    let old = one.as_ref().map_or(-1.0, |one| one.moved);
    if next.moved > old || (next.moved.is_nan() && !old.is_nan()) {
        *one = Some(next);
    }
}

/// The rates on the nodes of a window: q̇^a of all coordinates, then ṗ_a of the active ones.
struct Slopes<'v, S> {
    /// q^a and p_a at the start.
    start: [&'v [S]; 2],
    active: &'v [usize],
    rows: &'v [Vec<S>],
}

impl<'v, S: Real> Slopes<'v, S> {
    /// The rates where coordinates and momenta are ahead of the start of the window by `increments`; NaN outside of the
    /// domain. There is room for them.
    fn new(
        view: &'v WindowNodes<'_, S>,
        mut increments: Vec<Vec<S>>,
        active: &'v [usize],
        (motion, room): (&mut Motion<S>, &'v mut Vec<Vec<S>>),
    ) -> Self {
        let starts = view.start.q.iter().chain(active.iter().map(|&a| &view.start.p[a]));
        for (row, &start) in increments.iter_mut().zip(starts) {
            row.iter_mut().for_each(|value| *value = start + *value);
        }
        let ((q, p), points) = (increments.split_at(view.start.q.len()), view.window.points());
        if motion.all_rates(OnNodes { q, p, start: view.start.p }, points, room).is_err() {
            room.iter_mut().for_each(|row| *row = vec![S::from(f64::NAN); points]);
        }
        Self { start: [view.start.q, view.start.p], active, rows: room }
    }

    /// A number for every row.
    fn along(&self, of: impl Fn(&[S]) -> S) -> Vec<S> {
        self.rows.iter().map(|row| of(row)).collect()
    }

    /// By how much each q̇^a is off where the state is ahead of the start by `here`, and the slopes are these; and by
    /// how much it would be if the slopes were off by `modes`, if these are known. Where ṗ is off, momenta are by that
    /// times the length of the window, and q̇ with them.
    fn off(&self, [here, slopes]: [&[S]; 2], modes: Option<&[S]>, length: S, point: &mut Point<S>) -> [Vec<f64>; 2] {
        let [mut q, mut p] = self.start.map(<[S]>::to_vec);
        let n = q.len();
        q.iter_mut().zip(here).for_each(|(q, &ahead)| *q += ahead);
        self.active.iter().zip(&here[n..]).for_each(|(&a, &ahead)| p[a] += ahead);
        let nan = || vec![f64::NAN; n];
        if point.evaluate(&q, &p).is_err() {
            return [nan(), nan()];
        }
        let rates: Vec<S> = (0..n).map(|a| point.q_dot(a)).collect();
        let forces: Vec<S> = (0..self.active.len()).map(|place| point.p_dot(place)).collect();
        let mut moved = |off: &dyn Fn(usize) -> S| -> Vec<S> {
            let mut p = p.clone();
            self.active.iter().enumerate().for_each(|(place, &a)| p[a] += length * off(place));
            match point.evaluate(&q, &p) {
                Ok(()) => (0..n).map(|a| (point.q_dot(a) - rates[a]).abs()).collect(),
                Err(_) => vec![S::from(f64::NAN); n],
            }
        };
        let by_force = moved(&|place| slopes[n + place] - forces[place]);
        let foreseen = modes.map_or_else(Vec::new, |modes| {
            let by_modes = moved(&|place| modes[n + place]);
            (0..n).map(|a| (modes[a] + by_modes[a]).to_f64()).collect()
        });
        let off = (0..n).map(|a| larger(S::ZERO, (slopes[a] - rates[a]).abs() + by_force[a]).to_f64()).collect();
        [off, foreseen]
    }
}
