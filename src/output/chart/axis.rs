//! Ranges, ticks and their labels.

use std::ops::Range;

use super::Scale;

/// The room beside the values at either end, relative to their range.
const ROOM: f64 = 0.04;
/// A logarithmic axis of more decades need not begin and end with whole ones.
const WHOLE: f64 = 3.0;

const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// Returns true if a coordinate can be drawn. The difference of two such values is finite.
pub(super) fn is_drawable(value: f64) -> bool {
    value.abs() <= 1e300
}

/// An axis. Its own coordinate is the value or, on a logarithmic axis, the decimal logarithm.
pub(super) struct Axis {
    scale: Scale,
    pub(super) range: Range<f64>,
    /// Ticks with a label and a grid line.
    pub(super) labelled: Vec<f64>,
    /// Other grid lines.
    pub(super) fine: Vec<f64>,
    /// Spacing of the labels.
    step: f64,
    /// Where values that have no logarithm are drawn, the label there, and a word for these values.
    floor: Option<(f64, &'static str, &'static str)>,
}

impl Axis {
    /// An axis for `values`, which must be drawable.
    pub(super) fn new(scale: Scale, values: &[f64]) -> Self {
        match scale {
            Scale::Linear => Self::linear(values),
            Scale::Log => Self::logarithmic(values),
        }
    }

    fn linear(values: &[f64]) -> Self {
        let (low, high) = ends(values.iter().copied()).unwrap_or((0.0, 1.0));
        let largest = low.abs().max(high.abs());
        // Values that differ by less are equal up to rounding, or too close to zero for powers of ten.
        let padding = if high - low > (1e-12 * largest).max(1e-290) {
            ROOM * (high - low)
        } else if largest > 1e-290 {
            0.1 * largest
        } else {
            1.0
        };
        Self::even(low - padding, high + padding)
    }

    /// The length of its range.
    pub(super) fn span(&self) -> f64 {
        self.range.end - self.range.start
    }

    /// The share of its range that is before this position.
    pub(super) fn share(&self, at: f64) -> f64 {
        (at - self.range.start) / self.span()
    }

    /// The same linear axis over a range of this length around its middle.
    pub(super) fn widened(&self, span: f64) -> Self {
        let middle = 0.5 * (self.range.start + self.range.end);
        Self::even(middle - 0.5 * span, middle + 0.5 * span)
    }

    /// A linear axis over this range.
    pub(super) fn even(low: f64, high: f64) -> Self {
        let rough = (high - low) / 7.0 * (1.0 - 1e-9);
        let power = 10_f64.powi(decade(rough));
        let step = power * [1.0, 2.0, 5.0].into_iter().find(|m| m * power >= rough).unwrap_or(10.0);
        let labelled = whole((low / step).ceil(), (high / step).floor()).map(|k| k * step).collect();
        Self { scale: Scale::Linear, range: low..high, labelled, fine: Vec::new(), step, floor: None }
    }

    fn logarithmic(values: &[f64]) -> Self {
        let positive = values.iter().copied().filter(|&v| v > 0.0).map(f64::log10);
        // If no value is positive, the floor is put below the rounding of numbers of order one.
        let (least, most) = ends(positive).unwrap_or((-16.0, -15.0));
        // The logarithms of powers of ten may be rounded; the tolerance makes them whole numbers.
        let (mut low, mut high) = ((least + 1e-9).floor(), (most - 1e-9).ceil());
        if low >= high {
            (low, high) = (low - 1.0, low + 1.0);
        }
        let decades = high - low;
        // Many decades have labels enough, where the axis ends with the values.
        if decades > WHOLE && !values.iter().any(|&v| v <= 0.0) {
            let room = ROOM * (most - least);
            (low, high) = (low.max(least - room), high.min(most + room));
        }
        let step = [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0].into_iter().find(|s| decades <= 9.0 * s).unwrap_or(100.0);
        let mut labelled: Vec<f64> = whole((low / step).ceil(), (high / step).floor()).map(|k| k * step).collect();
        let within = |digits: &[f64]| -> Vec<f64> {
            let all = whole(low.floor(), high.ceil() - 1.0).flat_map(|k| digits.iter().map(move |m| k + m.log10()));
            all.filter(|at| (low..=high).contains(at)).collect()
        };
        let fine = match decades {
            ..=5.0 => within(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
            _ => whole(low.ceil(), high.floor()).collect(),
        };
        if decades <= 1.0 {
            labelled.extend(within(&[2.0, 5.0]));
        }
        let (zero, negative) = (values.contains(&0.0), values.iter().any(|&v| v < 0.0));
        let floor = match (zero, negative) {
            (false, false) => None,
            (true, false) => Some((low - 1.0, "0", "zeros")),
            (false, true) => Some((low - 1.0, "< 0", "negative values")),
            (true, true) => Some((low - 1.0, "≤ 0", "zeros and negative values")),
        };
        if let Some((at, ..)) = floor {
            // Room for the symbols under the floor, and for its label among those of the decades.
            low = at - 0.03 * (high - at);
            labelled.retain(|v| v - at > 0.05 * (high - at));
            labelled.push(at);
        }
        labelled.sort_by(f64::total_cmp);
        Self { scale: Scale::Log, range: low..high, labelled, fine, step, floor }
    }

    /// Where on the axis `value` is drawn, if it is.
    pub(super) fn position(&self, value: f64) -> Option<f64> {
        match self.scale {
            _ if !is_drawable(value) => None,
            Scale::Linear => Some(value),
            Scale::Log if value > 0.0 => Some(value.log10()),
            Scale::Log => self.floor.map(|(at, ..)| at),
        }
    }

    /// Returns true if `value` is drawn at the floor.
    pub(super) fn is_at_floor(&self, value: f64) -> bool {
        self.scale == Scale::Log && value <= 0.0
    }

    /// A sentence for the reader about the floor, if there is one.
    pub(super) fn remark(&self) -> Option<String> {
        self.floor.map(|(at, _, values)| format!("{values} drawn at {}", logarithmic_label(at)))
    }

    /// The label at one of the ticks.
    pub(super) fn label(&self, at: f64) -> String {
        match (self.scale, self.floor) {
            (Scale::Log, Some((floor, label, _))) if at <= floor => label.to_owned(),
            (Scale::Log, _) => logarithmic_label(at),
            (Scale::Linear, _) if at.abs() < 0.5 * self.step => "0".to_owned(),
            (Scale::Linear, _) => {
                let largest = decade(self.labelled.iter().fold(0.0, |largest, v| v.abs().max(largest)));
                let exponent = if (-4..5).contains(&largest) { 0 } else { largest };
                let digits = usize::try_from(exponent - decade(self.step)).unwrap_or(0);
                let mantissa = format!("{:.digits$}", at / 10_f64.powi(exponent)).replace('-', "−");
                if exponent == 0 { mantissa } else { format!("{mantissa}×10{}", superscript(exponent)) }
            }
        }
    }
}

/// The label for a power of ten, or a whole multiple of one, from its logarithm.
fn logarithmic_label(logarithm: f64) -> String {
    let exponent = (logarithm + 1e-9).floor();
    let power = format!("10{}", superscript(exponent as i32));
    let mantissa = 10_f64.powf(logarithm - exponent).round();
    if mantissa > 1.0 { format!("{mantissa}×{power}") } else { power }
}

/// An exponent in raised digits.
fn superscript(exponent: i32) -> String {
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| SUPERSCRIPTS[digit as usize]);
    exponent.to_string().chars().map(raised).collect()
}

