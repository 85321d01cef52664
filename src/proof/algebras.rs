//! Balls and discs in rows of 32, as the algebras that programs are run in.

use std::cell::Cell;
use std::fmt;

use pulp::{Simd, WithSimd};

use crate::formula::{Algebra, Function, Fused};
use crate::number::ball::{Ball, Disc};
use crate::number::vector::Level;

/// Nodes of a window, and discs on its ellipse: registers have so many values.
pub(super) const LANES: usize = 32;

/// A number for each node.
pub(super) type Row = [f64; LANES];

/// A ball for each node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Balls {
    pub(super) hi: Row,
    pub(super) lo: Row,
    pub(super) rad: Row,
}

impl Balls {
    /// The same ball for all nodes.
    pub(super) fn of(ball: Ball) -> Self {
        Self { hi: [ball.hi; LANES], lo: [ball.lo; LANES], rad: [ball.rad; LANES] }
    }

    #[inline(always)]
    pub(super) fn at(&self, k: usize) -> Ball {
        Ball { hi: self.hi[k], lo: self.lo[k], rad: self.rad[k] }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, k: usize, ball: Ball) {
        (self.hi[k], self.lo[k], self.rad[k]) = (ball.hi, ball.lo, ball.rad);
    }
}

/// A disc for each place on the ellipse.
#[derive(Debug, Clone, Copy)]
pub(super) struct Discs {
    pub(super) re: Row,
    pub(super) im: Row,
    pub(super) rad: Row,
}

impl Discs {
    /// The same disc everywhere.
    pub(super) fn of(disc: Disc) -> Self {
        Self { re: [disc.re; LANES], im: [disc.im; LANES], rad: [disc.rad; LANES] }
    }

    #[inline(always)]
    pub(super) fn at(&self, k: usize) -> Disc {
        Disc { re: self.re[k], im: self.im[k], rad: self.rad[k] }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, k: usize, disc: Disc) {
        (self.re[k], self.im[k], self.rad[k]) = (disc.re, disc.im, disc.rad);
    }

    /// The side of the imaginary axis on which all discs are: 1, −1, or 0 if there is none.
    #[inline(always)]
    pub(super) fn side(&self) -> f64 {
        let first = self.at(0).side();
        if (1..LANES).all(|k| self.at(k).side() == first) { first } else { 0.0 }
    }

    /// The largest of a bound of each; NaN if one is.
    #[inline(always)]
    pub(super) fn largest(&self, bound: impl Fn(Disc) -> f64) -> f64 {
        (0..LANES).map(|k| bound(self.at(k))).fold(0.0, crate::number::norm::larger)
    }
}

/// What formulas do where they are not analytic, or may not be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obstacle {
    /// A function is not analytic where its argument is 0.
    Function(Function),
    /// A divisor may be 0.
    Divisor,
    /// The base of a power may be 0.
    Base,
    /// Something depends on a coordinate along which there is no force.
    Hidden,
    /// A table has no points there.
    OffTable,
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name =
            |function: &Function| Function::NAMED.iter().find(|(_, named)| named == function).map(|named| named.0);
        match self {
            Self::Function(Function::Abs) => f.write_str("a kink of abs"),
            // The derivative of abs is sign.
            Self::Function(Function::Sign) => f.write_str("a kink of abs or a jump of sign"),
            Self::Function(Function::Step) => f.write_str("a jump of step"),
            Self::Function(Function::Table(_)) => f.write_str("a table, which is not one analytic function"),
            Self::Function(function) => write!(f, "the edge of {}", name(function).unwrap_or_default()),
            Self::Divisor => f.write_str("a divisor that may be 0"),
            Self::Base => f.write_str("a power whose base may be 0"),
            Self::OffTable => f.write_str("the end of a table"),
            Self::Hidden => f.write_str("a jump along a coordinate without a force"),
        }
    }
}

/// Work that is done lane by lane. A bare closure would be compiled for any machine, with a call for each fused
/// multiplication.
struct ByLane<F>(F);

impl<F: FnMut(usize)> WithSimd for ByLane<F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        (0..LANES).for_each(|k| (self.0)(k));
    }
}

/// The algebra of balls.
pub(super) struct InBalls;

/// The algebra of discs that cover the boundary of a region, in which all registers are to be analytic.
///
/// A divisor, and an argument of sqrt, ln, abs, sign and step, must have a real part of one sign on all discs. That is
/// a harmonic function of the place, so it has this sign within the region, too, and no zero there.
#[derive(Default)]
pub(super) struct InDiscs {
    /// What was met first where this fails.
    obstacle: Cell<Option<Obstacle>>,
}

