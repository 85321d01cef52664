//! The algebras that a program is run in: numbers and blocks of them here, vectors of nodes, intervals and series
//! elsewhere.

use std::marker::PhantomData;

use super::Function;
use super::operation::{Fused, Operation};
use super::program::{Program, Register, Step};
use crate::number::Real;

/// The operations on values, whatever a value is. What `to` held before is of no interest but to series, which grow.
pub(crate) trait Algebra {
    /// The type of a register.
    type Value;

    /// `to` = a + b.
    fn add(&self, to: &mut Self::Value, a: &Self::Value, b: &Self::Value);
    /// `to` = a − b.
    fn subtract(&self, to: &mut Self::Value, a: &Self::Value, b: &Self::Value);
    /// `to` = a b.
    fn multiply(&self, to: &mut Self::Value, a: &Self::Value, b: &Self::Value);
    /// `to` = a/b.
    fn divide(&self, to: &mut Self::Value, a: &Self::Value, b: &Self::Value);
    /// `to` = −a.
    fn negate(&self, to: &mut Self::Value, a: &Self::Value);
    /// `to` = a^b.
    fn power(&self, to: &mut Self::Value, a: &Self::Value, b: &Self::Value);
    /// `to` = f(a).
    fn call(&self, to: &mut Self::Value, function: Function, a: &Self::Value);

    /// `to` = a².
    #[inline(always)]
    fn square(&self, to: &mut Self::Value, a: &Self::Value) {
        self.multiply(to, a, a);
    }

    /// `to` = ab + c, ab − c or c − ab, rounded once or twice. Only programs that were [`Program::fused`] have it.
    #[inline(always)]
    fn fused(&self, _to: &mut Self::Value, fused: Fused, _operands: [&Self::Value; 3]) {
        unreachable!("a program for other algebras has {fused:?}");
    }

    /// `sin` and `cos` of a.
    #[inline(always)]
    fn sin_cos(&self, sin: &mut Self::Value, cos: &mut Self::Value, a: &Self::Value) {
        self.call(sin, Function::Sin, a);
        self.call(cos, Function::Cos, a);
    }
}

/// Carries out steps in the registers, which lie above those that they read.
#[inline(always)]
pub(crate) fn run<A: Algebra>(algebra: &A, steps: &[Step], registers: &mut [A::Value]) {
    let mut k = 0;
    while k < steps.len() {
        let Step { to: register, operation } = steps[k];
        k += 1;
        let (known, rest) = registers.split_at_mut(register as Register);
        let (to, rest) = rest.split_at_mut(1);
        let to = &mut to[0];
        match operation {
            Operation::Add(a, b) => algebra.add(to, &known[a as usize], &known[b as usize]),
            Operation::Subtract(a, b) => algebra.subtract(to, &known[a as usize], &known[b as usize]),
            Operation::Multiply(a, b) if a == b => algebra.square(to, &known[a as usize]),
            Operation::Multiply(a, b) => algebra.multiply(to, &known[a as usize], &known[b as usize]),
            Operation::Divide(a, b) => algebra.divide(to, &known[a as usize], &known[b as usize]),
            Operation::Negate(a) => algebra.negate(to, &known[a as usize]),
            Operation::Power(a, b) => algebra.power(to, &known[a as usize], &known[b as usize]),
            Operation::Fused(fused, [a, b, c]) => {
                let operands = [&known[a as usize], &known[b as usize], &known[c as usize]];
                match fused {
                    Fused::Add => algebra.fused(to, Fused::Add, operands),
                    Fused::Subtract => algebra.fused(to, Fused::Subtract, operands),
                    Fused::SubtractFrom => algebra.fused(to, Fused::SubtractFrom, operands),
                }
            }
            Operation::Call(function, a) => match steps.get(k) {
                // The cosine stands in the next register, unless something between them is left out.
                Some(&Step { to: cos, operation: Operation::Call(Function::Cos, b) })
                    if function == Function::Sin && a == b && cos == register + 1 =>
                {
                    k += 1;
                    algebra.sin_cos(to, &mut rest[0], &known[a as usize]);
                }
                _ => algebra.call(to, function, &known[a as usize]),
            },
        }
    }
}

/// Makes a method of an algebra from a function of two numbers.
macro_rules! binary {
    ($($name:ident $f:expr),*) => {$(
        #[inline(always)]
        fn $name(&self, to: &mut Self::Value, a: &Self::Value, b: &Self::Value) {
            Self::binary(to, a, b, $f);
        }
    )*};
}
pub(super) use binary;

