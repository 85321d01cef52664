//! Approximations that a proof starts from: the motion in a window, and its adjoint matrix. Nothing is proved of them;
//! where they are bad the bounds that follow are large.

use super::algebras::{LANES, Row};
use super::equations::Equations;
use super::tables::{FEW, FewRow, MODES, TABLES};
use crate::formula::run_at;
use crate::number::Real;
use crate::number::norm::larger;

/// Sweeps end when changes are below this share of the sizes, or do not shrink any more below the other one.
const SMALLEST_CHANGE: f64 = 3e-16;
const SMALL_CHANGE: f64 = 4e-15;
const MOST_SWEEPS: usize = 120;
/// The adjoint matrix needs few digits: E is to be 1e-6.
const SMALL_CHANGE_OF_ADJOINT: f64 = 1e-8;
const MOST_ADJOINT_SWEEPS: usize = 60;

/// Coefficients below this share of the largest slope are rounding of the sweeps. On the ellipse they would be as large
/// as the motion.
const NOISE: f64 = 2e-16;

/// Room for both, and the window before, from which the first guess of the next comes.
pub(super) struct Approximate {
    registers: Vec<Row>,
    of_jacobian: Vec<FewRow>,
    y: Vec<Row>,
    v: Vec<Row>,
    before: Option<(f64, Vec<Row>)>,
}

/// Σ of the columns of a table, times factors.
#[inline(always)]
pub(super) fn combined<const N: usize>(table: &[[f64; N]], factors: impl Iterator<Item = f64>) -> [f64; N] {
    let mut sum = [0.0; N];
    for (row, factor) in table.iter().zip(factors) {
        for i in 0..N {
            sum[i] = factor.mul_add(row[i], sum[i]);
        }
    }
    sum
}

impl Approximate {
    pub(super) fn new(equations: &Equations<'_>) -> Self {
        Self {
            registers: equations.registers(false, |constant| [constant.to_f64(); LANES]),
            of_jacobian: equations.registers(true, |constant| [constant.to_f64(); FEW]),
            y: vec![[0.0; LANES]; equations.unknowns],
            v: vec![[0.0; LANES]; equations.unknowns],
            before: None,
        }
    }

    /// Keeps the slopes of a window for the next one.
    pub(super) fn keep(&mut self, h: f64, slopes: Vec<Row>) {
        self.before = Some((h, slopes));
    }

    /// The Legendre coefficients of the slopes in the window of length `h` from `start`; `None` if sweeps do not
    /// converge.
    #[inline(always)]
    pub(super) fn slopes(&mut self, equations: &Equations<'_>, start: &[f64], h: f64) -> Option<Vec<Row>> {
        self.guess(equations.active, start, h);
        let m = equations.active / 2;
        let (mut most, mut sizes) = (vec![0.0; equations.unknowns], vec![0.0; equations.unknowns]);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_SWEEPS {
            for k in 0..2 * m {
                self.registers[equations.variables[k]] = self.y[k];
            }
            for (steps, range) in [(&equations.forces, m..2 * m), (&equations.velocities, 0..m)] {
                run_at(steps, &mut self.registers);
                for k in range {
                    (most[k], sizes[k]) = self.sweep(equations, k, start[k], h);
                    self.registers[equations.variables[k]] = self.y[k];
                }
            }
            let shares = most.iter().zip(equations.shared(&sizes)).map(|(most, size)| most / size.max(1e-300));
            let change = shares.fold(0.0, larger);
            if !change.is_finite() {
                return None;
            }
            if change < SMALLEST_CHANGE || change < SMALL_CHANGE && change >= 0.3 * last {
                run_at(&equations.all, &mut self.registers);
                let slopes = equations.slopes.iter().map(|&register| cleaned(&self.registers[register]));
                return Some(slopes.collect());
            }
            last = change;
        }
        None
    }