impl InDiscs {
    /// What was met, which is forgotten.
    pub(super) fn obstacle(&self) -> Option<Obstacle> {
        self.obstacle.take()
    }

    fn meet(&self, obstacle: Obstacle) {
        self.obstacle.set(self.obstacle.get().or(Some(obstacle)));
    }
}

/// Methods of an algebra of rows from the operations of their values.
macro_rules! by_lanes {
    ($($name:ident $operation:tt),*) => {$(
        #[inline(always)]
        fn $name(&self, to: &mut Self::Value, a: &Self::Value, b: &Self::Value) {
            for k in 0..LANES {
                to.set(k, a.at(k) $operation b.at(k));
            }
        }
    )*};
}

/// The methods of both algebras that are the same.
macro_rules! common {
    () => {
        by_lanes!(add +, subtract -, multiply *);

        #[inline(always)]
        fn negate(&self, to: &mut Self::Value, a: &Self::Value) {
            for k in 0..LANES {
                to.set(k, -a.at(k));
            }
        }

        #[inline(always)]
        fn fused(&self, to: &mut Self::Value, fused: Fused, [a, b, c]: [&Self::Value; 3]) {
            for k in 0..LANES {
                let product = a.at(k) * b.at(k);
                to.set(k, match fused {
                    Fused::Add => product + c.at(k),
                    Fused::Subtract => product - c.at(k),
                    Fused::SubtractFrom => c.at(k) - product,
                });
            }
        }

        fn sin_cos(&self, sin: &mut Self::Value, cos: &mut Self::Value, a: &Self::Value) {
            Level::Best.dispatch(ByLane(
                #[inline(always)]
                |k| {
                    let values = a.at(k).sin_cos();
                    sin.set(k, values[0]);
                    cos.set(k, values[1]);
                },
            ));
        }
    };
}

impl Algebra for InBalls {
    type Value = Balls;

    common!();
    by_lanes!(divide /);

    fn power(&self, to: &mut Balls, a: &Balls, b: &Balls) {
        (0..LANES).for_each(|k| to.set(k, a.at(k).power(b.at(k))));
    }

    // Functions are too long to be part of every program, and are compiled for the machine by themselves.
    fn call(&self, to: &mut Balls, function: Function, a: &Balls) {
        Level::Best.dispatch(ByLane(
            #[inline(always)]
            |k| to.set(k, a.at(k).call(function)),
        ));
    }
}

impl Algebra for InDiscs {
    type Value = Discs;

    common!();

    #[inline(always)]
    fn divide(&self, to: &mut Discs, a: &Discs, b: &Discs) {
        if b.side() == 0.0 {
            self.meet(Obstacle::Divisor);
        }
        for k in 0..LANES {
            to.set(k, a.at(k) / b.at(k));
        }
    }

    fn power(&self, to: &mut Discs, a: &Discs, b: &Discs) {
        if a.side() != 1.0 {
            self.meet(Obstacle::Base);
        }
        (0..LANES).for_each(|k| to.set(k, a.at(k).power(b.at(k))));
    }

    fn call(&self, to: &mut Discs, function: Function, a: &Discs) {
        let side = a.side();
        let quotient = match function {
            Function::Tan => Some([Function::Sin, Function::Cos]),
            Function::Tanh if side == 0.0 => Some([Function::Sinh, Function::Cosh]),
            _ => None,
        };
        if let Some(of) = quotient {
            let [above, below] = of.map(|function| {
                let mut row = *a;
                self.call(&mut row, function, a);
                row
            });
            return self.divide(to, &above, &below);
        }
        Level::Best.dispatch(ByLane(
            #[inline(always)]
            |k| to.set(k, a.at(k).call(function, side)),
        ));
        let has_edge = match function {
            Function::Abs | Function::Sign | Function::Step => side == 0.0,
            Function::Sqrt | Function::Ln | Function::Log10 => side != 1.0,
            // They are made of roots and logarithms, of which each disc sees by itself whether it is on the right.
            Function::Asin | Function::Acos | Function::Atan => !to.rad.iter().all(|rad| rad.is_finite()),
            Function::Table(_) => true,
            _ => false,
        };
        if has_edge {
            self.meet(Obstacle::Function(function));
        }
    }
}
