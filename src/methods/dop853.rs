//! DOP853: the explicit Runge–Kutta pair of order 8 by Dormand and Prince, with Hairer's error estimate and control.

use super::force::{Force, WithForce, dispatch};
use super::{Failure, MOST_STEPS, Output, Problem, State, Trajectory, check};

const STAGES: usize = 12;

/// Rows 2 … 12 of A with b below: (stage, coefficient) of what is not zero. From dop853.f, E. Hairer and G. Wanner;
/// Hairer, Nørsett, Wanner, "Solving Ordinary Differential Equations I", II.5.
const A: [&[(usize, f64)]; STAGES] = [
    &[(0, 5.260_015_195_876_773e-2)],
    &[(0, 1.972_505_698_453_79e-2), (1, 5.917_517_095_361_37e-2)],
    &[(0, 2.958_758_547_680_685e-2), (2, 8.876_275_643_042_054e-2)],
    &[(0, 2.413_651_341_592_667e-1), (2, -8.845_494_793_282_861e-1), (3, 9.248_340_032_617_92e-1)],
    &[(0, 3.703_703_703_703_703_5e-2), (3, 1.708_286_087_294_738_6e-1), (4, 1.254_676_875_668_224_2e-1)],
    &[(0, 3.7109375e-2), (3, 1.702_522_110_195_440_5e-1), (4, 6.021_653_898_045_596e-2), (5, -1.7578125e-2)],
    &[
        (0, 3.709_200_011_850_479e-2),
        (3, 1.703_839_257_122_399_8e-1),
        (4, 1.072_620_304_463_732_8e-1),
        (5, -1.531_943_774_862_440_2e-2),
        (6, 8.273_789_163_814_023e-3),
    ],
    &[
        (0, 6.241_109_587_160_757e-1),
        (3, -3.360_892_629_446_941_4),
        (4, -8.682_193_468_417_26e-1),
        (5, 2.759_209_969_944_671e1),
        (6, 2.015_406_755_047_789_4e1),
        (7, -4.348_988_418_106_996e1),
    ],
    &[
        (0, 4.776_625_364_382_643_4e-1),
        (3, -2.488_114_619_971_667_7),
        (4, -5.902_908_268_368_43e-1),
        (5, 2.123_005_144_818_119_3e1),
        (6, 1.527_923_363_288_242_3e1),
        (7, -3.328_821_096_898_486e1),
        (8, -2.033_120_170_850_862_7e-2),
    ],
    &[
        (0, -9.371_424_300_859_873e-1),
        (3, 5.186_372_428_844_064),
        (4, 1.091_437_348_996_729_5),
        (5, -8.149_787_010_746_927),
        (6, -1.852_006_565_999_696e1),
        (7, 2.273_948_709_935_050_5e1),
        (8, 2.493_605_552_679_652_3),
        (9, -3.046_764_471_898_219_6),
    ],
    &[
        (0, 2.273_310_147_516_538),
        (3, -1.053_449_546_673_725e1),
        (4, -2.000_872_058_224_862_5),
        (5, -1.795_893_186_311_88e1),
        (6, 2.794_888_452_941_996e1),
        (7, -2.858_998_277_135_023_5),
        (8, -8.872_856_933_530_63),
        (9, 1.236_056_717_579_430_3e1),
        (10, 6.433_927_460_157_636e-1),
    ],
    &[
        (0, 5.429_373_411_656_876_5e-2),
        (5, 4.450_312_892_752_409),
        (6, 1.891_517_899_314_500_3),
        (7, -5.801_203_960_010_585),
        (8, 3.111_643_669_578_199e-1),
        (9, -1.521_609_496_625_161e-1),
        (10, 2.013_654_008_040_303_4e-1),
        (11, 4.471_061_572_777_259e-2),
    ],
];

/// What b lacks to the embedded method of order 5, and that of order 3.
const E5: [(usize, f64); 8] = [
    (0, 1.312_004_499_419_488e-2),
    (5, -1.225_156_446_376_204_4),
    (6, -4.957_589_496_572_502e-1),
    (7, 1.664_377_182_454_986_4),
    (8, -3.503_288_487_499_736_6e-1),
    (9, 3.341_791_187_130_175e-1),
    (10, 8.192_320_648_511_571e-2),
    (11, -2.235_530_786_388_629_4e-2),
];
const B3: [(usize, f64); 3] =
    [(0, 2.440_944_881_889_764e-1), (8, 7.338_466_882_816_118e-1), (11, 2.205_882_352_941_176_6e-2)];

/// A step's share of the one that the error allows, and the limits of its change.
const SAFETY: f64 = 0.9;
const LEAST_CHANGE: f64 = 1.0 / 3.0;
const MOST_CHANGE: f64 = 6.0;
/// Shorter steps than this share of the whole length are none.
const LEAST_STEP: f64 = 1e-13;

