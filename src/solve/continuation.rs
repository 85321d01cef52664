//! The end of a run as text, from which another one continues it to the last bit.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::world_line::WorldLine;
use crate::engine::{Handed, Marched, Sensitivity};
use crate::geometry::{Geometry, Start};
use crate::number::{Compensated, Real};

/// A number: its decimal, and what rounding took from it.
type Digits = [String; 2];

/// The end of a run: `end_state` in `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Continuation {
    /// γ.
    gamma: Digits,
    /// True if γ falls.
    is_backward: bool,
    /// The origin that t counts from in one coordinate.
    #[serde(skip_serializing_if = "Option::is_none")]
    t_counts_from: Option<Digits>,
    /// q^a by their names.
    q: BTreeMap<String, Digits>,
    /// dq^a/dγ.
    q_dot: BTreeMap<String, Digits>,
    /// p_a, as a user sees it.
    p: BTreeMap<String, Digits>,
    /// True if these are momenta of mechanics with Newton's law; summaries of old versions had those of the geometry.
    #[serde(default)]
    is_mechanical: bool,
    /// True if the decimals stand for doubles, and not for themselves, in more digits too.
    #[serde(default)]
    is_double: bool,
    /// K of q^a and dq^a/dγ, by which another space-time is known from the one of this run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    norm: Option<Digits>,
    /// The state of a march.
    #[serde(skip_serializing_if = "Option::is_none")]
    march: Option<Marched>,
    /// By how much q^a and p_a may be off, by `NAME` and `p_NAME`: see [`Off`]. Absent where that is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    error: Option<BTreeMap<String, f64>>,
}

/// By how much a state may be off: a second state that the true one may be as far away as. The signs belong together:
/// errors of positions and momenta that came about on one way grow in another way than each would by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Off {
    /// Of q^a, for every coordinate.
    pub q: Vec<f64>,
    /// Of p_a.
    pub p: Vec<f64>,
}

impl Off {
    /// No error of so many coordinates.
    pub fn none(coordinates: usize) -> Self {
        Self { q: vec![0.0; coordinates], p: vec![0.0; coordinates] }
    }

    /// Returns true if no number is off.
    pub fn is_none(&self) -> bool {
        self.q.iter().chain(&self.p).all(|off| *off == 0.0)
    }
}

fn digits<S: Real>(value: S, low: S) -> Digits {
    let decimal = value.to_decimal(S::MOST_DIGITS);
    let read = S::from_decimal(&decimal).unwrap_or(value);
    [decimal, ((value - read) + low).to_decimal(S::MOST_DIGITS)]
}

fn sum<S: Real>(digits: &Digits, is_double: bool) -> Option<Compensated<S>> {
    let read = |decimal: &String| {
        if is_double { f64::from_decimal(decimal).map(S::from) } else { S::from_decimal(decimal) }
    };
    let [value, dropped] = [read(&digits[0])?, read(&digits[1])?];
    (value.is_finite() && dropped.is_finite()).then(|| Compensated::from(value).plus(dropped))
}

impl Continuation {
    /// The one of a run.
    pub fn new<S: Real>(line: &WorldLine<S>) -> Self {
        let (names, joint, end) = (line.geometry().names(), line.last_joint(), line.end());
        let low = |lows: &[f64], k: Option<usize>| S::from(k.and_then(|k| lows.get(k)).copied().unwrap_or(0.0));
        let place = |a: usize| line.geometry().active().iter().position(|&active| active == a);
        let handed = &line.handed;
        let by_name = |of: &dyn Fn(usize) -> Digits| -> BTreeMap<String, Digits> {
            names.iter().cloned().enumerate().map(|(a, name)| (name, of(a))).collect()
        };
        let q_low = |a: usize| line.sums.get(a).copied().unwrap_or_else(|| low(&handed.q_low, Some(a)));
        Self {
            gamma: digits(line.gamma_f(), S::ZERO),
            is_backward: line.is_backward,
            t_counts_from: line.origin.map(|(_, origin)| digits(origin, S::ZERO)),
            q: by_name(&|a| digits(joint.q[a], q_low(a))),
            q_dot: by_name(&|a| digits(end.q_dot[a], S::ZERO)),
            p: by_name(&|a| {
                let [p, low] = [end.p[a], line.signed(low(&handed.p_low, place(a)))];
                digits(line.geometry().seen(a, p), line.geometry().seen(a, low))
            }),
            is_mechanical: true,
            is_double: !S::IS_EXTENDED,
            norm: Some(digits(line.geometry().norm(&end.q, &end.q_dot), S::ZERO)),
            march: handed.march.clone(),
            error: None,
        }
    }

