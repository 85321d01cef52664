//! Bounds on what steep functions and quotients do to the motion.
//!
//! For fixed places every value depends on what the steep operations give. Along with its interval every value gets a
//! bound on how much it varies because of them: all of its width for what is steep itself, and from there on by the
//! rules of differentials, with the largest factors on the box.

use super::{BOXES, Enclosed};
use crate::formula::{Function, Operation, Program, Register};
use crate::number::norm::times;

/// A width that may be rounding, relative to the value.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// What is not above this is below the range of numbers, but for what it was multiplied by on the way.
const NOTHING: f64 = 1e-290;

/// A bound for each box.
pub(super) type Bounds = [f64; BOXES];

/// Room for the bounds of all values.
pub(super) struct Influence {
    bounds: Vec<Bounds>,
    /// By the register of each value, which of all that is watched makes it steep.
    causes: Vec<Vec<usize>>,
}

impl Influence {
    /// For all that drives the motion.
    pub(super) fn new(program: &Program<f64>, causes: Vec<Vec<usize>>) -> Self {
        Self { bounds: vec![[0.0; BOXES]; program.size()], causes }
    }

    /// By how much what is steep on boxes changes an output, in units of its tolerance: the most of all outputs, box by
    /// box. `steep` says of each box, the last of which is repeated, what of all that is watched hides something there.
    pub(super) fn largest(&mut self, enclosed: &Enclosed, steep: &[Vec<bool>], tolerances: &[f64]) -> Bounds {
        let program = &enclosed.program;
        for variable in 0..program.variables {
            self.bounds[variable] = self.bound(enclosed, steep, variable, None);
        }
        for step in program.steps_to(program.outputs.len()) {
            self.bounds[step.to()] = self.bound(enclosed, steep, step.to(), Some(step.operation()));
        }
        let mut largest = [0.0_f64; BOXES];
        // Nothing depends on an output whose tolerance is infinite.
        for (output, &tolerance) in tolerances.iter().enumerate().filter(|(_, tolerance)| tolerance.is_finite()) {
            for (largest, &bound) in largest.iter_mut().zip(&self.bounds[program.output(output)]) {
                let share = if bound <= NOTHING { 0.0 } else { bound / tolerance };
                *largest = if share.is_nan() { f64::INFINITY } else { largest.max(share) };
            }
        }
        largest
    }

    /// The bound of a value that this operation makes, or of a variable.
    fn bound(&self, enclosed: &Enclosed, steep: &[Vec<bool>], to: Register, operation: Option<Operation>) -> Bounds {
        let size = |register: Register, k: usize| {
            let [lo, hi] = enclosed.interval(register, k);
            lo.abs().max(hi.abs())
        };
        let of = |register: Register, k: usize| self.bounds[register][k];
        std::array::from_fn(|k| {
            let [lo, hi] = enclosed.interval(to, k);
            let width = hi - lo;
            if self.causes[to].iter().any(|&cause| steep[k.min(steep.len() - 1)][cause]) {
                // Nothing is known of values without bounds.
                return if width.is_finite() { (width - ROUNDING * size(to, k)).max(0.0) } else { f64::INFINITY };
            }
            let bound = match operation {
                None => return 0.0,
                Some(Operation::Add(a, b) | Operation::Subtract(a, b)) => of(a, k) + of(b, k),
                Some(Operation::Negate(a)) => of(a, k),
                Some(Operation::Multiply(a, b)) => times(size(a, k), of(b, k)) + times(size(b, k), of(a, k)),
                Some(Operation::Divide(a, b)) => {
                    let [lo, hi] = enclosed.interval(b, k);
                    (of(a, k) + times(size(to, k), of(b, k))) / lo.abs().min(hi.abs())
                }
                Some(Operation::Call(function, a)) => {
                    times(slope(function, [lo, hi], enclosed.interval(a, k)), of(a, k))
                }
                Some(Operation::Power(..) | Operation::Fused(..)) => {
                    unreachable!("these are written by simpler operations")
                }
            };
            // What does not vary because of them may still have a width.
            if bound > width { width } else { bound }
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
        // An argument that varies unseen has both signs where its interval has.
        Function::Sign | Function::Step if argument[0] <= 0.0 && argument[1] >= 0.0 => f64::INFINITY,
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
