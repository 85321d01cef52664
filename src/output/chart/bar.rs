//! Axes of maps: a bar that says which value a colour is, and round ticks along cells.

use super::Scale;
use super::axis::Axis;

/// A colour bar in the place of a legend: the kinds in their order are equal steps of this range.
#[derive(Debug, Clone)]
pub struct Bar {
    /// Whether the steps are those of logarithms.
    pub scale: Scale,
    /// The values at its ends.
    pub range: [f64; 2],
}

impl Bar {
    /// Its ticks, as shares of its length, with their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let axis = match self.scale {
            Scale::Linear => Axis::even(self.range[0], self.range[1]),
            Scale::Log => Axis::new(self.scale, &self.range),
        };
        let [from, to] = self.range.map(|value| axis.position(value).unwrap_or(value));
        let shares = axis.labelled.iter().map(|&at| ((at - from) / (to - from), axis.label(at)));
        shares.filter(|(share, _)| (0.0..=1.0).contains(share)).collect()
    }
}

/// Round ticks along cells whose middles are at these values, in cells (0.5 is the middle of the first); `None` if the
/// values are not equidistant, so that cells have no axis.
pub(crate) fn ticks_of_cells(values: &[f64]) -> Option<Vec<(f64, String)>> {
    let [first, .., last] = *values else { return None };
    let step = (last - first) / (values.len() - 1) as f64;
    // Decimals of a range are rounded.
    let is_even = |(k, value): (usize, &f64)| (value - first - k as f64 * step).abs() <= 1e-6 * step.abs();
    if step == 0.0 || !step.is_finite() || !values.iter().enumerate().all(is_even) {
        return None;
    }
    let ends = [first - 0.5 * step, last + 0.5 * step];
    let axis = Axis::even(ends[0].min(ends[1]), ends[0].max(ends[1]));
    Some(axis.labelled.iter().map(|&at| ((at - first) / step + 0.5, axis.label(at))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equidistant_cells_have_round_ticks() {
        let ticks = ticks_of_cells(&(0..14).map(|k| f64::from(k) / 13.0).collect::<Vec<_>>()).unwrap();
        let labels: Vec<&str> = ticks.iter().map(|(_, label)| &**label).collect();
        assert_eq!(labels, ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert!((ticks[0].0 - 0.5).abs() < 1e-12 && (ticks[5].0 - 13.5).abs() < 1e-9, "{ticks:?}");
        // Downwards, too.
        assert!((ticks_of_cells(&[2.0, 1.0, 0.0]).unwrap().last().unwrap().0 - 0.5).abs() < 1.0);
        assert_eq!([&[1.0, 10.0, 100.0][..], &[1.0], &[2.0, 2.0]].map(ticks_of_cells), [None, None, None]);
    }

    #[test]
    fn a_bar_has_its_ends_where_its_values_are() {
        let bar = |scale, range| Bar { scale, range }.ticks();
        assert_eq!(bar(Scale::Linear, [0.0, 2.0])[2], (0.5, "1.0".to_owned()));
        let decades = bar(Scale::Log, [1e-6, 1e-2]);
        assert_eq!((decades.len(), decades[1].1.as_str()), (5, "10⁻⁵"));
        assert!((decades[1].0 - 0.25).abs() < 1e-12);
    }
}
