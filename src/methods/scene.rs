//! The equations of a scene of n coordinates.

use nalgebra::{DMatrix, DVectorViewMut, Dyn, LU};

use super::equations::{Equations, Parts};
use super::{Failure, Problem, States};
use crate::geometry::{Geometry, Point, Start};

/// Hamilton's equations. Quadratures are the ignorable coordinates, counted from the start; positions are the active
/// ones. Behind them are the velocities of these if the geometry is separable, and otherwise the momenta.
pub(super) struct SceneEquations<'p> {
    problem: &'p Problem,
    parts: Parts,
    ignorable: Vec<usize>,
    /// g_ab of the active coordinates, where it is constant.
    block: Vec<f64>,
    point: Point,
    evaluations: usize,
    /// All coordinates and momenta. Charges stay in their places.
    q: Vec<f64>,
    p: Vec<f64>,
    /// ∂(q̇, ṗ)/∂(q, p) of the active coordinates, and the derivatives of the driving rates by the unknowns.
    jacobian: DMatrix<f64>,
    driving: DMatrix<f64>,
    /// The system of [`Equations::correct`].
    nodes: LU<f64, Dyn, Dyn>,
}

/// Replaces a right-hand side by the solution, which is not a number if there is none.
fn solve(system: &LU<f64, Dyn, Dyn>, right: &mut [f64]) {
    let count = right.len();
    if !system.solve_mut(&mut DVectorViewMut::from_slice(right, count)) {
        right.fill(f64::NAN);
    }
}

impl<'p> SceneEquations<'p> {
    pub(super) fn new(problem: &'p Problem) -> Self {
        let Problem { space: geometry, start, .. } = problem;
        let (n, active) = (geometry.dimension(), geometry.active());
        let m = active.len();
        let parts = Parts { quadratures: n - m, positions: m, is_second_order: geometry.is_separable() };
        Self {
            problem,
            parts,
            ignorable: geometry.ignorable().collect(),
            block: block(geometry, start),
            point: geometry.point(),
            evaluations: 0,
            q: start.q.clone(),
            p: start.p.clone(),
            jacobian: DMatrix::zeros(2 * m, 2 * m),
            driving: DMatrix::zeros(0, 0),
            nodes: DMatrix::zeros(0, 0).lu(),
        }
    }

    /// Puts the active coordinates and their momenta into their places.
    fn place(&mut self, state: &[f64]) {
        let (active, m) = (self.problem.space.active(), self.parts.positions);
        let (positions, rest) = state[self.parts.quadratures..].split_at(m);
        for (place, &a) in active.iter().enumerate() {
            self.q[a] = positions[place];
            // The momenta of a separable geometry do not act on the others.
            if !self.parts.is_second_order {
                self.p[a] = rest[place];
            }
        }
    }
}

/// g_ab of the active coordinates of a separable geometry: p_a = g_ab q̇^b.
fn block(geometry: &Geometry, start: &Start) -> Vec<f64> {
    let active = geometry.active();
    if !geometry.is_separable() {
        return Vec::new();
    }
    let still = geometry.momenta(&start.q, &vec![0.0; start.q.len()]);
    let column = |b: usize| {
        let mut q_dot = vec![0.0; start.q.len()];
        q_dot[b] = 1.0;
        geometry.momenta(&start.q, &q_dot)
    };
    let columns: Vec<Vec<f64>> = active.iter().map(|&b| column(b)).collect();
    active.iter().flat_map(|&a| columns.iter().map(|column| column[a] - still[a]).collect::<Vec<f64>>()).collect()
}

