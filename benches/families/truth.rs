//! The exact end of a run, twice: by DOP853 and by Taylor series, on different pieces. Pieces end at kinks and jumps,
//! and are smooth there: formulas go on as they were. None is longer than a tenth of a feature near it, so that neither
//! steps over it. Runs that go back are followed forward in the mirrored scene.

use std::collections::HashMap;
use std::sync::Arc;

use geodesic_ivp::case::Case;
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::methods::{Output, Peer, Problem, Setting, State};
use geodesic_ivp::reference::ReferenceTrajectory;

use super::scene::Scene;

/// A piece is at most this share of the width of a feature at it, and of the distance from one further away.
const OF_WIDTH: f64 = 0.1;
const OF_DISTANCE: f64 = 0.2;
/// A distance is from this many widths on.
const NEAR: f64 = 2.0;
/// The pieces of the second reference are shorter by this.
const SHORTER: f64 = 0.77;
/// The order and the digits of its series.
const SERIES: (usize, u32) = (24, 17);
/// A piece may move by so many times what was foreseen.
const FARTHER: f64 = 2.0;
/// Pieces shorter than this share of the pace do nothing.
const NOTHING: f64 = 1e-14;
/// Nothing is known if there are more pieces.
const MOST_PIECES: usize = 100_000;
/// The most refinements of the place of a kink.
const MOST_STEPS: usize = 60;

/// The end of a draw as two references know it.
pub(crate) struct Truth {
    pub(crate) end: Vec<f64>,
    /// By how much the second reference differs there.
    pub(crate) doubt: Vec<f64>,
    /// The sizes of the coordinates: their ranges, or their largest values if these are larger.
    pub(crate) own: Vec<f64>,
    /// The largest sizes of coordinates with the same metric.
    pub(crate) shared: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq)]
enum By {
    RungeKutta,
    Series,
}

/// A reference on its way.
struct March<'s> {
    scene: &'s Scene,
    by: By,
    /// The geometries by the signs of the arguments of kinks.
    geometries: HashMap<Vec<bool>, Arc<Geometry>>,
    /// The coordinates of kinks and of features.
    kinks: Vec<usize>,
    features: Vec<usize>,
    is_positive: Vec<bool>,
    here: Start,
}

impl Truth {
    /// `None` where a reference does not get there.
    pub(crate) fn of(scene: &Scene) -> Option<Self> {
        let (first, second) = (March::new(scene, By::RungeKutta)?, March::new(scene, By::Series)?);
        let (geometry, start) = (first.geometry()?, first.here.clone());
        let (one, ranges) = first.into_end()?;
        let (other, _) = second.into_end()?;
        let doubt = one.iter().zip(&other).map(|(one, other)| (one - other).abs()).collect();
        let is_time = |a: usize| geometry.names()[a] == "t";
        let own = |(a, [low, high]): (usize, &[f64; 2])| {
            if is_time(a) { high - low } else { (high - low).max(high.abs()).max(low.abs()) }
        };
        let own: Vec<f64> = ranges.iter().enumerate().map(own).collect();
        let n = own.len();
        let diagonal = |a: usize| {
            let velocity = |speed: f64| (0..n).map(|b| if b == a { speed } else { 0.0 }).collect::<Vec<f64>>();
            geometry.momenta(&start.q, &velocity(1.0))[a] - geometry.momenta(&start.q, &velocity(0.0))[a]
        };
        let diagonal: Vec<f64> = (0..n).map(diagonal).collect();
        let kin = |a: usize| {
            (0..n)
                .filter(|&b| b == a || !is_time(a) && !is_time(b) && diagonal[a] == diagonal[b])
                .collect::<Vec<usize>>()
        };
        let shared = (0..n).map(|a| kin(a).iter().map(|&b| own[b]).fold(0.0, f64::max)).collect();
        Some(Self { end: one, doubt, own, shared })
    }
}

