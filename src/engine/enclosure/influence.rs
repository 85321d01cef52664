//! Bounds on what steep functions and quotients do to the motion.
//!
//! For fixed places every value depends on what the steep operations give. Along with its interval every value gets a
//! bound on how much it varies because of them: all of its width for what is steep itself, and from there on by the
//! rules of differentials, with the largest factors on the box.

use super::{BOXES, Enclosed, Path, is_gentle};
use crate::formula::{Function, Kind, Operation, Program, Register, Step, kind};
use crate::number::norm::times;

/// A width that may be rounding, relative to the value.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// A bound for each box.
pub(super) type Bounds = [f64; BOXES];

/// Room for the bounds of all values.
pub(super) struct Influence {
    bounds: Vec<Bounds>,
    /// Arguments of abs, sign and step, and the bounds of each on the nodes of a window.
    kinks: Vec<(Register, Vec<[f64; 2]>)>,
    /// Number of these nodes.
    points: usize,
}

impl Influence {
    /// For all that drives the motion.
    pub(super) fn new(program: &Program<f64>) -> Self {
        let mut kinks: Vec<(Register, Vec<[f64; 2]>)> = Vec::new();
        for step in program.steps_to(program.outputs.len()) {
            if let Operation::Call(function, a) = step.operation()
                && kind(function) == Kind::Sign
                && kinks.iter().all(|kink| kink.0 != a)
            {
                kinks.push((a, Vec::new()));
            }
        }
        Self { bounds: vec![[0.0; BOXES]; program.size()], kinks, points: 0 }
    }

    /// Looks at the nodes of a window, if there may be kinks.
    pub(super) fn see_nodes(&mut self, path: &Path, enclosed: &mut Enclosed, drive: &[Step]) {
        if self.kinks.is_empty() {
            return;
        }
        self.points = path.points;
        self.kinks.iter_mut().for_each(|kink| kink.1.clear());
        for first in (0..path.points).step_by(BOXES) {
            enclosed.place(path, |row, k| [path.value(row, (first + k).min(path.points - 1)); 2]);
            enclosed.run(drive);
            for (register, seen) in &mut self.kinks {
                seen.extend((0..BOXES).map(|k| enclosed.interval(*register, k)));
            }
        }
    }

    /// Returns true if the nodes of a pair, or of one beside it, whose bend the kink makes too, show both sides of it.
    fn is_seen(&self, register: Register, pair: usize) -> bool {
        let kink = self.kinks.iter().find(|kink| kink.0 == register);
        kink.is_some_and(|(_, seen)| {
            let around = &seen[pair.saturating_sub(1)..(pair + 3).min(self.points)];
            around.iter().any(|bounds| bounds[0] <= 0.0) && around.iter().any(|bounds| bounds[1] >= 0.0)
        })
    }

    /// By how much what is steep on the boxes of these pairs changes an output, in units of its tolerance: the most of
    /// all outputs, pair by pair.
    pub(super) fn largest(&mut self, enclosed: &Enclosed, pairs: &[usize], tolerances: &[f64]) -> Bounds {
        let program = &enclosed.program;
        for step in program.steps_to(program.outputs.len()) {
            self.bounds[step.to()] = self.bound(enclosed, pairs, step.to(), step.operation());
        }
        let mut largest = [0.0_f64; BOXES];
        // Nothing depends on an output whose tolerance is infinite.
        for (output, &tolerance) in tolerances.iter().enumerate().filter(|(_, tolerance)| tolerance.is_finite()) {
            for (largest, &bound) in largest.iter_mut().zip(&self.bounds[program.output(output)]) {
                let share = if bound == 0.0 { 0.0 } else { bound / tolerance };
                *largest = if share.is_nan() { f64::INFINITY } else { largest.max(share) };
            }
        }
        largest
    }

    fn bound(&self, enclosed: &Enclosed, pairs: &[usize], to: Register, operation: Operation) -> Bounds {
        let size = |register: Register, k: usize| {
            let [lo, hi] = enclosed.interval(register, k);
            lo.abs().max(hi.abs())
        };
        let of = |register: Register, k: usize| self.bounds[register][k];
        std::array::from_fn(|k| {
            let [lo, hi] = enclosed.interval(to, k);
            let width = hi - lo;
            // Nothing is known of values without bounds.
            let rounding = ROUNDING * size(to, k);
            let steep = if width.is_finite() { (width - rounding).max(0.0) } else { f64::INFINITY };
            let is_steep = |argument: Register, kind: Kind| !is_gentle(kind, enclosed.interval(argument, k));
            match operation {
                Operation::Add(a, b) | Operation::Subtract(a, b) => of(a, k) + of(b, k),
                Operation::Negate(a) => of(a, k),
                Operation::Multiply(a, b) => times(size(a, k), of(b, k)) + times(size(b, k), of(a, k)),
                Operation::Divide(_, b) if is_steep(b, Kind::Ratio) => steep,
                Operation::Divide(a, b) => {
                    let [lo, hi] = enclosed.interval(b, k);
                    (of(a, k) + times(size(to, k), of(b, k))) / lo.abs().min(hi.abs())
                }
                Operation::Call(function, a) => {
                    let pair = pairs[k.min(pairs.len() - 1)];
                    let is_steep = is_steep(a, kind(function));
                    match function {
                        _ if is_steep && kind(function) == Kind::Sign && self.is_seen(a, pair) => of(a, k).min(width),
                        _ if is_steep => steep,
                        _ => times(slope(function, [lo, hi], enclosed.interval(a, k)), of(a, k)).min(width),
                    }
                }
                Operation::Power(..) | Operation::Fused(..) => unreachable!("these are written by simpler operations"),
            }
        })
    }
}

/// The largest slope of a function with these values, whose argument varies little.
fn slope(function: Function, [lo, hi]: [f64; 2], argument: [f64; 2]) -> f64 {
    match function {
        Function::Exp | Function::Cosh => hi,
        Function::Sinh => 1.0 + lo.abs().max(hi.abs()),
        Function::Sqrt => 0.5 / lo,
        Function::Ln => 1.0 / argument[0],
        Function::Asin | Function::Acos => {
            let largest = argument[0].abs().max(argument[1].abs());
            1.0 / ((1.0 - largest) * (1.0 + largest)).sqrt()
        }
        Function::Sign | Function::Step => 0.0,
        Function::Table(table) => table.derivative().map_or(0.0, |slope| {
            let [least, most] = slope.bounds(argument);
            most.max(-least)
        }),
        Function::Abs | Function::Sin | Function::Cos | Function::Tanh | Function::Atan => 1.0,
        // They are written by others before.
        Function::Tan | Function::Log10 => f64::INFINITY,
    }
}
