//! How often the values of a program are factors of what they drive.
//!
//! Programs have no powers but repeated products. So every value is written as a product of powers of *atoms*, of what
//! is no product itself, and the exponents multiply along every chain: in ((g² + c)² + c)², g counts eight times. That
//! is the factor by which the logarithm of the result changes more than that of the atom, where all terms of sums have
//! one sign.

use super::Function;
use super::operation::Operation;
use super::program::{Register, Step};

/// A product of powers of atoms.
type Product = Vec<(Register, f64)>;

/// The largest powers of the values of a program.
pub(super) struct Powers {
    /// Of each register, the largest power of it in anything it drives.
    powers: Vec<f64>,
    /// The largest power of it as a divisor, or 0.
    divisors: Vec<f64>,
    /// Every value as a product of powers of atoms; an atom is that of itself.
    products: Vec<Product>,
}

impl Powers {
    /// Of steps that are sorted by the registers that they write; those that do not depend on variables are numbers.
    pub(super) fn new(steps: &[Step], depends: &[bool]) -> Self {
        let mut products: Vec<Product> = depends
            .iter()
            .enumerate()
            .map(|(atom, &depends)| if depends { vec![(atom, 1.0)] } else { vec![] })
            .collect();
        for step in steps.iter().filter(|step| depends[step.to()]) {
            let of = |register: Register| products[register].as_slice();
            let product = match step.operation() {
                Operation::Multiply(a, b) => merged(of(a), of(b), 1.0),
                Operation::Divide(a, b) => merged(of(a), of(b), -1.0),
                Operation::Negate(a) => of(a).to_vec(),
                Operation::Call(Function::Sqrt, a) => of(a).iter().map(|&(atom, power)| (atom, 0.5 * power)).collect(),
                _ => continue,
            };
            products[step.to()] = product;
        }
        let mut found = Self { powers: vec![1.0; depends.len()], divisors: vec![0.0; depends.len()], products };
        for step in steps.iter().rev().filter(|step| depends[step.to()]) {
            let power = found.powers[step.to()];
            match step.operation() {
                Operation::Add(a, b) | Operation::Subtract(a, b) => {
                    [a, b].into_iter().for_each(|term| found.raise(&[(term, 1.0)], power));
                }
                Operation::Fused(_, [a, b, c]) => {
                    found.raise(&merged(&found.products[a], &found.products[b], 1.0), power);
                    found.raise(&[(c, 1.0)], power);
                }
                Operation::Call(function, _) if function != Function::Sqrt => {}
                Operation::Power(..) => {}
                _ => found.raise(&found.products[step.to()].clone(), power),
            }
        }
        found
    }

    /// The largest power of an atom in anything that it drives, 0 of a product.
    pub(super) fn of(&self, register: Register) -> f64 {
        if self.products[register][..] == [(register, 1.0)] { self.powers[register] } else { 0.0 }
    }

    /// What a value is a product of.
    pub(super) fn atoms_of(&self, register: Register) -> impl Iterator<Item = Register> {
        self.products[register].iter().map(|&(atom, _)| atom)
    }

    /// The largest power of a value as a divisor, 0 where it is none.
    pub(super) fn of_divisor(&self, register: Register) -> f64 {
        self.divisors[register]
    }

    /// There is this power of a product.
    fn raise(&mut self, product: &[(Register, f64)], power: f64) {
        for &(atom, exponent) in product {
            let new = exponent.abs() * power;
            self.powers[atom] = self.powers[atom].max(new);
            if exponent < 0.0 {
                self.divisors[atom] = self.divisors[atom].max(new);
            }
        }
    }
}

/// The product of one with a power of another.
fn merged(one: &[(Register, f64)], other: &[(Register, f64)], power: f64) -> Product {
    let mut product = one.to_vec();
    for &(atom, exponent) in other {
        match product.iter_mut().find(|(known, _)| *known == atom) {
            Some((_, sum)) => *sum += power * exponent,
            None => product.push((atom, power * exponent)),
        }
    }
    product.retain(|&(_, exponent)| exponent != 0.0);
    product
}
