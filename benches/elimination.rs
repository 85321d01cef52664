//! What solving a Newton system of the doubled action costs, and what the sparse LU of faer takes for the same.
//!
//! Every system is the Hessian on a straight world-line. Timed are its factorisation with one solution, and what is
//! found once for an operator: the order of the unknowns and what the elimination fills in. The fastest of several runs
//! in turns counts. What faer stands on is only fast if it is optimised, which a build of the program does not do.
//!
//! ```text
//! cargo bench --bench elimination --config 'profile.release.package."*".opt-level=3' [-- NAME]
//! ```

use std::hint::black_box;
use std::time::Instant;

use faer::linalg::solvers::SolveCore;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};
use geodesic_ivp::action::{DoubledAction, Form};
use geodesic_ivp::case::{SceneCase, builtin};
use geodesic_ivp::geometry::{Geometry, Start};
use geodesic_ivp::linalg::sparse::SparseMatrix;
use geodesic_ivp::sbp::{SbpOperator, coefficients};

/// Seconds that a system is timed for at least, and the least number of runs.
const PATIENCE: f64 = 0.5;
const RUNS: usize = 3;

/// Two coordinates, one with friction, and an orbit around a rotating black hole, all with t.
const SCENES: [&str; 3] = ["henon-heiles", "damped-oscillator", "kerr-inclined"];
/// Operators with their nodes.
const GRIDS: [(&str, usize); 5] = [("SBP21", 20_000), ("SBP42", 20_000), ("SBP84", 5_000), ("GLL", 20), ("GLL", 64)];

fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let now = Instant::now();
    black_box(work());
    now.elapsed().as_secs_f64()
}

/// The system in the form of faer.
fn columns(matrix: &SparseMatrix<'_>) -> SparseColMat<usize, f64> {
    let n = matrix.order();
    let of_row = |row| matrix.row(row).map(move |(col, val)| Triplet { row, col, val });
    let triplets: Vec<_> = (0..n).flat_map(of_row).collect();
    SparseColMat::try_new_from_triplets(n, n, &triplets).expect("all entries lie inside the matrix")
}

fn report(name: &str, action: &DoubledAction<'_, f64, Geometry>) {
    let (layout, sbp, start) = (action.layout(), action.sbp(), action.initial());
    let row = |a: usize| (0..sbp.points()).map(|k| start.q[a] + start.q_dot[a] * sbp.node(k)).collect();
    let rows: Vec<Vec<f64>> = (0..layout.dimension()).map(row).collect();
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    let u = layout.physical_limit(&rows, &vec![0.0; layout.multiplier_range().len()]);
    let pattern = action.hessian_pattern();
    let hessian = action.hessian(&u, &pattern).expect("the line lies inside the domain");
    let envelope = action.envelope(&pattern);
    let (matrix, n) = (columns(&hessian), hessian.order());
    let symbolic = SymbolicLu::try_new(matrix.symbolic()).expect("the system fits into memory");
    let b: Vec<f64> = (0..n).map(|k| (k as f64).sin()).collect();
    let (begin, mut runs, mut least) = (Instant::now(), 0, [f64::INFINITY; 4]);
    while runs < RUNS || begin.elapsed().as_secs_f64() < PATIENCE {
        let mut x = [b.clone(), b.clone()];
        let found = [
            seconds(|| action.envelope(&pattern)),
            seconds(|| SymbolicLu::try_new(matrix.symbolic())),
            seconds(|| envelope.factor(&hessian).expect("it is regular").solve_in_place(&mut x[0])),
            seconds(|| {
                let lu = Lu::try_new_with_symbolic(symbolic.clone(), matrix.as_ref()).expect("it is regular");
                lu.solve_in_place_with_conj(faer::Conj::No, faer::MatMut::from_column_major_slice_mut(&mut x[1], n, 1));
            }),
        ];
        least = std::array::from_fn(|i| least[i].min(found[i]));
        runs += 1;
    }
    let [orders, faer_orders, solves, faer_solves] = least.map(|seconds| 1e3 * seconds);
    println!(
        "{name:38} {n:8} {:8} {orders:8.3} {faer_orders:8.3} {solves:9.3} {faer_solves:9.3} {:6.1}",
        envelope.size(),
        faer_solves / solves
    );
}

fn main() {
    let wanted = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    println!(
        "{:38} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>6}",
        "ms for a system", "unknowns", "kept", "order", "faer", "solution", "faer", "ratio"
    );
    for scene in SCENES {
        let case = SceneCase::parse(scene, builtin::text(scene).expect("a shipped scene"), &[]).expect("a valid scene");
        let (geometry, start): (Geometry, Start) = (case.geometry(), case.start());
        for (operator, points) in GRIDS {
            let spacing = 1.0 / (points - 1) as f64;
            let sbp = match operator {
                "SBP21" => SbpOperator::new(&coefficients::SBP21, points, spacing).expect("enough points"),
                "SBP42" => SbpOperator::new(&coefficients::SBP42, points, spacing).expect("enough points"),
                "SBP84" => SbpOperator::new(&coefficients::SBP84, points, spacing).expect("enough points"),
                _ => SbpOperator::gauss_lobatto(points, 1.0),
            };
            for (form, word) in [(Form::Strong, "strong"), (Form::Weak, "weak")] {
                let name = format!("{scene}, {operator}, {points}, {word}");
                if wanted.as_ref().is_none_or(|wanted| name.contains(wanted.as_str())) {
                    report(&name, &DoubledAction::of_form(form, &sbp, &geometry, start.clone()));
                }
            }
        }
    }
}
