//! Which operations of a program can make something steep of what changes little.
//!
//! Sums and products of what a polynomial follows are followed by a polynomial of a higher degree. Only functions and
//! quotients have scales of their own, and those show in what they are *applied to*: between two points at which the
//! argument of exp differs by one, exp changes by a factor of e and hides nothing. So a smaller program is made, of
//! arguments and divisors alone.
//!
//! A power multiplies the logarithm of what its base may change by. Programs have no powers but repeated products, so
//! that `powers` finds how often a value is a factor of what it drives.

use std::collections::HashMap;

use super::Function;
use super::operation::{Fused, Operation};
use super::powers::Powers;
use super::program::{Program, Register, Step};
use crate::number::spline::Table;

/// Largest over smallest value of a divisor between neighbouring nodes, at most. What the nodes do not see is then at
/// most so many times what they see, and they see it if their modes are small beside it. On the built-in cases with
/// smooth motion the ratio stays below. Of a power it is the power that changes by no more.
const RATIO: f64 = 8.0;

/// The exponential of less is 0.
const UNDERFLOW: f64 = -746.0;

/// The change of an argument of exp and the like, and of an angle.
const STEP: f64 = 2.0;
const ANGLE: f64 = 1.5;

/// Lower powers of what is no divisor and no exponential are not looked at. Between nodes a cosine is at most 1.37
/// times what they see of it, by the largest change of its angle, and its sixth power less than `RATIO` times.
const LOW_POWER: f64 = 6.0;

/// Between two nodes an argument leaves its values there by at most this part of its changes from them to their
/// neighbours and from one to the other. A parabola comes to half of that.
pub(crate) const BENT: f64 = 0.125;

/// The measure by which an argument must not change much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// A divisor, or what a root or a logarithm is taken of: by its ratio, and it must not contain 0.
    Ratio,
    /// The base of a high power: by how much larger it is than on the nodes.
    Base,
    /// The argument of exp: by its difference.
    Exponent,
    /// The argument of tanh and the like: by its difference.
    Step,
    /// An angle: by its difference.
    Angle,
    /// The argument of abs, sign and step: by its side of 0.
    Side(Function),
    /// The argument of asin and acos: by the ratio of its distances from ±1.
    Edge,
    /// The argument of a table: by the knots that it passes.
    Table(Table),
}

/// A value that must not change much between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Watched {
    pub(crate) register: Register,
    pub(crate) kind: Kind,
    /// The largest ratio or difference of its values that is gentle.
    most: f64,
}

impl Watched {
    /// What drives the motion contains a power of what is made of it.
    pub(crate) fn new(register: Register, kind: Kind, power: f64) -> Self {
        let most = match kind {
            Kind::Ratio | Kind::Base => RATIO.powf(1.0 / power),
            Kind::Exponent => STEP / power,
            Kind::Step => STEP,
            Kind::Angle => ANGLE,
            Kind::Edge | Kind::Side(_) | Kind::Table(_) => RATIO,
        };
        Self { register, kind, most }
    }

    /// True if a value in that interval makes nothing steep, whatever it is on the nodes.
    #[inline(always)]
    pub(crate) fn is_gentle(&self, [lo, hi]: [f64; 2]) -> bool {
        match self.kind {
            Kind::Ratio | Kind::Base => lo > 0.0 && hi <= self.most * lo || hi < 0.0 && -lo <= -self.most * hi,
            Kind::Exponent | Kind::Step | Kind::Angle => hi - lo <= self.most,
            // A step is 1 at 0, and the absolute value is the same from both sides.
            Kind::Side(Function::Step) => lo >= 0.0 || hi < 0.0,
            Kind::Side(Function::Abs) => lo >= 0.0 || hi <= 0.0,
            Kind::Side(_) => lo > 0.0 || hi < 0.0,
            // No piece is left out.
            Kind::Table(table) => table.passed([lo, hi]).is_some_and(|knots| knots <= 1),
            Kind::Edge => {
                let (near, far) = (1.0 - lo.abs().max(hi.abs()), 1.0 - lo.max(-hi).max(0.0));
                near > 0.0 && far <= self.most * near
            }
        }
    }

    /// True if there is a kink or a jump between places where the value is the least and the most of these.
    #[inline(always)]
    pub(crate) fn has_kink_between(&self, [least, most]: [f64; 2]) -> bool {
        match self.kind {
            Kind::Side(Function::Step) => least < 0.0 && most >= 0.0,
            Kind::Side(Function::Abs) => least < 0.0 && most > 0.0,
            Kind::Side(_) => least <= 0.0 && most >= 0.0 && least < most,
            _ => false,
        }
    }

