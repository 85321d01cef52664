//! DOP853: the explicit Runge–Kutta pair of order 8 by Dormand and Prince, with Hairer's error estimate and control.

use super::driver::{AdaptiveSteps, Control, Counted, Walker, adaptive_steps};
use super::force::Force;
use super::{About, Failure, Output, Peer, Problem, Setting, State, Step, Trajectory};

const STAGES: usize = 12;
/// With the derivative at the end, and three that only the dense output needs.
const DENSE_STAGES: usize = 16;

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

/// Three more stages for the dense output, of which the thirteenth is the derivative at the end of the step.
const A_DENSE: [&[(usize, f64)]; 3] = [
    &[
        (0, 5.616_750_228_304_795e-2),
        (6, 2.535_002_102_166_248_3e-1),
        (7, -2.462_390_374_708_025e-1),
        (8, -1.241_914_232_638_163_7e-1),
        (9, 1.532_917_982_787_656_8e-1),
        (10, 8.201_052_295_634_69e-3),
        (11, 7.567_897_660_545_699e-3),
        (12, -8.298e-3),
    ],
    &[
        (0, 3.183_464_816_350_214e-2),
        (5, 2.830_090_967_236_677_6e-2),
        (6, 5.354_198_830_743_856_6e-2),
        (7, -5.492_374_857_139_099e-2),
        (10, -1.083_473_286_972_493_2e-4),
        (11, 3.825_710_908_356_584e-4),
        (12, -3.404_650_086_874_045_6e-4),
        (13, 1.413_124_436_746_325e-1),
    ],
    &[
        (0, -4.288_963_015_837_919_4e-1),
        (5, -4.697_621_415_361_164),
        (6, 7.683_421_196_062_599),
        (7, 4.068_989_818_397_11),
        (8, 3.567_271_874_552_811e-1),
        (12, -1.399_024_165_159_014_5e-3),
        (13, 2.947_514_789_152_772_4),
        (14, -9.150_958_472_179_87),
    ],
];

/// The stages' weights in the last four coefficients of the dense output.
const D: [&[(usize, f64)]; 4] = [
    &[
        (0, -8.428_938_276_109_013),
        (5, 5.667_149_535_193_777e-1),
        (6, -3.068_949_945_949_891_7),
        (7, 2.384_667_656_512_07),
        (8, 2.117_034_582_445_028),
        (9, -8.713_915_837_779_73e-1),
        (10, 2.240_437_430_260_788_3),
        (11, 6.315_787_787_694_688e-1),
        (12, -8.899_033_645_133_331e-2),
        (13, 1.814_850_552_085_472_7e1),
        (14, -9.194_632_392_478_356),
        (15, -4.436_036_387_594_894),
    ],
    &[
        (0, 1.042_750_864_257_913_4e1),
        (5, 2.422_834_917_752_581_7e2),
        (6, 1.652_004_517_172_702_8e2),
        (7, -3.745_467_547_226_902e2),
        (8, -2.211_366_685_312_530_6e1),
        (9, 7.733_432_668_472_264),
        (10, -3.067_408_473_108_939_8e1),
        (11, -9.332_130_526_430_229),
        (12, 1.569_723_812_177_084_5e1),
        (13, -3.113_940_321_956_517_8e1),
        (14, -9.352_924_358_844_48),
        (15, 3.581_684_148_639_408e1),
    ],
    &[
        (0, 1.998_505_324_200_243_3e1),
        (5, -3.870_373_087_493_518e2),
        (6, -1.891_781_381_951_675_8e2),
        (7, 5.278_081_592_054_236e2),
        (8, -1.157_390_253_995_963e1),
        (9, 6.881_232_694_696_3),
        (10, -1.000_605_096_691_083_8),
        (11, 7.777_137_798_053_443e-1),
        (12, -2.778_205_752_353_508),
        (13, -6.019_669_523_126_412e1),
        (14, 8.432_040_550_667_716e1),
        (15, 1.199_229_113_618_279e1),
    ],
    &[
        (0, -2.569_393_346_270_375e1),
        (5, -1.541_897_486_902_364_3e2),
        (6, -2.315_293_791_760_455e2),
        (7, 3.576_391_179_106_141e2),
        (8, 9.340_532_418_362_432e1),
        (9, -3.745_832_313_645_163e1),
        (10, 1.040_996_495_089_623e2),
        (11, 2.984_029_342_666_05e1),
        (12, -4.353_345_659_001_114e1),
        (13, 9.632_455_395_918_828e1),
        (14, -3.917_726_167_561_544e1),
        (15, -1.497_268_362_579_856_4e2),
    ],
];

/// Relative and absolute tolerance for x and w. The quadrature of t is carried along outside the error norm, where it
/// would only cost; between the ends of steps are the polynomials of degree 7 of the dense output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dop853;

impl Peer for Dop853 {
    fn about(&self) -> About {
        About {
            name: "DOP853".to_owned(),
            curve: "DOP853",
            order: Some(8),
            step: Step::Adaptive,
            has_dense_output: true,
            coarsest: 1.0,
            source: "Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, II.5",
        }
    }

