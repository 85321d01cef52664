//! Scenes in other units, in which no digit of a number is the same.

use geodesic_ivp::geometry::GeometryText;

use super::random::Random;
use super::scenes::Scene;

/// Lengths and energies are between 1/`LARGEST` and `LARGEST` times as large.
const LARGEST: f64 = 1e12;

/// The same scene in random units: of energy and of all positions in a potential, of each coordinate in a metric.
pub(crate) fn in_units((text, mut q, mut v): Scene, draw: &mut Random) -> Scene {
    let mut unit = || draw.scale(1.0 / LARGEST, LARGEST);
    let names = text.coordinates();
    let (text, units) = match text {
        GeometryText::Potential(mut potential) => {
            let (length, energy) = (unit(), unit());
            let units: Vec<f64> = names
                .iter()
                .map(|name| match name.as_str() {
                    "t" => 1.0,
                    "s" => energy,
                    _ => length,
                })
                .collect();
            let new = |text: &str, unit: f64| format!("({})*{unit:e}", in_place(text, &names, &units));
            potential.expression = new(&potential.expression, energy);
            potential.mass = new(&potential.mass, energy);
            potential.masses.iter_mut().for_each(|mass| *mass = new(mass, energy / (length * length)));
            potential.definitions.iter_mut().for_each(|(_, text)| *text = new(text, 1.0));
            potential.one_form.iter_mut().for_each(|(_, text)| *text = new(text, energy / length));
            potential.force.iter_mut().for_each(|(_, text)| *text = new(text, energy / length));
            (GeometryText::Potential(potential), units)
        }
        GeometryText::Metric(mut metric) => {
            let units: Vec<f64> = names.iter().map(|_| unit()).collect();
            let of_k = unit();
            let new = |text: &str, unit: f64| format!("({})*{unit:e}", in_place(text, &names, &units));
            let of = |a: usize| of_k / units[a];
            metric.components.iter_mut().for_each(|([a, b], text)| *text = new(text, of(*a) / units[*b]));
            metric.definitions.iter_mut().for_each(|(_, text)| *text = new(text, 1.0));
            metric.one_form.iter_mut().for_each(|(a, text)| *text = new(text, of(*a)));
            metric.force.iter_mut().for_each(|(a, text)| *text = new(text, of(*a)));
            metric.conformal.iter_mut().for_each(|text| *text = new(text, 1.0));
            (GeometryText::Metric(metric), units)
        }
    };
    for row in [&mut q, &mut v] {
        row.iter_mut().zip(&units).for_each(|(value, unit)| *value *= unit);
    }
    (text, q, v)
}

/// The formula with every coordinate, and its velocity, over its unit.
fn in_place(text: &str, names: &[String], units: &[f64]) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut formula = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        // A number such as 1e-3 is no word, whatever letters it has.
        let is_number = first.is_ascii_digit() || first == '.';
        let is_part = |c: char| is_word(c) || is_number && c == '.';
        let length = if is_part(first) { rest.find(|c| !is_part(c)).unwrap_or(rest.len()) } else { first.len_utf8() };
        let (word, others) = rest.split_at(length);
        let coordinate = word.strip_suffix("_dot").unwrap_or(word);
        match names.iter().position(|name| name == coordinate) {
            Some(a) => formula += &format!("({word}/{:e})", units[a]),
            None => formula += word,
        }
        rest = others;
    }
    formula
}
