//! Families of random scenes.

use geodesic_ivp::geometry::{GeometryText, Law, MetricText, PotentialText, Preset};

/// Numbers that look random (splitmix64).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }

    /// Uniform in its logarithm.
    pub(crate) fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }
}

/// A scene as text, its start, and dq/dγ there.
pub(crate) type Scene = (GeometryText, Vec<f64>, Vec<f64>);

const NAMES: [&str; 3] = ["x", "y", "z"];

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

fn potential(expression: String, dimension: usize) -> PotentialText {
    PotentialText {
        coordinates: names(&NAMES[..dimension]),
        expression,
        mass: "1".to_owned(),
        masses: vec!["1".to_owned(); dimension],
        c: "1".to_owned(),
        law: Law::Newtonian,
        ..PotentialText::default()
    }
}

/// Newton's law.
fn newton(text: PotentialText, x: &[f64], v: &[f64]) -> Scene {
    (GeometryText::Potential(text), [&[0.0], x, &[0.0]].concat(), [&[1.0], v, &[0.0]].concat())
}

fn plain(expression: String, x: &[f64], v: &[f64]) -> Scene {
    newton(potential(expression, x.len()), x, v)
}

fn metric(coordinates: &[&str], components: &[(usize, usize, String)], q: &[f64], v: &[f64]) -> Scene {
    let text = MetricText {
        coordinates: names(coordinates),
        components: components.iter().map(|(a, b, formula)| ([*a, *b], formula.clone())).collect(),
        ..MetricText::default()
    };
    (GeometryText::Metric(text), q.to_vec(), v.to_vec())
}

fn vector(draw: &mut Draw, dimension: usize, size: f64) -> Vec<f64> {
    (0..dimension).map(|_| draw.between(-size, size)).collect()
}

fn polynomial(draw: &mut Draw, n: usize) -> Scene {
    let mut terms = Vec::new();
    for (k, x) in NAMES[..n].iter().enumerate() {
        terms.push(format!("{}*{x}^2 + {}*{x}^4", draw.between(0.3, 1.5), draw.between(0.05, 0.5)));
        let other = NAMES[(k + 1) % n];
        terms.push(format!("{}*{x}^2*{other} + {}*{x}^2*{other}^2", draw.between(-0.2, 0.2), draw.between(0.0, 0.3)));
    }
    let (x, v) = (vector(draw, n, 0.8), vector(draw, n, 0.8));
    plain(terms.join(" + "), &x, &v)
}

fn trigonometric(draw: &mut Draw, n: usize) -> Scene {
    let mut terms = Vec::new();
    for (k, x) in NAMES[..n].iter().enumerate() {
        terms.push(format!("{}*cos({x} + {})", draw.between(0.3, 1.5), draw.between(0.0, 6.0)));
        let other = NAMES[(k + 1) % n];
        terms.push(format!("{}*sin({x} - {}*{other})", draw.between(0.0, 0.5), draw.between(0.5, 1.5)));
    }
    let (x, v) = (vector(draw, n, 2.0), vector(draw, n, 1.5));
    plain(terms.join(" + "), &x, &v)
}

fn kepler(draw: &mut Draw) -> Scene {
    let (e, angle) = (draw.between(0.0, 0.95), draw.between(0.0, std::f64::consts::TAU));
    let (r, sign) = if draw.unit() < 0.5 { (1.0 - e, 1.0) } else { (1.0 + e, -1.0) };
    let v = ((1.0 + sign * e) / r).sqrt();
    let (s, c) = angle.sin_cos();
    plain("-1/sqrt(x^2 + y^2)".into(), &[r * c, r * s], &[-v * s, v * c])
}

fn radial(draw: &mut Draw) -> Scene {
    let e = draw.between(0.0, 0.95);
    let r = if draw.unit() < 0.5 { 1.0 - e } else { 1.0 + e };
    let square = 1.0 - e * e;
    plain(format!("{square}/(2*x^2) - 1/x"), &[r], &[0.0])
}

fn kerr(draw: &mut Draw) -> Scene {
    let mut text = Preset::from_name("kerr").expect("there is a preset").text();
    text.parameters[1].1 = format!("{}", draw.between(0.1, 0.95));
    let (r, v) = (draw.between(8.0, 20.0), draw.between(0.9, 1.1));
    let orbit = v * r.powf(-1.5);
    let q = vec![0.0, r, draw.between(0.9, 2.2), 0.0];
    (GeometryText::Metric(text), q, vec![1.0, 0.0, 0.3 * orbit * draw.sign(), orbit])
}

fn schwarzschild(draw: &mut Draw) -> Scene {
    let (r, v) = (draw.between(8.0, 30.0), draw.between(0.85, 1.15));
    let components = [(0, 0, "1 - 2/r".into()), (1, 1, "-1/(1 - 2/r)".into()), (2, 2, "-r^2".into())];
    metric(&["t", "r", "phi"], &components, &[0.0, r, 0.0], &[1.0, 0.0, v * r.powf(-1.5)])
}

