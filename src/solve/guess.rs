//! The first guess of Newton's method: the motion on the nodes of a window, by the engine of few nodes.
//!
//! It follows the geodesic however coarse the grid is, and costs next to nothing where the grid is fine. On few nodes
//! that resolve the motion its tables would take longer than the rest of the solve: there one step of the method of
//! Bogacki and Shampine (Appl. Math. Lett. 2, 1989) from node to node is enough.

use super::piece::Problem;
use super::status::InitialGuess;
use crate::engine::{Accuracy, Engine, Failure};
use crate::geometry::{OutsideGeometry, Rates};

/// The accuracy of each window of the engine. On a fine grid Newton's method has one step less to take from there.
const ACCURACY: f64 = 1e-9;
/// With more nodes than this the engine takes less time than a step from each to the next.
const MOST_STEPS: usize = 2000;
/// A step resolves the motion if its error estimate is at most this share of what the step adds up to.
const RESOLVED: f64 = 1e-2;
/// A grid with fewer than one node for so many windows resolves nothing.
const MOST_WINDOWS: usize = 64;
/// So many there may be on any grid: where t has no limit before a horizon, the engine comes to it by thousands.
const WINDOWS_TO_A_HORIZON: usize = 10_000;

/// A world-line on the nodes.
pub(super) struct Guess {
    /// q^a, a row for each coordinate. Steps leave out ignorable coordinates, which the physical limit does not need.
    pub(super) q: Vec<Vec<f64>>,
    /// p_a, a row for each active coordinate.
    pub(super) p: Vec<Vec<f64>>,
    /// The way in which it was found.
    pub(super) kind: InitialGuess,
}

/// The geodesic on the nodes. Of a grid that resolves nothing the last nodes are where the engine has come to, as they
/// are where it finds no next window, and Newton's method says what there is.
///
/// # Errors
/// γ from the start of the window where the geodesic leaves the domain, q^a there, and a point outside.
pub(super) fn guess(window: &Problem<'_, f64>) -> Result<Guess, (f64, Vec<f64>, OutsideGeometry)> {
    let (geometry, start, sbp) = (window.geometry, window.start, window.sbp);
    let (points, length) = (window.points(), window.sbp.node(window.points() - 1));
    let mut q: Vec<Vec<f64>> = start.q.iter().map(|&q| vec![q]).collect();
    let mut p: Vec<Vec<f64>> = geometry.active().iter().map(|&a| vec![start.p[a]]).collect();
    q.iter_mut().chain(&mut p).for_each(|row| row.reserve_exact(points - 1));
    let engine = Engine::accurate(geometry, start, length, Accuracy::Local(ACCURACY));
    let mut engine = engine.map_err(|point| (0.0, start.q.clone(), point))?;
    for _ in 0..WINDOWS_TO_A_HORIZON.max(MOST_WINDOWS * points) {
        match engine.next() {
            Ok(Some(window)) => {
                let end = window.gamma + window.length;
                let reached = |k: &usize| window.is_last || sbp.node(*k) <= end;
                let nodes = (q[0].len()..points).take_while(reached);
                let fractions = nodes.map(|k| (sbp.node(k) - window.gamma) / window.length);
                window.dense().append(fractions, &mut q, &mut p);
            }
            Err(Failure::OutsideDomain(point)) => {
                let (gamma, q) = engine.place();
                let position = geometry.active().first().map_or(f64::NAN, |&a| q[a]);
                return Err((gamma, q, OutsideGeometry { position, ..point }));
            }
            Ok(None) | Err(_) => break,
        }
    }
    q.iter_mut().chain(&mut p).for_each(|row| row.resize(points, row[row.len() - 1]));
    Ok(Guess { q, p, kind: InitialGuess::Engine })
}

/// The geodesic on the nodes by one step from each to the next, if there are few and they resolve the motion: it then
/// comes to no pole, which steps could leap over. Ignorable coordinates are left out.
pub(super) fn by_steps(window: &Problem<'_, f64>) -> Option<Guess> {
    let (active, start, sbp) = (window.geometry.active(), window.start, window.sbp);
    if window.points() > MOST_STEPS {
        return None;
    }
    let mut state: Vec<f64> = active.iter().map(|&a| start.q[a]).chain(active.iter().map(|&a| start.p[a])).collect();
    let mut nodes = vec![Vec::with_capacity(window.points()); state.len()];
    let [mut first, mut second, mut third, mut last, mut stage] = [(); 5].map(|()| vec![0.0; state.len()]);
    let mut rates = Rates::new(window.geometry, start);
    let mut slopes = |state: &[f64], out: &mut [f64]| {
        state.iter().enumerate().for_each(|(place, &value)| rates.set(place, value));
        let found = rates.evaluate();
        out.iter_mut().enumerate().for_each(|(place, out)| *out = rates.get(place));
        found.ok()
    };
    slopes(&state, &mut first)?;
    for k in 0..window.points() {
        nodes.iter_mut().zip(&state).for_each(|(row, &value)| row.push(value));
        if k + 1 == window.points() {
            break;
        }
        let h = sbp.node(k + 1) - sbp.node(k);
        (0..state.len()).for_each(|i| stage[i] = state[i] + 0.5 * h * first[i]);
        slopes(&stage, &mut second)?;
        (0..state.len()).for_each(|i| stage[i] = state[i] + 0.75 * h * second[i]);
        slopes(&stage, &mut third)?;
        (0..state.len()).for_each(|i| state[i] += h / 9.0 * (2.0 * first[i] + 3.0 * second[i] + 4.0 * third[i]));
        slopes(&state, &mut last)?;
        let is_resolved = |i: usize| {
            let error = (-5.0 * first[i] + 6.0 * second[i] + 8.0 * third[i] - 9.0 * last[i]) / 72.0;
            error.abs() <= RESOLVED * (first[i].abs() + second[i].abs() + third[i].abs())
        };
        if !(0..state.len()).all(is_resolved) {
            return None;
        }
        std::mem::swap(&mut first, &mut last);
    }
    let p = nodes.split_off(active.len());
    let mut q = vec![Vec::new(); start.q.len()];
    active.iter().zip(nodes).for_each(|(&a, row)| q[a] = row);
    Some(Guess { q, p, kind: InitialGuess::Steps })
}
