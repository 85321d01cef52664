//! Malformed scenes: each is refused with what is wrong, and with its place in the text. The mistakes that keys and
//! values have by themselves are all told at once.

use geodesic_ivp::case::Case;

use super::{KEPLER, KERR, SCHWARZSCHILD};
use crate::world_lines::acting::BALL;
use crate::world_lines::bodies::{BODIES, DUST};

/// Behind @ stands a part of a valid text, or (end). A row has what takes its place, or with (and) follows it on a line
/// of its own; words of the message about it; and the text at the place that it points at.
const METRIC: &str = r#"@ "t", "r", "phi"
"t", "r", "2phi" | '2phi' cannot be written in a formula | "2phi"
"gamma", "r", "phi" | 'gamma': it is reserved | "gamma"
"t", "window", "phi" | 'window': it is reserved | "window"
"t", "norm", "phi" | 'norm': it is reserved | "norm"
"t", "r_dot", "phi" | end in _dot are those of velocities | "r_dot"
"t", "p_r", "phi" | names that begin with p_ are reserved | "p_r"
"t", "delta_r", "phi" | names that begin with delta_ | "delta_r"
"t", "eps_r", "phi" | names that begin with eps_ | "eps_r"
"t", "error_r", "phi" | names that begin with error_ | "error_r"
"t", "pi", "phi" | 'pi': it has a meaning in formulas | "pi"
"t", "sin", "phi" | 'sin': it has a meaning in formulas | "sin"
"t", "r", "r" | the coordinate 'r' is given twice | "r"
"t", "r", 3 | must have strings only, found integer | 3
@ ["t", "r", "phi"]
[] | at least one coordinate | []
"t" | 'metric.coordinates' must be an array of strings, found string | "t"
@ { m = 1.0 }
{ m = "n/2", n = "2*m" } | the definitions are circular: m -> n -> m | "n/2"
{ m = 1.0, r = 2 } | the parameter name 'r' is already that of a coordinate | r
{ m = 1.0, r_dot = 2 } | 'r_dot' is already that of a velocity | r_dot
{ m = 1.0, p_t = 2 } | 'p_t' is already that of a momentum | p_t
{ m = 1.0, norm = 2 } | 'norm' is already that of the norm | norm
{ m = 1.0, exp = 2 } | 'exp' already has a meaning in a formula | exp
{ m = 1.0, "a b" = 2 } | 'a b' cannot be written in a formula | "a b"
{ m = "ln(0)" } | 'metric.parameters.m' is not a finite number | "ln(0)"
{ m = nan } | must be a finite number, got NaN | nan
{ m = "2*r" } | unknown name 'r' | r
3 | 'metric.parameters' must be a table, found integer | 3
@ f = "1 - 2*m/r"
f = "1 - 2*m/r", m = "2" | the definition name 'm' is already that of a parameter | m
f = "1 - 2*m/r", phi = "2" | 'phi' is already that of a coordinate | phi
f = "1 - g", g = "f*r" | the definitions are circular: f -> g -> f | "1 - g"
f = "1 - 2*M/r" | unknown name 'M' | M
f = "f*r" | the definitions are circular: f -> f | "f*r"
f = "g", g = "2*h", h = "g*r" | the definitions are circular: g -> h -> g | "2*h"
f = "g(r)" | unknown function 'g' | g
@ "phi phi" = "-r^2"
"phi" = "-r^2" | must name two coordinates | "phi"
"phi phi phi" = 1 | must name two coordinates | "phi phi phi"
"phi ph" = "-r^2" | unknown coordinate 'ph' | "phi ph"
"phi phi" = "-r^2", "t phi" = "r", "phi t" = "2*r" | is given twice: here, and as "t phi" at line 4, column 65 | "phi t"
"phi phi" = "-r^2", "phi  phi" = "-r^2" | is given twice | "phi  phi"
"phi phi" = 0 | no component with 'phi' is given | { "t t" = "f", "r r" = "-1/f", "phi phi" = 0 }
"phi phi" = true | must be a number or a formula, found boolean | true
"phi phi" = inf | must be a finite number, got inf | inf
"phi phi" = "-r^^2" | (character 4 of the expression) | ^
"phi phi" = "-rho^2" | unknown name 'rho' | r
"phi phi" = "-r_dot^2" | unknown name 'r_dot' | r
@ , "phi phi" = "-r^2"
 | no component with 'phi' is given | { "t t" = "f", "r r" = "-1/f" }
