//! Families of random scenes.

use geodesic_ivp::geometry::{GeometryText, Law, MetricText, PotentialText, Preset};

use super::random::Random;

/// A scene as text, its start, and dq/dγ there.
pub(crate) type Scene = (GeometryText, Vec<f64>, Vec<f64>);

const NAMES: [&str; 3] = ["x", "y", "z"];

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

/// Newton's law in a potential.
fn potential(expression: impl Into<String>, dimension: usize) -> PotentialText {
    PotentialText {
        coordinates: names(&NAMES[..dimension]),
        expression: expression.into(),
        mass: "1".to_owned(),
        masses: vec!["1".to_owned(); dimension],
        c: "1".to_owned(),
        law: Law::Newtonian,
        ..PotentialText::default()
    }
}

fn at(text: PotentialText, x: &[f64], v: &[f64]) -> Scene {
    (GeometryText::Potential(text), [&[0.0], x, &[0.0]].concat(), [&[1.0], v, &[0.0]].concat())
}

/// A start somewhere around the origin.
fn around(draw: &mut Random, text: PotentialText, [place, velocity]: [f64; 2]) -> Scene {
    let n = text.coordinates.len();
    let (x, v) = (vector(draw, n, place), vector(draw, n, velocity));
    at(text, &x, &v)
}

/// A potential with a term for each coordinate and the next one.
fn terms(draw: &mut Random, n: usize, sizes: [f64; 2], term: fn(&mut Random, &str, &str) -> String) -> Scene {
    let terms: Vec<String> = (0..n).map(|k| term(draw, NAMES[k], NAMES[(k + 1) % n])).collect();
    around(draw, potential(terms.join(" + "), n), sizes)
}

fn metric(coordinates: &[&str], components: &[(usize, usize, String)], q: &[f64], v: &[f64]) -> Scene {
    let text = MetricText {
        coordinates: names(coordinates),
        components: components.iter().map(|(a, b, formula)| ([*a, *b], formula.clone())).collect(),
        ..MetricText::default()
    };
    (GeometryText::Metric(text), q.to_vec(), v.to_vec())
}

fn vector(draw: &mut Random, dimension: usize, size: f64) -> Vec<f64> {
    (0..dimension).map(|_| draw.between(-size, size)).collect()
}

fn polynomial(draw: &mut Random, n: usize) -> Scene {
    terms(draw, n, [0.8, 0.8], |draw, x, other| {
        let (own, quartic) = (draw.between(0.3, 1.5), draw.between(0.05, 0.5));
        let (skew, coupling) = (draw.between(-0.2, 0.2), draw.between(0.0, 0.3));
        format!("{own}*{x}^2 + {quartic}*{x}^4 + {skew}*{x}^2*{other} + {coupling}*{x}^2*{other}^2")
    })
}

fn trigonometric(draw: &mut Random, n: usize) -> Scene {
    terms(draw, n, [2.0, 1.5], |draw, x, other| {
        let (own, phase) = (draw.between(0.3, 1.5), draw.between(0.0, 6.0));
        let (coupling, ratio) = (draw.between(0.0, 0.5), draw.between(0.5, 1.5));
        format!("{own}*cos({x} + {phase}) + {coupling}*sin({x} - {ratio}*{other})")
    })
}

fn kepler(draw: &mut Random) -> Scene {
    let (e, angle) = (draw.between(0.0, 0.95), draw.between(0.0, std::f64::consts::TAU));
    let (r, sign) = if draw.sign() < 0.0 { (1.0 - e, 1.0) } else { (1.0 + e, -1.0) };
    let v = ((1.0 + sign * e) / r).sqrt();
    let (s, c) = angle.sin_cos();
    at(potential("-1/sqrt(x^2 + y^2)", 2), &[r * c, r * s], &[-v * s, v * c])
}

fn radial(draw: &mut Random) -> Scene {
    let e = draw.between(0.0, 0.95);
    let r = if draw.sign() < 0.0 { 1.0 - e } else { 1.0 + e };
    at(potential(format!("{}/(2*x^2) - 1/x", 1.0 - e * e), 1), &[r], &[0.0])
}

