//! Templates of cases: texts with places for random numbers.

use super::random::Random;

/// The families of a text: their names and templates, which blank lines separate. A comment comes first.
pub(crate) fn families(text: &'static str) -> Vec<(&'static str, &'static str)> {
    let families = text.trim_end().split("\n\n").skip(1);
    families.map(|family| family.split_once('\n').expect("a name and a template")).collect()
}

/// The text with numbers and choices in the places of what is in angle brackets: `<a:b>` is a number between a and b,
/// `<a~b>` one with an even logarithm, `<a..b>` a whole one with an even logarithm, and `<p|q>` one of several texts.
pub(crate) fn filled(text: &str, random: &mut Random) -> String {
    let mut parts = text.split('<');
    let mut filled = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (choice, rest) = part.split_once('>').expect("a bracket is closed");
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let texts: Vec<&str> = choice.split('|').collect();
        let ends = |separator: &str| choice.split_once(separator).map(|(low, high)| [number(low), number(high)]);
        filled += &if texts.len() > 1 {
            texts[random.next() as usize % texts.len()].to_owned()
        } else if let Some([low, high]) = ends("..") {
            random.scale(low, high + 1.0).floor().to_string()
        } else if let Some([low, high]) = ends(":") {
            random.between(low, high).to_string()
        } else if let Some([low, high]) = ends("~") {
            random.scale(low, high).to_string()
        } else {
            choice.to_owned()
        };
        filled += rest;
    }
    filled
}