/// The least and the greatest of `values`.
fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |ends, v| Some(ends.map_or((v, v), |(low, high): (f64, f64)| (low.min(v), high.max(v)))))
}

/// The whole numbers from `first` to `last`.
fn whole(first: f64, last: f64) -> impl Iterator<Item = f64> {
    (first as i64..=last as i64).map(|k| k as f64)
}

/// Exponent of the power of ten at or below a positive value.
fn decade(value: f64) -> i32 {
    (value.log10() + 1e-9).floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, values: &[f64]) -> Vec<String> {
        let axis = Axis::new(scale, values);
        axis.labelled.iter().map(|&v| axis.label(v)).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(labels(Scale::Linear, &[-1.0, 1.0]), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(labels(Scale::Linear, &[0.0, 1.5e-6])[..3], ["0", "0.5×10⁻⁶", "1.0×10⁻⁶"]);
        assert_eq!(labels(Scale::Linear, &[0.0, 6e6])[1..4], ["1×10⁶", "2×10⁶", "3×10⁶"]);
        assert_eq!(labels(Scale::Linear, &[7.0]), ["6.4", "6.6", "6.8", "7.0", "7.2", "7.4", "7.6"]);
        let axis = Axis::new(Scale::Linear, &[0.0, 100.0]);
        assert_eq!(axis.range, -4.0..104.0);
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten() {
        assert_eq!(labels(Scale::Log, &[2e-3, 0.05]), ["10⁻³", "10⁻²", "10⁻¹"]);
        assert_eq!(labels(Scale::Log, &[1e-3, 1e-1]), ["10⁻³", "10⁻²", "10⁻¹"]);
        assert_eq!(labels(Scale::Log, &[2e3, 3e3]), ["10³", "2×10³", "5×10³", "10⁴"]);
        assert_eq!(labels(Scale::Log, &[1.0]), ["10⁻¹", "10⁰", "10¹"]);
        for k in -300..300 {
            let axis = Axis::new(Scale::Log, &[10_f64.powi(k), 10_f64.powi(k + 2)]);
            assert_eq!(axis.range, f64::from(k)..f64::from(k + 2));
        }
    }

    #[test]
    fn many_decades_have_few_labels() {
        assert_eq!(labels(Scale::Log, &[3e-16, 6e-2])[..2], ["10⁻¹⁶", "10⁻¹⁴"]);
        for low in -300..0 {
            assert!((3..=10).contains(&labels(Scale::Log, &[10_f64.powi(low), 100.0]).len()));
        }
    }

    #[test]
    fn an_axis_of_many_decades_ends_with_the_values() {
        let (axis, room) = (Axis::new(Scale::Log, &[4e-14, 1.2]), 0.04 * (1.2_f64 / 4e-14).log10());
        let ends = [axis.range.start - 4e-14_f64.log10(), axis.range.end - 1.2_f64.log10()];
        assert!((ends[0] + room).abs() < 1e-9 && (ends[1] - room).abs() < 1e-9, "{ends:?} {room}");
        assert!(axis.labelled.iter().chain(&axis.fine).all(|at| axis.range.contains(at)));
        assert_eq!(Axis::new(Scale::Log, &[1.3e-14, 0.9]).range, -14.0..0.0);
    }

    #[test]
    fn the_floor_is_a_decade_below_the_least_value() {
        let axis = Axis::new(Scale::Log, &[0.0, 3e-16, 6e-2]);
        assert_eq!(axis.position(0.0), Some(-17.0));
        assert_eq!(axis.remark().as_deref(), Some("zeros drawn at 10⁻¹⁷"));
        assert!(axis.labelled.iter().any(|&v| axis.label(v) == "0"));
        let axis = Axis::new(Scale::Log, &[0.0, -2.0]);
        assert_eq!(axis.remark().as_deref(), Some("zeros and negative values drawn at 10⁻¹⁷"));
        assert!(Axis::new(Scale::Log, &[1.0]).remark().is_none());
    }
}
