//! The doubled action in n coordinates against its definition, with dual numbers, and its Hessian against differences.

use geodesic_ivp::action::{DoubledAction, Form, Layout};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::sbp::{SbpOperator, coefficients};
use num_dual::Dual64;
use proptest::prelude::*;

use super::formulas::{Everything, Null, Number, OneCoordinate, Plane, Scene};
use crate::common::{assert_near, of_x, start};

const POINTS: usize = 9;

fn start_of<G: Scene>(geometry: &Geometry) -> Start {
    let n = geometry.dimension();
    start(geometry, &[0.4, 0.8, -0.3, 0.2][..n], &[1.3, -0.2, 0.5, 0.7][..n])
}

/// Calls `check` with the actions of a scene, and with true where their operators are regularised.
fn with_actions<G: Scene>(check: impl Fn(&DoubledAction<'_, f64>, bool)) {
    let geometry = G::geometry();
    let banded = [&coefficients::SBP21, &coefficients::SBP42].map(|c| SbpOperator::new(c, POINTS, 0.11).unwrap());
    for sbp in banded.into_iter().chain([SbpOperator::gauss_lobatto(POINTS, 0.9)]) {
        for form in [Form::Strong, Form::Weak] {
            check(&DoubledAction::new(form, &sbp, &geometry, start_of::<G>(&geometry)), true);
        }
        if G::ACTIVE == OneCoordinate::ACTIVE {
            let action = DoubledAction::new(Form::Strong, &sbp, &geometry, start_of::<G>(&geometry));
            check(&action.without_regularisation(), false);
        }
    }
}

/// One branch: positions and D̄ of them, by coordinate and node.
struct Branch<D> {
    q: Vec<Vec<D>>,
    q_dot: Vec<Vec<D>>,
}

impl<D: Number> Branch<D> {
    fn new(action: &DoubledAction<'_, f64>, is_regularised: bool, u: &[D], branch: usize) -> Self {
        let (layout, sbp) = (action.layout(), action.sbp);
        let q: Vec<Vec<D>> = (0..layout.dimension).map(|a| layout.values(u, branch, a).to_vec()).collect();
        let bar = |(a, q): (usize, &Vec<D>)| {
            let mut row: Vec<D> = (0..POINTS).map(|k| derivative(sbp, q, k)).collect();
            if is_regularised {
                row[0] += (q[0] - action.initial.q[a]) / sbp.weights()[0];
            }
            row
        };
        let q_dot = q.iter().enumerate().map(bar).collect();
        Self { q, q_dot }
    }

    fn at(&self, k: usize) -> (Vec<D>, Vec<D>) {
        let of = |rows: &Vec<Vec<D>>| rows.iter().map(|row| row[k]).collect();
        (of(&self.q), of(&self.q_dot))
    }
}

fn derivative<D: Number>(sbp: &SbpOperator, q: &[D], k: usize) -> D {
    sbp.row(k).fold(D::from(0.0), |sum, (column, d)| sum + q[column] * d)
}

/// E_IVP from its definition.
fn value<G: Scene, D: Number>(action: &DoubledAction<'_, f64>, is_regularised: bool, u: &[D]) -> D {
    let (sbp, layout, initial) = (action.sbp, action.layout(), &action.initial);
    let (n, last) = (layout.dimension, POINTS - 1);
    let [one, two] = [0, 1].map(|branch| Branch::new(action, is_regularised, u, branch));
    let gap = |a: usize, k: usize| one.q[a][k] - two.q[a][k];
    let mut sum = D::from(0.0);
    for (k, &weight) in sbp.weights().iter().enumerate() {
        let ((q1, v1), (q2, v2)) = (one.at(k), two.at(k));
        sum += (G::lagrangian(&q1, &v1) - G::lagrangian(&q2, &v2)) * weight;
        let mean = |a: &[D], b: &[D]| a.iter().zip(b).map(|(&a, &b)| (a + b) * 0.5).collect::<Vec<D>>();
        let force = G::force(&mean(&q1, &q2), &mean(&v1, &v2));
        for (a, &force) in force.iter().enumerate() {
            sum += gap(a, k) * force * weight;
        }
    }
    let multipliers = layout.multipliers(u);
    for a in 0..n {
        match action.form {
            Form::Strong => {
                let [lambda, mu, nu, kappa] =
                    [layout.lambda(a), layout.mu(a), layout.nu(a), layout.kappa(a)].map(|place| multipliers[place]);
                sum += lambda * (one.q[a][0] - initial.q[a]);
                sum += mu * (derivative(sbp, &one.q[a], 0) - initial.q_dot[a]);
                sum += nu * gap(a, last);
                sum += kappa * (derivative(sbp, &one.q[a], last) - derivative(sbp, &two.q[a], last));
            }
            Form::Weak => {
                let mean = |k: usize| {
                    let ((q1, v1), (q2, v2)) = (one.at(k), two.at(k));
                    (G::momenta(&q1, &v1)[a] + G::momenta(&q2, &v2)[a]) * 0.5
                };
                sum -= mean(last) * gap(a, last) + (mean(0) - initial.p[a]) * gap(a, 0);
            }
        }
    }
    sum
}

fn check_gradient<G: Scene>(u: &[f64]) {
    with_actions::<G>(|action, is_regularised| {
        let u = &u[..action.layout().unknowns()];
        let mut gradient = vec![0.0; u.len()];
        action.gradient(u, &mut gradient).unwrap();
        let largest = gradient.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
        assert_eq!(action.gradient_norm(u), largest);
        let exact = value::<G, f64>(action, is_regularised, u);
        assert_near(action.value(u).unwrap(), exact, 1e-11, "the value");
        let mut dual: Vec<Dual64> = u.iter().map(|&value| Dual64::from(value)).collect();
        for i in 0..u.len() {
            dual[i].eps = 1.0;
            let slope = value::<G, Dual64>(action, is_regularised, &dual).eps;
            dual[i].eps = 0.0;
            assert_near(gradient[i], slope, 1e-10, &format!("{:?}, entry {i}", action.form));
        }
    });
}

/// The system that Newton's method solves at equal branches, against differences of the gradient. E_IVP is odd in
/// q₁ − q₂ where λ = μ = 0. So a step with all unknowns keeps equal branches equal, and is that of the system with half
/// of them: along such a step all other equations go on to hold.
fn check_newton_matrix<G: Scene>(q: &[f64]) {
    with_actions::<G>(|action, is_regularised| {
        if !is_regularised {
            return;
        }
        let layout = action.layout();
        let rows: Vec<&[f64]> = q.chunks_exact(POINTS).take(layout.dimension).collect();
        // ν and κ, the second half of the multipliers, may have any value.
        let count = layout.multiplier_range().len();
        let multipliers: Vec<f64> = (0..count).map(|j| if 2 * j < count { 0.0 } else { 0.3 * j as f64 }).collect();
        let u = layout.physical_limit(&rows, &multipliers);
        let ones = vec![1.0; action.layout().equal_unknowns()];
        let lu = action.newton_pattern().factor(&action.newton_matrix(&u).unwrap(), [&ones, &ones]).unwrap();
        let mut step = vec![0.0; u.len()];
        for j in 0..layout.equal_unknowns() {
            let unit: Vec<f64> = (0..layout.equal_unknowns()).map(|i| f64::from(u8::from(i == j))).collect();
            layout.write_equal_step(&unit, &mut step);
            let shifted = |h: f64| {
                let u: Vec<f64> = u.iter().zip(&step).map(|(u, step)| u + h * step).collect();
                let mut gradient = vec![0.0; u.len()];
                action.gradient(&u, &mut gradient).unwrap();
                gradient
            };
            let h = 1e-3;
            let (a, b, c, d) = (shifted(h), shifted(-h), shifted(2.0 * h), shifted(-2.0 * h));
            let difference = |i: usize| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h);
            let difference: Vec<f64> = (0..u.len()).map(difference).collect();
            let column = lu.multiply(&unit);
            let largest = difference.iter().fold(1.0, |largest: f64, entry| largest.max(entry.abs()));
            // A text for each entry takes longer than the entry.
            let name = format!("{:?}, column {j}", action.form);
            for (got, want) in column.iter().zip(layout.equal_equations(&difference)) {
                assert_near(*got, want, 1e-8 * largest, &name);
            }
            // The mean of both branches' equations, and the ends that ν and κ tie.
            let branch = layout.row(1, 0);
            (0..branch).for_each(|i| assert_near(difference[i], -difference[branch + i], 1e-9 * largest, &name));
            let tied = layout.multiplier_range().skip(count / 2);
            tied.for_each(|i| assert_near(difference[i], 0.0, 1e-9 * largest, &name));
        }
    });
}