    /// Continues the slopes of the window before.
    #[inline(always)]
    fn guess(&mut self, active: usize, start: &[f64], h: f64) {
        let table = self.before.as_ref().map(|(length, _)| TABLES.continued(h / length));
        for k in 0..active {
            let rest = match (&self.before, &table) {
                (Some((_, modes)), Some(table)) => {
                    let slope = combined(table, modes[k].iter().copied());
                    combined(&TABLES.integrals, slope.iter().map(|slope| h * slope))
                }
                _ => [0.0; LANES],
            };
            self.y[k] = rest.map(|rest| start[k] + rest);
        }
    }

    /// Integrates one slope. Returns by how much that changes the unknown, and its size.
    #[inline(always)]
    fn sweep(&mut self, equations: &Equations<'_>, k: usize, start: f64, h: f64) -> (f64, f64) {
        let slope = self.registers[equations.slopes[k]];
        let way = combined(&TABLES.integrals, slope.iter().map(|slope| h * slope));
        let (mut most, mut size) = (0.0_f64, 0.0_f64);
        for i in 0..LANES {
            let new = start + way[i];
            most = larger(most, (new - self.y[k][i]).abs());
            size = size.max(new.abs()).max((h * slope[i]).abs());
            self.y[k][i] = new;
        }
        self.v[k] = slope;
        (most, size)
    }

    /// Coefficients of W for the slopes of a window: where B′ = W, B = I + ∫W, it solves W = −BJ. `None` if sweeps do
    /// not converge. Columns of what nothing depends on are zero.
    #[inline(always)]
    pub(super) fn adjoint(
        &mut self,
        equations: &Equations<'_>,
        start: &[f64],
        h: f64,
        slopes: &[Row],
    ) -> Option<Vec<FewRow>> {
        let (d, active) = (equations.unknowns, equations.active);
        for k in 0..active {
            let way = combined(&TABLES.few_integral, slopes[k].iter().map(|slope| 0.5 * h * slope));
            self.of_jacobian[equations.variables[k]] = way.map(|way| start[k] + way);
        }
        run_at(&equations.of_jacobian, &mut self.of_jacobian);
        let mut columns: Vec<Vec<(usize, FewRow)>> = vec![Vec::new(); active];
        for entry in &equations.entries {
            let value = equations.value(entry, &self.of_jacobian, |constant| [constant.to_f64(); FEW]);
            columns[entry.column].push((entry.row, value));
        }
        let one = |i: usize, c: usize| if i == c { 1.0 } else { 0.0 };
        let mut b: Vec<FewRow> = (0..d * d).map(|at| [one(at / d, at % d); FEW]).collect();
        let mut w = vec![[0.0; FEW]; d * d];
        let mut last = f64::INFINITY;
        for _ in 0..MOST_ADJOINT_SWEEPS {
            let (mut change, mut largest) = (0.0, 1.0_f64);
            for (i, (c, entries)) in (0..d).flat_map(|i| columns.iter().enumerate().map(move |column| (i, column))) {
                let mut slope = [0.0; FEW];
                for (row, value) in entries {
                    for k in 0..FEW {
                        slope[k] -= b[i * d + row][k] * value[k];
                    }
                }
                w[i * d + c] = slope;
                let way = combined(&TABLES.few_integrals, slope.iter().map(|slope| h * slope));
                for k in 0..FEW {
                    let new = one(i, c) + way[k];
                    change = larger(change, (new - b[i * d + c][k]).abs());
                    largest = largest.max(new.abs());
                    b[i * d + c][k] = new;
                }
            }
            if !change.is_finite() {
                return None;
            }
            if change < SMALL_CHANGE_OF_ADJOINT * largest
                || change < 100.0 * SMALL_CHANGE_OF_ADJOINT * largest && change > 0.5 * last
            {
                return Some(w.iter().map(|w| TABLES.few_modes_of(w)).collect());
            }
            last = change;
        }
        None
    }
}

/// The coefficients of values at the nodes without those that are noise.
fn cleaned(values: &Row) -> Row {
    let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let mut modes = TABLES.modes_of(values);
    // The highest ones: in a small one between larger ones there may be a digit.
    for k in (0..MODES).rev() {
        if modes[k].abs() > NOISE * largest * (2 * k + 1) as f64 {
            break;
        }
        modes[k] = 0.0;
    }
    modes
}