    fn run(&self, problem: &Problem, output: &Output, setting: Setting) -> Result<Trajectory, Failure> {
        let (here, tolerance) = (problem.start(), setting.tolerance);
        let walk = Walk { tolerance, stages: Stages::default(), from: here, here, next: here, h: 0.0 };
        adaptive_steps(problem, output, tolerance, walk)
    }
}

/// Derivatives of (t, x, w) at the stages.
#[derive(Default)]
struct Stages {
    t: [f64; DENSE_STAGES],
    x: [f64; DENSE_STAGES],
    w: [f64; DENSE_STAGES],
}

impl Stages {
    #[inline(always)]
    fn set(&mut self, stage: usize, t: f64, x: f64, w: f64) {
        (self.t[stage], self.x[stage], self.w[stage]) = (t, x, w);
    }

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
    fn step(&mut self, force: &mut Counted<impl Force>, state: State, h: f64) -> State {
        let advance =
            |[t, x, w]: [f64; 3]| State { elapsed: state.elapsed + h * t, x: state.x + h * x, w: state.w + h * w };
        for stage in 1..STAGES {
            let at = advance(self.combine(A[stage - 1]));
            let (u, a) = force.at(at.x);
            self.set(stage, u, at.w, a);
        }
        advance(self.combine(A[STAGES - 1]))
    }

    /// The dense output of a step of length `h`, given the derivative at its end: it takes 3 evaluations.
    #[inline(always)]
    fn dense(&mut self, force: &mut Counted<impl Force>, from: State, to: State, h: f64) -> Dense {
        for (stage, row) in (STAGES + 1..).zip(A_DENSE) {
            let [_, x, w] = self.combine(row);
            let (u, a) = force.at(from.x + h * x);
            self.set(stage, u, from.w + h * w, a);
        }
        let (from, to) = ([from.elapsed, from.x, from.w], [to.elapsed, to.x, to.w]);
        let first = [self.t[0], self.x[0], self.w[0]];
        let end = [self.t[STAGES], self.x[STAGES], self.w[STAGES]];
        let mut coefficients = [[0.0; 3]; 8];
        for k in 0..3 {
            let rise = to[k] - from[k];
            coefficients[0][k] = from[k];
            coefficients[1][k] = rise;
            coefficients[2][k] = h * first[k] - rise;
            coefficients[3][k] = 2.0 * rise - h * (first[k] + end[k]);
        }
        for (coefficients, row) in coefficients[4..].iter_mut().zip(D) {
            *coefficients = self.combine(row).map(|sum| h * sum);
        }
        Dense { coefficients }
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

/// Σ over powers of s and 1 − s in turns, of (t, x, w).
struct Dense {
    coefficients: [[f64; 3]; 8],
}

impl Dense {
    #[inline(always)]
    fn at(&self, s: f64) -> State {
        let mut value = [0.0; 3];
        for (power, coefficients) in self.coefficients.iter().enumerate().rev() {
            let factor = if power % 2 == 0 { s } else { 1.0 - s };
            for k in 0..3 {
                value[k] = value[k] * factor + coefficients[k];
            }
        }
        let [elapsed, x, w] = value;
        State { elapsed, x, w }
    }
}

struct Walk {
    tolerance: f64,
    /// The stages of the step that was tried last. The derivative at the end of the last step is in its place for the
    /// dense output, behind the stages.
    stages: Stages,
    from: State,
    here: State,
    /// The end of the step that was tried last, and its length.
    next: State,
    h: f64,
}

impl Walker for Walk {
    #[inline(always)]
    fn state(&self) -> State {
        self.here
    }

    #[inline(always)]
    fn inside<F: Force>(&mut self, force: &mut Counted<F>, fractions: &[f64], states: &mut Vec<State>) {
        let dense = self.stages.dense(force, self.from, self.here, self.h);
        states.extend(fractions.iter().map(|&fraction| dense.at(fraction)));
    }
}

impl AdaptiveSteps for Walk {
    const CONTROL: Control =
        Control { exponent: 0.125, change: [1.0 / 3.0, 6.0], after_failure: 1.0 / 3.0, ends_on_output: false };

    #[inline(always)]
    fn begin<F: Force>(&mut self, _: &mut Counted<F>, (u, a): (f64, f64)) {
        self.stages.set(STAGES, u, self.here.w, a);
    }

    #[inline(always)]
    fn attempt<F: Force>(&mut self, force: &mut Counted<F>, h: f64) -> Option<f64> {
        let Self { stages, here, .. } = self;
        stages.set(0, stages.t[STAGES], stages.x[STAGES], stages.w[STAGES]);
        let next = stages.step(force, *here, h);
        let error = stages.error(*here, next, h, self.tolerance);
        (self.next, self.h) = (next, h);
        (next.x.is_finite() && next.w.is_finite() && !error.is_nan()).then_some(error)
    }

    #[inline(always)]
    fn accept<F: Force>(&mut self, force: &mut Counted<F>) {
        (self.from, self.here) = (self.here, self.next);
        let (u, a) = force.at(self.here.x);
        self.stages.set(STAGES, u, self.here.w, a);
    }
}
