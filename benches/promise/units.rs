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
        GeometryText::Potential(mut text) => {
            let (length, energy) = (unit(), unit());
            let of_name = |name: &String| match name.as_str() {
                "t" => 1.0,
                "s" => energy,
                _ => length,
            };
            let units: Vec<f64> = names.iter().map(of_name).collect();
            let scale = |text: &mut String, unit: f64| *text = scaled(text, unit, &names, &units);
            scale(&mut text.expression, energy);
            scale(&mut text.mass, energy);
            text.masses.iter_mut().for_each(|mass| scale(mass, energy / (length * length)));
            text.definitions.iter_mut().for_each(|(_, text)| scale(text, 1.0));
            text.one_form.iter_mut().chain(&mut text.force).for_each(|(_, text)| scale(text, energy / length));
            (GeometryText::Potential(text), units)
        }
        GeometryText::Metric(mut text) => {
            let units: Vec<f64> = names.iter().map(|_| unit()).collect();
            let of_k = unit();
            let scale = |text: &mut String, unit: f64| *text = scaled(text, unit, &names, &units);
            text.components.iter_mut().for_each(|([a, b], text)| scale(text, of_k / units[*a] / units[*b]));
            text.definitions.iter_mut().for_each(|(_, text)| scale(text, 1.0));
            text.one_form.iter_mut().chain(&mut text.force).for_each(|(a, text)| scale(text, of_k / units[*a]));
            text.conformal.iter_mut().for_each(|text| scale(text, 1.0));
            (GeometryText::Metric(text), units)
        }
    };
    for row in [&mut q, &mut v] {
        row.iter_mut().zip(&units).for_each(|(value, unit)| *value *= unit);
    }
    (text, q, v)
}

/// The formula times a unit, with every coordinate, and its velocity, over its own.
fn scaled(text: &str, unit: f64, names: &[String], units: &[f64]) -> String {
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
    format!("({formula})*{unit:e}")
}
