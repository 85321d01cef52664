//! Random scenes, by the templates of `families.txt`: the case that is run, and what the references need to know of it.

use geodesic_ivp::geometry::value_of;
use geodesic_ivp::number::{Extended, Real};

use super::random::Random;
use super::template::filled;

/// A function with a kink or a jump, by its name in templates: what it is in a case, before and behind its argument,
/// and where the argument is negative and where it is positive.
const SWITCHES: [(&str, &str, [&str; 2]); 3] =
    [("step{", "step(", ["0*(", "1 + 0*("]), ("ramp{", "max(0, ", ["0*(", "("]), ("abs{", "abs(", ["-(", "("])];
/// The share of scenes in the relativistic law, where a template leaves the choice, and of runs that go back.
const RELATIVISTIC: f64 = 0.25;
const BACKWARD: f64 = 0.15;

/// The unit of dyadic numbers.
const UNIT: f64 = 1.0 / 16_777_216.0;

/// A place of a coordinate where formulas have kinks or jumps: `sign` is that of q − `place` where their argument is
/// positive.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kink {
    pub(crate) coordinate: String,
    pub(crate) place: f64,
    pub(crate) sign: f64,
}

/// Something at a place of a coordinate that is so wide.
#[derive(Debug, Clone)]
pub(crate) struct Feature {
    pub(crate) coordinate: String,
    pub(crate) place: f64,
    pub(crate) width: f64,
}

/// A part of the text of the references.
#[derive(Debug, Clone)]
enum Part {
    Text(String),
    /// A function of [`SWITCHES`], the index of its kink, and its argument.
    Switch(usize, usize, String),
}

/// A scene without a scheme.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scene {
    /// The case that is run.
    pub(crate) text: String,
    /// Keys besides, of the run and of the references.
    pub(crate) settings: Vec<String>,
    parts: Vec<Part>,
    pub(crate) kinks: Vec<Kink>,
    pub(crate) features: Vec<Feature>,
    /// A time in which little happens far from all features.
    pub(crate) pace: f64,
    pub(crate) length: f64,
    /// True if t is given: in Newton's law.
    pub(crate) is_newtonian: bool,
    /// True if trust in a run is wrong, whatever its error.
    pub(crate) is_untrue: bool,
}

/// The names of numbers with their decimals, in order.
type Numbers = Vec<(String, String)>;

impl Scene {
    /// Draws a scene of a template.
    pub(crate) fn drawn(template: &str, random: &mut Random) -> Self {
        let is_backward = template.contains("@v") && random.between(0.0, 1.0) < BACKWARD;
        let (mut scene, mut numbers) = (Self::default(), Numbers::new());
        let (mut run, mut exact, mut shifted) = (Vec::new(), Vec::new(), None);
        let mut lines: Vec<String> = Vec::new();
        for line in template.lines() {
            let (is_dyadic, pairs) = (line.strip_prefix("dyadic "), line.strip_prefix("let "));
            if let Some(pairs) = is_dyadic.or(pairs) {
                for (name, formula) in pairs.split(", ").filter_map(|pair| pair.split_once(" = ")) {
                    let unit = if is_dyadic.is_some() { UNIT } else { 0.0 };
                    numbers.push((name.to_owned(), number_of(&put_in(&filled(formula, random), &numbers), unit)));
                }
            } else {
                lines.extend(repeated(line, &numbers).iter().map(|line| filled(line, random)));
            }
        }
        lines.push("grid.gamma_f = \"@v($L)\"".to_owned());
        // The tables of bodies come last.
        let first = lines.iter().position(|line| line.starts_with("[["));
        if let Some(first) = first {
            lines[first..].rotate_right(1);
        }
        for line in &lines {
            match line.split_once(' ').unwrap_or((line, "")) {
                ("pace", formula) => scene.pace = double(&put_in(formula, &numbers)),
                ("near", rest) => scene.features.push(feature(&put_in(rest, &numbers))),
                ("law", law) => {
                    scene.is_newtonian = law != "any" || random.between(0.0, 1.0) >= RELATIVISTIC;
                    scene.settings = keys_of_law(scene.is_newtonian, random);
                }
                ("exact", line) => exact.push(line.to_owned()),
                ("shifted", name) => shifted = Some(name.to_owned()),
                ("untrue", _) => scene.is_untrue = true,
                _ => run.push(line.clone()),
            }
        }
        scene.is_newtonian |= first.is_some();
        scene.length = double(&put_in("$L", &numbers));
        let key = |line: &str| line.split_once(" = ").map(|(key, _)| key.to_owned());
        let taken = |line: &String| exact.iter().find(|other| key(other) == key(line)).unwrap_or(line).clone();
        let reference: Vec<String> = run.iter().map(taken).collect();
        scene.text = plain(&turned(&put_in(&run.join("\n"), &numbers), is_backward));
        numbers.iter_mut().filter(|(name, _)| Some(name) == shifted.as_ref()).for_each(|(_, number)| {
            "0.0".clone_into(number);
        });
        scene.divide(&turned(&put_in(&reference.join("\n"), &numbers), false));
        scene
    }

