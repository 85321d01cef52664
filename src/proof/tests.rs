//! Ends of motions against integrations in 45 digits, by Taylor series in mpmath.

use super::algebras::{LANES, Row};
use super::tables::TABLES;
use super::*;
use crate::geometry::{GeometryText, Law, value_of};
use crate::number::Real;

/// A scene, where it starts, and the length of γ.
pub(super) struct Scene {
    pub(super) text: GeometryText,
    pub(super) q: &'static str,
    rates: &'static str,
    length: &'static str,
}

fn potential(names: &[&str], formula: &str, law: Law) -> GeometryText {
    GeometryText::of_potential(names, formula, law)
}

impl Scene {
    fn new(text: GeometryText, q: &'static str, rates: &'static str, length: &'static str) -> Self {
        Self { text, q, rates, length }
    }

    fn start(&self, geometry: &Geometry<Extended>) -> Start<Extended> {
        let (q, q_dot) = (self.numbers(self.q), self.numbers(self.rates));
        Start { p: geometry.momenta(&q, &q_dot), q, q_dot }
    }

    pub(super) fn numbers(&self, list: &str) -> Vec<Extended> {
        list.split(',').map(|text| value_of(text.trim(), &self.text.parameters).unwrap()).collect()
    }

    fn proved(&self) -> Proof {
        let geometry: Geometry<Extended> = Geometry::new(&self.text).unwrap();
        let start = self.start(&geometry);
        let until = Until::Length(self.numbers(self.length)[0]);
        prove(&Motion::new(&geometry, &start, until), &mut |_| true)
    }
}

/// The share of the radius of a coordinate that a known value uses, and the radius.
fn share(proof: &Proof, coordinate: usize, value: &str) -> (f64, f64) {
    let end = proof.end.as_ref().unwrap_or_else(|reason| panic!("{reason} at {}", proof.reached));
    let found = end.iter().find(|found| found.coordinate == coordinate).expect("it is a result");
    let off = (found.value - Extended::from_decimal(value).unwrap()).abs().to_f64();
    (off / found.radius, found.radius)
}

pub(super) fn henon_heiles(length: &'static str) -> Scene {
    let text = potential(&["x", "y"], "(x^2 + y^2)/2 + x^2*y - y^3/3", Law::Newtonian);
    Scene::new(text, "0, 0.1, 0, 0", "1, 0, 0.5, 0", length)
}

