//! The schemes of a scene that are no call of `solve` on a grid.

use std::ops::ControlFlow;

use super::course::{Course, Marched};
use super::run::{Raw, Run, none};
use crate::engine::lobatto::flow::{Flow, FlowFailure};
use crate::geometry::Geometry;
use crate::methods::{Output, SceneState, Setting, Trajectory};

impl Marched for Geometry {
    /// There is none.
    fn march(_: &Course<Self>, _: usize, _: Setting, _: Output) -> Run<'_, Self> {
        none("not-for-scenes")
    }

    /// Certified windows for an accuracy, and the states inside them.
    fn accuracy(course: &Course<Self>, accuracy: f64, output: Output) -> Run<'_, Self> {
        let (geometry, start, length) = (&*course.problem.space, &course.problem.start, course.problem.length);
        let marks: Vec<f64> = output.gamma(length).collect();
        Box::new(move || {
            let (mut states, mut points): (Vec<SceneState>, _) = (Vec::with_capacity(marks.len()), 0);
            let followed = Flow::new(geometry).certified().run(start, length, &mut [], accuracy, &mut |view| {
                if view.index == 0 {
                    states.clear();
                    points = 0;
                }
                points += view.points;
                let end = view.gamma + view.length;
                let is_inside = |mark: &&f64| **mark <= end || end >= length;
                let fractions = marks[states.len()..].iter().take_while(is_inside);
                let fractions: Vec<f64> = fractions.map(|mark| ((mark - view.gamma) / view.length).min(1.0)).collect();
                view.inside(&fractions, |q, p| {
                    let mut momenta = start.p.clone();
                    geometry.active().iter().zip(p).for_each(|(&a, &p)| momenta[a] = p);
                    states.push(SceneState { q: q.to_vec(), p: momenta });
                });
                ControlFlow::Continue(())
            });
            let evaluations = match followed {
                Ok(followed) => followed.statistics.evaluations * (points / followed.statistics.windows.max(1)),
                Err(FlowFailure::OutsideDomain { .. }) => return Err("outside-domain"),
                Err(FlowFailure::NotConverged { .. }) => return Err("not-converged"),
                Err(FlowFailure::AccuracyNotReached { .. }) => return Err("accuracy-not-reached"),
                Err(FlowFailure::EvaluationLimit { .. }) => return Err("evaluation-limit"),
            };
            Ok(Raw::Trajectory(Trajectory { states, evaluations, steps: points }))
        })
    }
}