    /// Finds the kinks in the text of the references.
    fn divide(&mut self, text: &str) {
        let mut rest = text;
        while let Some((at, function)) = next_switch(rest) {
            let (before, behind) = rest.split_at(at);
            let (argument, behind) = behind[SWITCHES[function].0.len()..].split_once('}').expect("a brace is closed");
            let (left, right) = argument.split_once(" - ").expect("a difference");
            // One of them is a number.
            let kink = value_of::<f64>(right, &[]).map_or_else(
                |_| Kink { coordinate: right.to_owned(), place: double(left), sign: -1.0 },
                |place| Kink { coordinate: left.to_owned(), place, sign: 1.0 },
            );
            let index = self.kinks.iter().position(|other| *other == kink).unwrap_or(self.kinks.len());
            if index == self.kinks.len() {
                self.kinks.push(kink);
            }
            self.parts.push(Part::Text(before.to_owned()));
            self.parts.push(Part::Switch(function, index, argument.to_owned()));
            rest = behind;
        }
        self.parts.push(Part::Text(rest.to_owned()));
    }

    /// The case of the references where the arguments of kinks have these signs. It goes forward.
    pub(crate) fn smooth(&self, is_positive: &[bool]) -> String {
        let text = |part: &Part| match part {
            Part::Text(text) => text.clone(),
            Part::Switch(function, kink, argument) => {
                format!("({}{argument}))", SWITCHES[*function].2[usize::from(is_positive[*kink])])
            }
        };
        self.parts.iter().map(text).collect()
    }
}

/// The place of the next function with a kink in a text, and its index.
fn next_switch(text: &str) -> Option<(usize, usize)> {
    let found = SWITCHES.iter().enumerate().filter_map(|(function, (name, ..))| Some((text.find(name)?, function)));
    found.min()
}

/// The text with functions of the grammar.
fn plain(text: &str) -> String {
    let (mut done, mut rest) = (String::new(), text);
    while let Some((at, function)) = next_switch(rest) {
        let (name, call, _) = SWITCHES[function];
        let (argument, behind) = rest[at + name.len()..].split_once('}').expect("a brace is closed");
        done += &format!("{}{call}{argument})", &rest[..at]);
        rest = behind;
    }
    done + rest
}

/// The text for a run forward or backward.
fn turned(text: &str, is_backward: bool) -> String {
    let [time, sign] = if is_backward { ["(-t)", "-"] } else { ["t", ""] };
    text.replace("@t", time).replace("@v", sign)
}

/// The text with numbers in the places of their names.
fn put_in(text: &str, numbers: &Numbers) -> String {
    numbers.iter().fold(text.to_owned(), |text, (name, number)| text.replace(&format!("${name}"), number))
}

/// The value of a formula as a decimal: in more digits, rounded once, to a multiple of `unit`, if above 0.
fn number_of(formula: &str, unit: f64) -> String {
    let value = value_of::<Extended>(formula, &[]).unwrap_or_else(|error| panic!("{formula}: {error}")).to_f64();
    format!("{:?}", if unit > 0.0 { (value / unit).round() * unit } else { value })
}

fn double(formula: &str) -> f64 {
    value_of(formula, &[]).unwrap_or_else(|error| panic!("{formula}: {error}"))
}

fn feature(line: &str) -> Feature {
    let words: Vec<&str> = line.split(' ').collect();
    Feature { coordinate: words[0].to_owned(), place: double(words[1]), width: double(words[2]) }
}

/// The keys of a law.
fn keys_of_law(is_newtonian: bool, random: &mut Random) -> Vec<String> {
    if is_newtonian {
        return vec!["particle.law=newtonian".to_owned()];
    }
    vec![format!("particle.c={:?}", random.scale(10.0, 100.0)), "initial.t_dot=1.0".to_owned()]
}

/// The lines that a line stands for.
fn repeated(line: &str, numbers: &Numbers) -> Vec<String> {
    let count = numbers.iter().find(|(name, _)| name == "N").map_or(0, |(_, number)| double(number) as usize);
    let at = |text: &str, i: usize| text.replace('#', &i.to_string()).replace('&', &(i + 1).to_string());
    if let Some(line) = line.strip_prefix("each ") {
        return (0..count).map(|i| at(line, i)).collect();
    }
    if let Some(line) = line.strip_prefix("rest ") {
        return (1..count).map(|i| at(line, i)).collect();
    }
    let (mut done, mut rest) = (String::new(), line);
    for (word, least) in [("[each ", 0), ("[pairs ", 1)] {
        if let Some((before, behind)) = rest.split_once(word) {
            let (part, behind) = behind.split_once(']').expect("a bracket is closed");
            done += before;
            done.extend((least..count).map(|i| at(part, i - least)));
            rest = behind;
        }
    }
    vec![done + rest]
}
