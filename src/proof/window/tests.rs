//! Each term of the bounds of a window by itself, in windows in which nothing else is wrong. B = 1 and h = 1 where
//! nothing else is said. Beside each test stands the part of the bound that its example reaches.

use super::super::algebras::{Discs, Row};
use super::super::tests::{lagrange_at_end, of_nodes_there, with_one_coordinate};
use super::*;
use crate::number::{Extended, Real};

/// Bounds, matrices and a defect of `d` unknowns, the first two of which are x and p.
struct Window {
    bounds: Bounds,
    matrices: Matrices,
    found: Found,
    defect: Vec<f64>,
}

/// One on the diagonal.
fn one(d: usize) -> Vec<f64> {
    (0..d * d).map(|at| if at.is_multiple_of(d + 1) { 1.0 } else { 0.0 }).collect()
}

impl Window {
    fn new(d: usize) -> Self {
        let zero = vec![0.0; d * d];
        let bounds = Bounds {
            defect: vec![0.0; d],
            slope: vec![0.0; d],
            jacobian: vec![0.0; 2],
            spread: vec![0.0; 2],
            reach: vec![10.0; d],
            sides: vec![0.0; d],
        };
        let matrices = Matrices {
            d,
            b: one(d).iter().map(|b| [*b; LANES]).collect(),
            slack: zero.clone(),
            b_most: one(d),
            e_most: zero.clone(),
            a_most: one(d),
            b_there: one(d),
            a_end: one(d),
            miss: zero,
        };
        let found = Found { middle: vec![[0.0; LANES]; d], radius: vec![[0.0; LANES]; d], places: Vec::<Discs>::new() };
        Self { bounds, matrices, found, defect: vec![0.0; d] }
    }

    fn closing<T>(&self, h: f64, work: impl FnOnce(&Closing<'_, '_>) -> T) -> T {
        let Self { bounds, matrices, defect, .. } = self;
        with_one_coordinate(|equations| work(&Closing { equations, h, bounds, matrices, defect: defect.clone() }))
    }

    /// ε from errors of x and p at the start.
    fn epsilon(&self, e_0: [f64; 2]) -> Vec<f64> {
        self.closing(1.0, |closing| closing.epsilon(&e_0)).unwrap()
    }

    /// g, and the parts of δ.
    fn gain(&self, h: f64, epsilon: &[f64]) -> (Vec<f64>, [Vec<f64>; 3]) {
        self.closing(h, |closing| closing.gain(&self.found, epsilon)).unwrap()
    }
}

/// Asserts that a bound holds, and that at least this part of it is met.
#[track_caller]
fn is_met(value: f64, bound: f64, part: f64) {
    assert!(value <= bound && value >= part * bound, "{value:e} of {bound:e}: {}", value / bound);
}

/// The term Ē ε in ε and in δ: e′ = 0.3 e grows to exp 0.3. Parts 0.8 and 0.7.
#[test]
fn errors_that_grow_within_a_window_are_bounded() {
    let mut window = Window::new(2);
    window.matrices.e_most[0] = 0.3;
    let epsilon = window.epsilon([1.0, 0.0]);
    is_met(0.3_f64.exp(), epsilon[0], 0.8);
    let (_, [_, _, way]) = window.gain(1.0, &epsilon);
    is_met(0.3_f64.exp() - 1.0, way[0], 0.7);
}

/// The term B̄ d̄ in ε: e′ = d. Part 0.9.
#[test]
fn a_constant_defect_is_bounded() {
    let mut window = Window::new(2);
    window.defect[0] = 1e-3;
    is_met(1e-3, window.epsilon([0.0; 2])[0], 0.9);
}

/// The term B̄ Q̄ in ε and in δ: x′ = p², where J = 2p is at most 2R from 0 for |p| ≤ R. Schwarz' lemma loses a half,
/// and ε = 1.1 |p| a tenth twice. Parts 0.35 and 0.4.
#[test]
fn what_is_not_linear_in_the_error_is_bounded() {
    let mut window = Window::new(2);
    (window.bounds.reach, window.bounds.spread[0]) = (vec![1e3, 10.0], 20.0);
    let epsilon = window.epsilon([0.0, 1.0]);
    is_met(1.0, epsilon[0], 0.35);
    let (_, [_, _, way]) = window.gain(1.0, &epsilon);
    is_met(1.0, way[0], 0.4);
}

/// The radii of the defect in δ: all of it is on one side. Part 0.999.
#[test]
fn radii_of_the_defect_are_integrated() {
    let mut window = Window::new(2);
    window.found.radius[0] = [1e-3; LANES];
    is_met(1e-3, window.gain(1.0, &[0.0; 2]).1[0][0], 0.999);
}