    /// True if a value in that interval between two nodes, which show it at the `ends`, makes nothing steep. A power is
    /// small where its base is, and a quotient where its divisor is large, so that they hide nothing where these are
    /// hardly larger or smaller than on the nodes.
    #[inline(always)]
    pub(crate) fn is_gentle_between(&self, [lo, hi]: [f64; 2], ends: [f64; 2]) -> bool {
        let ends = ends.map(f64::abs);
        match self.kind {
            // A base that is gentle is no larger than its values on the nodes allow.
            Kind::Base => (-lo).max(hi) <= self.most * ends[0].max(ends[1]),
            Kind::Ratio => {
                let (least, most) = (lo.abs().min(hi.abs()), lo.abs().max(hi.abs()));
                let is_shown = most <= RATIO * least && ends[0].min(ends[1]) <= self.most * least;
                // An interval whose ends are gentle keeps its sign, too.
                (lo > 0.0 || hi < 0.0) && (most <= self.most * least || is_shown)
            }
            // All of it is 0.
            Kind::Exponent if hi < UNDERFLOW => true,
            _ => self.is_gentle([lo, hi]),
        }
    }
}

impl Watched {
    /// True if a value that is this on the nodes changes little from each to the next. There is room for `margins`, one
    /// for each node: by how much the value may leave its values on it and the next one between them.
    #[inline(always)]
    pub(crate) fn changes_little(&self, nodes: &[f64], values: &[f64], margins: &mut [f64]) -> bool {
        if self.kind == Kind::Base {
            bends(nodes, values, margins)
        } else {
            changes(values, margins)
        }
        let is_gentle = |k: usize| {
            let ends @ [a, b] = [values[k], values[k + 1]];
            self.is_gentle_between([a.min(b) - margins[k], a.max(b) + margins[k]], ends)
        };
        // All of them side by side are faster than one after the other until one is not.
        (0..values.len() - 1).fold(true, |all, k| all & is_gentle(k))
    }
}

/// Margins by the changes around two nodes.
#[inline(always)]
fn changes(values: &[f64], margins: &mut [f64]) {
    let count = values.len();
    let change = |k: usize| if k + 1 < count { (values[k + 1] - values[k]).abs() } else { 0.0 };
    let before = |k: usize| if k > 0 { change(k - 1) } else { 0.0 };
    (0..count).for_each(|k| margins[k] = BENT * (change(k) + (before(k) + change(k + 1))));
}

/// Margins by second derivatives: whether what is linear comes to 0 does not matter.
#[inline(always)]
fn bends(nodes: &[f64], values: &[f64], margins: &mut [f64]) {
    let count = values.len();
    let turn = |k: usize| turn([nodes[k - 1], nodes[k], nodes[k + 1]], [values[k - 1], values[k], values[k + 1]]);
    margins[0] = 0.0;
    (1..count - 1).for_each(|k| margins[k] = turn(k));
    margins[count - 1] = 0.0;
    for k in 0..count - 1 {
        let distance = nodes[k + 1] - nodes[k];
        margins[k] = 0.25 * margins[k].max(margins[k + 1]) * distance * distance;
    }
}

/// The second derivative of a value at the second of three nodes, without its sign.
#[inline(always)]
pub(crate) fn turn(nodes: [f64; 3], values: [f64; 3]) -> f64 {
    let slope = |k: usize| (values[k + 1] - values[k]) / (nodes[k + 1] - nodes[k]);
    2.0 * (slope(1) - slope(0)).abs() / (nodes[2] - nodes[0])
}

/// A program with what may become steep in it.
#[derive(Debug, Clone)]
pub(crate) struct Steep {
    /// All that drives the motion, by simpler operations.
    pub(crate) program: Program<f64>,
    /// The registers that are looked at.
    pub(crate) watched: Vec<Watched>,
    /// By the register of each value, those of them that make it steep where they are not gentle.
    pub(crate) causes: Vec<Vec<usize>>,
}

impl Steep {
    /// Looks at what the first `outputs` outputs of `program` need, where some of its variables vary; `None` if there
    /// is nothing to look at.
    pub(crate) fn new(program: &Program<f64>, outputs: usize, varies: impl Fn(usize) -> bool) -> Option<Self> {
        let program = plain(program, outputs);
        let depends = program.depends_on(varies);
        let powers = Powers::new(&program.steps, &depends);
        let watched = watched(&program.steps, &depends, &powers);
        let mut causes = vec![Vec::new(); program.size()];
        let mut blame = |value: Register, register: Register, kind: Kind| {
            causes[value].extend(watched.iter().position(|look| look.register == register && look.kind == kind));
        };
        for step in &program.steps {
            match step.operation() {
                Operation::Divide(_, b) => {
                    powers.atoms_of(b).for_each(|atom| blame(step.to(), atom, Kind::Ratio));
                }
                Operation::Call(function, a) => blame(step.to(), a, kind(function)),
                _ => {}
            }
        }
        (0..program.size()).for_each(|register| blame(register, register, Kind::Base));
        (!watched.is_empty()).then_some(Self { program, watched, causes })
    }
}