impl<'s> March<'s> {
    fn new(scene: &'s Scene, by: By) -> Option<Self> {
        // Signs at the start are not known before the start.
        let mut is_positive = vec![true; scene.kinks.len()];
        let setup = case(scene, &is_positive)?.setup::<f64>();
        let names = setup.place.geometry.names();
        let place = |name: &String| names.iter().position(|other| other == name);
        let kinks: Vec<usize> = scene.kinks.iter().map(|kink| place(&kink.coordinate)).collect::<Option<_>>()?;
        let features = scene.features.iter().map(|feature| place(&feature.coordinate)).collect::<Option<_>>()?;
        for ((is_positive, kink), &a) in is_positive.iter_mut().zip(&scene.kinks).zip(&kinks) {
            *is_positive = (setup.place.start.q[a] - kink.place) * kink.sign >= 0.0;
        }
        let here = Start::clone(&case(scene, &is_positive)?.setup::<f64>().place.start);
        let mut march = Self { scene, by, geometries: HashMap::new(), kinks, features, is_positive, here };
        march.look()?;
        Some(march)
    }

    /// Compiles the formulas for the signs here.
    fn look(&mut self) -> Option<()> {
        if !self.geometries.contains_key(&self.is_positive) {
            let place = case(self.scene, &self.is_positive)?.setup::<f64>().place;
            self.geometries.insert(self.is_positive.clone(), place.geometry);
        }
        Some(())
    }

    fn geometry(&self) -> Option<Arc<Geometry>> {
        self.geometries.get(&self.is_positive).cloned()
    }

    /// The state behind a piece of this length.
    fn behind(&self, h: f64) -> Option<Start> {
        let geometry = self.geometry()?;
        let next = match self.by {
            By::RungeKutta => {
                let problem = Problem { space: Arc::clone(&geometry), start: self.here.clone(), length: h, g00: None };
                let found = Peer::Dop853.run(&problem, &Output::even(1), Setting::tolerance(1e-15)).ok()?;
                let State { q, p } = found.states.last()?;
                Start { q_dot: geometry.velocities(q, p).ok()?, q: q.to_vec(), p: p.to_vec() }
            }
            By::Series => ReferenceTrajectory::unchecked(&geometry, &self.here, h, SERIES.0, SERIES.1).ok()?.at(h),
        };
        next.q.iter().all(|q| q.is_finite()).then_some(next)
    }

    /// Returns the distance that the coordinate of a feature may go before it is near it.
    fn room(&self, feature: usize) -> f64 {
        let of = &self.scene.features[feature];
        let distance = (self.here.q[self.features[feature]] - of.place).abs() - NEAR * of.width;
        (OF_WIDTH * of.width).max(OF_DISTANCE * distance)
    }

    /// The next piece that steps over nothing: its length, and the state behind it.
    fn piece(&self, longest: f64) -> Option<(f64, Start)> {
        let share = if self.by == By::Series { SHORTER } else { 1.0 };
        let mut h = longest.min(share * self.scene.pace);
        for (feature, &a) in self.features.iter().enumerate() {
            h = h.min(share * self.room(feature) / self.here.q_dot[a].abs());
        }
        loop {
            let next = self.behind(h)?;
            let is_far =
                |(feature, &a): (usize, &usize)| (next.q[a] - self.here.q[a]).abs() > FARTHER * self.room(feature);
            if !self.features.iter().enumerate().any(is_far) {
                return Some((h, next));
            }
            h *= 0.5;
        }
    }

    /// The difference from the place of a kink, positive where its argument is.
    fn argument(&self, kink: usize, at: &Start) -> f64 {
        let Scene { kinks, .. } = self.scene;
        (at.q[self.kinks[kink]] - kinks[kink].place) * kinks[kink].sign
    }

    fn has_changed(&self, kink: usize, at: &Start) -> bool {
        (self.argument(kink, at) > 0.0) != self.is_positive[kink]
    }

