//! The algebra of balls, one at a time.

use super::Function;
use super::algebra::Algebra;
use super::operation::Fused;
use crate::number::ball::Ball;

/// A ball in each register.
pub(crate) struct OneBall;

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