/// Numbers at N points.
pub(super) struct Plain<S, const N: usize>(pub(super) PhantomData<S>);

impl<S: Real, const N: usize> Plain<S, N> {
    #[inline(always)]
    fn unary(to: &mut [S; N], a: &[S; N], f: impl Fn(S) -> S) {
        for (to, a) in to.iter_mut().zip(a) {
            *to = f(*a);
        }
    }

    #[inline(always)]
    fn binary(to: &mut [S; N], a: &[S; N], b: &[S; N], f: impl Fn(S, S) -> S) {
        for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
            *to = f(*a, *b);
        }
    }
}

impl<S: Real, const N: usize> Algebra for Plain<S, N> {
    type Value = [S; N];

    binary!(add |a, b| a + b, subtract |a, b| a - b, multiply |a, b| a * b, divide |a, b| a / b, power S::powf);

    #[inline(always)]
    fn negate(&self, to: &mut [S; N], a: &[S; N]) {
        Self::unary(to, a, |a| -a);
    }

    #[inline(always)]
    fn call(&self, to: &mut [S; N], function: Function, a: &[S; N]) {
        Self::unary(to, a, |a| function.apply(a));
    }

    #[inline(always)]
    fn fused(&self, to: &mut [S; N], fused: Fused, [a, b, c]: [&[S; N]; 3]) {
        for (k, to) in to.iter_mut().enumerate() {
            let product = a[k] * b[k];
            *to = match fused {
                Fused::Add => product + c[k],
                Fused::Subtract => product - c[k],
                Fused::SubtractFrom => c[k] - product,
            };
        }
    }
}

/// Number of points that are evaluated together: enough to vectorise, and so few that all values of a formula stay in
/// the cache.
pub(crate) const BLOCK: usize = 16;

/// After so many points that cannot be mended no others are tried.
pub(crate) const MOST_LOST: usize = 16;

/// Carries out steps at N points.
#[inline]
pub(crate) fn run_at<S: Real, const N: usize>(steps: &[Step], registers: &mut [[S; N]]) {
    run(&Plain(PhantomData), steps, registers);
}

impl<S: Real> Program<S> {
    /// All outputs at one point, given by its variables.
    #[cfg(test)]
    pub(crate) fn values<const N: usize>(&self, variables: &[S]) -> [S; N] {
        let mut registers = self.registers(|constant| [constant]);
        registers.as_flattened_mut()[..variables.len()].copy_from_slice(variables);
        self.run(N, 1, &mut registers, &mut 1);
        std::array::from_fn(|output| registers[self.output(output)][0])
    }

    /// Computes the first outputs on a block, of which so many points count, and mends them ([`Self::mend`]). The
    /// constants and the variables are in their registers.
    pub(crate) fn run<const N: usize>(
        &self,
        outputs: usize,
        points: usize,
        registers: &mut [[S; N]],
        chances: &mut usize,
    ) {
        run_at(self.steps_to(outputs), registers);
        self.mend(outputs, points, registers, chances);
    }

    /// Writes the first outputs at many points into `out`, an array for each. There is an array of the points for each
    /// variable; all arrays have one length. Each step is carried out on a block of points at a time, unless there is
    /// one point only, or numbers are of a type without vector instructions.
    pub(crate) fn sample(&self, variables: &[&[S]], out: &mut [&mut [S]]) {
        if variables[0].len() == 1 || S::IS_EXTENDED {
            self.sample_by::<1>(variables, out);
        } else {
            self.sample_by::<BLOCK>(variables, out);
        }
    }

    fn sample_by<const N: usize>(&self, variables: &[&[S]], out: &mut [&mut [S]]) {
        let (points, mut chances) = (variables[0].len(), MOST_LOST);
        let mut registers = self.registers(|constant| [constant; N]);
        for start in (0..points).step_by(N) {
            let end = points.min(start + N);
            for (register, variable) in registers.iter_mut().zip(variables) {
                register[..end - start].copy_from_slice(&variable[start..end]);
            }
            self.run(out.len(), end - start, &mut registers, &mut chances);
            for (output, out) in out.iter_mut().enumerate() {
                out[start..end].copy_from_slice(&registers[self.output(output)][..end - start]);
            }
        }
    }
}
