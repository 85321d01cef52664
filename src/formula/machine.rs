//! What carries out the steps of a program, and the two kinds of machine that work on plain numbers.

use super::Function;
use super::graph::Fused;
use super::program::{Program, Register};
use crate::number::Real;

/// The operations on registers, whatever a register holds. `to` is never one of the operands.
pub(crate) trait Machine {
    /// `to` = a + b.
    fn add(&mut self, to: Register, a: Register, b: Register);
    /// `to` = a − b.
    fn subtract(&mut self, to: Register, a: Register, b: Register);
    /// `to` = a b.
    fn multiply(&mut self, to: Register, a: Register, b: Register);
    /// `to` = a/b.
    fn divide(&mut self, to: Register, a: Register, b: Register);
    /// `to` = −a.
    fn negate(&mut self, to: Register, a: Register);
    /// `to` = a^b.
    fn power(&mut self, to: Register, a: Register, b: Register);
    /// `to` = f(a).
    fn call(&mut self, to: Register, function: Function, a: Register);

    /// `to` = ab + c, ab − c or c − ab, rounded once or twice. Only programs that were [`Program::fused`] have it.
    #[inline(always)]
    fn fused(&mut self, to: Register, fused: Fused, operands: [Register; 3]) {
        unreachable!("a program for other machines has {fused:?} of {operands:?} for {to}");
    }

    /// `sin` and `cos` of a.
    #[inline(always)]
    fn sin_cos(&mut self, sin: Register, cos: Register, a: Register) {
        self.call(sin, Function::Sin, a);
        self.call(cos, Function::Cos, a);
    }
}

/// The registers besides the one that is written.
pub(crate) struct Others<'r, T> {
    before: &'r [T],
    after: &'r [T],
}

/// Register `to`, writable, and all others.
#[inline(always)]
pub(crate) fn around<T>(registers: &mut [T], to: Register) -> (&mut T, Others<'_, T>) {
    let (before, rest) = registers.split_at_mut(to);
    let (out, after) = rest.split_at_mut(1);
    (&mut out[0], Others { before, after })
}

impl<'r, T> Others<'r, T> {
    /// The register of that index.
    #[inline(always)]
    pub(crate) fn at(&self, register: Register) -> &'r T {
        let place = self.before.len();
        if register < place { &self.before[register] } else { &self.after[register - place - 1] }
    }
}

/// A number in every register.
pub(super) struct Numbers<'r, S>(pub(super) &'r mut [S]);

impl<S: Real> Machine for Numbers<'_, S> {
    #[inline(always)]
    fn add(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a] + self.0[b];
    }

    #[inline(always)]
    fn subtract(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a] - self.0[b];
    }

    #[inline(always)]
    fn multiply(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a] * self.0[b];
    }

    #[inline(always)]
    fn divide(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a] / self.0[b];
    }

    #[inline(always)]
    fn negate(&mut self, to: Register, a: Register) {
        self.0[to] = -self.0[a];
    }

    #[inline(always)]
    fn power(&mut self, to: Register, a: Register, b: Register) {
        self.0[to] = self.0[a].powf(self.0[b]);
    }

    #[inline(always)]
    fn call(&mut self, to: Register, function: Function, a: Register) {
        self.0[to] = function.apply(self.0[a]);
    }

    #[inline(always)]
    fn fused(&mut self, to: Register, fused: Fused, [a, b, c]: [Register; 3]) {
        let product = self.0[a] * self.0[b];
        self.0[to] = match fused {
            Fused::Add => product + self.0[c],
            Fused::Subtract => product - self.0[c],
            Fused::SubtractFrom => self.0[c] - product,
        };
    }
}

/// Number of points that are evaluated together: enough to vectorise, and so few that all values of a formula stay in
/// the cache.
const BLOCK: usize = 64;

/// After so many points that cannot be mended no others are tried: the first of them is outside the domain already.
const MOST_LOST: usize = 16;

/// The values at a block of points in every register. Beyond the last point they are of no interest.
struct Blocks<'r, S>(&'r mut [[S; BLOCK]]);

