//! Bounds on the ellipse of a window, with a polydisc of errors around the motion.
//!
//! 32 discs cover the upper half of the boundary of the ellipse E; on the lower half all is conjugate. Formulas are
//! evaluated on y + e for all |e_k| ≤ R_k there. By the maximum principle for the real parts of divisors and arguments
//! all registers are analytic on E × polydisc, and every bound on the discs holds within.

use super::algebras::{Discs, InDiscs, LANES, Obstacle, Row};
use super::approximate::combined;
use super::equations::{Equations, number};
use super::tables::{TABLES, UP};
use crate::formula::run;
use crate::number::ball::Disc;
use crate::number::norm::larger;

/// Radii of polydiscs, in units of the discs on the ellipse: as wide as these makes both cost the same.
const REACH: f64 = 0.7;
/// Where nothing moves, radii are this share of a coordinate.
const AT_REST: f64 = 1e-10;
/// Where nothing moves at 0, radii are this.
const NOWHERE: f64 = 1e-30;
/// The errors at the start are within the polydisc by this factor.
const ROOM: f64 = 8.0;

/// Bounds on E × polydisc.
pub(super) struct Bounds {
    /// Of the defect d, with no error.
    pub(super) defect: Vec<f64>,
    /// Of f, of the entries of J, and of half of what errors change these by.
    pub(super) slope: Vec<f64>,
    pub(super) jacobian: Vec<f64>,
    pub(super) spread: Vec<f64>,
    /// The radii of the polydisc.
    pub(super) reach: Vec<f64>,
    /// The sides on which the slopes are.
    pub(super) sides: Vec<f64>,
}

/// Room for registers.
pub(super) struct Ellipse {
    algebra: InDiscs,
    of_slopes: Vec<Discs>,
    of_jacobian: Vec<Discs>,
}

/// v on the discs: values in their middles with what rounding does to them, and a bound of |v′|, by the place.
struct Slope {
    there: [Row; 2],
    rounding: f64,
    second: f64,
}

impl Slope {
    /// |v(z)| in the middle of disc i.
    fn size(&self, i: usize) -> f64 {
        Disc { re: self.there[0][i], im: self.there[1][i], rad: self.rounding }.size()
    }
}

/// A bound of what rounding does to Σ c_k P_k, by these bounds of |P_k|: a part of u for each of 35 roundings of sums
/// and products and for the table, of 64 that are allowed for.
fn room(modes: &Row, most: &Row) -> f64 {
    32.0 * f64::EPSILON * modes.iter().zip(most).map(|(mode, most)| mode.abs() * most).sum::<f64>() * UP
}

/// Radii of a polydisc by unknown, with room for the set at the start, which reaches as far as `e_0`.
fn reach(equations: &Equations<'_>, start: &[f64], e_0: &[f64], places: &[Discs]) -> Vec<f64> {
    let of_disc = |((place, start), e_0): ((&Discs, &f64), &f64)| {
        let moves = REACH * place.rad.iter().fold(0.0_f64, |most, rad| larger(most, *rad)) + AT_REST * start.abs();
        moves + ROOM * e_0 + if moves == 0.0 { NOWHERE } else { 0.0 }
    };
    let of_active = places.iter().zip(start).zip(e_0).map(of_disc);
    of_active.chain(std::iter::repeat_n(0.0, equations.unknowns - equations.active)).collect()
}

impl Ellipse {
    pub(super) fn new(equations: &Equations<'_>) -> Self {
        let disc = |constant| Discs::of(Disc::of(number(constant)));
        Self {
            algebra: InDiscs::default(),
            of_slopes: equations.registers(false, disc),
            of_jacobian: equations.registers(true, disc),
        }
    }

    /// Bounds for the window of length `h` from `start` with these coefficients of slopes; or what is in the way.
    #[inline(always)]
    pub(super) fn bounds(
        &mut self,
        equations: &Equations<'_>,
        (start, h): (&[f64], f64),
        e_0: &[f64],
        modes: &[Row],
    ) -> Result<Bounds, Option<Obstacle>> {
        // Loops, and no closures: what is not inlined has a call for each fused multiplication.
        let (mut slopes, mut places) = (Vec::with_capacity(modes.len()), Vec::with_capacity(equations.active));
        for modes in modes {
            slopes.push(slope_there(modes));
        }
        for k in 0..equations.active {
            places.push(place(start[k], h, &modes[k], &slopes[k]));
        }
        let reach = equations.shared(&reach(equations, start, e_0, &places));
        self.put(equations, places.iter().zip(&reach).map(|(place, reach)| widened(place, *reach)));
        run(&self.algebra, &equations.all_formulas, &mut self.of_slopes);
        run(&self.algebra, &equations.of_jacobian, &mut self.of_jacobian);
        if let Some(obstacle) = self.algebra.obstacle() {
            return Err(Some(obstacle));
        }
        let found = |k: usize| &self.of_slopes[equations.slopes[k]];
        let entry = |entry| equations.value(entry, &self.of_jacobian, |constant| Discs::of(Disc::of(number(constant))));
        let jacobian: Vec<Discs> = equations.entries.iter().map(entry).collect();
        let bounds = Bounds {
            // d is smaller where no error widens f, but interpolation and quadrature hardly see it.
            defect: (slopes.iter().enumerate()).map(|(k, slope)| defect(slope, found(k))).collect(),
            slope: (0..modes.len()).map(|k| found(k).largest(Disc::size)).collect(),
            sides: (0..modes.len()).map(|k| found(k).side()).collect(),
            // With an error and without it J is in one disc; so it is within, by the maximum principle for each error.
            spread: jacobian.iter().map(|discs| discs.largest(|disc| disc.rad)).collect(),
            jacobian: jacobian.iter().map(|discs| discs.largest(Disc::size)).collect(),
            reach,
        };
        let all = [&bounds.defect, &bounds.slope, &bounds.jacobian, &bounds.spread];
        if all.into_iter().flatten().all(|bound| *bound < f64::MAX) { Ok(bounds) } else { Err(None) }
    }

