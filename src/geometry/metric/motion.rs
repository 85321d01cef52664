//! The paper's metric as a Lagrangian in the coordinates t and x, and Hamilton's equations of it: p_t = Q_t,
//! p_x = −dx/dγ.

use super::{Metric, MetricSamples, OutsideDomain};
use crate::geometry::{Dynamics, Motion, Samples, Source, Structure, Term};
use crate::number::Real;

/// The row of g00 among the samples of the metric on some nodes.
pub const G00: usize = 0;
/// That of g00′.
pub const G00_FIRST: usize = 1;
/// That of g00″.
pub const G00_SECOND: usize = 2;

/// The two coordinates t and x: g_tt = g00(x), g_xx = −1. The rows are those of [`MetricSamples`].
impl<S: Real> Dynamics<S> for Metric<S> {
    type Outside = OutsideDomain;

    fn structure(&self) -> &Structure<S> {
        self.structure.get_or_init(|| {
            let of_g00 = |row| Source::Row(row);
            Structure {
                dimension: 2,
                values: vec![
                    Term { ab: [0, 0], by: [], value: of_g00(G00) },
                    Term { ab: [1, 1], by: [], value: Source::Constant(-S::ONE) },
                ],
                first: vec![Term { ab: [0, 0], by: [1], value: of_g00(G00_FIRST) }],
                second: vec![Term { ab: [0, 0], by: [1, 1], value: of_g00(G00_SECOND) }],
                rows: 3,
                inertias: vec![(1, -S::ONE)],
                ..Structure::default()
            }
        })
    }

    fn fill(&self, q: &[&[S]], samples: &mut Samples<S>) -> Result<(), OutsideDomain> {
        let mut rows = samples.rows_mut();
        let rows = [(); 3].map(|()| rows.next().expect("there are three rows"));
        self.sample_rows(q[1], rows)
    }

    fn raise(&self, q: &[S], v: &[S], weight: S) -> Vec<S> {
        vec![v[0] / (weight * self.g00(q[1])), -v[1] / weight]
    }

    fn fill_force(&self, _: &[&[S]], _: &[&[S]], _: &mut Samples<S>) {}
}

/// x is the only active coordinate.
const ACTIVE: [usize; 1] = [1];

/// What was computed last.
#[derive(Debug, Clone)]
pub struct MetricRoom<S> {
    /// dt/dγ, dx/dγ and d²x/dγ² at one point.
    t_dot: S,
    x_dot: S,
    acceleration: S,
    /// On the nodes.
    samples: MetricSamples<S>,
}

impl<S: Real> MetricRoom<S> {
    fn resize(&mut self, points: usize) {
        if self.samples.g00.len() != points {
            self.samples = MetricSamples::zeros(points);
        }
    }
}

impl<S: Real> Motion<S> for Metric<S> {
    type Room = MetricRoom<S>;

    fn motion_room(&self) -> MetricRoom<S> {
        MetricRoom { t_dot: S::ZERO, x_dot: S::ZERO, acceleration: S::ZERO, samples: MetricSamples::zeros(0) }
    }

    #[inline]
    fn active(&self) -> &[usize] {
        &ACTIVE
    }

    #[inline]
    fn rates_at(&self, q: &[S], p: &[S], index: usize, room: &mut MetricRoom<S>) -> Result<(), OutsideDomain> {
        let x = q[1];
        let jet = self.at(x);
        room.t_dot = p[0] / jet.g00;
        room.x_dot = -p[1];
        room.acceleration = -jet.first.half() * room.t_dot * room.t_dot;
        if jet.is_inside() && x.is_finite() {
            return Ok(());
        }
        Err(OutsideDomain { index, x: x.to_f64(), g00: jet.g00.to_f64() })
    }

    #[inline]
    fn q_dot(&self, room: &MetricRoom<S>, a: usize) -> S {
        if a == 0 { room.t_dot } else { room.x_dot }
    }

    #[inline]
    fn p_dot(&self, room: &MetricRoom<S>, _: usize) -> S {
        -room.acceleration
    }

    #[inline]
    fn acceleration(&self, room: &MetricRoom<S>, _: usize) -> Option<S> {
        Some(room.acceleration)
    }

    fn rates(
        &self,
        q: &[Vec<S>],
        p: &[Vec<S>],
        start: &[S],
        room: &mut MetricRoom<S>,
        out: &mut [Vec<S>],
    ) -> Result<(), OutsideDomain> {
        room.resize(q[1].len());
        self.sample_into(&q[1], &mut room.samples)?;
        let MetricSamples { g00, first, .. } = &room.samples;
        let [q_dot, p_dot] = out else { unreachable!("there is one active coordinate") };
        q_dot.iter_mut().zip(&p[0]).for_each(|(q_dot, &p)| *q_dot = -p);
        for ((p_dot, &g00), &first) in p_dot.iter_mut().zip(g00).zip(first) {
            *p_dot = -acceleration(start[0], g00, first);
        }
        Ok(())
    }

    fn steps(&self, _: &[Vec<S>], _: &[Vec<S>], start: &[S], h: S, room: &mut MetricRoom<S>) -> Vec<Vec<S>> {
        let h_q = h * start[0];
        vec![room.samples.g00.iter().map(|&g00| h_q / g00).collect()]
    }

    fn jacobian(&self, _: &[S], p: &[S], k: usize, room: &mut MetricRoom<S>, mut see: impl FnMut(usize, usize, S)) {
        let MetricSamples { g00, first, second } = &room.samples;
        see(0, 1, -S::ONE);
        see(1, 0, -acceleration_slope(p[0], g00[k], first[k], second[k]));
    }
}

/// ẍ = −½ g00′ (Q_t/g00)², the geodesic equation for x after Q_t has eliminated ṫ.
#[inline]
pub fn acceleration<S: Real>(q_t: S, g00: S, first: S) -> S {
    let t_dot = q_t / g00;
    -first.half() * t_dot * t_dot
}

/// The derivative of [`acceleration`] with respect to x: −½ g00″ (Q_t/g00)² + g00′² Q_t²/g00³.
#[inline]
pub fn acceleration_slope<S: Real>(q_t: S, g00: S, first: S, second: S) -> S {
    let t_dot = q_t / g00;
    t_dot * t_dot * (first * first / g00 - second.half())
}
