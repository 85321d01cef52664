//! What is said of digits that rounding takes from a motion.

use crate::geometry::{Geometry, GeometryText, Law, Place, WrittenFormulas, value_of};
use crate::number::{Extended, Real};

/// The first formula that loses this share of what another one loses is the one to name: those after it may use it.
const SHARE: f64 = 0.1;
/// At most so many coordinates are named.
const NAMED: usize = 3;

/// What is said of a loss.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Finding {
    /// A sentence: what loses, how much, and where.
    pub(super) sentence: String,
    /// True if it loses all of its digits: then a solve in more of them, whose guesses have 16, begins with nothing.
    pub(super) is_all: bool,
    /// The coordinate that is too far from 0, if it is that.
    pub(super) far: Option<String>,
}

/// The number of the 16 digits that a share is, in words, and whether it is all.
fn digits(share: f64) -> (String, bool) {
    let (digits, is_all) = ((-f64::EPSILON.log10() + share.min(1.0).log10()).round().max(1.0), share >= SHARE);
    (if is_all { "all of its digits".to_owned() } else { format!("{digits} of its 16 digits") }, is_all)
}

/// What is said of a coordinate that is too far from 0.
pub(super) fn of_coordinate(name: &str, value: f64, share: f64) -> Finding {
    let (many, is_all) = digits(share);
    let sentence = format!(
        "{name} is far from 0 beside what it moves by: of what it makes of the motion, rounding takes {many} near \
         {name} = {value:.4}"
    );
    Finding { sentence, is_all, far: Some(name.to_owned()) }
}

/// What is said of the formula that loses most at a place, where rates lose this share.
pub(super) fn of_formula(
    (text, geometry, count): (&GeometryText, &Geometry, usize),
    q: &[f64],
    q_dot: &[Extended],
    share: f64,
) -> Finding {
    let names = geometry.names();
    let active = (0..count).filter(|a| geometry.depends_on(*a) || geometry.active().contains(a));
    let shown: Vec<String> = active.take(NAMED).map(|a| format!("{} = {:.4}", names[a], q[a])).collect();
    let place = if shown.is_empty() { String::new() } else { format!(" near {}", shown.join(", ")) };
    let (name, share) = named(text, q, q_dot).unwrap_or_else(|| ("that the motion follows from".to_owned(), share));
    let (many, is_all) = digits(share);
    Finding { sentence: format!("the formula {name} loses {many} to rounding{place}"), is_all, far: None }
}

/// The name of the formula that loses most at a place, as it stands in the case, and the share that it loses.
fn named(text: &GeometryText, q: &[f64], q_dot: &[Extended]) -> Option<(String, f64)> {
    let share = |rough: f64, exact: Extended| {
        let off = (Extended::from(rough) - exact).to_f64().abs();
        if off == 0.0 { 0.0 } else { (off / exact.to_f64().abs()).min(1.0) }
    };
    let parameter = |(name, _): &(String, String)| {
        let rough = value_of::<f64>(name, &text.parameters).ok()?;
        Some((format!("of the parameter {name}"), share(rough, value_of(name, &text.parameters).ok()?)))
    };
    let mut found: Vec<(String, f64)> = text.parameters.iter().filter_map(parameter).collect();
    // Newton's forces have velocities by t.
    let pace = if text.law() == Some(Law::Newtonian) { q_dot[0] } else { Extended::ONE };
    let q_dot: Vec<Extended> = q_dot.iter().map(|&rate| rate / pace).collect();
    let rough_rates: Vec<f64> = q_dot.iter().map(|rate| rate.to_f64()).collect();
    let q_exact: Vec<Extended> = q.iter().map(|&q| Extended::from(q)).collect();
    let rough = WrittenFormulas::<f64>::new(text).ok()?.at(q, &rough_rates);
    let exact = WrittenFormulas::<Extended>::new(text).ok()?.at(&q_exact, &q_dot);
    for ((place, rough), (_, exact)) in rough.into_iter().zip(exact) {
        let shares = rough.into_iter().zip(exact).map(|(rough, exact)| share(rough, exact));
        found.push((name_of(&place, text), shares.fold(0.0, f64::max)));
    }
    let most = found.iter().fold(0.0_f64, |most, (_, share)| most.max(*share));
    found.into_iter().find(|(_, share)| *share > 0.0 && *share >= SHARE * most)
}

/// The name of a formula as it stands in a case.
fn name_of(place: &Place, text: &GeometryText) -> String {
    let coordinate = |a: usize| text.coordinates.get(a).cloned().unwrap_or_default();
    match place {
        Place::Component([a, b]) => format!("of the component \"{} {}\"", coordinate(*a), coordinate(*b)),
        Place::Definition(name) => format!("of the definition {name}"),
        Place::Parameter(name) => format!("of the parameter {name}"),
        Place::OneForm(a) => format!("one_form.{}", coordinate(*a)),
        Place::Force(a) => format!("force.{}", coordinate(*a)),
        Place::Conformal => "conformal".to_owned(),
        Place::Potential => "of the potential".to_owned(),
        Place::Mass(Some(a)) => format!("of the mass of {}", coordinate(*a)),
        Place::Mass(None) => "of the mass".to_owned(),
        Place::SpeedOfLight => "of c".to_owned(),
    }
}