impl<S: Real> Blocks<'_, S> {
    #[inline(always)]
    fn unary(&mut self, to: Register, a: Register, f: impl Fn(S) -> S) {
        let (out, others) = around(self.0, to);
        for (out, u) in out.iter_mut().zip(others.at(a)) {
            *out = f(*u);
        }
    }

    #[inline(always)]
    fn binary(&mut self, to: Register, a: Register, b: Register, f: impl Fn(S, S) -> S) {
        let (out, others) = around(self.0, to);
        for ((out, u), v) in out.iter_mut().zip(others.at(a)).zip(others.at(b)) {
            *out = f(*u, *v);
        }
    }
}

impl<S: Real> Machine for Blocks<'_, S> {
    fn add(&mut self, to: Register, a: Register, b: Register) {
        self.binary(to, a, b, |u, v| u + v);
    }

    fn subtract(&mut self, to: Register, a: Register, b: Register) {
        self.binary(to, a, b, |u, v| u - v);
    }

    fn multiply(&mut self, to: Register, a: Register, b: Register) {
        self.binary(to, a, b, |u, v| u * v);
    }

    fn divide(&mut self, to: Register, a: Register, b: Register) {
        self.binary(to, a, b, |u, v| u / v);
    }

    fn negate(&mut self, to: Register, a: Register) {
        self.unary(to, a, |u| -u);
    }

    fn power(&mut self, to: Register, a: Register, b: Register) {
        self.binary(to, a, b, S::powf);
    }

    fn call(&mut self, to: Register, function: Function, a: Register) {
        self.unary(to, a, |u| function.apply(u));
    }
}

/// Programs of at most this many registers keep the values of a single point on the stack.
const STACK_REGISTERS: usize = 64;

impl<S: Real> Program<S> {
    /// All outputs at one point, given by its variables.
    ///
    /// # Panics
    /// If the program has not N outputs, or another number of variables.
    pub(crate) fn values<const N: usize>(&self, variables: &[S]) -> [S; N] {
        if self.registers() <= STACK_REGISTERS {
            self.values_in(variables, &mut [S::ZERO; STACK_REGISTERS])
        } else {
            self.values_in(variables, &mut vec![S::ZERO; self.registers()])
        }
    }

    fn values_in<const N: usize>(&self, variables: &[S], registers: &mut [S]) -> [S; N] {
        self.each_constant(|register, c| registers[register] = c);
        registers[..self.variables()].copy_from_slice(variables);
        self.run(N, registers);
        std::array::from_fn(|output| registers[self.output(output)])
    }

    /// Computes the first outputs in `registers`, in which the constants and the variables are in place.
    #[inline]
    pub(crate) fn run(&self, outputs: usize, registers: &mut [S]) {
        self.run_once(outputs, registers);
        if self.is_broken(outputs, |register| registers[register]) {
            self.mend(outputs, registers, |number| number);
        }
    }

    /// The same for callers that look at the outputs themselves, and call [`Self::mend`] where one is not finite.
    #[inline]
    pub(crate) fn run_once(&self, outputs: usize, registers: &mut [S]) {
        self.walk(outputs, &mut Numbers(registers));
    }

    /// Writes the first outputs at many points into `out`, an array for each. There is an array of the points for each
    /// variable; all arrays have one length. Each step is carried out on a block of points at a time.
    pub(crate) fn sample(&self, variables: &[&[S]], out: &mut [&mut [S]]) {
        let mut registers = vec![[S::ZERO; BLOCK]; self.registers()];
        self.each_constant(|register, c| registers[register] = [c; BLOCK]);
        let points = variables[0].len();
        let mut lost = 0;
        for start in (0..points).step_by(BLOCK) {
            let end = points.min(start + BLOCK);
            for (register, variable) in registers.iter_mut().zip(variables) {
                register[..end - start].copy_from_slice(&variable[start..end]);
            }
            self.walk(out.len(), &mut Blocks(&mut registers));
            let is_finite = |row: &[S; BLOCK]| row[..end - start].iter().fold(true, |all, v| all & v.is_finite());
            if !(0..out.len()).all(|output| is_finite(&registers[self.output(output)])) {
                for k in 0..end - start {
                    let is_broken = self.is_broken(out.len(), |register| registers[register][k]);
                    if is_broken && lost < MOST_LOST && !self.mend(out.len(), &mut registers, |row| &mut row[k]) {
                        lost += 1;
                    }
                }
            }
            for (output, out) in out.iter_mut().enumerate() {
                out[start..end].copy_from_slice(&registers[self.output(output)][..end - start]);
            }
        }
    }
}