/// The slack of B in δ: it is off by so much everywhere. Part 0.999.
#[test]
fn what_the_adjoint_matrix_is_off_by_is_integrated() {
    let mut window = Window::new(2);
    (window.matrices.slack[0], window.found.middle[0]) = (1e-3, [1.0; LANES]);
    is_met(1e-3, window.gain(1.0, &[0.0; 2]).1[0][0], 0.999);
}

/// Σ w_i b_i d_i in 71 digits.
fn sum_of_nodes(b: &Row, middle: &Row) -> Extended {
    let exact = Extended::from;
    (0..LANES).fold(Extended::ZERO, |sum, i| sum + exact(TABLES.weights[i]) * exact(b[i]) * exact(middle[i]))
}

/// δ has all of its parts. Part 0.999.
#[test]
fn what_a_window_adds_is_the_sum_of_its_parts() {
    is_met(7.0, added(&[vec![1.0], vec![2.0], vec![4.0]])[0], 0.999);
}

/// The rounding of the sum over the nodes in δ, of which 40 ε a term is a worst case. Part 0.01. That of the sum over
/// unknowns is taken away, as there is but one; where d̄ is Λ times the defect at the nodes it is larger than this one.
#[test]
fn rounding_of_the_sum_over_nodes_is_bounded() {
    let mut seed = 1_u64;
    let mut unit = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut largest = 0.0_f64;
    for _ in 0..300 {
        let mut window = Window::new(2);
        window.matrices.b[0] = std::array::from_fn(|_| unit());
        window.found.middle[0] = std::array::from_fn(|_| unit());
        let (gain, [radii, ..]) = window.gain(2.0, &[0.0; 2]);
        let exact = sum_of_nodes(&window.matrices.b[0], &window.found.middle[0]);
        let off = (exact + Extended::from(gain[0])).abs().to_f64();
        assert!(off <= radii[0], "{off:e} {:e}", radii[0]);
        largest = largest.max(off / radii[0]);
    }
    assert!(largest > 0.01, "{largest}");
}

/// The rounding of the sum over unknowns in δ: a large term, and 127 smaller ones that are lost one by one. It is a
/// hundred times that, and with less than eighty unknowns the rounding of the sum over nodes is larger. Part 0.01.
#[test]
fn rounding_of_the_sum_over_unknowns_is_bounded() {
    let d = 128;
    let mut window = Window::new(d);
    for k in 0..d {
        window.matrices.b[k] = [1.0; LANES];
        window.matrices.b_most[k] = 1.0;
        let size = if k == 0 { 1.2 } else { 1e-16 };
        window.found.middle[k][LANES / 2] = size / TABLES.weights[LANES / 2];
        window.defect[k] = window.found.middle[k][LANES / 2];
    }
    let (gain, [radii, ..]) = window.gain(2.0, &vec![0.0; d]);
    let terms = window.found.middle.iter().map(|middle| sum_of_nodes(&[1.0; LANES], middle));
    let off = (terms.fold(Extended::from(gain[0]), |sum, term| sum + term)).abs().to_f64();
    is_met(off, radii[0], 0.01);
}

/// What the quadrature leaves in δ: of T_64, whose integral is −2/4095, and which is (3⁶⁴ + 3⁻⁶⁴)/2 on the ellipse.
/// Part 0.6.
#[test]
fn what_the_quadrature_leaves_is_bounded() {
    let mut window = Window::new(2);
    window.found.middle[0] = TABLES.legendre[1].hi.map(|x| (64.0 * x.acos()).cos());
    window.bounds.defect[0] = 0.5 * 3.0_f64.powi(64);
    let (gain, [_, left, _]) = window.gain(2.0, &[0.0; 2]);
    is_met((gain[0] - 2.0 / 4095.0).abs(), left[0], 0.6);
}

/// The term Λ max (|d| + radius) at the nodes: the polynomial with the signs of ℓ_j(1) there, half of which is in the
/// radii. Part 0.9.
#[test]
fn a_defect_at_the_nodes_is_larger_between_them() {
    let mut window = Window::new(2);
    let at_end = lagrange_at_end();
    (window.found.middle[0], window.found.radius[0]) = (at_end.map(|l| 0.5 * l.signum()), [0.5; LANES]);
    let most = defect_most(&window.found, &window.bounds);
    is_met(at_end.iter().map(|l| l.abs()).sum(), most[0], 0.9);
}

/// The term of interpolation: P_32, which is 0 at all nodes. Part 0.2.
#[test]
fn a_defect_that_the_nodes_do_not_see_is_bounded() {
    let mut window = Window::new(2);
    window.bounds.defect[0] = of_nodes_there();
    is_met(1.0, defect_most(&window.found, &window.bounds)[0], 0.2);
}
