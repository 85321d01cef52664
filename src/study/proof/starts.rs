//! The starts of a case in which some numbers may be others, as the set that a proof is about.

use std::sync::Arc;

use crate::case::Case;
use crate::geometry::{Degrees, Geometry, Start};
use crate::number::{Extended, Real};
use crate::proof::{Generator, Motion, Until};
use crate::solve::{Limit, Setup};

/// So many starts are looked at in which all numbers change, by parts that are no fractions of each other.
const TOGETHER: usize = 3;
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// What is left of a linear number, beside its size.
const LINEAR: f64 = 1e-55;

/// The keys of parameters are in this table.
const PARAMETERS: &str = "parameters.";

/// A case with some of its numbers, by their keys, around which others are looked at. Parameters among them are
/// unknown: they are coordinates of the proof behind those of the case, which stay where they are.
pub(crate) struct Starts {
    /// The text that gives the case once these numbers are set.
    text: String,
    keys: Vec<String>,
    /// Their values in the middle.
    pub(crate) middles: Vec<Extended>,
    /// The places of parameters among them.
    parameters: Vec<usize>,
    /// The case, with its unknown parameters.
    pub(crate) case: Case,
    pub(crate) setup: Setup<Extended>,
    /// The start in the middle, with unknown parameters behind its coordinates.
    pub(crate) start: Start<Extended>,
    /// True if formulas show that the start and the length of the run are linear in these numbers.
    is_linear: bool,
    /// True if the value at which the run ends, if it does, is the same for all of them.
    ends_alike: bool,
}

/// The start and the length of a run.
struct Ends {
    q: Vec<Extended>,
    p: Vec<Extended>,
    length: Extended,
}

impl Ends {
    /// Those of a run with these values of unknown parameters.
    fn new(setup: &Setup<Extended>, parameters: &[Extended]) -> Self {
        let start = &setup.place.start;
        let length = match setup.limit {
            Limit::Length(length) => length,
            Limit::Value { coordinate, value } => {
                (value - setup.origin_of(coordinate) - start.q[coordinate]) / start.q_dot[coordinate]
            }
        };
        let p = start.p.iter().copied().chain(parameters.iter().map(|_| Extended::ZERO));
        Self { q: [&start.q, parameters].concat(), p: p.collect(), length }
    }
}

impl Starts {
    /// The case of `text` with these numbers in the middle.
    ///
    /// # Errors
    /// The reason why a proof says nothing of it.
    pub(crate) fn new(text: String, keys: Vec<String>, middles: Vec<Extended>) -> Result<Self, String> {
        let mut case = parsed(&text, &keys, &middles)?;
        if !case.is_determined() {
            return Err("a rate at the start is not known to all digits".to_owned());
        }
        let setup: Setup<Extended> = case.setup();
        let parameters: Vec<usize> = (0..keys.len()).filter(|&j| keys[j].starts_with(PARAMETERS)).collect();
        let unknown: Vec<String> = parameters.iter().map(|&j| keys[j][PARAMETERS.len()..].to_owned()).collect();
        if case.geometry_text.is_law_of(&unknown) {
            return Err("the mass of the relativistic law, or c, is not known".to_owned());
        }
        case.geometry_text.unknown = unknown;
        let Ends { q, p, .. } = Ends::new(&setup, &at(&parameters, &middles));
        let mut q_dot = setup.place.start.q_dot.clone();
        q_dot.resize(q.len(), Extended::ZERO);
        let [is_linear, ends_alike] = is_linear(&text, &keys, &middles)?;
        Ok(Self { start: Start { q, q_dot, p }, setup, parameters, text, keys, middles, case, is_linear, ends_alike })
    }

    /// The start and the length with these numbers.
    fn ends(&self, values: &[Extended]) -> Result<Ends, String> {
        let case = parsed(&self.text, &self.keys, values)?;
        if !case.is_in_scene_of(&self.case) {
            return Err(format!("with other values of {} it is another scene", self.keys.join(" and ")));
        }
        let setup: Setup<Extended> = case.setup();
        let is_moved = (0..setup.place.start.q.len()).any(|a| setup.origin_of(a) != self.setup.origin_of(a));
        if is_moved {
            return Err(format!("{} is where the run counts from", self.keys.join(" or ")));
        }
        Ok(Ends::new(&setup, &at(&self.parameters, values)))
    }

    /// About how long the run is, and as long in the middle if it ends after a length.
    pub(crate) fn length(&self) -> Extended {
        self.middle().length
    }

    /// Those in the middle.
    fn middle(&self) -> Ends {
        Ends::new(&self.setup, &at(&self.parameters, &self.middles))
    }