/// The equations of one coordinate and its momentum, whose Jacobian has the entries (0, 1) and (1, 0).
pub(super) fn with_one_coordinate<T>(work: impl FnOnce(&Equations<'_>) -> T) -> T {
    let scene = Scene::new(potential(&["x"], "x^4/4", Law::Newtonian), "0, 1, 0", "1, 0.1, 0", "1");
    let geometry: Geometry<Extended> = Geometry::new(&scene.text).unwrap();
    let equations = Equations::new(&geometry, &scene.start(&geometry), [Some(2), None], &[]);
    assert_eq!(equations.of, [(1, false), (1, true)]);
    assert_eq!(equations.entries.iter().map(|entry| (entry.row, entry.column)).collect::<Vec<_>>(), [(0, 1), (1, 0)]);
    work(&equations)
}

/// ℓ_j(1) of the nodes: a polynomial with the signs of these there is the largest at the end of a window.
pub(super) fn lagrange_at_end() -> Row {
    let t = &*TABLES;
    std::array::from_fn(|j| {
        let terms = (0..LANES).map(|k| (2 * k + 1) as f64 * t.legendre[k].hi[j]);
        0.5 * t.weights[j] * terms.sum::<f64>()
    })
}

/// P_32 where the ellipse meets the real axis. P_32 is 0 at all nodes and 1 at the end of a window.
pub(super) fn of_nodes_there() -> f64 {
    let (x, mut before, mut here) = (5.0 / 3.0, 1.0, 5.0 / 3.0);
    for k in 1..LANES {
        (before, here) = (here, ((2 * k + 1) as f64 * x * here - k as f64 * before) / (k + 1) as f64);
    }
    here
}

/// A tenth is no number of 71 digits: ten times what stands for it is off by its last digit, which the radius of the
/// ball holds beside what pairs leave.
#[test]
fn a_decimal_is_in_its_ball() {
    let tenth: Extended = value_of("0.1", &[]).unwrap();
    let [eight, two] = [8.0, 2.0].map(|factor| Extended::from(factor) * tenth);
    let off = (eight - Extended::ONE + two).abs().to_f64();
    let ball = equations::number(tenth);
    let left = (tenth - Extended::from(ball.hi) - Extended::from(ball.lo)).abs().to_f64();
    assert!(off > 0.0 && ball.rad >= left + off, "{off:e} {left:e} {:e}", ball.rad);
    assert!(equations::number(Extended::ONE).rad >= 1e-61);
}

#[test]
fn ends_are_those_of_45_digits() {
    let kepler = potential(&["x", "y"], "-1/sqrt(x^2 + y^2)", Law::Newtonian);
    let mut pendulum = potential(&["x"], "1 - cos(x)", Law::Relativistic);
    pendulum.potential.as_mut().unwrap().c = "10".into();
    let mut damped = potential(&["x"], "x^2/2 + x^4/4", Law::Newtonian);
    damped.force = vec![(0, "-x_dot/10 + cos(t)/3".into())];
    let three = "-1/sqrt((x1 - x2)^2 + (y1 - y2)^2) - 1/sqrt((x2 - x3)^2 + (y2 - y3)^2) \
                 - 1/sqrt((x3 - x1)^2 + (y3 - y1)^2)";
    let mut restricted = potential(
        &["x", "y"],
        "-(x^2 + y^2)/2 - (1 - mu)/sqrt((x + mu)^2 + y^2) - mu/sqrt((x - 1 + mu)^2 + y^2)",
        Law::Newtonian,
    );
    restricted.parameters.push(("mu".into(), "0.0009537".into()));
    restricted.one_form = vec![(0, "-y".into()), (1, "x".into())];
    let scenes = [
        (henon_heiles("100"), 1, "-0.0401942378760688167944025003237361721562454887", 1e-17),
        (henon_heiles("100"), 2, "0.679016921772021642134721800871534099545540387", 1e-17),
        (
            Scene::new(kepler, "0, 0.4, 0, 0", "1, 0, 2, 0", "62.83185307179586"),
            1,
            "0.399999999999999999999999999981253002716726781",
            1e-15,
        ),
        (
            Scene::new(potential(&["x"], "x^4/2", Law::Relativistic), "0, 1", "1, 0.1", "10"),
            0,
            "15.6066805067837356979877139946450666563053728",
            1e-17,
        ),
        (Scene::new(pendulum, "0, 2.5", "1, 0", "10"), 1, "2.48009995589305324633831046986963362299704791109", 1e-17),
        (Scene::new(damped, "0, 1, 0", "1, 0, 0", "100"), 1, "0.537793675895076626149310967612394177407696740", 1e-17),
        (
            Scene::new(
                potential(&["x1", "y1", "x2", "y2", "x3", "y3"], three, Law::Newtonian),
                "0, 0.97000435664712467982, -0.24308753046758826958, -0.97000435664712467982, \
                 0.24308753046758826958, 0, 0, 0",
                "1, 0.466203685347163, 0.432365730734568, 0.466203685347163, 0.432365730734568, -0.932407370694326, \
                 -0.864731461469136, 0",
                "6.32591398",
            ),
            1,
            "0.97000435754423889460078780",
            1e-16,
        ),
        (
            Scene::new(restricted, "0, 0.9208034913207400196, 0, 0", "1, 0, 0.10444767270690774, 0", "3.0821191263765"),
            1,
            "0.920803491318327171136930821510912781311644471",
            1e-14,
        ),
    ];
    for (scene, coordinate, value, most) in scenes {
        let proof = scene.proved();
        let (share, radius) = share(&proof, coordinate, value);
        println!("{}: {share:.1e} of {radius:.1e}, {} windows, {:.1} ms", scene.q, proof.windows, 1e3 * proof.seconds);
        assert!(share <= 1.0 && radius < most, "{coordinate} of {}: {share} of {radius}", scene.q);
    }
}

#[test]
fn a_kink_is_refused_with_its_place() {
    let scene = Scene::new(potential(&["x"], "abs(x)", Law::Newtonian), "0, -1, 0", "1, 0, 0", "5");
    let proof = scene.proved();
    assert_eq!(proof.end, Err(Reason::Obstacle(Obstacle::Function(crate::number::Function::Sign))));
    // x = −1 + γ²/2 is 0 at √2.
    assert!((proof.reached - 2.0_f64.sqrt()).abs() < 1e-2, "{}", proof.reached);
}
