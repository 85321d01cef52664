//! The motions from a set of starts: where they end.

use super::end::{End, moved};
use super::equations::Equations;
use super::tables::UP;
use super::{Generator, Motion, Spread};
use crate::number::Real;
use crate::number::ball::OFF;

/// Every q^a and then every p_a at the end, `None` for a coordinate that is no result. `end` has the unknowns.
pub(super) fn state(motion: &Motion<'_>, equations: &Equations<'_>, end: &End) -> Vec<Option<Spread>> {
    let n = motion.geometry.dimension();
    // Columns of a set have what lengths differ by, but for the rounding of these; those to a value are not known.
    let is_length = !motion.generators.is_empty() && !end.is_at_value;
    let by_length = |generator: &Generator| if is_length { generator.length } else { 0.0 };
    let (length, late) = (end.gamma.0, motion.generators.iter().map(|of| by_length(of).abs()).sum::<f64>());
    let off = match is_length {
        false => end.gamma.1,
        true => (2.0 * OFF * length.abs().to_f64() + 4.0 * f64::EPSILON * late) * UP,
    };
    let position = |a: usize| {
        let unknown = equations.of.iter().position(|of| *of == (a, false));
        unknown.map(|k| end.spreads[k].clone()).or_else(|| {
            equations.steady.contains(&a).then(|| {
                let rate = motion.start.q_dot[a];
                let (value, radius) = moved(motion.start.q[a], rate, (length, off));
                let column = |k: usize| motion.generators[k].q[a] + rate.to_f64() * by_length(&motion.generators[k]);
                let columns: Vec<f64> = (0..motion.generators.len()).map(column).collect();
                let rounded = 4.0 * f64::EPSILON * columns.iter().map(|column| column.abs()).sum::<f64>();
                let radius = (radius + rounded + motion.off_at_start(a)) * UP;
                Spread { value, columns, radius, slack: rounded * UP }
            })
        })
    };
    let momentum = |a: usize| {
        if motion.generators.iter().any(|generator| generator.p[a].is_nan()) {
            return None;
        }
        let unknown = equations.of.iter().position(|of| *of == (a, true));
        let constant = || {
            let columns: Vec<f64> = motion.generators.iter().map(|generator| generator.p[a]).collect();
            let slack = f64::EPSILON * columns.iter().map(|column| column.abs()).sum::<f64>();
            let radius = (motion.start.p[a].abs().to_f64() * OFF + slack) * UP;
            Spread { value: motion.start.p[a], columns, radius, slack }
        };
        Some(unknown.map_or_else(constant, |k| end.spreads[k].clone()))
    };
    (0..n).map(position).chain((0..n).map(momentum)).collect()
}