    /// The same, whose state is off by this; `None` if that is not known.
    pub fn off_by(self, names: &[String], off: Option<&Off>) -> Self {
        let is_finite = |off: &&Off| off.q.iter().chain(&off.p).all(|value| value.is_finite());
        let by_name = |off: &Off| {
            let momenta = names.iter().map(|name| format!("p_{name}")).zip(off.p.iter().copied());
            names.iter().cloned().zip(off.q.iter().copied()).chain(momenta).collect()
        };
        Self { error: off.filter(is_finite).map(by_name), ..self }
    }

    /// Returns true if it has these coordinates.
    pub fn has(&self, name: &str) -> bool {
        [&self.q, &self.q_dot, &self.p].iter().all(|values| values.contains_key(name))
    }

    /// γ as a formula.
    pub fn gamma(&self) -> String {
        self.gamma.join(" + ")
    }

    /// q^a, and p_a as a user gives it, of a coordinate of this geometry as formulas.
    pub fn formulas(&self, a: usize, geometry: &Geometry) -> Option<[String; 2]> {
        let name = geometry.names()[a].as_str();
        let origin = self.t_counts_from.as_ref().filter(|_| name == "t");
        let origin: String = origin.into_iter().flatten().map(|number| format!(" + {number}")).collect();
        let momentum = self.p.get(name)?.join(" + ");
        let is_other = !self.is_mechanical && geometry.seen(a, 1.0) < 0.0;
        let momentum = if is_other { format!("-({momentum})") } else { momentum };
        Some([self.q.get(name)?.join(" + ") + &origin, momentum])
    }

    /// The origin that t counts from in one coordinate.
    pub fn origin<S: Real>(&self) -> Option<S> {
        Some(sum(self.t_counts_from.as_ref()?, self.is_double)?.high)
    }

    /// K at the end, if that is known.
    pub fn norm<S: Real>(&self) -> Option<S> {
        Some(sum(self.norm.as_ref()?, self.is_double)?.high)
    }

    /// The state at the end, and what else the run hands on to one that goes the same way.
    pub fn state<S: Real>(&self, geometry: &Geometry<S>, is_backward: bool) -> Option<(Start<S>, Carried<S>)> {
        let (names, active) = (geometry.names(), geometry.active());
        let all = |values: &BTreeMap<String, Digits>| -> Option<Vec<Compensated<S>>> {
            names.iter().map(|name| sum(values.get(name)?, self.is_double)).collect()
        };
        let (q, q_dot, mut p) = (all(&self.q)?, all(&self.q_dot)?, all(&self.p)?);
        if self.is_mechanical {
            p.iter_mut().enumerate().for_each(|(a, p)| {
                *p = Compensated { high: geometry.seen(a, p.high), low: geometry.seen(a, p.low) };
            });
        }
        let high = |sums: &[Compensated<S>]| sums.iter().map(|sum| sum.high).collect::<Vec<S>>();
        let p_low = active.iter().map(|&a| p[a].low.to_f64()).map(|low| if is_backward { -low } else { low });
        let handed = Handed {
            q_low: q.iter().map(|q| q.low.to_f64()).collect(),
            p_low: p_low.collect(),
            march: self.march.clone().filter(|_| self.is_backward == is_backward),
        };
        let start = Start { q: high(&q), q_dot: high(&q_dot), p: high(&p) };
        let error = self.off(names, is_backward);
        Some((start, Carried { sums: q.iter().map(|q| q.low).collect(), handed, error, sensitivity: None }))
    }

    /// By how much the state is off, with the momenta of the reversed motion if that `is_backward`.
    fn off(&self, names: &[String], is_backward: bool) -> Option<Off> {
        let known = self.error.as_ref()?;
        let all = |of: &dyn Fn(&String) -> String| -> Option<Vec<f64>> {
            names.iter().map(|name| known.get(&of(name)).copied().filter(|off| off.is_finite())).collect()
        };
        let momenta = all(&|name| format!("p_{name}"))?.into_iter();
        Some(Off { q: all(&String::clone)?, p: momenta.map(|off| if is_backward { -off } else { off }).collect() })
    }
}

/// The state that a run takes over from the one that it continues, besides its start.
#[derive(Debug, Clone, Default)]
pub struct Carried<S = f64> {
    /// The rounding errors of q^a.
    pub sums: Vec<S>,
    /// The state that the engine takes over.
    pub handed: Handed,
    /// By how much the start is off, if the run that it is the end of knows.
    pub error: Option<Off>,
    /// What small changes have grown to, behind an event.
    pub sensitivity: Option<Box<Sensitivity>>,
}