fn kerr(draw: &mut Random) -> Scene {
    let mut text = Preset::from_name("kerr").expect("there is a preset").text();
    text.parameters[1].1 = format!("{}", draw.between(0.1, 0.95));
    let (r, v) = (draw.between(8.0, 20.0), draw.between(0.9, 1.1));
    let orbit = v * r.powf(-1.5);
    let q = vec![0.0, r, draw.between(0.9, 2.2), 0.0];
    (GeometryText::Metric(text), q, vec![1.0, 0.0, 0.3 * orbit * draw.sign(), orbit])
}

fn schwarzschild(draw: &mut Random) -> Scene {
    let (r, v) = (draw.between(8.0, 30.0), draw.between(0.85, 1.15));
    let components = [(0, 0, "1 - 2/r".into()), (1, 1, "-1/(1 - 2/r)".into()), (2, 2, "-r^2".into())];
    metric(&["t", "r", "phi"], &components, &[0.0, r, 0.0], &[1.0, 0.0, v * r.powf(-1.5)])
}

fn oscillating(draw: &mut Random, k: f64) -> Scene {
    let components = [
        (0, 0, format!("1 + 0.4*sin({k}*y)")),
        (1, 1, format!("1 + 0.3*cos({k}*x)")),
        (0, 1, format!("0.2*sin({k}*(x - y)/2)")),
    ];
    let (q, v) = (vector(draw, 2, 1.0), vector(draw, 2, 1.0));
    metric(&["x", "y"], &components, &q, &v)
}

fn magnetic(draw: &mut Random) -> Scene {
    let mut text = potential(format!("(x^2 + y^2)/2 + {}*x^2*y^2", draw.between(0.0, 0.5)), 2);
    let b = draw.between(0.2, 3.0);
    text.one_form = vec![(0, format!("-{b}*y/2")), (1, format!("{b}*x/2*(1 + x^2/9)"))];
    around(draw, text, [0.8, 0.8])
}

fn conformal(draw: &mut Random) -> Scene {
    let components = [(0, 0, "1 + x^2/2".into()), (1, 1, "-1".into()), (2, 2, "-1 - x^2/5".into())];
    let (mut text, q, v) = metric(
        &["t", "x", "y"],
        &components,
        &[0.0, draw.between(-1.0, 1.0), 0.0],
        &[1.0, draw.between(-0.4, 0.4), draw.between(-0.4, 0.4)],
    );
    if let GeometryText::Metric(text) = &mut text {
        text.conformal = Some(format!("1 + {}*cos(y)", draw.between(0.05, 0.3)));
    }
    (text, q, v)
}

fn sphere(draw: &mut Random) -> Scene {
    let components = [(0, 0, "1".into()), (1, 1, "sin(theta)^2".into())];
    let v = [draw.sign() * draw.between(0.3, 1.0), draw.scale(1e-4, 1.0)];
    metric(&["theta", "phi"], &components, &[draw.between(0.8, 2.3), 0.0], &v)
}

fn scattering(draw: &mut Random) -> Scene {
    let bump = format!("{}*exp(-(x^2 + y^2)) + y^2/50 + x^2/50", draw.between(0.3, 3.0));
    let (x, v) = ([-draw.between(2.0, 6.0), draw.between(-1.0, 1.0)], [draw.between(0.5, 2.0), 0.0]);
    at(potential(bump, 2), &x, &v)
}

fn friction(draw: &mut Random) -> Scene {
    let mut text = potential("(x^2 + y^2)/2 + x^2*y^2/4", 2);
    let rate = draw.scale(1e-3, 0.3);
    text.force = vec![(0, format!("-{rate}*x_dot")), (1, format!("-{rate}*y_dot"))];
    around(draw, text, [1.0, 1.0])
}

fn kink(draw: &mut Random) -> Scene {
    let (a, e) = (draw.between(0.3, 1.5), draw.scale(1e-3, 0.1));
    let (x, v) = (vector(draw, 2, 1.0), vector(draw, 2, 0.5));
    let b = draw.between(-0.2, 0.2);
    at(potential(format!("{a}*sqrt(x^2 + {}) + y^2/2 + {b}*x^2*y", e * e), 2), &x, &v)
}

/// The wall is so narrow that it may lie between two nodes.
fn narrow_kink(draw: &mut Random) -> Scene {
    let (a, b, e) = (draw.between(0.3, 1.5), draw.between(-0.2, 0.2), draw.scale(1e-9, 1e-2));
    let wall = match (3.0 * draw.between(0.0, 1.0)) as usize {
        0 => format!("x*tanh(x/{e})"),
        1 => format!("sqrt(x^2 + {})", e * e),
        _ => format!("atan((x - y/10)/{e})"),
    };
    around(draw, potential(format!("{a}*{wall} + y^2/2 + {b}*x^2*y"), 2), [1.0, 0.5])
}