/// The world-line with relative and absolute `tolerance` for x and w. The quadrature of t is carried along outside the
/// error norm, where it would only cost; steps end on the points of `output`, the last ones before it made even.
///
/// # Errors
/// [`Failure`].
pub fn dop853(problem: &Problem, output: &Output, tolerance: f64) -> Result<Trajectory, Failure> {
    dispatch(&problem.metric, problem.q_t(), March { problem, output, tolerance })
}

struct March<'a> {
    problem: &'a Problem,
    output: &'a Output,
    tolerance: f64,
}

/// Derivatives of (t, x, w) at the stages.
#[derive(Default)]
struct Stages {
    t: [f64; STAGES],
    x: [f64; STAGES],
    w: [f64; STAGES],
}

impl Stages {
    #[inline(always)]
    fn combine(&self, row: &[(usize, f64)]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &(j, c) in row {
            sum[0] += c * self.t[j];
            sum[1] += c * self.x[j];
            sum[2] += c * self.w[j];
        }
        sum
    }

    /// One step of length `h`; the first stage is there already.
    #[inline(always)]
    fn step(&mut self, force: &mut impl Force, state: State, h: f64) -> State {
        let advance =
            |[t, x, w]: [f64; 3]| State { elapsed: state.elapsed + h * t, x: state.x + h * x, w: state.w + h * w };
        for stage in 1..STAGES {
            let at = advance(self.combine(A[stage - 1]));
            let (u, a) = force.at(at.x);
            (self.t[stage], self.x[stage], self.w[stage]) = (u, at.w, a);
        }
        advance(self.combine(A[STAGES - 1]))
    }

    /// The error of a step of length `h` in units of the tolerance.
    #[inline(always)]
    fn error(&self, from: State, to: State, h: f64, tolerance: f64) -> f64 {
        let (five, mut three) = (self.combine(&E5), self.combine(A[STAGES - 1]));
        let embedded = self.combine(&B3);
        let scales = [from.x.abs().max(to.x.abs()), from.w.abs().max(to.w.abs())].map(|v| tolerance * (1.0 + v));
        let (mut err, mut err_2) = (0.0, 0.0);
        for k in 0..2 {
            three[k + 1] -= embedded[k + 1];
            err += (five[k + 1] / scales[k]).powi(2);
            err_2 += (three[k + 1] / scales[k]).powi(2);
        }
        let denominator = err + 0.01 * err_2;
        if denominator == 0.0 { 0.0 } else { h * err / (2.0 * denominator).sqrt() }
    }
}

impl WithForce for March<'_> {
    type Output = Result<Trajectory, Failure>;

    #[inline(always)]
    fn with(self, mut force: impl Force) -> Self::Output {
        let Self { problem, output, tolerance } = self;
        let mut state = problem.start();
        let (u, a) = force.at(state.x);
        let mut stages = Stages::default();
        (stages.t[0], stages.x[0], stages.w[0]) = (u, state.w, a);
        // A step on which the force changes x about as much as the tolerance of order 8 allows.
        let pace = a.abs().sqrt().max(state.w.abs()).max(1.0 / problem.length);
        let mut h = (0.5 * tolerance.powf(0.125) / pace).min(problem.length);
        let (mut evaluations, mut accepted, mut attempts) = (1, 0, 0);
        let mut gamma = 0.0;
        let mut states = Vec::with_capacity(output.marks.len());
        for target in output.gamma(problem.length) {
            loop {
                let remaining = target - gamma;
                // As many steps as it takes to the point, all alike: no short one is left over.
                let parts = (remaining / h * (1.0 - 1e-12)).ceil().max(1.0);
                let step = if parts <= 2.0 { remaining / parts } else { h };
                let next = stages.step(&mut force, state, step);
                evaluations += STAGES - 1;
                attempts += 1;
                let error = stages.error(state, next, step, tolerance);
                if attempts > MOST_STEPS || step < LEAST_STEP * problem.length {
                    return Err(Failure::TooManySteps);
                }
                if !(next.x.is_finite() && next.w.is_finite()) {
                    h = step * LEAST_CHANGE;
                    continue;
                }
                let change = (SAFETY * error.powf(-0.125)).clamp(LEAST_CHANGE, MOST_CHANGE);
                if error > 1.0 {
                    h = step * change.min(1.0);
                    continue;
                }
                // A step that was cut says nothing against longer ones.
                h = if step < h { (step * change).max(h) } else { step * change };
                state = next;
                gamma += step;
                accepted += 1;
                let (u, a) = force.at(state.x);
                evaluations += 1;
                (stages.t[0], stages.x[0], stages.w[0]) = (u, state.w, a);
                if parts == 1.0 {
                    gamma = target;
                    break;
                }
            }
            check(&problem.metric, state)?;
            states.push(state);
        }
        Ok(Trajectory { states, evaluations, steps: accepted })
    }
}