@ "t t" = "f", "r r" = "-1/f"
"t t"=1, "t r"=1, "r r"=1 | is zero everywhere (coordinates t, r) | { "t t"=1, "t r"=1, "r r"=1, "phi phi" = "-r^2" }
@ components = {
component = { | unknown field `component`, expected one of `coordinates` | component
@ coordinates = ["t", "r", "phi"]\n
 | missing field `coordinates` | [metric]
@ { m = 1.0 } (and)
one_form = { q = "r" } | unknown coordinate 'q' in 'metric.one_form.q' | q
one_form = { t = "r_dot" } | unknown name 'r_dot' | r
conformal = "1 +" | found the end (character 4 of the expression) | 
force = { rr = "r" } | unknown coordinate 'rr' in 'metric.force.rr' | rr
preset = "kerr" | 'metric.coordinates' and 'metric.preset' are both | coordinates
@ [initial]
[particle]\nmass = 2\n[initial] | belongs to a potential | [particle]
[potential]\nfree = {}\n[initial] | both a metric and a potential are given | potential
[initals] | unknown field `initals` | initals
@ r = 10.0\n
 | missing field `r` | [initial]
r = 2\n | the metric is degenerate at the start: the determinant of the components of t is 0 | 2
r = 0\n | the metric is degenerate at the start | 0
r = "R"\n | unknown name 'R' | R
r = "1/0"\n | 'initial.r' is not a finite number | "1/0"
r = [10]\n | must be a number, a formula or two ends, found an array of 1 | [10]
@ r_dot = -0.05
rdot = -0.05 | unknown field `rdot` | rdot
solve = { r_dot = "+" } | solve is given without norm | solve
norm = 1\nsolve = { r_dot = "up" } | the sign of a root is "+" or "-" | "up"
norm = 1\nsolve = { r_dt = "+" } | unknown velocity or momentum `r_dt` | r_dt
norm = 1\nsolve = {} | exactly one velocity or momentum, and names 0 | {}
norm = 1\nsolve = {r_dot="+", p_t="+"} | exactly one velocity or momentum, and names 2 | {r_dot="+", p_t="+"}
norm = "spacelike"\nsolve = { r_dot = "+" } | unknown name 'spacelike' | s
norm = 2\nsolve = { r_dot = "+" } | no real r_dot gives K = 2: K is at most 1.06 | { r_dot = "+" }
@ r_dot = -0.05 (and)
p_r = 1 | both r_dot and p_r are given | p_r
norm = 1 | norm is given, and nothing to solve for | norm
norm = 1\nsolve = { r_dot = "+" } | 'initial.r_dot' is given, so there is nothing to solve for | { r_dot = "+" }
@ r_dot = -0.05\n
 | neither r_dot nor p_r is given | [initial]
@ t_dot = 1.2\nr_dot = -0.05\nphi_dot = 0.03
t_dot = 0\nr_dot = 0\nphi_dot = 0 | would be a point | [initial]
@ gamma_f = 40.0
gamma_f = 0 | gamma_f = 0 must be another value than gamma_i = 0 | 0
t_f = 0 | t_f = 0 must be another time than the initial t = 0 | 0
gamma_f = "tau" | unknown name 'tau' | t
gamma_f = 1\ngamma_i = 1e-20\nn_gamma = 13 | GLL12 has 12 nodes, got n_gamma = 13 | 13
windows = 0 | windows must be at least 1 | 0
n_gama = 12 | unknown field `n_gama` | n_gama
until = "R - 3" | unknown name 'R' | R
until = "p_r" | unknown name 'p_r' | p
@ gamma_f = 40.0 (and)
t_f = 3 | both gamma_f and t_f are given | t_f
windows = 3\n[solver]\naccuracy = 1e-8 | both solver.accuracy and grid.windows are given | windows
n_gamma = 30\n[solver]\naccuracy = 1e-8 | both solver.accuracy and grid.n_gamma are given | n_gamma
@ sbp = "GLL12"\n
 | missing field `sbp` | [scheme]
@ sbp = "GLL12"
sbp = "SBP42" | missing field `n_gamma` | [grid]
sbp = "SBP43" | unknown operator | "SBP43"
@ form = "weak"
form = "week" | unknown form | "week"
regularised = false | regularised = false needs solver.system | false
form = "weak | |
@ (end)
[solver]\naccuracy = 2.0 | accuracy must lie between 0 and 1 | 2.0
[solver]\naccuracy = "1e-8" | must be a number | "1e-8"
[solver]\naccuracy = 1e-8\ndigits = 30 | solver.accuracy and solver.digits exclude each other | 30
[solver]\naccuracy = 1e-8\nsystem = "doubled" | solver.accuracy needs system = "physical-limit" | "doubled"
[solver]\ndigits = 80 | digits must be from 16 to 70, got 80 | 80
[solver]\nsystem = "double" | unknown variant `double` | "double"
[solver]\nmax_iterations = 0 | must be at least 1 | 0
[solver]\nmax_iterations = 1.5 | must be a whole number | 1.5
[expect]\nr_final = 1 | final coordinates need a tolerance | [expect]
[expect]\ngamma_final = 1 | final coordinates need a tolerance | [expect]
[expect]\nx_final = 1 | unknown field `x_final` | x_final
[expect]\nr_final = 1\ntolerance = 0 | tolerance must be positive | 0
[expect]\nstatus = "fine" | unknown variant `fine` | "fine"
[invariants]\nk = "p_r" | delta_k has a meaning already | k
[invariants]\nl = "p_x" | unknown name 'p_x' | p
[events]\nl = "r" | 'events.l' must be a table, found string | "r"
[events]\ngamma = { when = "r" } | an event cannot have the name 'gamma' | gamma
[events]\nwindow = { when = "r" } | an event cannot have the name 'window' | window
[events]\nevent = { when = "r" } | an event cannot have the name 'event' | event
[events]\nl = { until = true } | the event 'l' has no `when` | { until = true }
[events]\nl = { when = "r_dot", direction = "dwn" } | unknown direction "dwn" | "dwn"
[plot]\nx = "r" | missing field `y` | [plot]
[plot]\nx = "r"\ny = "z" | unknown name 'z' | z
"#;

const NEWTON: &str = r#"@ ["x", "y"]
["x", "t"] | the scene adds a coordinate of that name itself | "t"
["x", "s"] | the scene adds a coordinate of that name itself | "s"
["x"] | unknown name 'y' | y
@ formula = "-1/sqrt(x^2 + y^2)"\n
 | no potential is given | [potential]
@ formula = "-1/sqrt(x^2 + y^2)"
free = {}\nformula = "x" | more than one potential is given | formula
formula = "x"\nparameters = { s = 1 } | 's' is already that of a coordinate that the scene adds itself | s
formula = "x"\nparameters = { p_s = 1 } | 'p_s' is already that of a momentum | p_s
formula = "x"\ndefinitions = { t = "x" } | 't' is already that of a coordinate that the scene adds itself | t
quartic = { kappa = 1 } | is for one coordinate, and there are 2 | quartic
formula = { parameters = {} } | missing field `expression` | { parameters = {} }
formula = "u" | unknown name 'u' | u
formula = "x*s" | unknown name 's' | s
formula={expression="k*x", parameters={k=1}}\nparameters={k=2} | name 'k' is already that of a parameter | k
@ [particle]
one_form = { s = "x" }\n[particle] | unknown coordinate 's' | s
force = { x = "-x_dt" }\n[particle] | unknown name 'x_dt' | x
@ law = "newtonian"
law = "newtonain" | unknown law "newtonain" | "newtonain"
law = "relativistic"\nc = "ln(0)" | not a finite number | "ln(0)"
law = "relativistic" | neither t_dot nor p_t is given | [initial]
@ law = "newtonian" (and)
c = 1 | Newton's law has no speed of light | c
mass = "0/0" | not a finite number | "0/0"
masses = { x = 1, y = "heavy" } | unknown name 'heavy' | h
mass = 0 | particle.mass must be positive, got 0 | 0
masses = { x = 1 } | has no mass for the coordinate 'y' | { x = 1 }
masses = { x = 1, y = 1, z = 2 } | unknown coordinate 'z' | z
masses = { x = 1, y = -1 } | must be positive, got -1 | -1
mass = 1\nmasses = { x = 1, y = 1 } | both mass and masses | mass
@ law = "newtonian"\n\n[initial]
law = "relativistic"\n\n[initial]\nt_dot = 1 | must be positive and finite at the start, got -19 | [initial]
@ y_dot = "sqrt(19)"
y_dot = 1\ns_dot = 3 | a newtonian scene has K = 0 | [initial]
norm = 1\nsolve = { y_dot = "+" } | a newtonian case has norm = 0, got 1 | 1
norm = 0\nsolve = { y_dot = "+" } | neither s_dot nor p_s is given | [initial]
velocity = 3 | both x_dot and velocity are given | velocity
@ x = 0.1\n
x = 0\n | not finite | [initial]
from = "none"\n | unknown field `y` | y
@ t_f = "2*pi"
t_f = 0 | t_f = 0 must be another time than the initial t = 0 | 0
t_f = 1\nwindows = 1_000_000_000 | above the limit | 1_000_000_000
gamma_i = 1e20\ngamma_f = 1.0000000000000001e20 | too small or too large | 1.0000000000000001e20
@ n_gamma = 64
n_gamma = 4 | SBP42 needs at least 8 points, got n_gamma = 4 | 4
"#;

const PRESET: &str = r#"@ "kerr"
"ker" | unknown preset "ker" | "ker"
4 | 'metric.preset' must be a string, found integer | 4
@ a = 0.9
b = 0.9, a = 0.9 | the preset "kerr" has no parameter 'b' | b
sigma = 0.9, a = 0.9 | 'sigma' is no parameter of the preset | sigma
@ w = "2*m*r/sigma"
m = "2" | 'm' is no definition of the preset | m
v = "2*m" | has no definition 'v' | v
w = "sigma", sigma = "w" | the definitions are circular | "w"
@ theta = "pi/2"
theta = 0 | the metric is degenerate at the start | [initial]
@ norm = "timelike"
norm = "timelik" | unknown name 'timelik' | t
@ p_t = "e"
p_t = "0*e + 0.5" | no real r_dot gives K = 1 | { r_dot = "+" }
@ gamma_f = 100
gamma_f = "a - a" | must be another value than gamma_i | "a - a"
"#;

const EVENTS: &str = r#"@ set = { z_dot = "-0.9*z_dot" }
set = { w_dot = "1" } | unknown coordinate 'w' in 'events.floor.set.w_dot' | w_dot
set = { g = "1/w" } | unknown name 'w' | w
set = { z_dot = "-z_do" } | unknown name 'z_do' | z
set = { z_dot = "1", p_z = "1" } | velocities or momenta, not both | set
set = {} | set is empty | set
set = { s_dot = "1" } | s follows from the energy | floor
set = { t = "1" } | t runs by itself | floor
set = { z_dot = "1" }, until = true | both until and set | set
@ gamma_f = 5.0
gamma_f = -5.0 | the run goes backward | floor
@ parameters = { g = 9.81 }
parameters = { g = 9.81 }, conformal = "1 + z^2" | conformal factor | floor
@ solver.accuracy = 1e-11\n
grid.windows = 20\nscheme = { sbp = "GLL16", form = "weak" }\n | acts where windows end | floor
"#;

const PAIRS: &str = r#"@ mass = 1.0
mass = -1.0 | a mass must not be negative | -1.0
mas = 1.0 | unknown field `mas` | mas
@ position = [1.0, 0.0]
position = [1.0, 0.0, 0.0] | two or three numbers each | [0.0, 1.25]
@ "planet"
"sun" | the coordinate 'x_sun' is given twice | "sun"
@ m_1*m_2/r
m_1*m_3/r | unknown name 'm_3' | "-g*m_1*m_3/r"
@ formula = "-g*m_1*m_2/r", 
 | missing field `formula` of [pair] | { parameters = { g = 2.0, mu = 1e-3 } }
@ g = 2.0
r = 2.0 | 'r' has a meaning in the formula of a pair | r
@ pair = {
potential.formula = "x"\npair = { | both [[body]] and [potential] are given | potential
initial.x_sun = 1.0\npair = { | unknown field `x_sun`, expected one of `from`, `t` | x_sun
"#;

/// Returns the rows that do not hold, and how many there are.
fn complaints(base: &str, rows: &str) -> (Vec<String>, usize) {
    let (mut complaints, mut count, mut from) = (Vec::new(), 0, String::new());
    for line in rows.lines() {
        let line = line.replace("\\n", "\n");
        if let Some(part) = line.strip_prefix("@ ") {
            from = part.to_owned();
            continue;
        }
        let parts: Vec<&str> = line.split('|').map(|part| part.trim_matches(' ')).collect();
        let [to, fragment, place] = parts[..] else { panic!("{line} is no row") };
        let text = match from.strip_suffix(" (and)") {
            _ if from == "(end)" => format!("{base}{to}"),
            part => {
                let (part, kept) = part.map_or((&from[..], String::new()), |part| (part, format!("{part}\n")));
                assert!(base.contains(part), "{part} is not in the text");
                base.replacen(part, &(kept + to), 1)
            }
        };
        count += 1;
        let error = match Case::parse("case", &text, &[]) {
            Ok(_) => {
                complaints.push(format!("{to}: accepted"));
                continue;
            }
            Err(error) => error,
        };
        let found = error.span.clone().and_then(|span| error.text.get(span));
        if !error.message.contains(fragment) {
            complaints.push(format!("{to}: the message is \"{}\"", error.message));
        }
        // A table without a place of its own is pointed at by its header.
        if found.is_none_or(|found| {
            !place.is_empty() && found != place && !(place.starts_with('[') && found.starts_with(place))
        }) {
            complaints.push(format!("{to}: points at {found:?} ({:?}): {}", error.span, error.message));
        }
    }
    (complaints, count)
}

#[test]
fn every_mistake_is_refused_at_its_place() {
    let texts = [(SCHWARZSCHILD, METRIC), (KEPLER, NEWTON), (KERR, PRESET), (BALL, EVENTS), (BODIES, PAIRS)];
    let (wrong, counts): (Vec<_>, Vec<_>) = texts.into_iter().map(|(base, rows)| complaints(base, rows)).unzip();
    assert!(counts.iter().sum::<usize>() >= 177 && wrong.concat().is_empty(), "{}", wrong.concat().join("\n"));
}

/// Bodies that are not there, or without the masses that are needed.
#[test]
fn pairs_need_bodies_and_bodies_masses() {
    for (text, words) in [
        ("pair.formula = '1/r'\ngrid.t_f = 1.0\n".to_owned(), "[pair] needs bodies"),
        (format!("pair.formula = '1/r'\ngrid.t_f = 1.0\n{DUST}"), "at least one body must have a mass"),
        (format!("{}{DUST}", BODIES.replace("-g*m_1*m_2/r", "g*r^2")), "a body without mass needs an energy"),
    ] {
        let error = Case::parse("bodies", &text, &[]).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn what_was_meant_is_said() {
    for (base, from, to, help) in [
        (SCHWARZSCHILD, "r_dot", "rdot", "did you mean `r_dot`?"),
        (SCHWARZSCHILD, "components", "component", "did you mean `components`?"),
        (SCHWARZSCHILD, "\"phi phi\"", "\"phi ph\"", "did you mean 'phi'?"),
        (SCHWARZSCHILD, "gamma_f = 40.0", "digits = 20", "did you mean `solver.digits`?"),
        (SCHWARZSCHILD, "[initial]", "[initals]", "did you mean `initial`?"),
        (KERR, "\"kerr\"", "\"kerr-shild\"", "did you mean \"kerr-schild\"?"),
        (KEPLER, "newtonian", "newtonain", "did you mean \"newtonian\"?"),
        (KEPLER, "sqrt(x^2", "sqrtt(x^2", "did you mean 'sqrt'?"),
        (KEPLER, "-1/sqrt(x^2 + y^2)", "u", "known are t, x, y, pi, numbers"),
        (KERR, "a = 0.9", "ma = 0.9", "it has m, a"),
    ] {
        assert!(base.contains(from));
        let error = Case::parse("case", &base.replacen(from, to, 1), &[]).unwrap_err();
        assert!(error.help.as_ref().is_some_and(|found| found.contains(help)), "{to}: {error}: {:?}", error.help);
    }
}

/// Whatever is missing or doubled, the answer is a scene or a mistake with a place; nothing panics.
#[test]
fn damaged_texts_are_read_or_refused() {
    for base in [SCHWARZSCHILD, KEPLER, KERR] {
        let lines: Vec<&str> = base.lines().collect();
        let without = (0..lines.len()).map(|k| [&lines[..k], &lines[k + 1..]].concat().join("\n"));
        let doubled = (0..lines.len()).map(|k| [&lines[..=k], &lines[k..]].concat().join("\n"));
        let cut = (0..base.len()).map(|end| base[..end].to_owned());
        let holes = (0..base.len()).map(|at| format!("{}{}", &base[..at], &base[at + 1..]));
        for text in without.chain(doubled).chain(cut).chain(holes) {
            match Case::parse("case", &text, &[]) {
                Ok(scene) => {
                    let (start, _) = (scene.start::<f64>(), scene.warnings());
                    assert!(start.q_dot.iter().chain(&start.p).all(|value| value.is_finite()), "{text}");
                    assert_eq!(Case::parse("case", &scene.to_toml(), &[]).as_ref(), Ok(&scene), "{text}");
                }
                Err(error) => {
                    let place = error.span.clone().and_then(|span| error.text.get(span));
                    assert!(place.is_some(), "{error} has no place in\n{text}");
                }
            }
        }
    }
}

/// All that keys and values have wrong by themselves is told at once, in the order of the text.
#[test]
fn the_mistakes_of_keys_and_values_are_all_found_at_once() {
    let text = r#"
titel = "Six"
[potential]
coordinates = ["x", 1]
formula = { expression = 2, parametres = {} }
[particle]
law = "newton"
[grid]
n_gamma = 3.5
windows = 0
[scheme]
sbp = "SBP22"
[solver]
digits = 99
accuracy = 2
[events]
up = { when = "x", direction = "left", unti = true }
"#;
    let error = Case::parse("case", text, &[]).unwrap_err();
    let all: Vec<_> = std::iter::once(&error).chain(&error.further).collect();
    let places: Vec<&str> = all.iter().map(|error| &text[error.span.clone().unwrap()]).collect();
    let expected = "titel 1 2 parametres \"newton\" 3.5 0 \"SBP22\" 99 2 \"left\" unti";
    assert_eq!(places.join(" "), expected);
    assert!(error.to_string().ends_with("(and 11 more mistakes)"), "{error}");
}

/// Where nothing says what the coordinates are, that is what is wrong, and not their names.
#[test]
fn coordinates_of_an_unknown_geometry_are_no_unknown_keys() {
    let text = "[initial]\nr = 1.0\nr_dot = 0.0\n[scheme]\nsbp = \"GLL8\"\n";
    let error = Case::parse("case", text, &[]).unwrap_err();
    assert!(error.message.starts_with("missing field") && error.further.is_empty(), "{error}");
}
