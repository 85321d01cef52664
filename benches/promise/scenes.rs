//! Random scenes, by the templates of `families.txt`.

use super::random::Random;
use super::template::filled;

/// Units are between 1/`LARGEST` and `LARGEST`.
const LARGEST: f64 = 1e12;

/// Draws a case of a family without an accuracy: its text, and settings; and whether it is in random units.
pub(crate) fn drawn(template: &str, random: &mut Random) -> (String, Vec<String>, bool) {
    let is_in_units = random.sign() < 0.0;
    let (mut text, mut newtonian, mut around) = (String::new(), None, None);
    for line in template.lines() {
        match (line.strip_prefix("newtonian "), line.strip_prefix("around ")) {
            (Some(line), _) => newtonian = line.split_once(' '),
            (_, Some(line)) => around = line.split_once(' '),
            _ => text += &format!("{line}\n"),
        }
    }
    if let Some((axes, potential)) = newtonian {
        text += &newtonian_keys(axes, potential, around);
    }
    let units = if text.contains("potential") { "LE" } else { "ABCK" };
    let mut unit = || if is_in_units { random.scale(1.0 / LARGEST, LARGEST) } else { 1.0 };
    let units = units.chars().filter(|name| text.contains(*name));
    let mut settings: Vec<String> = units.map(|name| format!("parameters.{name}={:e}", unit())).collect();
    settings.push(format!("parameters.N={}", random.scale(0.3, 1000.0)));
    if !text.contains("gamma_f") {
        settings.push("grid.gamma_f=\"N\"".to_owned());
    }
    (filled(&text, random), settings, is_in_units)
}

/// The keys of a scene of Newton's law in units.
fn newtonian_keys(axes: &str, potential: &str, around: Option<(&str, &str)>) -> String {
    let letters: Vec<String> = axes.to_uppercase().chars().map(String::from).collect();
    let next = letters.iter().cycle().skip(1);
    let terms = letters.iter().zip(next).map(|(own, next)| potential.replace('@', own).replace('&', next));
    let terms: Vec<String> = terms.take(if potential.contains('@') { axes.len() } else { 1 }).collect();
    let names: Vec<String> = axes.chars().map(String::from).collect();
    let mut text = format!("potential.coordinates = {names:?}\npotential.formula = \"E*({})\"\n", terms.join(" + "));
    text += "particle.law = \"newtonian\"\n";
    for (name, letter) in names.iter().zip(&letters) {
        text += &format!("particle.masses.{name} = \"E/L^2\"\npotential.definitions.{letter} = \"{name}/L\"\n");
        if let Some((place, velocity)) = around {
            text += &format!("initial.{name} = \"L*(<-{place}:{place}>)\"\n");
            text += &format!("initial.{name}_dot = \"L*(<-{velocity}:{velocity}>)\"\n");
        }
    }
    text
}
