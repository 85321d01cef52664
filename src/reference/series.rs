//! Taylor arithmetic on a program: the coefficients of its outputs from those of its variables, all series in s.
//!
//! Coefficient k of a value needs only the coefficients 0 … k of its operands. Therefore a solution can be extended one
//! coefficient at a time, while the right-hand side of its equation is computed from the known ones (automatic
//! differentiation of ODEs, e.g. Jorba & Zou, Exp. Math. 14 (2005) 99–117). The rule for each function follows from its
//! differential equation. For example, f = exp u gives f′ = f u′ and hence k f_k = Σ_j j u_j f_{k−j}.

use std::marker::PhantomData;

use crate::formula::{Algebra, Function, Fused, Kind, Operation, Program, Register, Step, kind, run};
use crate::number::{Extended, Real, sum};

/// The series of a value, with room for all coefficients. Those that are not known yet are of no interest.
#[derive(Debug, Clone)]
struct Taylor<S> {
    coefficients: Vec<S>,
    /// A second series that some functions need, for example the cosine for a sine, or 1 + u² for an arc tangent.
    partner: Vec<S>,
}

impl<S: Real> Taylor<S> {
    fn constant(value: S, order: usize) -> Self {
        let zeros = vec![S::ZERO; order];
        let mut coefficients = zeros.clone();
        coefficients[0] = value;
        Self { coefficients, partner: zeros }
    }
}

/// The series of every value of a program, extended coefficient by coefficient.
#[derive(Debug)]
pub(super) struct ProgramSeries<S> {
    program: Program<S>,
    /// The registers of the outputs, and the steps that compute these.
    outputs: Vec<Register>,
    steps: Box<[Step]>,
    registers: Vec<Taylor<S>>,
    /// So many coefficients are known of the variables, and of the outputs.
    known: usize,
    /// The same in extended numbers, for coefficients of outputs that are finite although something on the way to them
    /// overflows.
    far: Option<Box<ProgramSeries<Extended>>>,
}

impl<S: Real> ProgramSeries<S> {
    /// The series of some registers, the outputs, with so many coefficients at most.
    pub(super) fn new(program: &Program<S>, outputs: Vec<Register>, order: usize) -> Self {
        let registers = program.registers(|constant| Taylor::constant(constant, order));
        let steps = program.schedule(outputs.iter().copied(), |_| false);
        Self { program: program.clone(), outputs, steps, registers, known: 0, far: None }
    }

    /// Forgets all coefficients.
    pub(super) fn restart(&mut self) {
        self.known = 0;
        self.far.iter_mut().for_each(|far| far.restart());
    }

    /// Appends coefficient k of every value, from those of the variables, which are given by index. The coefficients
    /// before it are known.
    pub(super) fn extend(&mut self, k: usize, variables: impl Iterator<Item = (usize, S)>) {
        variables.for_each(|(variable, c)| self.registers[variable].coefficients[k] = c);
        run(&Coefficient { k, numbers: PhantomData }, &self.steps, &mut self.registers);
        self.known = k + 1;
        if !S::IS_EXTENDED && !(0..self.outputs.len()).all(|output| self.output(output)[k].is_finite()) {
            self.mend();
        }
    }

    /// Takes those of the last coefficients of outputs that are not finite from extended numbers, see
    /// [`Program::mend`].
    #[cold]
    fn mend(&mut self) {
        let Self { program, outputs, registers, known, far, .. } = self;
        let order = registers[0].coefficients.len();
        let far = far.get_or_insert_with(|| Box::new(ProgramSeries::new(&program.extended(), outputs.clone(), order)));
        for j in far.known..*known {
            let variables = registers[..program.variables].iter().enumerate();
            far.extend(j, variables.map(|(variable, series)| (variable, series.coefficients[j].to_f64().into())));
        }
        for (output, &register) in outputs.iter().enumerate() {
            let last = &mut registers[register].coefficients[*known - 1];
            if !last.is_finite() {
                *last = S::from(far.output(output)[*known - 1].to_f64());
            }
        }
    }

    /// The series of an output, as far as it is known.
    pub(super) fn output(&self, output: usize) -> &[S] {
        self.known_of(self.outputs[output])
    }

    fn known_of(&self, register: usize) -> &[S] {
        &self.registers[register].coefficients[..self.known]
    }