impl Equations for SceneEquations<'_> {
    type Rows<T: Copy> = Vec<T>;

    fn rows<T: Copy>(&self, value: T) -> Vec<T> {
        vec![value; self.parts.quadratures + 2 * self.parts.positions]
    }

    #[inline(always)]
    fn parts(&self) -> Parts {
        self.parts
    }

    fn start(&self) -> Vec<f64> {
        let (start, active) = (&self.problem.start, self.problem.space.active());
        let rest = if self.parts.is_second_order { &start.q_dot } else { &start.p };
        let mut state = vec![0.0; self.parts.quadratures];
        state.extend(active.iter().map(|&a| start.q[a]));
        state.extend(active.iter().map(|&a| rest[a]));
        state
    }

    fn evaluations(&self) -> usize {
        self.evaluations
    }

    fn rates(&mut self, state: &Vec<f64>, rates: &mut Vec<f64>) {
        self.evaluations += 1;
        self.place(state);
        let geometry = &*self.problem.space;
        if self.point.evaluate(&self.q, &self.p).is_err() {
            rates.fill(f64::NAN);
            return;
        }
        let (quadratures, moving) = rates.split_at_mut(self.parts.quadratures);
        for (rate, &a) in quadratures.iter_mut().zip(&self.ignorable) {
            *rate = self.point.q_dot(a);
        }
        let (positions, rest) = moving.split_at_mut(self.parts.positions);
        if self.parts.is_second_order {
            positions.copy_from_slice(&state[self.parts.driving()]);
            for (place, rate) in rest.iter_mut().enumerate() {
                *rate = self.point.acceleration(place).unwrap_or(f64::NAN);
            }
            return;
        }
        for (place, (&a, (position, momentum))) in
            geometry.active().iter().zip(positions.iter_mut().zip(rest)).enumerate()
        {
            *position = self.point.q_dot(a);
            *momentum = self.point.p_dot(place);
        }
    }

    fn point(&mut self, state: &Vec<f64>, out: &mut States) -> Result<(), Failure> {
        if !state.iter().all(|v| v.is_finite()) {
            return Err(Failure::Diverged);
        }
        self.place(state);
        let Problem { space: geometry, start, .. } = self.problem;
        self.point.evaluate(&self.q, &self.p).map_err(|_| Failure::OutsideDomain)?;
        let Self { q, p, .. } = self;
        for (&a, elapsed) in self.ignorable.iter().zip(state) {
            q[a] = start.q[a] + elapsed;
        }
        if self.parts.is_second_order {
            let q_dot = &state[self.parts.driving()];
            for (row, &a) in self.block.chunks_exact(self.parts.positions.max(1)).zip(geometry.active()) {
                p[a] = row.iter().zip(q_dot).map(|(g, q_dot)| g * q_dot).sum();
            }
        }
        out.push(q, p);
        Ok(())
    }

    fn linearise(&mut self, state: &Vec<f64>) {
        self.evaluations += 1;
        self.place(state);
        let Self { jacobian, point, q, p, parts, .. } = self;
        jacobian.fill(0.0);
        point.jacobian(q, p, |row, column, value| jacobian[(row, column)] = value);
        let m = parts.positions;
        self.driving = match parts.is_second_order {
            // q̈ = g ṗ with g = ∂q̇/∂p.
            true => jacobian.view((0, m), (m, m)) * jacobian.view((m, 0), (m, m)),
            false => jacobian.clone(),
        };
    }

    fn factor(&mut self, matrix: &[[f64; 3]; 3], scale: f64) {
        let (driving, size) = (&self.driving, 3 * self.parts.unknowns().len());
        let entry = |row: usize, column: usize| {
            let one = f64::from(u8::from(row == column));
            one - scale * matrix[row % 3][column % 3] * driving[(row / 3, column / 3)]
        };
        self.nodes = DMatrix::from_fn(size, size, entry).lu();
    }

    fn correct(&mut self, right: &mut Vec<[f64; 3]>) {
        solve(&self.nodes, right[self.parts.unknowns()].as_flattened_mut());
    }

    fn smooth(&mut self, diagonal: f64, right: &mut Vec<f64>) {
        let m = self.parts.positions;
        let derivative = |row: usize, column: usize| match self.parts.is_second_order {
            false => self.jacobian[(row, column)],
            true if row < m => f64::from(u8::from(column == row + m)),
            true if column < m => self.driving[(row - m, column)],
            true => 0.0,
        };
        let entry = |row, column| diagonal * f64::from(u8::from(row == column)) - derivative(row, column);
        solve(&DMatrix::from_fn(2 * m, 2 * m, entry).lu(), &mut right[self.parts.moving()]);
    }
}