const UNKNOWNS: usize = 2 * 4 * POINTS + 16;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn the_gradient_is_the_derivative_of_the_definition(u in proptest::collection::vec(-1.0..1.2_f64, UNKNOWNS)) {
        check_gradient::<Everything>(&u);
        check_gradient::<Plane>(&u);
        check_gradient::<Null>(&u);
        check_gradient::<OneCoordinate>(&u);
    }

    #[test]
    fn the_newton_matrix_is_the_derivative_of_the_gradient(q in proptest::collection::vec(-1.0..1.2_f64, 4 * POINTS)) {
        check_newton_matrix::<Everything>(&q);
        check_newton_matrix::<Plane>(&q);
        check_newton_matrix::<Null>(&q);
        check_newton_matrix::<OneCoordinate>(&q);
    }
}

fn check_value_of_equal_branches<G: Scene>() {
    with_actions::<G>(|action, _| {
        let (layout, initial) = (action.layout(), &action.initial);
        let line = |a: usize| -> Vec<f64> {
            (0..POINTS).map(|k| initial.q[a] + initial.q_dot[a] * action.sbp.node(k)).collect()
        };
        let rows: Vec<Vec<f64>> = (0..layout.dimension).map(line).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let multipliers: Vec<f64> = (0..layout.multiplier_range().len()).map(|j| j as f64 - 7.5).collect();
        let u = layout.physical_limit(&rows, &multipliers);
        assert_near(action.value(&u).unwrap(), 0.0, 1e-13, "the value");
        assert!(action.constraints(&u).iter().all(|c| c.abs() < 1e-13));
        assert_eq!(action.constraints(&u).len(), 4 * layout.dimension);
    });
}

