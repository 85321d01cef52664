//! Independent checks of a solution. They use its nodes, the operator and the metric, and never call a solver.
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::diagnostics::Diagnostics;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let text = builtin::text("quartic").expect("it is built in");
//! let case = Case::parse("quartic", text, &["grid.gamma_f=100.0".to_owned(), "grid.n_gamma=2001".to_owned()])?;
//! let solution: Solution = solve(&case)?;
//! let found = Diagnostics::new(&solution);
//!
//! // Q_t is exact, and the trajectory is worth nothing: K tells.
//! assert!(found.charges[0].max_interior < 1e-12);
//! assert!(found.norm.max_interior > 0.4);
//! assert!(found.warnings(&solution).iter().any(|warning| warning.contains("K drifts")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod certificate;
mod defect;
mod deviations;
mod fields;
mod formulas;
pub mod gaps;
mod limits;
mod of_x;
mod sawtooth;
pub mod verdict;
mod warnings;
mod witnesses;

pub use certificate::Certificate;
pub use defect::Defect;
pub(crate) use deviations::energy_off;
pub use deviations::{ChargeDeviation, Deviation, WorkBalance};
pub use of_x::{NEGLIGIBLE, OfX};
pub use sawtooth::{Sawtooth, sawtooth};
pub use witnesses::{Heard, Place as WitnessPlace};

use std::borrow::Cow;

use self::deviations::{energy, invariants, tangent, work};
use self::fields::Fields;
use self::verdict::{FINER_GRID, Reason, SMALLER_ACCURACY};
use crate::geometry::{ConservedSum, Observable};
use crate::number::Real;
use crate::number::norm::{larger, max_abs};
use crate::solve::{Place, WorldLine};

/// Everything that is measured on a run, or on its last part if they were measured one after the other: then the rows
/// are those of the last one, and the largest values and sums are those of all.
#[derive(Debug, Clone)]
pub struct Diagnostics<S: Real = f64> {
    /// Dq^a on the nodes, by γ from the start, for every coordinate; D̄q^a in the weak form. In the strong form the
    /// value at the last node of a window is not a velocity, see [`Self::tangent`].
    pub q_dot: Vec<Vec<S>>,
    /// The charges of the ignorable coordinates, in order. That of t in one coordinate is ΔQ_t = g00(x)∘(Dt) − Q_t, the
    /// paper's ΔE.
    pub charges: Vec<ChargeDeviation<S>>,
    /// Conserved sums of the momenta of active coordinates.
    pub sums: Vec<ChargeDeviation<S>>,
    /// ΔG_a = (Dp_a) − f_a − F_a of every coordinate; in the weak form with D̄ and the initial momenta. For a
    /// coordinate of a potential, whose g_aa is constant, it is divided by that: a deviation of d²q^a/dγ². In one
    /// coordinate these are ΔGᵗ = D( g00(x)∘Dt ) and ΔGˣ = DDx + ½ g00′(x)∘(Dt)².
    pub delta_g: Vec<Vec<S>>,
    /// Largest |ΔG_a| over the nodes whose row of D does not reach the last node of the window (weak: all nodes).
    pub max_delta_g: S,
    /// K and its deviation g_ab Dq^a Dq^b − K.
    pub norm: Deviation<S>,
    /// In the lift of Newton's law: the energy ½mv² + V of the computed positions and velocities minus the charge
    /// p_t/p_s, which is −K/(2 ṫ p_s).
    pub energy: Option<Deviation<S>>,
    /// The invariants of the user and their names, in their order.
    pub invariants: Vec<(String, Deviation<S>)>,
    /// The size of K's terms besides the largest one, at most over the nodes: what motion contributes to K. It is 0
    /// where [`Self::of_x`] has the speed.
    pub motion: f64,
    /// The sawtooth of every coordinate that is active.
    pub sawtooth: Vec<(usize, Sawtooth<S>)>,
    /// The work balance of coordinates that only a force acts on.
    pub work: Vec<WorkBalance<S>>,
    /// What may explain its defects.
    work_places: Vec<WitnessPlace>,
    /// The gradient of the doubled action as the nodes have it, and as it was found in solving.
    pub certificate: Certificate,
    /// The defect between the nodes of spectral elements; `None` where there are none.
    pub defect: Option<Defect>,
    /// The range of every coordinate.
    pub reaches: Vec<Extent>,
    /// Largest distance between the branches in a coordinate, if the doubled system was solved.
    pub branch_distance: Option<S>,
    /// In a potential of x alone: the paper's bound, and how far the motion is from Newton's.
    pub of_x: Option<OfX<S>>,
    /// The numbers that ranges of coordinates count from, see [`Extent`].
    origins: Vec<S>,
}