    /// The direction of the starts in which the number `j` changes by its radius.
    fn generator(&self, j: usize, radius: f64) -> Result<Generator, String> {
        let key = &self.keys[j];
        let at = |times: f64| {
            let mut values = self.middles.clone();
            values[j] += Extended::from(times) * Extended::from(radius);
            self.ends(&values)
        };
        let (here, [one, other]) = (self.middle(), [at(1.0)?, at(-0.75)?]);
        let linear = |here: Extended, one: Extended, other: Extended| {
            let column = one - here;
            let left = (other - here + Extended::from(0.75) * column).abs().to_f64();
            let room = LINEAR * (here.abs() + one.abs()).to_f64();
            if left <= room {
                Ok(column.to_f64())
            } else {
                Err(format!("the start or the end of the run is not linear in {key}"))
            }
        };
        let all = |here: &[Extended], one: &[Extended], other: &[Extended]| -> Result<Vec<f64>, String> {
            let each = here.iter().zip(one).zip(other);
            each.map(|((&here, &one), &other)| linear(here, one, other)).collect()
        };
        // By Newton's law that of t is the energy, which is not linear, and on which no motion depends.
        let is_energy = |a: usize| self.case.is_lifted() && a == 0;
        let momentum = |a: usize| {
            let column = linear(here.p[a], one.p[a], other.p[a]);
            if is_energy(a) { Ok(column.unwrap_or(f64::NAN)) } else { column }
        };
        Ok(Generator {
            q: all(&here.q, &one.q, &other.q)?,
            p: (0..here.p.len()).map(momentum).collect::<Result<_, _>>()?,
            length: linear(here.length, one.length, other.length)?,
        })
    }

    /// The directions in which every number changes by its radius.
    ///
    /// # Errors
    /// The reason why the starts are no such set.
    pub(crate) fn generators(&self, radii: &[f64]) -> Result<Vec<Generator>, String> {
        let generators: Vec<Generator> =
            radii.iter().enumerate().map(|(j, radius)| self.generator(j, *radius)).collect::<Result<_, _>>()?;
        if radii.len() > 1 {
            // All of them change at once, each by another part: products of two have a term of their own.
            for round in 0..TOGETHER {
                let part = |j: usize| 1.0 - 1.7 * ((j + 1) as f64 * GOLDEN * (round + 1) as f64).fract();
                self.check_together(radii, &generators, &(0..radii.len()).map(part).collect::<Vec<f64>>())?;
            }
        }
        if !self.is_linear {
            // Between the places that were looked at it may do anything.
            let keys = self.keys.join(" and ");
            return Err(format!("the start or the end of the run is not seen to be linear in {keys}"));
        }
        Ok(generators)
    }

    /// Looks at the start where every number changes by a part of its radius.
    fn check_together(&self, radii: &[f64], generators: &[Generator], parts: &[f64]) -> Result<(), String> {
        let mut values = self.middles.clone();
        for ((value, radius), part) in values.iter_mut().zip(radii).zip(parts) {
            *value += Extended::from(*part) * Extended::from(*radius);
        }
        let (here, there) = (self.middle(), self.ends(&values)?);
        let is_sum = |here: Extended, there: Extended, columns: &dyn Fn(&Generator) -> f64| {
            let (mut sum, mut size) = (here, (here.abs() + there.abs()).to_f64() * LINEAR);
            for (generator, part) in generators.iter().zip(parts) {
                sum += Extended::from(columns(generator)) * Extended::from(*part);
                // Columns are doubles.
                size += 0.5 * f64::EPSILON * (1.0 + 1e-12) * (columns(generator) * part).abs();
            }
            // What is no result has no columns.
            sum.to_f64().is_nan() || (there - sum).abs().to_f64() <= size
        };
        let of_q = |a: usize| is_sum(here.q[a], there.q[a], &|of| of.q[a]);
        let of_p = |a: usize| is_sum(here.p[a], there.p[a], &|of| of.p[a]);
        let is_linear =
            (0..here.q.len()).all(|a| of_q(a) && of_p(a)) && is_sum(here.length, there.length, &|of| of.length);
        let message =
            || format!("the start or the end of the run is not linear in {} together", self.keys.join(" and "));
        if is_linear { Ok(()) } else { Err(message()) }
    }

    /// True if motions from these starts may meet events that act or end them.
    pub(crate) fn may_meet_events(&self) -> bool {
        let Case { grid, events, .. } = &self.case;
        self.case.has_acting_events() || grid.until.is_some() || events.iter().any(|event| event.until)
    }

