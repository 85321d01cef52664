//! Formulas of a state: what a user wants to see conserved, or where a run is to end.

use std::ops::Range;
use std::sync::Arc;

use super::parts::{self, Scope};
use super::text::{GeometryError, GeometryText, Place};
use crate::formula::{self, Kind, Program, Watched, run_on_balls, watched_registers};
use crate::number::ball::Ball;
use crate::number::{Extended, Real};

/// A formula in the positions `q`, the velocities `q_dot` and the momenta `p_q` of a scene, in `norm`, which is K at
/// the start, and in the parameters and definitions of the scene.
#[derive(Debug, Clone)]
pub struct Observable<S = f64> {
    program: Program<S>,
    registers: Vec<[S; 1]>,
    /// Its arguments of functions, divisors and bases of powers, which must not change much from a point to the next if
    /// the points are to show what it does between them. A table has no scale of its own.
    steep: Vec<Watched>,
    /// True for each of q^a and p_a that it depends on, or its velocities do.
    reads: Arc<[bool]>,
    /// True if it depends on velocities.
    has_velocities: bool,
    /// True if velocities and momenta are those of the reversed motion.
    is_reversed: bool,
    /// The coordinates whose momenta have the other sign in the formula, see [`Geometry::seen`](super::Geometry::seen).
    mirrored: Range<usize>,
}

/// The names that an observable may use of a scene with these coordinates: all positions, all velocities, all momenta
/// and the norm.
pub fn observed(coordinates: &[String]) -> Vec<String> {
    [parts::variables(coordinates, coordinates.len(), 3), vec!["norm".to_owned()]].concat()
}

impl<S: Real> Observable<S> {
    /// Compiles the formula `text` for the scene `geometry`, whose text gives the parameters. Mistakes are reported at
    /// `place`.
    ///
    /// # Errors
    /// [`GeometryError::Formula`] with the mistake.
    pub fn new(text: &str, scene: &GeometryText, place: Place) -> Result<Self, GeometryError> {
        let all = observed(&scene.names());
        let variables: Vec<&str> = all.iter().map(String::as_str).collect();
        let mut scope = Scope::new(scene)?;
        scope.define(&scene.definitions)?;
        let node = formula::parse(text, &variables, &scope.names, &mut scope.graph)
            .map_err(|error| GeometryError::Formula(place, error))?;
        let program = Program::new(&mut scope.graph, variables.len(), &[node]);
        let (registers, mirrored) = (program.registers(|constant| [constant]), scene.mirrored());
        let varies = program.depends_on(|variable| variable + 1 < variables.len());
        let (mut steep, _) = watched_registers(program.steps_to(1).iter(), &varies);
        steep.retain(|look| !matches!(look.kind, Kind::Table(_)));
        let n = variables.len() / 3;
        let needed = program.needed([program.output(0)], |_| false);
        let has_velocities = needed[n..2 * n].contains(&true);
        let reads = needed[..n].iter().chain(&needed[2 * n..3 * n]).map(|&is_read| is_read || has_velocities).collect();
        Ok(Self { registers, program, steep, reads, has_velocities, is_reversed: false, mirrored })
    }

    /// Returns true if velocities occur in it, and not positions and momenta alone.
    pub(crate) fn has_velocities(&self) -> bool {
        self.has_velocities
    }

    /// Says of each q^a of all coordinates, and then of each p_a, whether the formula changes with it.
    pub(crate) fn reads(&self) -> Arc<[bool]> {
        Arc::clone(&self.reads)
    }

    /// The values of all that may be steep in the formula, where it was evaluated last.
    pub(crate) fn arguments(&self) -> impl ExactSizeIterator<Item = f64> {
        self.steep.iter().map(|look| self.registers[look.register][0].to_f64())
    }

    /// What the values at these places show of the formula between them, where `arguments` has each of
    /// [`Self::arguments`] at all places. Where something is no number, nothing is known. There is room for `margins`.
    pub(crate) fn shows(&self, places: &[f64], arguments: &[f64], margins: &mut Vec<f64>) -> Shown {
        margins.resize(places.len(), 0.0);
        let mut kink: Option<(usize, usize)> = None;
        for (argument, look) in self.steep.iter().enumerate() {
            let values = &arguments[argument * places.len()..][..places.len()];
            if let Kind::Side(_) = look.kind {
                let point = values.windows(2).position(|pair| (pair[0] < 0.0) != (pair[1] < 0.0));
                let first = point.map(|point| (point, argument));
                kink = [kink, first].into_iter().flatten().min();
            } else if !look.changes_little(places, values, margins) && values.iter().all(|value| value.is_finite()) {
                return Shown::Some;
            }
        }
        kink.map_or(Shown::All, |(point, argument)| Shown::Kink { argument, point })
    }

