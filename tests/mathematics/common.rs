//! Cases, scenes and starts that several of these tests use.

use geodesic_ivp::case::builtin;
use geodesic_ivp::engine::Handed;
use geodesic_ivp::geometry::{FormulaError, Geometry, GeometryError, GeometryText, Law, Preset, Source, Start};
use geodesic_ivp::number::Real;
use geodesic_ivp::reference::ReferenceTrajectory;
use geodesic_ivp::solve::{Limit, Settings, Setup, System, WorldLine};
use geodesic_ivp::study::errors::{RunError, reference_error};
use geodesic_ivp::{Case, NoSolution, Solution, solve};

/// The base case of the paper, quartic potential; everything else is an override of it.
pub(crate) const QUARTIC: &str = r#"
[potential]
quartic = { kappa = 0.5 }

[initial]
t = 0.0
x = 1.0
t_dot = 1.0
x_dot = 0.1

[grid]
gamma_f = 1.0
n_gamma = 32

[scheme]
sbp = "SBP21"
"#;

/// `QUARTIC` with overrides, separated by white space.
pub(crate) fn case(overrides: &str) -> Case {
    let overrides: Vec<String> = overrides.split_whitespace().map(str::to_owned).collect();
    Case::parse("test", QUARTIC, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// The solution of `QUARTIC` with overrides.
pub(crate) fn solved(overrides: &str) -> Solution {
    solved_in(overrides)
}

/// The solution of `QUARTIC` with overrides in another arithmetic.
pub(crate) fn solved_in<S: Real>(overrides: &str) -> Solution<S> {
    solve(&case(overrides)).unwrap_or_else(|error| panic!("{overrides}: {error}"))
}

/// The case of a text with settings.
#[track_caller]
pub(crate) fn parsed(text: &str, set: &[&str]) -> Case {
    let set: Vec<String> = set.iter().map(|&set| set.to_owned()).collect();
    Case::parse("test", text, &set).unwrap_or_else(|error| panic!("{error}\n{set:?} in\n{text}"))
}

/// A case that is built in, with settings.
#[track_caller]
pub(crate) fn shipped(name: &str, set: &[&str]) -> Case {
    parsed(builtin::text(name).expect("it is built in"), set)
}

/// The solution of a case.
#[track_caller]
pub(crate) fn line_of<S: Real>(case: &Case) -> WorldLine<S> {
    solve(case).unwrap_or_else(|failure| panic!("{:?}: {failure}", case.title.as_deref()))
}

/// The solution of a text.
#[track_caller]
pub(crate) fn text_solved(text: &str) -> WorldLine {
    line_of(&parsed(text, &[]))
}

/// Why a text has no solution.
#[track_caller]
pub(crate) fn failure(text: &str) -> NoSolution {
    solve::<f64>(&parsed(text, &[])).expect_err("there is no solution")
}

/// V(x) with a text that follows it, as a case of one coordinate and as a scene of n = 1.
pub(crate) fn one_and_scene(formula: &str, rest: &str) -> [Case; 2] {
    ["potential.formula.expression", "potential.coordinates = ['x']\npotential.formula"]
        .map(|potential| parsed(&format!("{potential} = \"{formula}\"\n{rest}"), &[]))
}

/// The coordinate of that name at the end of a run.
pub(crate) fn end(line: &WorldLine, name: &str) -> f64 {
    line.end().q[line.geometry().names().iter().position(|other| other == name).unwrap()]
}

/// The Taylor trajectory of a run, in its own digits.
pub(crate) fn reference_of<S: Real>(line: &WorldLine<S>) -> ReferenceTrajectory<S> {
    let (start, length) = (&line.place.start, line.length);
    ReferenceTrajectory::new(line.geometry(), start, length, line.digits).unwrap_or_else(|error| panic!("{error}"))
}

/// The space-time of t and x in the potential of a formula, for a particle of this mass.
pub(crate) fn of_x<S: Real>(expression: &str, mass: f64, c: f64) -> Geometry<S> {
    Geometry::of_x(&GeometryText::of_x(expression, mass, c)).unwrap_or_else(|error| panic!("{expression}: {error}"))
}

/// Σ c_k x^k.
pub(crate) fn polynomial(coefficients: &[f64]) -> String {
    coefficients.iter().rev().fold("0".to_owned(), |sum, c| format!("(({sum})*x + ({c:?}))"))
}

/// The potential of the paper's quartic case.
pub(crate) const QUARTIC_POTENTIAL: &str = "0.5*x*x*x*x";

/// The space-time of one coordinate in a potential, and a start at t = 0.
pub(crate) fn one(expression: &str, c: f64, [x, t_dot, x_dot]: [f64; 3]) -> (Geometry, Start) {
    let geometry = of_x(expression, 1.0, c);
    let begin = start(&geometry, &[0.0, x], &[t_dot, x_dot]);
    (geometry, begin)
}

/// A formula in x: its value with two derivatives, as the component A_x of a one-form.
#[derive(Debug)]
pub(crate) struct Formula<S = f64>(Geometry<S>);

impl<S: Real> Formula<S> {
    pub(crate) fn new(expression: &str, parameters: &[(&str, f64)]) -> Result<Self, FormulaError> {
        let text = GeometryText {
            coordinates: ["t", "x"].map(str::to_owned).to_vec(),
            components: vec![([0, 0], "1".to_owned()), ([1, 1], "-1".to_owned())],
            parameters: parameters.iter().map(|(name, value)| ((*name).to_owned(), format!("{value:?}"))).collect(),
            one_form: vec![(1, expression.to_owned())],
            ..GeometryText::default()
        };
        match Geometry::new(&text) {
            Ok(geometry) => Ok(Self(geometry)),
            Err(GeometryError::Formula(_, error)) => Err(error),
            Err(error) => panic!("{expression}: {error}"),
        }
    }

    /// The formula at x, with its first two derivatives.
    pub(crate) fn at(&self, x: S) -> [S; 3] {
        self.sample(&[x])[0]
    }

    /// The same at many places.
    pub(crate) fn sample(&self, x: &[S]) -> Vec<[S; 3]> {
        let (structure, mut samples) = (self.0.structure(), self.0.room(x.len()));
        // It is evaluated where it is not a number, too.
        let _ = self.0.fill(&[&vec![S::ZERO; x.len()], x], &mut samples);
        let of = |ab: [usize; 2], value: Source<S>| (ab == [1, 2]).then_some(value);
        let sources = [
            structure.values.iter().find_map(|term| of(term.ab, term.value)),
            structure.first.iter().find_map(|term| of(term.ab, term.value)),
            structure.second.iter().find_map(|term| of(term.ab, term.value)),
        ];
        let at = |k: usize| sources.map(|source| source.map_or(S::ZERO, |source| samples.at(source, k)));
        (0..x.len()).map(at).collect()
    }
}

/// g00 at x.
pub(crate) fn g00(geometry: &Geometry, x: f64) -> f64 {
    geometry.g00(&[0.0, x]).unwrap()
}

/// K of a point.
pub(crate) fn norm_of(geometry: &Geometry, point: &Start) -> f64 {
    geometry.norm(&point.q, &point.q_dot)
}

/// max |a − b|.
pub(crate) fn distance<S: Real>(a: &[S], b: &[S]) -> S {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(&a, &b)| (a - b).abs()).fold(S::ZERO, S::max)
}

/// The preset of that name with other parameters.
pub(crate) fn preset(name: &str, parameters: &[(&str, &str)]) -> GeometryText {
    let mut text = Preset::from_name(name).unwrap().text();
    for (name, value) in parameters {
        text.parameters.iter_mut().find(|(other, _)| other == name).unwrap().1 = (*value).to_owned();
    }
    text
}

/// Newtonian motion of unit masses.
pub(crate) fn newtonian(coordinates: &[&str], expression: &str) -> GeometryText {
    GeometryText::of_potential(coordinates, expression, Law::Newtonian)
}

/// The geometry of a text.
pub(crate) fn geometry<S: Real>(text: &GeometryText) -> Geometry<S> {
    Geometry::new(text).unwrap_or_else(|error| panic!("{error}"))
}

/// A start by positions and velocities.
pub(crate) fn start<S: Real>(geometry: &Geometry<S>, q: &[S], q_dot: &[S]) -> Start<S> {
    Start { q: q.to_vec(), q_dot: q_dot.to_vec(), p: geometry.momenta(q, q_dot) }
}

/// A start by positions and momenta.
pub(crate) fn start_with_momenta(geometry: &Geometry, q: &[f64], p: &[f64]) -> Start {
    let q_dot = geometry.velocities(q, p).unwrap();
    Start { q: q.to_vec(), q_dot, p: p.to_vec() }
}

/// A Newtonian start at t = s = 0 with dt/dγ = 1; ds/dγ makes K zero.
pub(crate) fn newtonian_start<S: Real>(geometry: &Geometry<S>, x: &[S], v: &[S]) -> Start<S> {
    let q: Vec<S> = [S::ZERO].iter().chain(x).copied().chain([S::ZERO]).collect();
    let mut q_dot: Vec<S> = [S::ONE].iter().chain(v).copied().chain([S::ZERO]).collect();
    *q_dot.last_mut().unwrap() = -geometry.norm(&q, &q_dot).half();
    start(geometry, &q, &q_dot)
}

/// The reference in `f64`.
pub(crate) fn reference(geometry: &Geometry, start: &Start, length: f64) -> ReferenceTrajectory {
    ReferenceTrajectory::new(geometry, start, length, 16).unwrap_or_else(|error| panic!("{error}"))
}

/// |got − want| ≤ tolerance · max(1, |want|).
#[track_caller]
pub(crate) fn assert_near(got: f64, want: f64, tolerance: f64, what: &str) {
    let error = (got - want).abs();
    assert!(error <= tolerance * want.abs().max(1.0), "{what}: {got} against {want}, error {error:e}");
}

/// A metric from `"a b" = formula` pairs.
pub(crate) fn metric(coordinates: &[&str], components: &[(&str, &str)]) -> GeometryText {
    let index = |name: &str| coordinates.iter().position(|other| *other == name).unwrap();
    let pair = |names: &str| {
        let (a, b) = names.split_once(' ').unwrap();
        [index(a), index(b)]
    };
    GeometryText {
        coordinates: coordinates.iter().map(|name| (*name).to_owned()).collect(),
        components: components.iter().map(|(names, text)| (pair(names), (*text).to_owned())).collect(),
        ..GeometryText::default()
    }
}

/// The setup of a run, from its end; what solved it does not matter.
pub(crate) fn setup_of(line: &WorldLine) -> Setup {
    let limit = match line.ended_at {
        Some((coordinate, value)) => Limit::Value { coordinate, value },
        None => Limit::Length(line.length),
    };
    Setup {
        place: line.place.clone(),
        rough: line.place.clone(),
        origin: None,
        gamma_i: line.gamma_i,
        is_backward: line.is_backward,
        carried: None,
        dropped: Handed::default(),
        limit,
        until: Vec::new(),
        sides: Vec::new(),
        set: Vec::new(),
        floors: Vec::new(),
        settings: Settings {
            sbp: line.sbp_name,
            form: line.form,
            regularised: true,
            n_gamma: line.nodes(),
            windows: 1,
            system: System::PhysicalLimit,
            digits: line.digits,
            max_iterations: 50,
            accuracy: None,
            sensitivity: false,
            is_judged: true,
        },
    }
}

/// The error of a run against a Taylor reference.
pub(crate) fn against_reference(line: &WorldLine) -> RunError {
    reference_error(&setup_of(line), line, &[]).expect("the reference gets there")
}

/// Rounding leaves so much in the gradient of the action of windows of n nodes, by their ends with q^a and q̇^a, and by
/// their lengths: two derivatives on n nodes, each of norm 2n², and a quadrature weight of 1/n², of the terms g_ab q̇^b
/// that make the momenta. They may be far larger than those. In q̇^b counts what is rounded before it is
/// differentiated: q^b itself, which in a short window changes by little of its size. Ignorable coordinates are counted
/// from the start of the window.
pub(crate) fn rounding_of_gradients<'q>(
    geometry: &Geometry,
    ends: impl IntoIterator<Item = (&'q [f64], Vec<f64>, f64)>,
    n: usize,
) -> f64 {
    let terms = ends.into_iter().flat_map(|(q, q_dot, length)| {
        let mut sums = vec![0.0; q.len()];
        for (b, (&position, q_dot)) in q.iter().zip(q_dot).enumerate() {
            let of_size = if geometry.active().contains(&b) { position / length } else { 0.0 };
            let mut velocity = vec![0.0; q.len()];
            velocity[b] = q_dot.abs().max(of_size.abs());
            sums.iter_mut().zip(geometry.momenta(q, &velocity)).for_each(|(sum, p)| *sum += p.abs());
        }
        sums
    });
    16.0 * f64::EPSILON * (n * n) as f64 * terms.fold(1.0, f64::max)
}