    /// The series of the arguments of `abs`, `sign` and `step` with 0, and those of tables with the knots beside them.
    /// Where one passes this value, the series around this point are no longer valid.
    pub(super) fn kink_arguments(&self) -> impl Iterator<Item = (&[S], S)> {
        let arguments = self.steps.iter().filter_map(|step| match step.operation() {
            Operation::Call(function, a) if matches!(kind(function), Kind::Side(_)) => Some((a, None)),
            Operation::Call(Function::Table(table), a) => Some((a, Some(table))),
            _ => None,
        });
        arguments.flat_map(|(a, table)| {
            let series = self.known_of(a);
            let knots = table.map(|table| table.neighbours(series[0]));
            let zero = table.is_none().then_some(S::ZERO);
            knots.into_iter().flatten().chain(zero).map(move |at| (series, at))
        })
    }
}

/// Σ_{j≥1} c_j s^j, the polynomial without c_0. It is small, and is added to c_0 at the end to lose less to rounding.
pub(super) fn increment<S: Real>(c: &[S], s: S) -> S {
    c[1..].iter().rev().fold(S::ZERO, |sum, &c| (sum + c) * s)
}

/// The derivative dc/ds of the polynomial.
pub(super) fn slope<S: Real>(c: &[S], s: S) -> S {
    c.iter().enumerate().skip(1).rev().fold(S::ZERO, |sum, (j, &c)| sum * s + S::from(j as f64) * c)
}

/// Makes coefficient k of one value after the other.
struct Coefficient<S> {
    k: usize,
    numbers: PhantomData<S>,
}

impl<S: Real> Algebra for Coefficient<S> {
    type Value = Taylor<S>;

    fn add(&self, to: &mut Taylor<S>, a: &Taylor<S>, b: &Taylor<S>) {
        to.coefficients[self.k] = a.coefficients[self.k] + b.coefficients[self.k];
    }

    fn subtract(&self, to: &mut Taylor<S>, a: &Taylor<S>, b: &Taylor<S>) {
        to.coefficients[self.k] = a.coefficients[self.k] - b.coefficients[self.k];
    }

    fn multiply(&self, to: &mut Taylor<S>, a: &Taylor<S>, b: &Taylor<S>) {
        to.coefficients[self.k] = product(&a.coefficients, &b.coefficients, self.k);
    }

    fn divide(&self, to: &mut Taylor<S>, a: &Taylor<S>, b: &Taylor<S>) {
        to.coefficients[self.k] = quotient(&a.coefficients, &b.coefficients, &to.coefficients, self.k);
    }

    fn negate(&self, to: &mut Taylor<S>, a: &Taylor<S>) {
        to.coefficients[self.k] = -a.coefficients[self.k];
    }

    fn power(&self, to: &mut Taylor<S>, a: &Taylor<S>, b: &Taylor<S>) {
        let Taylor { coefficients, partner } = to;
        coefficients[self.k] = power(&a.coefficients, &b.coefficients, coefficients, partner, self.k);
    }

    fn fused(&self, to: &mut Taylor<S>, fused: Fused, [a, b, c]: [&Taylor<S>; 3]) {
        let (product, c) = (product(&a.coefficients, &b.coefficients, self.k), c.coefficients[self.k]);
        to.coefficients[self.k] = match fused {
            Fused::Add => product + c,
            Fused::Subtract => product - c,
            Fused::SubtractFrom => c - product,
        };
    }

    fn call(&self, to: &mut Taylor<S>, function: Function, a: &Taylor<S>) {
        let Taylor { coefficients, partner } = to;
        coefficients[self.k] = call(function, &a.coefficients, coefficients, partner, self.k);
    }
}

/// (u v)_k.
fn product<S: Real>(u: &[S], v: &[S], k: usize) -> S {
    sum((0..=k).map(|j| u[j] * v[k - j]))
}

/// Σ_{j=1}^{k−1} j u_j v_{k−j}, which occurs in most rules.
fn weighted<S: Real>(u: &[S], v: &[S], k: usize) -> S {
    sum((1..k).map(|j| number::<S>(j) * u[j] * v[k - j]))
}

fn number<S: Real>(k: usize) -> S {
    S::from(k as f64)
}

/// (u/v)_k from the earlier coefficients of the quotient.
fn quotient<S: Real>(u: &[S], v: &[S], earlier: &[S], k: usize) -> S {
    let known = sum((1..=k).map(|j| v[j] * earlier[k - j]));
    (u[k] - known) / v[0]
}

/// (√u)_k for k > 0.
fn square_root<S: Real>(u_k: S, earlier: &[S], k: usize) -> S {
    let known = sum((1..k).map(|j| earlier[j] * earlier[k - j]));
    (u_k - known) / (earlier[0] + earlier[0])
}

/// y_k for y′ = u′/q, from k q_0 y_k = k u_k − Σ j y_j q_{k−j}.
fn from_derivative<S: Real>(u: &[S], q: &[S], y: &[S], k: usize) -> S {
    (u[k] - weighted(y, q, k) / number(k)) / q[0]
}

