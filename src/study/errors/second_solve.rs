//! The error of a run by a second and cheaper solve.

use super::points::Points;
use super::run_error::{Found, Judge, RunError};
use super::stepped_over::Windows;
use crate::engine::{Accuracy, Engine, POINTS};
use crate::number::Real;
use crate::solve::Place;

/// The accuracy of every window of the second solve. What they add up to is estimated on its way.
const ACCURACY: f64 = 1e-13;

/// The largest number of windows of the second solve: the first number is per node of the run, and the second one is
/// allowed in any case.
const WINDOWS: (usize, usize) = (1, 10_000);

/// Compares the points of a run that starts at `place`. `None` if the second solve does not reach the end.
pub(super) fn compare<S: Real>(place: &Place, points: &Points<S>) -> Option<RunError> {
    let (geometry, start) = (&*place.geometry, &*place.start);
    let (most, last) = (WINDOWS.1.max(WINDOWS.0 * points.len()), points.len() - 1);
    let length = points.gamma[last].to_f64();
    let mut engine = Engine::accurate(geometry, start, length, Accuracy::Estimated(ACCURACY), POINTS).ok()?;
    let (mut found, mut next) = (Found::none(start.q.len()), 0);
    let mut between = Windows::new(geometry, start, length);
    let (mut q, mut p) = (vec![Vec::new(); start.q.len()], vec![Vec::new(); geometry.active().len()]);
    let (mut end, mut end_p) = (start.q.clone(), start.p.clone());
    // Windows that may add up to anything are never begun again.
    while let Some(window) = engine.next().ok()? {
        let (begin, h, dense) = (window.gamma, window.length, window.dense());
        let is_here = |k: &usize| window.is_last || points.gamma[*k].to_f64() < begin + h;
        let here = next..(next..last).take_while(is_here).last().map_or(next, |k| k + 1);
        q.iter_mut().chain(&mut p).for_each(Vec::clear);
        let fractions = here.clone().map(|k| ((points.gamma[k].to_f64() - begin) / h).clamp(0.0, 1.0));
        dense.append(fractions, &mut q, &mut p);
        for k in here.clone() {
            found.see(points.rows.iter().zip(&q).map(|(row, q)| row[k].to_f64() - q[k - next]));
        }
        next = here.end;
        between.see(&window, &dense);
        end.clone_from(&window.end().positions());
        geometry.active().iter().zip(window.end().momenta()).for_each(|(&a, p)| end_p[a] = p);
        if window.index >= most {
            return None;
        }
    }
    if next < last {
        return None;
    }
    let off = points.rows.iter().zip(&end).map(|(row, q)| row[last].to_f64() - q).collect();
    found.see(points.at_end(off, &geometry.velocities(&end, &end_p).ok()?));
    let (estimate, sizes) = (engine.error_estimate()?, engine.sizes());
    let own = points.own(sizes.iter().map(|size| estimate * size).collect());
    Some(found.finish(own, Judge::SecondSolve(estimate), between.share()))
}
