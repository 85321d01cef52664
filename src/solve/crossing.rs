//! Where one of some formulas of the state first changes its sign, roughly.

use super::arithmetic::Arithmetic;
use super::flow::Flow;
use super::setup::Setup;
use super::world_line::Place;
use crate::geometry::{Observable, OutsideGeometry};

/// Steps for each interval between two nodes.
const STEPS: usize = 8;

/// The values of some formulas of the state.
struct Values {
    formulas: Vec<Observable>,
    rates: Vec<f64>,
    k: f64,
}

impl Values {
    fn at(&mut self, flow: &mut Flow) -> Result<Vec<f64>, OutsideGeometry> {
        let Self { formulas, rates, k } = self;
        flow.rates(rates)?;
        let (q, p) = flow.place();
        Ok(formulas.iter_mut().map(|formula| formula.at(q, &rates[..q.len()], p, *k)).collect())
    }
}

/// A change of sign, roughly.
pub(super) struct Near {
    /// The place of the formula among those that end the run.
    pub(super) index: usize,
    /// γ − γ_i.
    pub(super) gamma: f64,
    /// Whether the formula is positive after it.
    pub(super) to_positive: bool,
}

/// A root that is so small a part of the first step is the start itself, which is none.
const AT_START: f64 = 1e-9;

/// The first change of sign in its direction within `length`; `None` if there is none, or the flow ends before it.
pub(super) fn first<S: Arithmetic>(setup: &Setup<S>, length: f64) -> Option<Near> {
    let Place { geometry, start } = &setup.rough;
    let mut flow = Flow::new(geometry, start);
    let mut values = Values {
        formulas: setup.until.iter().map(|until| until.rough.clone()).collect(),
        rates: vec![0.0; 2 * start.q.len()],
        k: geometry.norm(&start.q, &start.q_dot),
    };
    let steps = STEPS * (setup.settings.n_gamma - 1) * setup.settings.windows;
    let h = length / steps as f64;
    let mut before = values.at(&mut flow).ok()?;
    let mut found: Option<Near> = None;
    for k in 0..steps {
        flow.step(h).ok()?;
        let here = values.at(&mut flow).ok()?;
        for (index, (before, &here)) in before.iter_mut().zip(&here).enumerate() {
            let share = *before / (*before - here);
            let is_change = *before * here < 0.0 && !(k == 0 && share < AT_START);
            let to_positive = here > 0.0;
            let gamma = h * (k as f64 + share);
            if is_change
                && setup.until[index].direction.counts(to_positive)
                && found.as_ref().is_none_or(|other| gamma < other.gamma)
            {
                found = Some(Near { index, gamma, to_positive });
            }
            // A value of zero has no sign: the one before it counts.
            if here != 0.0 {
                *before = here;
            }
        }
        if found.is_some() {
            break;
        }
    }
    found
}