/// Divisors, arguments of functions and bases of powers in these steps that depend on variables. A register is written
/// by one step, and after those of its operands.
fn watched(steps: &[Step], depends: &[bool], powers: &Powers) -> Vec<Watched> {
    let mut watched: Vec<Watched> = Vec::new();
    let mut is_exponential = vec![false; depends.len()];
    let mut watch = |register: Register, kind: Kind, power: f64| {
        let is_known = |known: &Watched| known.register == register && known.kind == kind;
        if depends[register] && power > 0.0 {
            match watched.iter_mut().find(|known| is_known(known)) {
                // Several functions may have one argument.
                Some(known) => known.most = known.most.min(Watched::new(register, kind, power).most),
                None => watched.push(Watched::new(register, kind, power)),
            }
        }
    };
    for step in steps {
        match step.operation() {
            Operation::Power(a, _) => watch(a, Kind::Ratio, 1.0),
            // A root varies less than what it is taken of, which is looked at in its place.
            Operation::Call(Function::Sqrt, a) => watch(a, Kind::Ratio, 1.0),
            Operation::Call(function, a) => {
                is_exponential[step.to()] = function == Function::Exp;
                watch(a, kind(function), powers.of(step.to()).max(powers.of_divisor(step.to())));
            }
            _ => {}
        }
    }
    for register in (0..depends.len()).filter(|&register| !is_exponential[register]) {
        let (power, divisor) = (powers.of(register), powers.of_divisor(register));
        watch(register, Kind::Ratio, divisor);
        watch(register, Kind::Base, if power > LOW_POWER.max(divisor) { power } else { 0.0 });
    }
    watched
}

/// Returns what is to be looked at where these steps of a program were carried out, and whether that is all: the
/// divisor of a tangent and the exponent of a power have no registers.
pub(crate) fn watched_registers<'s>(steps: impl Iterator<Item = &'s Step>, depends: &[bool]) -> (Vec<Watched>, bool) {
    let mut steps: Vec<Step> = steps.copied().collect();
    steps.sort_by_key(Step::to);
    steps.dedup_by_key(|step| step.to());
    let is_plain = |step: &Step| !matches!(step.operation(), Operation::Call(Function::Tan, _) | Operation::Power(..));
    (watched(&steps, depends, &Powers::new(&steps, depends)), steps.iter().all(is_plain))
}

/// The measure by which the argument of a function must not change much.
pub(crate) fn kind(function: Function) -> Kind {
    match function {
        Function::Sqrt | Function::Ln | Function::Log10 => Kind::Ratio,
        Function::Sin | Function::Cos | Function::Tan => Kind::Angle,
        Function::Abs | Function::Sign | Function::Step => Kind::Side(function),
        Function::Asin | Function::Acos => Kind::Edge,
        Function::Exp => Kind::Exponent,
        Function::Table(table) => Kind::Table(table),
        Function::Sinh | Function::Cosh | Function::Tanh | Function::Atan => Kind::Step,
    }
}

/// The first `outputs` outputs by simpler operations: tan is sin/cos, x^y is exp(y ln x), log10 a multiple of ln, and a
/// product with a sum is both.
pub(crate) fn plain(program: &Program<f64>, outputs: usize) -> Program<f64> {
    let mut constants = program.constants.clone();
    let per_ten = program.variables + constants.len();
    constants.push(std::f64::consts::LOG10_E);
    // Operations without repetitions, each with the register of what it gives.
    let (mut operations, mut known) = (Vec::new(), HashMap::new());
    let mut value = |operation: Operation| {
        *known.entry(operation).or_insert_with(|| {
            operations.push(operation);
            per_ten + operations.len()
        })
    };
    let mut value_of: Vec<Register> = (0..program.size()).collect();
    for step in program.steps_to(outputs) {
        value_of[step.to()] = match step.operation().map(|operand| value_of[operand]) {
            Operation::Call(Function::Tan, a) => {
                let [sin, cos] = [Function::Sin, Function::Cos].map(|function| value(Operation::Call(function, a)));
                value(Operation::Divide(sin, cos))
            }
            Operation::Call(Function::Log10, a) => {
                let ln = value(Operation::Call(Function::Ln, a));
                value(Operation::Multiply(ln, per_ten))
            }
            Operation::Power(a, b) => {
                let ln = value(Operation::Call(Function::Ln, a));
                let exponent = value(Operation::Multiply(b, ln));
                value(Operation::Call(Function::Exp, exponent))
            }
            Operation::Fused(fused, [a, b, c]) => {
                let product = value(Operation::Multiply(a, b));
                value(match fused {
                    Fused::Add => Operation::Add(product, c),
                    Fused::Subtract => Operation::Subtract(product, c),
                    Fused::SubtractFrom => Operation::Subtract(c, product),
                })
            }
            operation => value(operation),
        };
    }
    let outputs = (0..outputs).map(|output| value_of[program.output(output)]);
    Program::of_operations(program.variables, constants, operations, outputs)
}