    /// The momenta, constants of the motion, that are not the same for all starts.
    pub(crate) fn kept(&self, generators: &[Generator]) -> Vec<usize> {
        let changes = |a: &usize| generators.iter().any(|of| of.p[*a] != 0.0 && !of.p[*a].is_nan());
        self.setup.place.geometry.ignorable().filter(changes).collect()
    }

    /// The space-time of a proof. A momentum that is not the same for all starts is no constant of it.
    ///
    /// # Errors
    /// The reason why motions of it end in no way that is known.
    pub(crate) fn geometry(&self, generators: &[Generator]) -> Result<Arc<Geometry<Extended>>, String> {
        let geometry = self.scene(generators);
        let is_steady = match self.setup.limit {
            Limit::Length(_) => true,
            Limit::Value { coordinate, .. } => geometry.is_steady(coordinate),
        };
        // The length of the run is linear in these numbers where t moves at a constant velocity.
        if is_steady || self.ends_alike {
            return Ok(geometry);
        }
        Err("the time at which a run ends depends on them, and its velocity changes".to_owned())
    }

    fn scene(&self, generators: &[Generator]) -> Arc<Geometry<Extended>> {
        let plain = &self.setup.place.geometry;
        let kept = self.kept(generators);
        if kept.is_empty() && self.parameters.is_empty() {
            return Arc::clone(plain);
        }
        // K is in no formula that is watched, as none is.
        Arc::new(self.case.watching(&[], (&kept, &[]), Extended::ZERO))
    }

    /// The motions of the set.
    pub(crate) fn motion<'m>(&'m self, geometry: &'m Geometry<Extended>, generators: &'m [Generator]) -> Motion<'m> {
        let until = match self.setup.limit {
            Limit::Length(length) => Until::Length(length),
            Limit::Value { coordinate, value } => Until::Value(coordinate, value - self.setup.origin_of(coordinate)),
        };
        let unused = self.case.is_lifted().then(|| self.setup.place.start.q.len() - 1);
        Motion { unused, generators, ..Motion::new(geometry, &self.start, until) }
    }
}

/// True if formulas show that the start and the length of a run are linear in the numbers with these keys, and true if
/// they show that t at its end does not depend on them.
fn is_linear(text: &str, keys: &[String], values: &[Extended]) -> Result<[bool; 2], String> {
    // Each stands for a parameter of its own, under a name that the text does not have.
    let own = |j: usize| {
        let mut name = format!("unknown_{j}");
        while text.contains(&name) {
            name.push('_');
        }
        name
    };
    let (mut set, mut unknown) = (Vec::new(), Vec::new());
    for (j, (key, value)) in keys.iter().zip(values).enumerate() {
        let value = value.to_decimal(Extended::MOST_DIGITS);
        match key.strip_prefix(PARAMETERS) {
            Some(name) => {
                set.push(format!("{key}={value}"));
                unknown.push(name.to_owned());
            }
            None => {
                set.extend([format!("{PARAMETERS}{}={value}", own(j)), format!("{key}={}", own(j))]);
                unknown.push(own(j));
            }
        }
    }
    let mut case = Case::parse("the case", text, &set).map_err(|error| error.to_string())?;
    case.geometry_text.unknown = unknown;
    let Degrees { q, q_dot, p, others } = case.start_degrees();
    let is_linear = |degree: &Option<u32>| degree.is_some_and(|degree| degree <= 1);
    let is_constant = |degree: &Option<u32>| *degree == Some(0);
    // No motion depends on the energy, which is the momentum of t by Newton's law.
    let first = usize::from(case.is_lifted());
    let ends_at_t = case.grid.t_f.is_some();
    let rate_of_t = case.coordinates().iter().position(|name| name == "t").and_then(|t| q_dot.get(t));
    let is_linear = q.iter().all(is_linear)
        && p[first..].iter().all(is_linear)
        && others.iter().all(is_linear)
        && others.first().is_none_or(is_constant)
        && (!ends_at_t || rate_of_t.is_some_and(is_constant));
    Ok([is_linear, others.last().is_none_or(is_constant)])
}

/// The values in these places.
fn at(places: &[usize], values: &[Extended]) -> Vec<Extended> {
    places.iter().map(|&j| values[j]).collect()
}

/// The case of a text with these numbers.
fn parsed(text: &str, keys: &[String], values: &[Extended]) -> Result<Case, String> {
    let one = |(key, value): (&String, &Extended)| format!("{key}={}", value.to_decimal(Extended::MOST_DIGITS));
    let set: Vec<String> = keys.iter().zip(values).map(one).collect();
    Case::parse("the case", text, &set).map_err(|error| error.to_string())
}