impl<S: Real> Diagnostics<S> {
    /// Measures a run.
    pub fn new(line: &WorldLine<S>) -> Self {
        Self::of(line, &[], &mut [], false)
    }

    /// Measures a run with conserved sums, which are constants by coordinate, and with formulas of the user and their
    /// names. The lift of Newton's law (`is_lifted`) has t first and s last.
    pub fn of(
        line: &WorldLine<S>,
        sums: &[Vec<(usize, S)>],
        formulas: &mut [(String, Observable<S>)],
        is_lifted: bool,
    ) -> Self {
        let fields = Fields::new(line);
        let (geometry, n) = (line.geometry(), fields.velocities.len());
        let charges: Vec<_> = geometry.ignorable().map(|a| fields.charge(vec![(a, S::ONE)])).collect();
        let norm = fields.norm();
        let delta_g: Vec<Vec<S>> = (0..n).map(|a| fields.residual(a)).collect();
        let max_delta_g =
            max_abs(&delta_g.iter().map(|row| fields.largest(row, |grid| grid.uncoupled())).collect::<Vec<_>>());
        let energy = is_lifted.then(|| energy(&fields, &norm, &tangent(line, 0, &fields.velocities[0])));
        let invariants = if formulas.is_empty() {
            Vec::new()
        } else {
            let rows = fields.velocities.iter().enumerate();
            invariants(&fields, &rows.map(|(a, row)| tangent(line, a, row)).collect::<Vec<_>>(), formulas, norm.value)
        };
        let of_x = OfX::new(&fields);
        let (work, work_places) = work(&fields).into_iter().unzip();
        Self {
            certificate: fields.certificate(&delta_g),
            defect: Defect::new(line),
            work_places,
            origins: (0..n).map(|a| origin(&line.place, a)).collect(),
            charges,
            sums: sums.iter().map(|terms| fields.charge(terms.clone())).collect(),
            delta_g,
            max_delta_g,
            norm,
            energy,
            invariants,
            motion: if of_x.is_some() { 0.0 } else { fields.motion() },
            sawtooth: geometry.active().iter().map(|&a| (a, Sawtooth::new(&line.q[a], &line.windows))).collect(),
            work,
            reaches: (0..n).map(|a| Extent::new(line, a)).collect(),
            branch_distance: line.is_doubled().then(|| line.branch_distance()),
            of_x,
            q_dot: fields.velocities,
        }
    }

    /// Joins the measures of the first part of a run, `self`, and of its second part, `next`.
    pub fn followed_by(self, next: Self) -> Self {
        fn each<T>(one: Vec<T>, two: Vec<T>, join: fn(T, T) -> T) -> Vec<T> {
            one.into_iter().zip(two).map(|(one, two)| join(one, two)).collect()
        }
        // Of a piece behind an event, ranges of ignorable coordinates count from where it starts.
        let shifts = self.origins.iter().zip(&next.origins).map(|(&one, &next)| (next - one).to_f64());
        let reaches = self.reaches.into_iter().zip(next.reaches).zip(shifts);
        let reaches = reaches.map(|((one, next), shift)| one.joined(next, shift)).collect();
        Self {
            charges: each(self.charges, next.charges, ChargeDeviation::followed_by),
            sums: each(self.sums, next.sums, ChargeDeviation::followed_by),
            max_delta_g: max_abs(&[self.max_delta_g, next.max_delta_g]),
            norm: self.norm.followed_by(next.norm),
            energy: self.energy.zip(next.energy).map(|(one, two)| one.followed_by(two)),
            invariants: each(self.invariants, next.invariants, |(name, one), (_, two)| (name, one.followed_by(two))),
            motion: larger(self.motion, next.motion),
            sawtooth: each(self.sawtooth, next.sawtooth, |(a, one), (_, next)| {
                let amplitude = one.amplitude.into_iter().chain(next.amplitude).reduce(larger);
                let sixth_difference = one.sixth_difference.into_iter().chain(next.sixth_difference);
                (a, Sawtooth { amplitude, sixth_difference: sixth_difference.reduce(larger) })
            }),
            work: each(self.work, next.work, |one, next| WorkBalance {
                work: one.work + next.work,
                defect: one.defect + next.defect,
                ..next
            }),
            work_places: each(self.work_places, next.work_places, WitnessPlace::plus),
            certificate: self.certificate.followed_by(next.certificate),
            defect: self.defect.into_iter().chain(next.defect).reduce(Defect::followed_by),
            reaches,
            origins: self.origins,
            branch_distance: self.branch_distance.into_iter().chain(next.branch_distance).reduce(larger),
            of_x: self.of_x.zip(next.of_x).map(|(one, two)| one.followed_by(two)),
            ..next
        }
    }

