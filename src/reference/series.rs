//! Taylor arithmetic on a program: the coefficients of its outputs from those of its variables, all series in s.
//!
//! Coefficient k of a value needs only the coefficients 0 … k of its operands. Therefore a solution can be extended one
//! coefficient at a time, while the right-hand side of its equation is computed from the known ones (automatic
//! differentiation of ODEs, e.g. Jorba & Zou, Exp. Math. 14 (2005) 99–117). The rule for each function follows from its
//! differential equation. For example, f = exp u gives f′ = f u′ and hence k f_k = Σ_j j u_j f_{k−j}.

use crate::formula::{Function, Machine, Operation, Program, Register};
use crate::number::{Extended, Real, sum};

/// The series of every value of a program, extended coefficient by coefficient.
#[derive(Debug)]
pub(super) struct SeriesMachine<S> {
    /// With a register for every value.
    program: Program<S>,
    /// Number of outputs that are computed.
    outputs: usize,
    /// Coefficients of each value.
    values: Vec<Vec<S>>,
    /// A second series that some functions need, for example the cosine for a sine, or 1 + u² for an arc tangent.
    partners: Vec<Vec<S>>,
    /// The same in extended numbers, for coefficients of outputs that are finite although something on the way to them
    /// overflows; and how many of its coefficients are known.
    far: Option<Box<SeriesMachine<Extended>>>,
    known: usize,
}

impl<S: Real> SeriesMachine<S> {
    /// Of the first `outputs` outputs, with room for series of the given `order`.
    pub(super) fn new(program: &Program<S>, outputs: usize, order: usize) -> Self {
        let series = || vec![Vec::with_capacity(order + 1); program.registers()];
        let (values, partners) = (series(), series());
        Self { program: program.clone(), outputs, values, partners, far: None, known: 0 }
    }

    /// Forgets all coefficients.
    pub(super) fn restart(&mut self) {
        self.values.iter_mut().chain(&mut self.partners).for_each(Vec::clear);
        self.known = 0;
        self.far.iter_mut().for_each(|far| far.restart());
    }

    /// Appends coefficient k of every value, from those of the variables, which are given by index. The coefficients
    /// before it are known.
    pub(super) fn extend(&mut self, k: usize, variables: impl Iterator<Item = (usize, S)>) {
        let Self { program, outputs, values, partners, .. } = self;
        program.each_constant(|register, c| values[register].push(if k == 0 { c } else { S::ZERO }));
        variables.for_each(|(variable, c)| values[variable].push(c));
        program.walk(*outputs, &mut Coefficient { values, partners, k });
        self.known = k + 1;
        if !S::IS_EXTENDED && !(0..self.outputs).all(|output| self.output(output)[k].is_finite()) {
            self.mend();
        }
    }

    /// Takes those of the last coefficients of outputs that are not finite from extended numbers, see
    /// [`Program::mend_nodes`].
    #[cold]
    fn mend(&mut self) {
        let Self { program, outputs, values, far, known, .. } = self;
        let order = values[0].capacity();
        let far = far.get_or_insert_with(|| Box::new(SeriesMachine::new(&program.extended(), *outputs, order)));
        while far.known < *known {
            let (variables, j) = (values[..program.variables()].iter().enumerate(), far.known);
            // Some variables are not used and have no series.
            let variables = variables.filter_map(|(variable, series)| Some((variable, series.get(j)?.to_f64().into())));
            far.extend(j, variables);
        }
        for output in 0..*outputs {
            let last = &mut values[program.output(output)][*known - 1];
            if !last.is_finite() {
                *last = S::from(far.output(output)[*known - 1].to_f64());
            }
        }
    }

    /// The series of an output, as far as it is known.
    pub(super) fn output(&self, output: usize) -> &[S] {
        &self.values[self.program.output(output)]
    }

    /// The series of every argument of `abs` and of its derivative. Where one changes its sign, the series around this
    /// point are no longer valid.
    pub(super) fn kink_arguments(&self) -> impl Iterator<Item = &[S]> {
        let of = |function| {
            self.program.operations(self.outputs).filter_map(move |(_, operation)| match operation {
                Operation::Call(other, a) if other == function => Some(a),
                _ => None,
            })
        };
        let signs_alone = of(Function::Sign).filter(move |a| !of(Function::Abs).any(|other| other == *a));
        of(Function::Abs).chain(signs_alone).map(|a| self.values[a].as_slice())
    }
}

/// Appends coefficient k of one value after the other.
struct Coefficient<'r, S> {
    values: &'r mut [Vec<S>],
    partners: &'r mut [Vec<S>],
    k: usize,
}