fn oscillating(draw: &mut Draw) -> Scene {
    let k = draw.between(0.5, 3.0);
    let components = [
        (0, 0, format!("1 + 0.4*sin({k}*y)")),
        (1, 1, format!("1 + 0.3*cos({k}*x)")),
        (0, 1, format!("0.2*sin({k}*(x - y)/2)")),
    ];
    let (q, v) = (vector(draw, 2, 1.0), vector(draw, 2, 1.0));
    metric(&["x", "y"], &components, &q, &v)
}

fn magnetic(draw: &mut Draw) -> Scene {
    let mut text = potential(format!("(x^2 + y^2)/2 + {}*x^2*y^2", draw.between(0.0, 0.5)), 2);
    let b = draw.between(0.2, 3.0);
    text.one_form = vec![(0, format!("-{b}*y/2")), (1, format!("{b}*x/2*(1 + x^2/9)"))];
    let (x, v) = (vector(draw, 2, 0.8), vector(draw, 2, 0.8));
    newton(text, &x, &v)
}

fn conformal(draw: &mut Draw) -> Scene {
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

fn sphere(draw: &mut Draw) -> Scene {
    let components = [(0, 0, "1".into()), (1, 1, "sin(theta)^2".into())];
    let v = [draw.sign() * draw.between(0.3, 1.0), draw.scale(1e-4, 1.0)];
    metric(&["theta", "phi"], &components, &[draw.between(0.8, 2.3), 0.0], &v)
}

fn scattering(draw: &mut Draw) -> Scene {
    let bump = format!("{}*exp(-(x^2 + y^2)) + y^2/50 + x^2/50", draw.between(0.3, 3.0));
    let (x, v) = ([-draw.between(2.0, 6.0), draw.between(-1.0, 1.0)], [draw.between(0.5, 2.0), 0.0]);
    plain(bump, &x, &v)
}

fn friction(draw: &mut Draw) -> Scene {
    let mut text = potential("(x^2 + y^2)/2 + x^2*y^2/4".into(), 2);
    let rate = draw.scale(1e-3, 0.3);
    text.force = vec![(0, format!("-{rate}*x_dot")), (1, format!("-{rate}*y_dot"))];
    let (x, v) = (vector(draw, 2, 1.0), vector(draw, 2, 1.0));
    newton(text, &x, &v)
}

fn kink(draw: &mut Draw) -> Scene {
    let (a, e) = (draw.between(0.3, 1.5), draw.scale(1e-3, 0.1));
    let (x, v) = (vector(draw, 2, 1.0), vector(draw, 2, 0.5));
    plain(format!("{a}*sqrt(x^2 + {}) + y^2/2 + {}*x^2*y", e * e, draw.between(-0.2, 0.2)), &x, &v)
}

fn quartic(draw: &mut Draw) -> Scene {
    let mut text = potential("x^4/2".into(), 1);
    text.law = Law::Relativistic;
    let (x, v) = (draw.between(0.3, 1.2), draw.between(-0.5, 0.5));
    (GeometryText::Potential(text), vec![0.0, x], vec![1.0, v])
}

fn one(draw: &mut Draw, formula: &str, x: [f64; 2], v: f64) -> Scene {
    let x = draw.between(x[0], x[1]);
    plain(formula.to_owned(), &[x], &[draw.between(-v, v)])
}

/// The families of scenes.
pub(crate) const FAMILIES: [&str; 23] = [
    "polynomial 1",
    "polynomial 2",
    "polynomial 3",
    "trigonometric 1",
    "trigonometric 2",
    "trigonometric 3",
    "kepler",
    "radial kepler",
    "henon-heiles",
    "pendulum",
    "double well",
    "quartic",
    "morse",
    "kerr",
    "schwarzschild",
    "oscillating metric",
    "magnetic",
    "conformal",
    "sphere",
    "scattering",
    "friction",
    "kink",
    "chaos",
];

/// A scene of a family.
pub(crate) fn scene(family: usize, draw: &mut Draw) -> Scene {
    match family {
        0..=2 => polynomial(draw, family + 1),
        3..=5 => trigonometric(draw, family - 2),
        6 => kepler(draw),
        7 => radial(draw),
        8 => {
            let (x, v) = (vector(draw, 2, 0.3), vector(draw, 2, 0.25));
            plain("(x^2 + y^2)/2 + x^2*y - y^3/3".into(), &x, &v)
        }
        9 => one(draw, "1 - cos(x)", [-2.0, 2.0], 2.5),
        10 => one(draw, "x^4/4 - x^2/2", [-1.3, 1.3], 0.8),
        11 => quartic(draw),
        12 => one(draw, "(1 - exp(-x))^2", [-0.4, 1.0], 0.5),
        13 => kerr(draw),
        14 => schwarzschild(draw),
        15 => oscillating(draw),
        16 => magnetic(draw),
        17 => conformal(draw),
        18 => sphere(draw),
        19 => scattering(draw),
        20 => friction(draw),
        21 => kink(draw),
        _ => {
            let (x, v) = (vector(draw, 2, 1.2), vector(draw, 2, 1.0));
            plain("x^2*y^2 + (x^4 + y^4)/20".into(), &x, &v)
        }
    }
}
