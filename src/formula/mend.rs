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

#[cfg(test)]
mod tests {
    use super::super::{Graph, Names, Program, parse};
    use crate::number::{Extended, Real};

    /// f, f′ and f″ at x, at a point alone and among others.
    fn values<S: Real>(formula: &str, x: f64) -> [S; 3] {
        let mut graph = Graph::default();
        let f = parse(formula, &["x"], &Names::new(), &mut graph).unwrap();
        let first = graph.derivative(f, 0);
        let second = graph.derivative(first, 0);
        let program = Program::new(&mut graph, 1, &[f, first, second]);
        let x = S::from(x);
        let alone = program.values(&[x]);
        let fused: [S; 3] = program.fused().values(&[x]);
        let points = vec![x; 100];
        let mut rows = [(); 3].map(|()| vec![S::ZERO; 100]);
        program.sample(&[&points], &mut rows.each_mut().map(Vec::as_mut_slice));
        for ((row, value), fused) in rows.iter().zip(&alone).zip(fused) {
            let is_near = (fused - *value).abs() <= S::from(1e-9) * (S::ONE + value.abs());
            assert!(is_near || !fused.is_finite(), "{formula} at {x:?}: {fused:?}, {value:?}");
            let is_close = |a: S| a == *value || a.is_nan() && value.is_nan();
            assert!(row.iter().all(|&a| is_close(a)), "{formula} at {x:?}: {row:?}, {value:?}");
        }
        alone
    }

    fn check<S: Real>(formula: &str, x: f64, expected: [f64; 3]) {
        let found = values::<S>(formula, x).map(S::to_f64);
        let is_close = |(found, expected): (&f64, &f64)| (found - expected).abs() <= 1e-8 * expected.abs().max(1.0);
        assert!(found.iter().zip(&expected).all(is_close), "{formula} at {x}: {found:?}, {expected:?}");
    }

    #[test]
    fn an_overflow_on_the_way_to_finite_values_is_none() {
        type Expected = fn(f64) -> [f64; 3];
        let kinds: [(&str, Expected); 10] = [
            ("1/(1 + exp(x))", |_| [0.0; 3]),
            ("exp(x)/(1 + exp(x))", |_| [1.0, 0.0, 0.0]),
            ("(exp(x) - exp(-x))/(exp(x) + exp(-x))", |_| [1.0, 0.0, 0.0]),
            ("ln(1 + exp(x))", |x| [x, 1.0, 0.0]),
            ("log10(1 + exp(x))", |x| [x / std::f64::consts::LN_10, 1.0 / std::f64::consts::LN_10, 0.0]),
            ("1/cosh(x)^2", |_| [0.0; 3]),
            ("sinh(x)/cosh(x)", |_| [1.0, 0.0, 0.0]),
            ("x*exp(-x^2)", |_| [0.0; 3]),
            ("sqrt(4 + exp(2*x))*exp(-x)", |_| [1.0, 0.0, 0.0]),
            ("(1 + exp(x))^2*exp(-2*x)", |_| [1.0, 0.0, 0.0]),
        ];
        for (formula, expected) in kinds {
            for x in [360.0, 705.0, 709.5, 712.0, 1e4, 1e6] {
                check::<f64>(formula, x, expected(x));
                check::<Extended>(formula, x, expected(x));
            }
        }
        for x in [6.0, 6.6, 8.0, 20.0] {
            check::<f64>("exp(-exp(x))", x, [0.0; 3]);
            check::<Extended>("exp(-exp(x))", x, [0.0; 3]);
        }
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        for (formula, x) in
            [("exp(x)", 1e4), ("ln(-x)", 2.0), ("1/(x - 2)", 2.0), ("(1 + exp(exp(x)))/exp(exp(x))", 1e3)]
        {
            assert!(!values::<f64>(formula, x)[0].is_finite(), "{formula}");
        }
        assert!(values::<f64>("x", f64::NAN)[0].is_nan());
    }
}
