//! The nodes of a run at which formulas lose most digits. Places that are spread over a run may all miss a short part
//! of it where a formula loses its digits, as in a pulse. So each window is looked at, in balls of 32 digits.

use super::evaluated::{Evaluated, ORDINARY, PATTERNS};
use super::places::Seen;
use crate::case::Case;
use crate::number::Real;
use crate::solve::{Setup, WorldLine};
use crate::trajectory::Sampler;

/// So many nodes are kept.
const KEPT: usize = 16;
/// So many are if all nodes are looked at twice.
const KEPT_OF_ALL: usize = 16 * KEPT;

/// A sum of independent numbers is hardly ever more than so many standard deviations.
const DEVIATIONS: f64 = 3.0;

/// The nodes of a run at which rates are most off.
#[derive(Debug)]
pub(super) struct Loudest {
    /// True if all nodes are looked at, and not one of each window.
    is_of_all: bool,
    here: Option<Evaluated>,
    /// The largest size of each rate so far.
    sizes: Vec<f64>,
    /// By how much what is lost at a node moves the run, with the node and its part of γ.
    kept: Vec<(f64, Seen)>,
    /// The sums of squares of what the rounding of coordinates adds to each p_a, where it changes a force by more than
    /// is ordinary: on the steep sides of a pulse, say.
    rounded: Vec<f64>,
}

impl Loudest {
    pub(super) fn new(is_of_all: bool) -> Self {
        Self { is_of_all, here: None, sizes: Vec::new(), kept: Vec::new(), rounded: Vec::new() }
    }

    /// Takes the next part of a run of `case` into account, where events have `set` parameters. A part that contains
    /// the first window begins the run again.
    pub(super) fn see<S: Real, R: Real>(
        &mut self,
        (case, setup): (&Case, &Setup<R>),
        part: &WorldLine<S>,
        set: &[(usize, f64)],
    ) {
        if part.window_count == part.windows.len() {
            let n = part.geometry().dimension();
            (self.sizes, self.kept, self.rounded) = (vec![0.0; 2 * n], Vec::new(), vec![0.0; n]);
        }
        if S::IS_EXTENDED {
            return;
        }
        // The windows of a given grid are not adapted to anything, so that one node says nothing of the others.
        let is_of_all = self.is_of_all || setup.settings.accuracy.is_none();
        let mut sampler = Sampler::new(part);
        for (index, window) in part.windows.iter().enumerate() {
            let inner = window.points().max(3) - 2;
            let nodes = if is_of_all { 1..inner + 1 } else { inner.div_ceil(2)..inner.div_ceil(2) + 1 };
            let length = window.length().to_f64() / nodes.len() as f64;
            let others = inner as f64 / nodes.len() as f64;
            for node in nodes {
                let seen = Seen { part: length, ..Seen::of(part, sampler.inside(index, node), set) };
                let share = self.share((case, setup), &seen, (index + node) as u32 % PATTERNS, others);
                if share > ORDINARY {
                    self.keep(share * length, seen);
                }
            }
        }
    }

    /// The largest share that a rate of a result is off by at a node, of its largest size so far. Takes what rounding
    /// of its place changes into account, for so many nodes.
    fn share<R: Real>(&mut self, of: (&Case, &Setup<R>), seen: &Seen, pattern: u32, nodes: f64) -> f64 {
        let Some(here) = Evaluated::where_set(&mut self.here, of, seen) else { return 0.0 };
        let (rates, off) = here.off(seen);
        self.sizes.iter_mut().zip(&rates).for_each(|(size, rate)| *size = size.max(rate.abs()));
        let moved = here.moved_by_rounding(seen, &rates, pattern);
        let n = self.sizes.len() / 2;
        for ((square, by), size) in self.rounded.iter_mut().zip(&moved[n..]).zip(&self.sizes[n..]) {
            // Roundings of nodes are independent, and lie anywhere within half a unit: their variance is a third of
            // its square.
            *square += if *by > ORDINARY * size { (by * seen.part).powi(2) / (3.0 * nodes) } else { 0.0 };
        }
        let results = off.iter().zip(&self.sizes).enumerate().filter(|(k, _)| k % n < here.count);
        results.filter(|(_, (off, _))| **off > 0.0).map(|(_, (off, size))| off / size).fold(0.0, f64::max)
    }

    /// Keeps a node, unless others are louder.
    fn keep(&mut self, loud: f64, seen: Seen) {
        self.kept.push((loud, seen));
        if self.kept.len() > if self.is_of_all { KEPT_OF_ALL } else { KEPT } {
            let least = (0..self.kept.len()).min_by(|&one, &other| self.kept[one].0.total_cmp(&self.kept[other].0));
            least.into_iter().for_each(|least| drop(self.kept.swap_remove(least)));
        }
    }

    /// By how much each p_a is moved in all as coordinates are rounded, where that is more than is ordinary.
    pub(super) fn moved_by_rounding(&self) -> impl Iterator<Item = f64> {
        self.rounded.iter().map(|square| DEVIATIONS * square.sqrt())
    }

    /// These nodes.
    pub(super) fn seen(&self) -> impl Iterator<Item = &Seen> {
        self.kept.iter().map(|(_, seen)| seen)
    }
}
