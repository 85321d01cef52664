//! Steps of programs on all nodes, compiled for every level of instructions and every number of lanes.

use pulp::{Simd, WithSimd};

use crate::formula::{Algebra, Function, Fused, Program, Step, run};
use crate::number::vector::{Nodes, elementary, multiply_add, neg, vectors, vectors_mut};

/// Work on vectors, which is compiled for every level, by what it is done with.
pub(super) struct On<A>(pub(super) A);

/// Carries out steps of a program on all nodes.
pub(super) struct Evaluate<'w, const N: usize> {
    pub(super) registers: &'w mut [Nodes<N>],
    pub(super) steps: &'w [Step],
}

impl<const N: usize> WithSimd for Evaluate<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        run(&Vectors { s }, self.steps, self.registers);
    }
}

/// Carries out steps on all nodes, and mends values of that program, if there is one, that are finite although
/// something on the way to them is not. The steps are one function for each level and number of lanes, since it is long
/// and called from several places.
#[inline(always)]
pub(super) fn evaluate<S: Simd, const N: usize>(
    s: S,
    steps: &[Step],
    registers: &mut [Nodes<N>],
    mended: Option<&Program<f64>>,
) {
    s.vectorize(Evaluate { steps, registers });
    if let Some(program) = mended {
        program.mend(program.outputs.len(), N, registers, &mut 1);
    }
}

/// An argument of a function that jumps or has a kink is on the surface at the first node if it is less than this part
/// of what it is at the second one. A window that crosses the surface there is off by no more than this part of the
/// first gap, a few 1e-15 of its length.
const ON_SURFACE: f64 = 1e-12;

/// Values of such an argument, where a window that begins on the surface is on the side that it goes to: that of the
/// first node is 0, or rounding, and what holds there is the limit from inside of the window.
#[inline(always)]
pub(super) fn leaving<const N: usize>(values: &Nodes<N>) -> Nodes<N> {
    let mut values = *values;
    let [first, second, ..] = &mut values.0[..] else { return values };
    if first.abs() < ON_SURFACE * second.abs() {
        *first = first.abs().max(f64::MIN_POSITIVE).copysign(*second);
    }
    values
}

/// The arithmetic of values that have a number on every node.
struct Vectors<S, const N: usize> {
    s: S,
}

macro_rules! lanewise {
    ($($name:ident $instruction:ident),*) => {$(
        #[inline(always)]
        fn $name(&self, to: &mut Nodes<N>, a: &Nodes<N>, b: &Nodes<N>) {
            let (a, b, to) = (vectors::<S>(&a.0), vectors::<S>(&b.0), vectors_mut::<S>(&mut to.0));
            for i in 0..to.len() {
                to[i] = self.s.$instruction(a[i], b[i]);
            }
        }
    )*};
}

impl<S: Simd, const N: usize> Algebra for Vectors<S, N> {
    type Value = Nodes<N>;

    lanewise!(add add_f64s, subtract sub_f64s, multiply mul_f64s, divide div_f64s);

    #[inline(always)]
    fn power(&self, to: &mut Nodes<N>, a: &Nodes<N>, b: &Nodes<N>) {
        elementary::power(self.s, &a.0, &b.0, &mut to.0);
    }

    #[inline(always)]
    fn negate(&self, to: &mut Nodes<N>, a: &Nodes<N>) {
        let (a, to) = (vectors::<S>(&a.0), vectors_mut::<S>(&mut to.0));
        for i in 0..to.len() {
            to[i] = neg(self.s, a[i]);
        }
    }

    #[inline(always)]
    fn call(&self, to: &mut Nodes<N>, function: Function, a: &Nodes<N>) {
        if let Function::Abs | Function::Sign | Function::Step = function {
            elementary::call(self.s, function, &leaving(a).0, &mut to.0);
        } else {
            elementary::call(self.s, function, &a.0, &mut to.0);
        }
    }

    #[inline(always)]
    fn fused(&self, to: &mut Nodes<N>, fused: Fused, [a, b, c]: [&Nodes<N>; 3]) {
        // Not by a map of the array, which the compiler may leave a call.
        let (a, b, c) = (vectors::<S>(&a.0), vectors::<S>(&b.0), vectors::<S>(&c.0));
        let to = vectors_mut::<S>(&mut to.0);
        for i in 0..to.len() {
            to[i] = match fused {
                Fused::Add => multiply_add(self.s, a[i], b[i], c[i]),
                Fused::Subtract => multiply_add(self.s, a[i], b[i], neg(self.s, c[i])),
                Fused::SubtractFrom => multiply_add(self.s, neg(self.s, a[i]), b[i], c[i]),
            };
        }
    }

    #[inline(always)]
    fn sin_cos(&self, sin: &mut Nodes<N>, cos: &mut Nodes<N>, a: &Nodes<N>) {
        elementary::sin_cos(self.s, &a.0, [&mut sin.0, &mut cos.0]);
    }
}