    /// dq^a/dγ of every coordinate on the nodes: Dq^a, except at the last node of a window in the strong form. There
    /// the row of D takes up the defect of D and does not give a velocity. Its place is taken by what the next window
    /// continues with.
    pub fn tangent(&self, run: &WorldLine<S>) -> Vec<Cow<'_, [S]>> {
        let mut rows: Vec<_> = self.q_dot.iter().enumerate().map(|(a, row)| tangent(run, a, row)).collect();
        if run.is_backward {
            rows.iter_mut().flat_map(|row| row.to_mut().iter_mut()).for_each(|rate| *rate = -*rate);
        }
        rows
    }
}

/// The number that the size of a coordinate counts from: 0 or, if it is ignorable, the start.
pub(crate) fn origin<S: Real>(place: &Place<S>, a: usize) -> S {
    if place.geometry.active().contains(&a) { S::ZERO } else { place.start.q[a] }
}

/// The least and the largest of some values; those of an ignorable coordinate count from the start of the run. One that
/// is no number makes both NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The least one.
    pub least: f64,
    /// The largest one.
    pub most: f64,
}

impl Extent {
    /// The range of coordinate `a` on the nodes of a world-line.
    pub fn new<S: Real>(line: &WorldLine<S>, a: usize) -> Self {
        let origin = origin(&line.place, a);
        Self::of(line.counted_from_origin(a, &line.q[a]).map(|q| (q - origin).to_f64()))
    }

    /// The range of these values.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        // Iteration from inside goes window by window, which is faster.
        values.for_each(|q| (least, most) = (-larger(-least, -q), larger(most, q)));
        Self { least, most }
    }

    /// The least and the largest of these values and of others, which count from a number that is larger by `shift`.
    pub(crate) fn joined(self, others: Self, shift: f64) -> Self {
        Self { least: -larger(-self.least, -(others.least + shift)), most: larger(self.most, others.most + shift) }
    }

    /// The largest absolute value.
    pub fn size(self) -> f64 {
        larger(self.least.abs(), self.most.abs())
    }

    /// The largest value minus the least.
    pub fn range(self) -> f64 {
        self.most - self.least
    }
}

impl<S: Real> Diagnostics<S> {
    /// The largest change of a charge or of a conserved sum where it is exact, relative to its terms.
    pub fn exactness(&self) -> f64 {
        // p_s of Newton's law is no result.
        let charges = &self.charges[..self.charges.len() - usize::from(self.energy.is_some())];
        charges.iter().chain(&self.sums).fold(0.0, |most, charge| larger(most, charge.heard.share()))
    }

    /// The reasons to doubt a run that its witnesses give: every number that it should keep, and the defect between its
    /// nodes. Its coordinates are off by at most `errors`, and behind them is what rounding takes from every force and
    /// from K. Errors that are not known explain everything that is a number.
    pub fn unexplained(&self, line: &WorldLine<S>, errors: Option<&[f64]>) -> Vec<Reason> {
        let (names, mut found) = (line.geometry().names(), Vec::new());
        let remedy = if line.accuracy.is_some() { SMALLER_ACCURACY } else { FINER_GRID };
        let mut hear = |name: String, heard: &Heard| found.extend(heard.doubt(&name, errors, remedy));
        let Certificate { nodes, solved } = &self.certificate;
        hear("the gradient of the action".to_owned(), nodes);
        let solved = solved.iter().cloned().map(Heard::of);
        solved.for_each(|heard| hear("the gradient of the action, as it was found in solving,".to_owned(), &heard));
        for charge in self.charges.iter().chain(&self.sums) {
            let terms = charge.terms.iter().map(|&(a, c)| (a, c.to_f64())).collect();
            hear(ConservedSum { terms }.formula(names), &charge.heard);
        }
        match &self.energy {
            Some(energy) => hear("the energy of positions and velocities".to_owned(), &energy.heard),
            None if line.geometry().keeps_norm() => hear("K".to_owned(), &self.norm.heard),
            None => {}
        }
        for (balance, place) in self.work.iter().zip(&self.work_places) {
            let place = WitnessPlace { change: balance.defect.to_f64().abs(), ..place.clone() };
            let name = format!("p_{} without the work of the force", names[balance.coordinate]);
            hear(name, &Heard::of(place));
        }
        for (name, invariant) in &self.invariants {
            hear(format!("the invariant {name}"), &invariant.heard);
        }
        // Windows of a run to an accuracy are chosen by their modes, and their errors are estimated from these.
        let defect = self.defect.as_ref().filter(|_| line.accuracy.is_none());
        let results = line.geometry().results();
        found.extend(defect.and_then(|defect| defect.doubt(names, results, errors, remedy)));
        found
    }
}
