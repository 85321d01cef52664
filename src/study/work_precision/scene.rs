//! The schemes of a scene that are no call of `solve` on a grid.

use std::ops::ControlFlow;

use super::course::{Course, Marched};
use super::run::{Raw, Run, none};
use crate::engine::{Accuracy, Engine, Failure};
use crate::geometry::Geometry;
use crate::methods::{Output, SceneState, Setting, Trajectory};
use crate::solve::POINTS;

impl Marched for Geometry {
    /// There is none.
    fn march(_: &Course<Self>, _: usize, _: Setting, _: Output) -> Run<'_, Self> {
        none("not-for-scenes")
    }

    /// Certified windows for an accuracy, and the states inside them.
    fn accuracy(course: &Course<Self>, accuracy: f64, output: Output) -> Run<'_, Self> {
        let (geometry, start, length) = (&*course.problem.space, &course.problem.start, course.problem.length);
        let marks: Vec<f64> = output.gamma(length).collect();
        let wanted = Accuracy::Promised(accuracy);
        Box::new(move || {
            let (mut states, mut windows): (Vec<SceneState>, _) = (Vec::with_capacity(marks.len()), 0);
            let (mut q, mut active) = (start.q.clone(), vec![0.0; geometry.active().len()]);
            let engine = Engine::accurate(geometry, start, length, wanted, POINTS);
            let mut engine = engine.map_err(|outside| Failure::OutsideDomain(outside).as_str())?;
            let solved = engine.run(|window| {
                if window.index == 0 {
                    states.clear();
                }
                windows = window.index + 1;
                let end = window.gamma + window.length;
                let mut dense = None;
                while let Some(mark) = marks.get(states.len()).filter(|mark| **mark <= end || end >= length) {
                    let fraction = ((mark - window.gamma) / window.length).min(1.0);
                    dense.get_or_insert_with(|| window.dense()).at(fraction, &mut q, &mut active);
                    let mut p = start.p.clone();
                    geometry.active().iter().zip(&active).for_each(|(&a, &momentum)| p[a] = momentum);
                    states.push(SceneState { q: q.clone(), p });
                }
                ControlFlow::Continue(())
            });
            solved.map_err(Failure::as_str)?;
            let (evaluations, steps) = (engine.sweeps() * POINTS, windows * POINTS);
            Ok(Raw::Trajectory(Trajectory { states, evaluations, steps }))
        })
    }
}