#[test]
fn the_value_vanishes_where_the_branches_agree_and_the_constraints_hold() {
    check_value_of_equal_branches::<Everything>();
    check_value_of_equal_branches::<OneCoordinate>();
}

#[test]
fn a_node_outside_the_domain_is_named() {
    let geometry = of_x("-0.5*x", 1.0, 1.0);
    let sbp = SbpOperator::new(&coefficients::SBP21, 4, 0.1).unwrap();
    let action = DoubledAction::new(Form::Strong, &sbp, &geometry, start_of::<OneCoordinate>(&geometry));
    let u = action.layout().physical_limit(&[&[0.0; 4], &[0.0, 0.5, 1.25, 0.0]], &[0.0; 8]);
    let outside = action.value(&u).unwrap_err();
    assert_eq!((outside.index, outside.position, outside.determinant), (2, 1.25, -0.25));
}

#[test]
fn every_unknown_belongs_to_the_node_it_acts_at() {
    for n in [1, 2, 4] {
        let layout = Layout::new(n, POINTS, Form::Strong);
        for (branch, a, k) in (0..2).flat_map(|b| (0..n).flat_map(move |a| (0..POINTS).map(move |k| (b, a, k)))) {
            assert_eq!(layout.node(layout.row(branch, a) + k), k);
        }
        let first = layout.multiplier_range().start;
        for a in 0..n {
            let node = |place: usize| layout.node(first + place);
            // λ and μ fix the start, ν and κ tie the ends.
            assert_eq!([node(layout.lambda(a)), node(layout.mu(a))], [0, 0], "{a} of {n}");
            assert_eq!([node(layout.nu(a)), node(layout.kappa(a))], [POINTS - 1; 2], "{a} of {n}");
        }
    }
}