    /// The length at which a motion that turns before a kink is next to it.
    fn turn(&self, h: f64, next: &Start) -> Option<f64> {
        let of = |(kink, &a): (usize, &usize)| {
            let (before, behind, distance) = (self.here.q_dot[a], next.q_dot[a], self.argument(kink, &self.here).abs());
            let approaches = self.argument(kink, &self.here) * before * self.scene.kinks[kink].sign < 0.0;
            let turns = approaches && before * behind < 0.0 && distance < h * before.abs();
            (turns && !self.has_changed(kink, next)).then(|| h * before / (before - behind))
        };
        self.kinks.iter().enumerate().filter_map(of).min_by(f64::total_cmp)
    }

    /// The length at which a coordinate is at a kink, and the state there.
    fn at_kink(&self, kink: usize, h: f64, next: &Start) -> Option<(f64, Start)> {
        let (a, sign) = (self.kinks[kink], self.scene.kinks[kink].sign);
        let (mut low, mut high) = (0.0, h);
        let side = if self.is_positive[kink] { 1.0 } else { -1.0 };
        let start = (self.argument(kink, &self.here) * side).max(0.0);
        let end = -self.argument(kink, next) * side;
        // Behind the kink the motion of these formulas may go anywhere: its rate here is the better guess.
        let by_rate = start / self.here.q_dot[a].abs();
        let mut length = if by_rate < h { by_rate } else { h * start / (start + end) };
        let mut best = (h, next.clone());
        for _ in 0..MOST_STEPS {
            if length <= NOTHING * self.scene.pace {
                return Some((0.0, self.here.clone()));
            }
            let at = self.behind(length)?;
            let value = self.argument(kink, &at) * side;
            if value > 0.0 {
                low = length
            } else {
                high = length
            }
            let correction = value / (at.q_dot[a] * sign * side);
            best = (length, at);
            let newton = length - correction;
            let is_inside = newton > low && newton < high;
            if correction.abs() <= 2.0 * f64::EPSILON * h || high - low <= 2.0 * f64::EPSILON * high {
                break;
            }
            length = if is_inside { newton } else { 0.5 * (low + high) };
        }
        Some(best)
    }

    /// The end, and the least and the largest values of the coordinates.
    fn into_end(mut self) -> Option<(Vec<f64>, Vec<[f64; 2]>)> {
        let (length, mut gamma) = (self.scene.length, 0.0);
        let mut ranges: Vec<[f64; 2]> = self.here.q.iter().map(|&q| [q, q]).collect();
        for _ in 0..MOST_PIECES {
            if length - gamma <= NOTHING * length {
                return Some((self.here.q, ranges));
            }
            let (mut h, mut next) = self.piece(length - gamma)?;
            if let Some(turn) = self.turn(h, &next) {
                (h, next) = (turn, self.behind(turn)?);
            }
            let crossed: Vec<usize> = (0..self.kinks.len()).filter(|&kink| self.has_changed(kink, &next)).collect();
            let places = crossed.iter().map(|&kink| Some((kink, self.at_kink(kink, h, &next)?)));
            let places = places.collect::<Option<Vec<_>>>()?;
            let first = places.into_iter().min_by(|one, other| one.1.0.total_cmp(&other.1.0));
            if let Some((kink, (at, state))) = first {
                (h, next) = (at, state);
                self.is_positive[kink] = !self.is_positive[kink];
                self.look()?;
                let geometry = self.geometry()?;
                next.q_dot = geometry.velocities(&next.q, &next.p).ok()?;
            }
            gamma += h;
            self.here = next;
            for (range, &q) in ranges.iter_mut().zip(&self.here.q) {
                *range = [range[0].min(q), range[1].max(q)];
            }
        }
        None
    }
}

/// The case for these signs of the arguments of kinks.
fn case(scene: &Scene, is_positive: &[bool]) -> Option<Case> {
    let text = scene.smooth(is_positive);
    let settings = [scene.settings.as_slice(), &["solver.accuracy=1e-8".to_owned()]].concat();
    match Case::parse("reference", &text, &settings) {
        Ok(case) => Some(case),
        Err(error) => {
            eprintln!("{text}\n{error}");
            None
        }
    }
}
