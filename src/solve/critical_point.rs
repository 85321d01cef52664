//! The critical point of the doubled action: Newton's method on ∇E_IVP = 0 from equal branches, with a sparse LU.

use std::iter;

use super::newton::{self, Equations, Failure, NewtonSystem, Root};
use super::status::Status;
use crate::action::{DoubledAction, GradientRounding};
use crate::geometry::OutsideGeometry;
use crate::linalg::Singular;
use crate::linalg::sparse::{Pattern, SparseLu};
use crate::number::Real;
use crate::number::norm::max_abs;

/// A refined linear solution must leave less than this share of the right-hand side; more means that the factorisation
/// is useless.
const LINEAR_TOLERANCE: f64 = 1e-3;

/// The critical point of `action` that Newton's method reaches from `guess`, where `rough` is the same action in `f64`.
/// More digits are those of a refinement, with the factors of Newton's system at the `f64` critical point.
pub(super) fn solve<S: Real>(
    action: &DoubledAction<'_, S>,
    rough: &DoubledAction<'_, f64>,
    guess: Vec<f64>,
    (digits, max_iterations): (u32, usize),
) -> Result<Root<S>, Failure> {
    let pattern = &rough.newton_pattern();
    let root = newton::solve(&mut Stationarity { pattern, action: rough }, guess, max_iterations)?;
    if !S::IS_EXTENDED {
        let Root { unknowns, history } = root;
        return Ok(Root { unknowns: unknowns.into_iter().map(S::from).collect(), history });
    }
    let (layout, lu) = (action.layout(), factored(pattern, rough, &root.unknowns));
    let lu = lu.ok_or_else(|| Failure::without_iterate(Status::Singular))?;
    let solve = |right: &mut [f64]| {
        let mut equal = layout.equal_equations(right);
        lu.solve_in_place(&mut equal);
        layout.write_equal_step(&equal, right);
        Ok(())
    };
    newton::refine(&mut Stationarity { pattern, action }, solve, root, (digits, max_iterations))
}

/// ∇E_IVP = 0, with the pattern of its Newton system.
struct Stationarity<'a, S> {
    pattern: &'a Pattern,
    action: &'a DoubledAction<'a, S>,
}

impl<S: Real> Equations<S> for Stationarity<'_, S> {
    fn residual(&mut self, u: &[S], out: &mut [S]) -> Result<(), OutsideGeometry> {
        self.action.gradient(u, out)
    }

    fn rounding(&self, u: &[S]) -> Option<Vec<f64>> {
        let GradientRounding { rows, values, .. } = self.action.gradient_rounding(u).ok()?;
        let h = self.action.sbp.spacing().to_f64();
        let mut levels = on_nodes(&rows, self.action);
        levels.extend_from_within(..);
        if !self.action.layout().multiplier_range().is_empty() {
            // Those of λ and μ, of ν, and of κ.
            levels.extend(values.iter().flat_map(|&value| [value, value / h]));
            levels.extend_from_slice(&values);
            levels.extend(values.iter().map(|value| value / h));
        }
        Some(levels)
    }

    /// Largest absolute value of each coordinate on both branches.
    fn sizes(&self, u: &[S]) -> Vec<S> {
        let layout = self.action.layout();
        let size = |a| max_abs(layout.values(u, 0, a)).max(max_abs(layout.values(u, 1, a)));
        (0..layout.dimension).map(size).collect()
    }

    fn scales(&self, u: &[S]) -> Vec<S> {
        let rounding = self.action.gradient_rounding(u);
        rounding.map_or_else(|_| self.sizes(u), |rounding| rounding.sizes.into_iter().map(S::from).collect())
    }
}

impl NewtonSystem for Stationarity<'_, f64> {
    fn newton_step(&mut self, u: &[f64], residual: &[f64], step: &mut [f64]) -> Result<(), Singular> {
        let lu = factored(self.pattern, self.action, u).ok_or(Singular)?;
        let layout = self.action.layout();
        let right: Vec<f64> = layout.equal_equations(residual).iter().map(|r| -r).collect();
        // One solve and two steps of iterative refinement: the matrix is indefinite and its entries span 1/h.
        let (mut solution, mut remainder) = (vec![0.0; right.len()], right.clone());
        for _ in 0..3 {
            lu.solve_in_place(&mut remainder);
            solution.iter_mut().zip(&remainder).for_each(|(solution, part)| *solution += part);
            remainder = right.iter().zip(lu.multiply(&solution)).map(|(right, product)| right - product).collect();
        }
        layout.write_equal_step(&solution, step);
        if !layout.multiplier_range().is_empty() {
            // λ holds the start, which the elimination finds but for rounding in units of the end.
            for (branch, a) in (0..2).flat_map(|branch| (0..layout.dimension).map(move |a| (branch, a))) {
                let first = layout.row(branch, a);
                step[first] = self.action.initial.q[a] - u[first];
            }
        }
        let [left, size] = [&remainder, &right].map(|rows| max_abs(&lu.in_units(rows)));
        if left <= LINEAR_TOLERANCE * size { Ok(()) } else { Err(Singular) }
    }
}

/// The factors of Newton's system at equal branches. What rounds there are the units of its equations, those of λ and μ
/// are the units of q, and those of the others the units of the multipliers beside them.
fn factored(pattern: &Pattern, action: &DoubledAction<'_, f64>, u: &[f64]) -> Option<SparseLu> {
    let GradientRounding { rows, values, .. } = action.gradient_rounding(u).ok()?;
    let (layout, h) = (action.layout(), action.sbp.spacing());
    let mut units = [&rows, &values].map(|units| on_nodes(units, action));
    if !layout.multiplier_range().is_empty() {
        units[0].extend(values.iter().flat_map(|&unit| [unit, unit / h]));
        units[1].extend(rows.iter().copied().chain(rows.iter().map(|unit| unit * h)));
    }
    pattern.factor(&action.newton_matrix(u).ok()?, [&units[0], &units[1]]).ok()
}

/// Numbers of each coordinate, for every row of a branch.
fn on_nodes<S: Real>(of_coordinates: &[f64], action: &DoubledAction<'_, S>) -> Vec<f64> {
    of_coordinates.iter().flat_map(|&number| iter::repeat_n(number, action.sbp.points())).collect()
}
