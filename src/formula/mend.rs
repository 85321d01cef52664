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
    /// Replaces those of the first outputs that are not finite by what wide exponents make of them, if that is, at so
    /// many points, in registers that hold a row of them. Returns true if there are any. After `chances` points that
    /// cannot be mended no others are tried: the first of them is outside the domain already.
    #[inline]
    pub(crate) fn mend<T: AsRef<[S]> + AsMut<[S]>>(
        &self,
        outputs: usize,
        points: usize,
        registers: &mut [T],
        chances: &mut usize,
    ) -> bool {
        let is_finite = |row: &T| row.as_ref()[..points].iter().fold(true, |all, value| all & value.is_finite());
        let is_broken = (0..outputs).any(|output| !is_finite(&registers[self.output(output)]));
        is_broken && (0..points).fold(false, |is_mended, k| is_mended | self.mend_at(k, outputs, registers, chances))
    }

    /// Does the same at point `k`.
    #[cold]
    #[inline(never)]
    fn mend_at<T: AsRef<[S]> + AsMut<[S]>>(
        &self,
        k: usize,
        outputs: usize,
        registers: &mut [T],
        chances: &mut usize,
    ) -> bool {
        let wanted = || (0..outputs).map(|output| self.output(output));
        if *chances == 0 || wanted().all(|register| registers[register].as_ref()[k].is_finite()) {
            return false;
        }
        // Nodes of a window are repeated beyond the last one, and where it begins.
        let is_repeated = |row: &T| match row.as_ref()[..=k] {
            [.., before, here] => before == here && before.signum() == here.signum(),
            _ => false,
        };
        let variables = &registers[..self.variables];
        if variables.iter().all(is_repeated) {
            for register in wanted() {
                let row = registers[register].as_mut();
                row[k] = row[k - 1];
            }
            return false;
        }
        let mut is_mended = false;
        if variables.iter().all(|row| row.as_ref()[k].is_finite()) {
            let mut wide = self.registers(Wide::from);
            wide.iter_mut().zip(variables).for_each(|(wide, row)| *wide = row.as_ref()[k].into());
            run(&Wides(PhantomData), self.steps_to(outputs), &mut wide);
            for register in wanted() {
                let (value, known) = (wide[register].nearest(), &mut registers[register].as_mut()[k]);
                if value.is_finite() && !known.is_finite() {
                    (*known, is_mended) = (value, true);
                }
            }
        }
        *chances -= usize::from(!is_mended);
        is_mended
    }

    /// The same steps for extended numbers, with the constants as they are.
    pub(crate) fn extended(&self) -> Program<Extended> {
        let Self { variables, constants, steps, outputs } = self.clone();
        let constants = constants.into_iter().map(|constant| constant.to_f64().into()).collect();
        Program { variables, constants, steps, outputs }
    }
}
