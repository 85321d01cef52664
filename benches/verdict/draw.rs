//! Random scenes in random schemes, as cases.

use std::fmt;

use geodesic_ivp::case::Case;

use super::random::Random;
use super::several::several;

/// A case, drawn.
pub(crate) struct Drawn {
    /// The kind of the scene, and the scheme.
    pub(crate) kind: &'static str,
    pub(crate) scheme: String,
    text: String,
    settings: Vec<String>,
}

impl fmt::Display for Drawn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:\n{}with {}", self.kind, self.text, self.settings.join(", "))
    }
}

/// The difference operators, with the least numbers of their nodes.
const OPERATORS: [(&str, u64); 4] = [("SBP21", 4), ("SBP42", 8), ("SBP63", 12), ("SBP84", 16)];
/// The most nodes of a window of the doubled system, which costs more.
const DOUBLED: u64 = 64;

impl Drawn {
    /// Every second one has several coordinates.
    pub(crate) fn new(random: &mut Random) -> Self {
        let scene = any(random);
        let (scheme, settings) = scheme(random);
        Self { kind: scene.0, scheme, text: scene.1, settings }
    }

    /// The same, but to an accuracy.
    pub(crate) fn accurate(random: &mut Random, scene: fn(&mut Random) -> (&'static str, String)) -> Self {
        let (kind, text) = scene(random);
        let settings = vec![format!("solver.accuracy={:e}", random.scale(1e-12, 1e-4))];
        Self { kind, scheme: "accuracy".to_owned(), text, settings }
    }

    pub(crate) fn case(&self) -> Case {
        Case::parse(self.kind, &self.text, &self.settings).unwrap_or_else(|error| panic!("{self}\n{error}"))
    }
}

/// The kind of a scene of any sort, and a case with it but without a scheme.
pub(crate) fn any(random: &mut Random) -> (&'static str, String) {
    match random.next() % 8 {
        0 | 1 => smooth(random),
        2 | 3 => rough(random),
        4 => ridge(random),
        _ => several(random),
    }
}

/// A scheme from coarse to fine, and the settings that choose it.
fn scheme(random: &mut Random) -> (String, Vec<String>) {
    if random.next().is_multiple_of(7) {
        return ("accuracy".to_owned(), vec![format!("solver.accuracy={:e}", random.scale(1e-12, 1e-2))]);
    }
    let form = ["strong", "weak"][random.next() as usize % 2];
    let is_doubled = random.next().is_multiple_of(8);
    let (name, nodes) = match random.next() % 6 {
        4 | 5 => {
            let nodes = 2 + random.next() % 23;
            (format!("GLL{nodes}"), nodes)
        }
        k => {
            let (name, least) = OPERATORS[k as usize];
            let most = if is_doubled { DOUBLED } else { 1500 };
            (name.to_owned(), random.scale(least as f64, most as f64) as u64)
        }
    };
    let windows = match random.next() % 3 {
        0 => 1,
        _ => random.scale(2.0, 60.0) as u64,
    };
    let settings = vec![
        format!("scheme.sbp={name}"),
        format!("scheme.form={form}"),
        format!("grid.n_gamma={nodes}"),
        format!("grid.windows={windows}"),
        format!("solver.system={}", if is_doubled { "doubled" } else { "physical-limit" }),
    ];
    let family = if name.starts_with("GLL") { "GLL" } else { name.as_str() };
    (format!("{family} {form}"), settings)
}

/// Smooth potentials, and the range of x at the start.
const SMOOTH: [(&str, [f64; 2]); 6] = [
    ("x^4/2", [0.2, 1.2]),
    ("x^2/2", [0.2, 1.2]),
    ("0.1*(1 - cos(x))", [0.2, 2.5]),
    ("0.3*(1 - exp(-x))^2", [-0.5, 1.5]),
    ("0.1*(x^2 - 1)^2", [0.2, 1.4]),
    ("0.2*x", [-1.0, 1.0]),
];

/// Smooth, to a value of γ or of t.
pub(crate) fn smooth(random: &mut Random) -> (&'static str, String) {
    let (formula, [low, high]) = SMOOTH[random.next() as usize % SMOOTH.len()];
    let c = [1.0, 1.0, 10.0][random.next() as usize % 3];
    let x = random.between(low, high);
    let x_dot = random.between(-0.4, 0.4);
    let end = random.scale(0.3, 60.0);
    let ends_at = ["gamma_f", "t_f"][random.next() as usize % 2];
    ("smooth", one_coordinate(formula, c, [x, 1.0, x_dot], (ends_at, end)))
}

/// One coordinate, and something in its potential that is no polynomial on a window.
pub(crate) fn rough(random: &mut Random) -> (&'static str, String) {
    let c: f64 = [1.0, 3.0, 10.0][random.next() as usize % 3];
    let strength = random.scale(0.05, 0.4) * c * c;
    let (kind, formula) = match random.next() % 6 {
        0 => ("cusp", format!("{strength}*sqrt(x^2 + {}^2)", random.scale(1e-3, 0.1))),
        1 => ("kink", format!("{strength}*abs(x - {})", random.between(-0.3, 0.3))),
        2 => ("wall", format!("{strength}*tanh({}*(x - 1))", random.scale(1.0, 200.0))),
        3 => ("power", format!("{strength}*x^{}", 2 * (2 + random.next() % 10))),
        4 => {
            let [place, width] = [random.between(-1.0, 1.0), random.scale(5e-3, 1.0)];
            ("hump", format!("{strength}*exp(-((x - {place})/{width})^2)"))
        }
        _ => {
            let s = random.scale(1e-3, 0.1);
            ("cusps", format!("{strength}*(sqrt((x - 0.3)^2 + {s}^2) + abs(x + 0.2))"))
        }
    };
    let t_dot = random.scale(1.0, 4.0);
    let start = [random.between(-0.9, 0.9), t_dot, random.between(-0.6, 0.6) * c * t_dot];
    let end = ("gamma_f", random.scale(0.5, 12.0) / t_dot);
    (kind, one_coordinate(&formula, c, start, end))
}

/// Writes a case without a scheme from V, c, the start in x, dt/dγ and dx/dγ, and the name of the end with its value.
fn one_coordinate(formula: &str, c: f64, [x, t_dot, x_dot]: [f64; 3], (name, end): (&str, f64)) -> String {
    format!(
        "[potential]\nformula = \"{formula}\"\n[particle]\nc = {c:?}\n[initial]\nx = {x:?}\nt_dot = {t_dot:?}\n\
         x_dot = {x_dot:?}\n[grid]\n{name} = {end:?}\n"
    )
}

/// Two coordinates, and a ridge across their way.
fn ridge(random: &mut Random) -> (&'static str, String) {
    let law = ["law = \"newtonian\"", "c = 4.0"][random.next() as usize % 2];
    let t_dot = if law.starts_with('c') { "t_dot = 1.0\n" } else { "" };
    let (height, place, width) = (random.between(-0.3, 0.3), random.between(-0.5, 0.5), random.scale(5e-3, 0.5));
    let [x, y, x_dot, y_dot] = [0; 4].map(|_| random.between(-0.7, 0.7));
    let end = random.scale(1.0, 30.0);
    let text = format!(
        "[potential]\ncoordinates = [\"x\", \"y\"]\n\
         formula = \"(x^2 + y^2)/2 + x^2*y/5 + {height:?}*exp(-((x + y - {place:?})/{width:?})^2)\"\n\
         [particle]\n{law}\n[initial]\nx = {x:?}\ny = {y:?}\nx_dot = {x_dot:?}\ny_dot = {y_dot:?}\n{t_dot}\
         [grid]\ngamma_f = {end:?}\n"
    );
    ("ridge", text)
}