/// f_k for f′ = g u′, from k f_k = Σ_{j=1}^{k} j u_j g_{k−j}.
fn chain<S: Real>(u: &[S], g: &[S], k: usize) -> S {
    (weighted(u, g, k) + number::<S>(k) * u[k] * g[0]) / number(k)
}

/// (u^v)_k. For a constant exponent α the rule is k u_0 p_k = Σ ((α+1) j − k) u_j p_{k−j}; for any other it is that of
/// exp(v ln u).
fn power<S: Real>(u: &[S], v: &[S], earlier: &[S], logarithm: &mut [S], k: usize) -> S {
    if k == 0 {
        logarithm[0] = u[0].ln();
        return u[0].powf(v[0]);
    }
    logarithm[k] = from_derivative(u, u, logarithm, k);
    if v[1..=k].iter().all(|&c| c == S::ZERO) {
        let next = v[0] + S::ONE;
        let terms = (1..=k).map(|j| (next * number(j) - number(k)) * u[j] * earlier[k - j]);
        return sum(terms) / (number::<S>(k) * u[0]);
    }
    // The rule of exp e with e = v ln u, whose coefficients are formed as needed.
    let exponent = |j: usize| product(v, logarithm, j);
    sum((1..=k).map(|j| number::<S>(j) * exponent(j) * earlier[k - j])) / number(k)
}

/// y_k for y = Σ cⱼ wʲ with w = u − u₀, the partner of which is w².
fn composed<S: Real>(c: &[S; 6], u: &[S], partner: &mut [S], k: usize) -> S {
    if k == 0 {
        partner[0] = S::ZERO;
        return c[0];
    }
    partner[k] = sum((1..k).map(|j| u[j] * u[k - j]));
    let cube = sum((1..k).map(|j| u[j] * partner[k - j]));
    let cubic = c[1] * u[k] + c[2] * partner[k] + c[3] * cube;
    if c[4] == S::ZERO && c[5] == S::ZERO {
        return cubic;
    }
    let fourth = |k: usize| sum((1..k).map(|j| partner[j] * partner[k - j]));
    cubic + c[4] * fourth(k) + c[5] * sum((1..k).map(|j| u[j] * fourth(k - j)))
}

/// f(u)_k. Also makes coefficient k of the partner series of the function.
fn call<S: Real>(function: Function, u: &[S], y: &[S], partner: &mut [S], k: usize) -> S {
    if let Function::Table(table) = function {
        return composed(&table.expansion(u[0]), u, partner, k);
    }
    if k == 0 {
        let (u, value) = (u[0], function.apply(u[0]));
        partner[0] = match function {
            Function::Sin => u.cos(),
            Function::Cos => u.sin(),
            Function::Sinh => u.cosh(),
            Function::Cosh => u.sinh(),
            Function::Tan => S::ONE + value * value,
            Function::Tanh => S::ONE - value * value,
            Function::Asin | Function::Acos => (S::ONE - u * u).sqrt(),
            Function::Atan => S::ONE + u * u,
            _ => u.signum(),
        };
        return value;
    }
    match function {
        Function::Sin | Function::Cos | Function::Sinh | Function::Cosh => {
            let (value, other) = (chain(u, partner, k), chain(u, y, k));
            // sin′ = cos, cos′ = −sin, and both hyperbolic derivatives are positive.
            partner[k] = if function == Function::Sin { -other } else { other };
            if function == Function::Cos { -value } else { value }
        }
        Function::Tan | Function::Tanh => {
            // y′ = (1 ± y²) u′ with the partner 1 ± y².
            let value = chain(u, partner, k);
            let square = sum((1..k).map(|j| y[j] * y[k - j])) + (y[0] + y[0]) * value;
            partner[k] = if function == Function::Tan { square } else { -square };
            value
        }
        Function::Asin | Function::Acos => {
            // y′ = ±u′/r with the partner r = √(1 − u²).
            partner[k] = square_root(-product(u, u, k), partner, k);
            let slope = if function == Function::Asin { u[k] } else { -u[k] };
            (slope - weighted(y, partner, k) / number(k)) / partner[0]
        }
        Function::Atan => {
            partner[k] = product(u, u, k);
            from_derivative(u, partner, y, k)
        }
        Function::Exp => chain(u, y, k),
        Function::Ln => from_derivative(u, u, y, k),
        Function::Log10 => (u[k] / S::LN_10 - weighted(y, u, k) / number(k)) / u[0],
        Function::Sqrt => square_root(u[k], y, k),
        Function::Abs => partner[0] * u[k],
        Function::Sign | Function::Step => S::ZERO,
        Function::Table(_) => unreachable!("its value is composed"),
    }
}
