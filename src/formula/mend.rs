//! Values that are finite although something on the way to them is not.
//!
//! Far outside, exp z overflows in 1/(1 + exp z), and the derivative of that comes out as 0 times ∞ although it is as
//! good as 0. So a point at which an output is not finite is computed once more, by the same steps in numbers whose
//! exponents reach far beyond. What is not finite there either lies outside the domain.
//!
//! A term that underflows to 0 leaves a value that is finite, and is not seen.

use std::marker::PhantomData;

use super::algebra::run;
use super::program::Program;
use super::wide::{Wide, Wides};
use crate::number::{Extended, Real};

impl<S: Real> Program<S> {
    /// Returns true if one of the first outputs is not finite, where `value` gives the number in a register.
    #[inline(always)]
    pub(super) fn is_broken(&self, outputs: usize, value: impl Fn(usize) -> S) -> bool {
        !(0..outputs).all(|output| value(self.output(output)).is_finite())
    }

    /// Replaces those of the first outputs that are not finite by what wide exponents make of them, if that is.
    /// Returns true if there are any. Of what is in a register, `number` is the one to look at.
    #[cold]
    #[inline(never)]
    pub(crate) fn mend<T>(&self, outputs: usize, registers: &mut [T], number: impl Fn(&mut T) -> &mut S) -> bool {
        let is_known = |value: &mut T| number(value).is_finite();
        let is_broken = (0..outputs).any(|output| !is_known(&mut registers[self.output(output)]));
        if !is_broken || !registers[..self.variables()].iter_mut().all(is_known) {
            return false;
        }
        let mut wide = self.registers(Wide::from);
        let variables = wide.iter_mut().zip(registers[..self.variables()].iter_mut());
        variables.for_each(|(wide, variable)| *wide = (*number(variable)).into());
        run(&Wides(PhantomData), self.steps_to(outputs), &mut wide);
        let mut is_mended = false;
        for register in (0..outputs).map(|output| self.output(output)) {
            let (value, known) = (wide[register].nearest(), number(&mut registers[register]));
            if value.is_finite() && !known.is_finite() {
                (*known, is_mended) = (value, true);
            }
        }
        is_mended
    }

    /// Does the same at so many points, in registers that hold a row of them. After `chances` points that cannot be
    /// mended no others are tried: the first of them is outside the domain already.
    pub(crate) fn mend_points<T: AsRef<[S]> + AsMut<[S]>>(
        &self,
        outputs: usize,
        points: usize,
        registers: &mut [T],
        chances: &mut usize,
    ) -> bool {
        let is_finite = |row: &T| row.as_ref()[..points].iter().fold(true, |all, value| all & value.is_finite());
        if (0..outputs).all(|output| is_finite(&registers[self.output(output)])) {
            return false;
        }
        let mut is_mended = false;
        for k in 0..points {
            if *chances == 0 {
                break;
            }
            if !self.is_broken(outputs, |register| registers[register].as_ref()[k]) {
                continue;
            }
            // Nodes of a window are repeated beyond the last one, and where it begins.
            let is_repeated = |row: &T| match row.as_ref()[..=k] {
                [.., before, here] => before == here && before.signum() == here.signum(),
                _ => false,
            };
            if registers[..self.variables()].iter().all(is_repeated) {
                for register in (0..outputs).map(|output| self.output(output)) {
                    let row = registers[register].as_mut();
                    row[k] = row[k - 1];
                }
            } else if self.mend(outputs, registers, |row| &mut row.as_mut()[k]) {
                is_mended = true;
            } else {
                *chances -= 1;
            }
        }
        is_mended
    }

    /// The same steps for extended numbers, with the constants as they are.
    pub(crate) fn extended(&self) -> Program<Extended> {
        let Self { variables, constants, steps, outputs } = self.clone();
        let constants = constants.into_iter().map(|constant| constant.to_f64().into()).collect();
        Program { variables, constants, steps, outputs }
    }
}
