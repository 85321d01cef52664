//! Where one of some formulas of the state first changes its sign, roughly: Runge–Kutta steps on Hamilton's equations.

use super::arithmetic::Arithmetic;
use super::routes::Routes;
use super::setup::Setup;
use crate::geometry::{Observable, OutsideGeometry, Point};
use crate::number::runge_kutta::runge_kutta;

/// Steps for each interval between two nodes.
const STEPS: usize = 8;

/// q^a of all coordinates, then p_a of all, on the way.
struct Flow {
    point: Point,
    state: Vec<f64>,
    slopes: [Vec<f64>; 4],
    k: f64,
}

impl Flow {
    /// The values of the formulas here.
    fn values(&mut self, formulas: &mut [Observable]) -> Result<Vec<f64>, OutsideGeometry> {
        self.point.slopes(&self.state, &mut self.slopes[0])?;
        let n = self.state.len() / 2;
        let (state, q_dot) = (&self.state, &self.slopes[0][..n]);
        Ok(formulas.iter_mut().map(|formula| formula.at(&state[..n], q_dot, &state[n..], self.k)).collect())
    }

    fn step(&mut self, h: f64) -> Result<(), OutsideGeometry> {
        let Self { point, state, slopes, .. } = self;
        runge_kutta(state, h, slopes, |_, trial, out| point.slopes(trial, out))
    }
}

/// The flow at its start.
fn begin<S: Arithmetic, G: Routes<S, Rough: Routes<f64>>>(setup: &Setup<S, G>) -> Flow {
    let (geometry, start) = (setup.rough.geometry.as_scene(), &setup.rough.start);
    let k = geometry.norm(&start.q, &start.q_dot);
    let state: Vec<f64> = start.q.iter().chain(&start.p).copied().collect();
    let slopes = [(); 4].map(|()| vec![0.0; state.len()]);
    Flow { point: geometry.point(), state, slopes, k }
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
pub(super) fn first<S: Arithmetic, G: Routes<S, Rough: Routes<f64>>>(setup: &Setup<S, G>, length: f64) -> Option<Near> {
    let mut flow = begin(setup);
    let mut formulas: Vec<Observable> = setup.until.iter().map(|until| until.rough.clone()).collect();
    let steps = STEPS * (setup.settings.n_gamma - 1) * setup.settings.windows;
    let h = length / steps as f64;
    let mut before = flow.values(&mut formulas).ok()?;
    let mut found: Option<Near> = None;
    for k in 0..steps {
        flow.step(h).ok()?;
        let here = flow.values(&mut formulas).ok()?;
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