/// Three hills with flat tops and steep sides, far behind which exp overflows.
fn disks(draw: &mut Random) -> Scene {
    let (h, w, turn) = (draw.between(2.0, 5.0), draw.scale(0.005, 0.1), draw.between(0.0, 2.0));
    let disk = |k: usize| {
        let (b, a) = (turn + k as f64 * std::f64::consts::TAU / 3.0).sin_cos();
        format!("{h}/(1 + exp((sqrt((x - ({a}))^2 + (y - ({b}))^2) - 0.4)/{w}))")
    };
    around(draw, potential([0, 1, 2].map(disk).join(" + "), 2), [0.1, 0.9])
}

/// A narrow valley.
fn stiff(draw: &mut Random) -> Scene {
    let (k, a, b) = (draw.scale(1e2, 1e5), draw.between(-0.5, 0.5), draw.between(-0.5, 0.5));
    let (x, v) = (vector(draw, 1, 1.0)[0], draw.between(-1.0, 1.0));
    let valley = a * x * x + b * x.sin();
    let text = potential(format!("{}*(y - {a}*x^2 - {b}*sin(x))^2 + x^2/2", k * k / 2.0), 2);
    at(text, &[x, valley + 0.1 / k], &[v, 0.0])
}

/// A straight line that passes the origin of polar coordinates closely.
fn polar(draw: &mut Random) -> Scene {
    let components = [(0, 0, "1".into()), (1, 1, "r^2".into())];
    let v = [-draw.between(0.3, 1.0), draw.sign() * draw.scale(1e-7, 0.1)];
    metric(&["r", "phi"], &components, &[draw.between(0.8, 2.0), 0.0], &v)
}

fn quartic(draw: &mut Random) -> Scene {
    let mut text = potential("x^4/2", 1);
    text.law = Law::Relativistic;
    let (x, v) = (draw.between(0.3, 1.2), draw.between(-0.5, 0.5));
    (GeometryText::Potential(text), vec![0.0, x], vec![1.0, v])
}

fn one(draw: &mut Random, formula: &str, x: [f64; 2], v: f64) -> Scene {
    let x = draw.between(x[0], x[1]);
    at(potential(formula, 1), &[x], &[draw.between(-v, v)])
}

/// A family of scenes, and what draws one of them.
type Family = (&'static str, fn(&mut Random) -> Scene);

/// All families.
pub(crate) const FAMILIES: [Family; 28] = [
    ("polynomial 1", |draw| polynomial(draw, 1)),
    ("polynomial 2", |draw| polynomial(draw, 2)),
    ("polynomial 3", |draw| polynomial(draw, 3)),
    ("trigonometric 1", |draw| trigonometric(draw, 1)),
    ("trigonometric 2", |draw| trigonometric(draw, 2)),
    ("trigonometric 3", |draw| trigonometric(draw, 3)),
    ("kepler", kepler),
    ("radial kepler", radial),
    ("henon-heiles", |draw| around(draw, potential("(x^2 + y^2)/2 + x^2*y - y^3/3", 2), [0.3, 0.25])),
    ("pendulum", |draw| one(draw, "1 - cos(x)", [-2.0, 2.0], 2.5)),
    ("double well", |draw| one(draw, "x^4/4 - x^2/2", [-1.3, 1.3], 0.8)),
    ("quartic", quartic),
    ("morse", |draw| one(draw, "(1 - exp(-x))^2", [-0.4, 1.0], 0.5)),
    ("kerr", kerr),
    ("schwarzschild", schwarzschild),
    ("oscillating metric", |draw| {
        let k = draw.between(0.5, 3.0);
        oscillating(draw, k)
    }),
    ("fast metric", |draw| {
        let k = draw.scale(5.0, 200.0);
        oscillating(draw, k)
    }),
    ("magnetic", magnetic),
    ("conformal", conformal),
    ("sphere", sphere),
    ("scattering", scattering),
    ("friction", friction),
    ("kink", kink),
    ("narrow kink", narrow_kink),
    ("disks", disks),
    ("stiff", stiff),
    ("polar", polar),
    ("chaos", |draw| around(draw, potential("x^2*y^2 + (x^4 + y^4)/20", 2), [1.2, 1.0])),
];
