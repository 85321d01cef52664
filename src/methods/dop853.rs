//! DOP853: the explicit Runge–Kutta pair of order 8 by Dormand and Prince, with Hairer's error estimate and control.

use super::driver::{AdaptiveSteps, Control, Method, Task, Walker, adaptive_steps};
use super::equations::{Equations, step};
use super::{Failure, Trajectory};

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

/// The difference of b from the embedded methods of order 5 and of order 3.
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

pub(super) struct Dop853;

impl Method for Dop853 {
    #[inline(always)]
    fn integrate<E: Equations>(&self, equations: E, task: &Task<'_>) -> Result<Trajectory, Failure> {
        const CONTROL: Control =
            Control { exponent: 0.125, change: [1.0 / 3.0, 6.0], after_failure: 1.0 / 3.0, ends_on_output: false };
        let (here, zero, tolerance) = (equations.start(), equations.rows(0.0), task.setting.tolerance);
        let stages = equations.rows([0.0; DENSE_STAGES]);
        let sums = [(); 3].map(|()| zero.clone());
        let walk = Walk { tolerance, stages, sums, from: here.clone(), next: zero, here, h: 0.0 };
        adaptive_steps(equations, task, CONTROL, walk)
    }
}

/// The derivatives of one number of a state at the stages.
type AtStages = [f64; DENSE_STAGES];

/// `sum` = Σ over the entries of `row` of coefficient times the derivatives at that stage.
#[inline(always)]
fn combine(stages: &[AtStages], row: &[(usize, f64)], sum: &mut [f64]) {
    sum.fill(0.0);
    for &(j, c) in row {
        for (sum, stages) in sum.iter_mut().zip(stages) {
            *sum += c * stages[j];
        }
    }
}

/// Sets the derivatives at a stage.
#[inline(always)]
fn set(stages: &mut [AtStages], stage: usize, rates: &[f64]) {
    for (stages, rate) in stages.iter_mut().zip(rates) {
        stages[stage] = *rate;
    }
}

struct Walk<E: Equations> {
    tolerance: f64,
    /// The derivatives at the stages of the step that was tried last. The derivative at the end of the last step is in
    /// its place for the dense output, behind the stages.
    stages: E::Rows<AtStages>,
    /// Room for sums over stages, one of the stages, and the derivatives there.
    sums: [E::Rows<f64>; 3],
    from: E::Rows<f64>,
    here: E::Rows<f64>,
    /// The end of the step that was tried last, and its length.
    next: E::Rows<f64>,
    h: f64,
}

impl<E: Equations> Walk<E> {
    /// The coefficients of the dense output of the last step, for powers of s and 1 − s in turns. It takes 3
    /// evaluations.
    #[inline(always)]
    fn dense(&mut self, equations: &mut E) -> [E::Rows<f64>; 8] {
        let Self { stages, sums: [sum, at, rates], from, here, h, .. } = self;
        for (stage, row) in (STAGES + 1..).zip(A_DENSE) {
            combine(stages.as_ref(), row, sum.as_mut());
            step(at, from, *h, sum);
            equations.rates(at, rates);
            set(stages.as_mut(), stage, rates.as_ref());
        }
        let (from, to, h, stages) = (from.as_ref(), here.as_ref(), *h, stages.as_ref());
        let mut coefficients: [E::Rows<f64>; 8] = std::array::from_fn(|_| here.clone());
        let [zero, one, two, three, high @ ..] = &mut coefficients;
        for k in 0..from.len() {
            let rise = to[k] - from[k];
            zero.as_mut()[k] = from[k];
            one.as_mut()[k] = rise;
            two.as_mut()[k] = h * stages[k][0] - rise;
            three.as_mut()[k] = 2.0 * rise - h * (stages[k][0] + stages[k][STAGES]);
        }
        for (coefficients, row) in high.iter_mut().zip(D) {
            combine(stages, row, coefficients.as_mut());
            coefficients.as_mut().iter_mut().for_each(|sum| *sum *= h);
        }
        coefficients
    }
}

impl<E: Equations> Walker<E> for Walk<E> {
    #[inline(always)]
    fn state(&self) -> &E::Rows<f64> {
        &self.here
    }

    #[inline(always)]
    fn inside(&mut self, equations: &mut E, fractions: &[f64]) -> Vec<E::Rows<f64>> {
        let dense = self.dense(equations);
        let at = |&s: &f64| {
            let mut state = equations.rows(0.0);
            for (power, coefficients) in dense.iter().enumerate().rev() {
                let factor = if power % 2 == 0 { s } else { 1.0 - s };
                for (value, coefficient) in state.as_mut().iter_mut().zip(coefficients.as_ref()) {
                    *value = *value * factor + coefficient;
                }
            }
            state
        };
        fractions.iter().map(at).collect()
    }
}

impl<E: Equations> AdaptiveSteps<E> for Walk<E> {
    #[inline(always)]
    fn begin(&mut self, _: &mut E, rates: &E::Rows<f64>) {
        set(self.stages.as_mut(), STAGES, rates.as_ref());
    }

    #[inline(always)]
    fn attempt(mut self, equations: &mut E, h: f64) -> (Self, Option<f64>) {
        let ([mut sum, mut at, mut rates], here, mut next) = (self.sums, self.here, self.next);
        let stages = self.stages.as_mut();
        stages.iter_mut().for_each(|stages| stages[0] = stages[STAGES]);
        for stage in 1..STAGES {
            combine(stages, A[stage - 1], sum.as_mut());
            step(&mut at, &here, h, &sum);
            equations.rates(&at, &mut rates);
            set(stages, stage, rates.as_ref());
        }
        combine(stages, A[STAGES - 1], sum.as_mut());
        step(&mut next, &here, h, &sum);
        // The sums of orders 5 and 3 take the places of a stage and its derivatives.
        combine(stages, &E5, at.as_mut());
        combine(stages, &B3, rates.as_mut());
        let [eight, five, three] = [&sum, &at, &rates].map(AsRef::as_ref);
        let [from, to] = [&here, &next].map(AsRef::as_ref);
        let (moving, mut err, mut err_2) = (equations.parts().moving(), 0.0, 0.0);
        for k in moving.clone() {
            let scale = self.tolerance * (1.0 + from[k].abs().max(to[k].abs()));
            err += (five[k] / scale).powi(2);
            err_2 += ((eight[k] - three[k]) / scale).powi(2);
        }
        let denominator = err + 0.01 * err_2;
        let error = if denominator == 0.0 { 0.0 } else { h * err / (moving.len() as f64 * denominator).sqrt() };
        let is_finite = to[moving].iter().all(|v| v.is_finite());
        (self.sums, self.here, self.next, self.h) = ([sum, at, rates], here, next, h);
        (self, (is_finite && !error.is_nan()).then_some(error))
    }

    #[inline(always)]
    fn accept(&mut self, equations: &mut E) {
        self.from.clone_from(&self.here);
        self.here.clone_from(&self.next);
        let [rates, ..] = &mut self.sums;
        equations.rates(&self.here, rates);
        set(self.stages.as_mut(), STAGES, rates.as_ref());
    }
}