impl<S: Real> Machine for Coefficient<'_, S> {
    fn add(&mut self, to: Register, a: Register, b: Register) {
        let next = self.values[a][self.k] + self.values[b][self.k];
        self.values[to].push(next);
    }

    fn subtract(&mut self, to: Register, a: Register, b: Register) {
        let next = self.values[a][self.k] - self.values[b][self.k];
        self.values[to].push(next);
    }

    fn multiply(&mut self, to: Register, a: Register, b: Register) {
        let next = product(&self.values[a], &self.values[b], self.k);
        self.values[to].push(next);
    }

    fn divide(&mut self, to: Register, a: Register, b: Register) {
        let next = quotient(&self.values[a], &self.values[b], &self.values[to], self.k);
        self.values[to].push(next);
    }

    fn negate(&mut self, to: Register, a: Register) {
        let next = -self.values[a][self.k];
        self.values[to].push(next);
    }

    fn power(&mut self, to: Register, a: Register, b: Register) {
        let next = power(&self.values[a], &self.values[b], &self.values[to], &mut self.partners[to], self.k);
        self.values[to].push(next);
    }

    fn call(&mut self, to: Register, function: Function, a: Register) {
        let next = call(function, &self.values[a], &self.values[to], &mut self.partners[to], self.k);
        self.values[to].push(next);
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

/// (√u)_k.
fn square_root<S: Real>(u_k: S, earlier: &[S], k: usize) -> S {
    if k == 0 {
        return u_k.sqrt();
    }
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
fn power<S: Real>(u: &[S], v: &[S], earlier: &[S], logarithm: &mut Vec<S>, k: usize) -> S {
    if k == 0 {
        logarithm.push(u[0].ln());
        return u[0].powf(v[0]);
    }
    let next = from_derivative(u, u, logarithm, k);
    logarithm.push(next);
    if v[1..=k].iter().all(|&c| c == S::ZERO) {
        let next = v[0] + S::ONE;
        let terms = (1..=k).map(|j| (next * number(j) - number(k)) * u[j] * earlier[k - j]);
        return sum(terms) / (number::<S>(k) * u[0]);
    }
    // The rule of exp e with e = v ln u, whose coefficients are formed as needed.
    let exponent = |j: usize| product(v, logarithm, j);
    sum((1..=k).map(|j| number::<S>(j) * exponent(j) * earlier[k - j])) / number(k)
}

/// Coefficient `k` of sin, cos, sinh or cosh, with its counterpart as `partner`.
fn circular<S: Real>(function: Function, u: &[S], y: &[S], partner: &mut Vec<S>, k: usize) -> S {
    if k == 0 {
        let (value, other) = match function {
            Function::Sin => (u[0].sin(), u[0].cos()),
            Function::Cos => (u[0].cos(), u[0].sin()),
            Function::Sinh => (u[0].sinh(), u[0].cosh()),
            _ => (u[0].cosh(), u[0].sinh()),
        };
        partner.push(other);
        return value;
    }
    let (value, other) = (chain(u, partner, k), chain(u, y, k));
    // sin′ = cos, cos′ = −sin, and both hyperbolic derivatives are positive.
    partner.push(if function == Function::Sin { -other } else { other });
    if function == Function::Cos { -value } else { value }
}

/// f(u)_k. Also appends coefficient k to the partner series of the function.
fn call<S: Real>(function: Function, u: &[S], y: &[S], partner: &mut Vec<S>, k: usize) -> S {
    let unit = if k == 0 { S::ONE } else { S::ZERO };
    match function {
        Function::Sin | Function::Cos | Function::Sinh | Function::Cosh => circular(function, u, y, partner, k),
        Function::Tan | Function::Tanh => {
            // y′ = (1 ± y²) u′ with the partner 1 ± y².
            let value = if k == 0 { function.apply(u[0]) } else { chain(u, partner, k) };
            let known = sum((1..k).map(|j| y[j] * y[k - j]));
            let square = if k == 0 { value * value } else { known + (y[0] + y[0]) * value };
            partner.push(if function == Function::Tan { unit + square } else { unit - square });
            value
        }
        Function::Asin | Function::Acos => {
            // y′ = ±u′/r with the partner r = √(1 − u²).
            let next = square_root(unit - product(u, u, k), partner, k);
            partner.push(next);
            if k == 0 {
                return function.apply(u[0]);
            }
            let slope = if function == Function::Asin { u[k] } else { -u[k] };
            (slope - weighted(y, partner, k) / number(k)) / partner[0]
        }
        Function::Atan => {
            partner.push(unit + product(u, u, k));
            if k == 0 { u[0].atan() } else { from_derivative(u, partner, y, k) }
        }
        Function::Exp => match k {
            0 => u[0].exp(),
            _ => chain(u, y, k),
        },
        Function::Ln => match k {
            0 => u[0].ln(),
            _ => from_derivative(u, u, y, k),
        },
        Function::Log10 => match k {
            0 => u[0].log10(),
            _ => (u[k] / S::LN_10 - weighted(y, u, k) / number(k)) / u[0],
        },
        Function::Sqrt => square_root(u[k], y, k),
        Function::Abs | Function::Sign => {
            if k == 0 {
                partner.push(u[0].signum());
                return function.apply(u[0]);
            }
            if function == Function::Abs { partner[0] * u[k] } else { S::ZERO }
        }
    }
}