    fn put(&mut self, equations: &Equations<'_>, values: impl Iterator<Item = Discs>) {
        for (&register, value) in equations.variables.iter().zip(values) {
            self.of_slopes[register] = value;
            self.of_jacobian[register] = value;
        }
    }

    /// Enclosures of f around one point.
    pub(super) fn slopes_around(&mut self, equations: &Equations<'_>, at: &[f64], radius: &[f64]) -> Vec<Disc> {
        let discs = at.iter().zip(radius).map(|(&re, &rad)| Discs::of(Disc { re, im: 0.0, rad }));
        self.put(equations, discs);
        run(&self.algebra, &equations.all, &mut self.of_slopes);
        let is_analytic = self.algebra.obstacle().is_none();
        let found = equations.slopes.iter().map(|&register| self.of_slopes[register].at(0));
        found.map(|disc| if is_analytic { disc } else { Disc::UNKNOWN }).collect()
    }

    /// J on real places, one in each lane, as discs around real numbers.
    #[inline(always)]
    pub(super) fn jacobian_at(&mut self, equations: &Equations<'_>, places: &[Discs]) -> Vec<Discs> {
        for (&register, place) in equations.variables.iter().zip(places) {
            self.of_jacobian[register] = *place;
        }
        run(&self.algebra, &equations.of_jacobian, &mut self.of_jacobian);
        // Real places lie within the ellipse, where all is analytic; they are not on one side for another reason.
        let _ = self.algebra.obstacle();
        let entries = equations.entries.iter();
        let constant = |constant| Discs::of(Disc::of(number(constant)));
        entries.map(|entry| equations.value(entry, &self.of_jacobian, constant)).collect()
    }
}

#[inline(always)]
fn slope_there(modes: &Row) -> Slope {
    let second = modes.iter().zip(&TABLES.most_slope).map(|(mode, most)| mode.abs() * most).sum::<f64>() * UP;
    let [re, im] = &TABLES.legendre_there;
    let there = [re, im].map(|table| combined(table, modes.iter().copied()));
    // The real and the imaginary part.
    Slope { there, rounding: 2.0 * room(modes, &TABLES.most), second }
}

/// y on the discs. Along E, no further than r from a middle z, |v| ≤ |v(z)| + s |v′| at a distance s, so that y leaves
/// y(z) by at most (h/2) r (|v(z)| + r |v′|/2). A middle lies on E but for rounding, for which r has room.
#[inline(always)]
fn place(start: f64, h: f64, modes: &Row, slope: &Slope) -> Discs {
    let [re, im] = &TABLES.integral_there;
    let factors = || modes.iter().map(|mode| 0.5 * h * mode);
    let (way, im) = (combined(re, factors()), combined(im, factors()));
    // The real and the imaginary part, and the factors h/2.
    let rounding = 0.5 * h * 3.0 * room(modes, &TABLES.most_integral);
    let mut place = Discs { re: way.map(|way| start + way), im, rad: [0.0; LANES] };
    for i in 0..LANES {
        let by = 0.5 * h * TABLES.disc * (slope.size(i) + 0.5 * TABLES.disc * slope.second);
        place.rad[i] = (by + rounding + 4.0 * f64::EPSILON * (start.abs() + place.re[i].abs())) * UP;
    }
    place
}

#[inline(always)]
fn widened(place: &Discs, by: f64) -> Discs {
    Discs { rad: place.rad.map(|rad| (rad + by) * UP), ..*place }
}

/// A bound of |v − f| on the ellipse.
#[inline(always)]
fn defect(slope: &Slope, found: &Discs) -> f64 {
    let rad = (TABLES.disc * slope.second + slope.rounding) * UP;
    (0..LANES).fold(0.0, |most, i| {
        let gap = Disc { re: slope.there[0][i], im: slope.there[1][i], rad };
        crate::number::norm::larger(most, (gap - found.at(i)).size())
    })
}

#[cfg(test)]
mod tests;
