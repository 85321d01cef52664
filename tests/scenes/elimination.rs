//! The Newton systems of the doubled action, solved as the program does and by another library.

use faer::linalg::solvers::SolveCore;
use faer::sparse::{SparseColMat, Triplet};
use geodesic_ivp::action::{DoubledAction, Form};
use geodesic_ivp::geometry::Geometry;
use geodesic_ivp::linalg::sparse::{Envelope, SparseMatrix};
use geodesic_ivp::sbp::{SbpOperator, coefficients};
use proptest::prelude::*;

use super::common::start;
use super::formulas::{Everything, Null, Plane, Scene};

/// As many nodes as need an interior stencil of every operator.
const POINTS: usize = 24;
const UNKNOWNS: usize = 2 * 4 * POINTS + 16;

/// Actions of a scene in both forms on all operators.
fn with_actions<G: Scene>(points: usize, check: impl Fn(&DoubledAction<'_, f64, Geometry>)) {
    let geometry = G::geometry();
    let n = geometry.dimension();
    let start = start(&geometry, &[0.4, 0.8, -0.3, 0.2][..n], &[1.3, -0.2, 0.5, 0.7][..n]);
    let tables = [&coefficients::SBP21, &coefficients::SBP42, &coefficients::SBP63, &coefficients::SBP84];
    let differences = tables.map(|table| SbpOperator::new(table, points, 0.05).unwrap());
    for sbp in differences.into_iter().chain([SbpOperator::gauss_lobatto(POINTS, 0.9)]) {
        for form in [Form::Strong, Form::Weak] {
            check(&DoubledAction::of_form(form, &sbp, &geometry, start.clone()));
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

/// A⁻¹b by the sparse LU of faer.
fn judge(matrix: &SparseMatrix<'_>, b: &[f64]) -> Vec<f64> {
    let n = matrix.order();
    let of_row = |row| matrix.row(row).map(move |(col, val)| Triplet { row, col, val });
    let triplets: Vec<_> = (0..n).flat_map(of_row).collect();
    let lu = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets).unwrap().sp_lu().unwrap();
    let mut x = b.to_vec();
    lu.solve_in_place_with_conj(faer::Conj::No, faer::MatMut::from_column_major_slice_mut(&mut x, n, 1));
    x
}

fn check_elimination<G: Scene>(u: &[f64], b: &[f64]) {
    with_actions::<G>(POINTS, |action| {
        let unknowns = action.layout().unknowns();
        let (u, b) = (&u[..unknowns], &b[..unknowns]);
        let pattern = action.hessian_pattern();
        let hessian = action.hessian(u, &pattern).unwrap();
        let row_sums: Vec<f64> =
            (0..unknowns).map(|row| hessian.row(row).map(|(_, value)| value.abs()).sum()).collect();
        let other = judge(&hessian, b);
        // In both orders, whichever the program takes.
        for order in [action.layout().along_branches(), action.layout().along_nodes()] {
            let mut x = b.to_vec();
            Envelope::new(&pattern, &order).factor(&hessian).unwrap().solve_in_place(&mut x);
            let left: Vec<f64> = hessian.multiply(&x).iter().zip(b).map(|(product, b)| b - product).collect();
            let scale = largest(&row_sums) * largest(&x) + largest(b);
            assert!(largest(&left) < 1e-13 * scale, "{:?}: {:e} of {scale:e}", action.form(), largest(&left));
            let apart: Vec<f64> = x.iter().zip(&other).map(|(x, other)| x - other).collect();
            assert!(largest(&apart) < 1e-7 * largest(&x), "{:?}: {:e}", action.form(), largest(&apart) / largest(&x));
        }
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3))]

    #[test]
    fn another_library_solves_the_same_newton_systems(
        u in proptest::collection::vec(-1.0..1.2_f64, UNKNOWNS),
        b in proptest::collection::vec(-1.0..1.0_f64, UNKNOWNS),
    ) {
        check_elimination::<Everything>(&u, &b);
        check_elimination::<Plane>(&u, &b);
        check_elimination::<Null>(&u, &b);
    }
}

/// What an elimination keeps grows with the nodes and not with their square, whatever ties the branches.
#[test]
fn an_elimination_is_linear_in_the_nodes() {
    fn check<G: Scene>() {
        let sizes = |points| {
            let sizes = std::cell::RefCell::new(Vec::new());
            with_actions::<G>(points, |action| {
                let pattern = action.hessian_pattern();
                sizes.borrow_mut().push((action.envelope(&pattern).size(), action.layout().unknowns()));
            });
            sizes.into_inner()
        };
        let (small, medium, large) = (sizes(100), sizes(200), sizes(300));
        // All but the spectral elements, which are last.
        for i in 0..8 {
            assert_eq!(large[i].0 - medium[i].0, medium[i].0 - small[i].0, "operator and form {i}");
            let of_unknown = (large[i].0 - medium[i].0) as f64 / (large[i].1 - medium[i].1) as f64;
            let order = 2.0 * (i / 2 + 1) as f64;
            // A stencil of D twice, to both sides, in all coordinates; both branches and pivots make it wider.
            assert!(of_unknown > 2.0 * order && of_unknown < 2.0 * 8.0 * 3.0 * order, "{i}: {of_unknown}");
        }
    }
    check::<Everything>();
    check::<Plane>();
    check::<Null>();
}

/// Along the branches nothing comes in between, unless something ties them before the end.
#[test]
fn the_order_follows_what_ties_the_branches() {
    let geometry = Null::geometry();
    let start = start(&geometry, &[0.4, 0.8, -0.3][..geometry.dimension()], &[1.3, -0.2, 0.5][..geometry.dimension()]);
    let sbp = SbpOperator::new(&coefficients::SBP42, 100, 0.05).unwrap();
    let sizes = |form| {
        let action = DoubledAction::of_form(form, &sbp, &geometry, start.clone());
        let (pattern, layout) = (action.hessian_pattern(), action.layout());
        let size = |order: Vec<u32>| Envelope::new(&pattern, &order).size();
        (size(layout.along_branches()), size(layout.along_nodes()), action.envelope(&pattern).size())
    };
    let (branches, nodes, taken) = sizes(Form::Strong);
    assert!(taken == branches && branches < nodes, "{branches} {nodes} {taken}");
    let (branches, nodes, taken) = sizes(Form::Weak);
    assert!(taken == nodes && 5 * nodes < branches, "{branches} {nodes} {taken}");
}
