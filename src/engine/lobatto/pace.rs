//! Whether a march gets anywhere.

/// The most evaluations of the force, on all nodes of a window, that a march to an accuracy may need: a day. At its
/// pace a march that needs more is stopped early.
pub const MOST_EVALUATIONS: f64 = 1e12;

/// After how many evaluations progress is looked at again.
const PAUSE: usize = 10_000;

/// When progress was looked at last.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    evaluations: usize,
    /// γ − γ_i.
    gamma: f64,
}

impl Pace {
    /// From the start of an attempt, before which there were so many `evaluations`.
    pub(super) fn new(evaluations: usize) -> Self {
        Self { evaluations, gamma: 0.0 }
    }

    /// By how much γ has advanced since progress was looked at last, if it is to be looked at again.
    pub(super) fn advance(&mut self, evaluations: usize, gamma: f64) -> Option<f64> {
        if evaluations - self.evaluations <= PAUSE {
            return None;
        }
        let before = std::mem::replace(self, Self { evaluations, gamma });
        Some(gamma - before.gamma)
    }
}

/// The evaluations that a run of which this part is done needs at its pace, if that is more than anybody would wait
/// for.
pub(super) fn too_many(evaluations: usize, done: f64) -> Option<f64> {
    let needed = evaluations as f64 / done;
    (needed > MOST_EVALUATIONS).then_some(needed)
}