    /// The same, which is given velocities and momenta of the reversed motion.
    pub fn of_reversed(self) -> Self {
        Self { is_reversed: true, ..self }
    }

    /// The value at a state, where `norm` is K at the start.
    pub fn at(&mut self, q: &[S], q_dot: &[S], p: &[S], norm: S) -> S {
        let n = q.len();
        let variables = self.registers.as_flattened_mut();
        for (place, values) in [q, q_dot, p].into_iter().enumerate() {
            variables[place * n..][..n].copy_from_slice(values);
        }
        if self.is_reversed {
            variables[n..3 * n].iter_mut().for_each(|rate| *rate = -*rate);
        }
        variables[2 * n..3 * n][self.mirrored.clone()].iter_mut().for_each(|momentum| *momentum = -*momentum);
        variables[3 * n] = norm;
        self.program.run(1, 1, &mut self.registers, &mut 1);
        self.registers[self.program.output(0)][0]
    }
}

impl<S: Real> Observable<S> {
    /// Writes the values at many states, given by rows of q^a, of dq^a/dγ and of p_a.
    pub(crate) fn along(&self, [q, q_dot, p]: [&[&[S]]; 3], norm: S, out: &mut [S]) {
        let (n, norm) = (q.len(), vec![norm; out.len()]);
        let turned = |(variable, row): (usize, &&[S])| {
            let is_mirrored = variable >= 2 * n && self.mirrored.contains(&(variable - 2 * n));
            let is_turned = is_mirrored != (self.is_reversed && variable >= n);
            is_turned.then(|| row.iter().map(|&value| -value).collect::<Vec<S>>())
        };
        let rows = || q.iter().chain(q_dot).chain(p);
        let turned: Vec<Option<Vec<S>>> = rows().enumerate().map(turned).collect();
        let rows = rows().zip(&turned).map(|(row, turned)| turned.as_deref().unwrap_or(row));
        let variables: Vec<&[S]> = rows.chain([norm.as_slice()]).collect();
        self.program.sample(&variables, &mut [out]);
    }
}

impl Observable<Extended> {
    /// The value at a state of which each number is off by at most the part `off`, and a bound of what it is off by.
    pub fn enclosed(&self, [q, q_dot, p]: [&[Extended]; 3], norm: Extended, off: f64) -> (Extended, f64) {
        let n = q.len();
        let mut registers = self.program.registers(|constant| Ball::of(constant, off));
        let state = q.iter().chain(q_dot).chain(p).chain([&norm]);
        registers.iter_mut().zip(state).for_each(|(register, &value)| *register = Ball::of(value, off));
        let reversed = if self.is_reversed { n..3 * n } else { 0..0 };
        let mirrored = self.mirrored.clone().map(|a| 2 * n + a);
        reversed.chain(mirrored).for_each(|variable| registers[variable] = -registers[variable]);
        run_on_balls(self.program.steps_to(1), &mut registers);
        let Ball { hi, lo, rad } = registers[self.program.output(0)];
        (Extended::from(hi) + Extended::from(lo), rad)
    }
}

/// What values at some places show of a formula between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shown {
    /// All that it does.
    All,
    /// Not all.
    Some,
    /// All but what it does around a kink or a jump, of which others may be near it: this argument of abs, sign or step
    /// changes its sign behind this point.
    Kink {
        /// By its place.
        argument: usize,
        /// By its place.
        point: usize,
    },
}

/// Which sign changes are events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// From negative to positive.
    Up,
    /// From positive to negative.
    Down,
    /// Either of them.
    #[default]
    Both,
}

impl Direction {
    /// The name used in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Down => "down",
            Self::Both => "both",
        }
    }

    /// Returns true if a change to positive values counts, or one to negative values.
    pub fn counts(self, to_positive: bool) -> bool {
        match self {
            Self::Up => to_positive,
            Self::Down => !to_positive,
            Self::Both => true,
        }
    }
}
