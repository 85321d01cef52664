//! The algebra of balls, one at a time.

use pulp::{Simd, WithSimd};

use super::Function;
use super::algebra::{Algebra, run};
use super::operation::Fused;
use super::program::Step;
use crate::number::ball::Ball;
use crate::number::vector::Level;

/// Carries out steps on balls. Their products are exact by a fused multiply-add, which is a slow library call unless
/// the instruction is enabled.
pub(crate) fn run_on_balls(steps: &[Step], registers: &mut [Ball]) {
    Level::Best.dispatch(OnBalls { steps, registers });
}

/// Steps and the registers that they work on.
struct OnBalls<'w> {
    steps: &'w [Step],
    registers: &'w mut [Ball],
}

impl WithSimd for OnBalls<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        run(&OneBall, self.steps, self.registers);
    }
}

/// A ball in each register.
struct OneBall;

/// Methods of the algebra from the operations of balls.
macro_rules! binary {
    ($($name:ident $operation:tt),*) => {$(
        #[inline(always)]
        fn $name(&self, to: &mut Ball, a: &Ball, b: &Ball) {
            *to = *a $operation *b;
        }
    )*};
}

impl Algebra for OneBall {
    type Value = Ball;

    binary!(add +, subtract -, multiply *, divide /);

    #[inline(always)]
    fn negate(&self, to: &mut Ball, a: &Ball) {
        *to = -*a;
    }

    fn power(&self, to: &mut Ball, a: &Ball, b: &Ball) {
        *to = a.power(*b);
    }

    fn call(&self, to: &mut Ball, function: Function, a: &Ball) {
        *to = a.call(function);
    }

    #[inline(always)]
    fn fused(&self, to: &mut Ball, fused: Fused, [a, b, c]: [&Ball; 3]) {
        let product = *a * *b;
        *to = match fused {
            Fused::Add => product + *c,
            Fused::Subtract => product - *c,
            Fused::SubtractFrom => *c - product,
        };
    }

    fn sin_cos(&self, sin: &mut Ball, cos: &mut Ball, a: &Ball) {
        [*sin, *cos] = a.sin_cos();
    }
}
