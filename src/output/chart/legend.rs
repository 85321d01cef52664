//! The legend: samples and labels in a box.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::Series;
use super::canvas::{Canvas, Drawn, GRID, PX, Pixel, TEXT, TICK, WIDTH, extent, font, units, write};
use super::trace::{Pen, Trace, pens};

const ROW: i32 = 20 * PX;
const SAMPLE: i32 = 30 * PX;
const PADDING: i32 = 8 * PX;
const WIDEST_LABEL: i32 = WIDTH * 2 / 5;

/// The labels of the series and the size of their box.
pub(super) struct Legend {
    entries: Vec<(String, Pen)>,
    pub(super) size: (i32, i32),
}

impl Legend {
    pub(super) fn new(series: &[Series]) -> Self {
        let labelled = series.iter().zip(pens(series)).filter(|(series, _)| !series.label.is_empty());
        let entries: Vec<(String, Pen)> = labelled.map(|(series, pen)| (series.label.clone(), pen)).collect();
        let widest = entries.iter().map(|(label, _)| extent(label, TICK).min(WIDEST_LABEL)).max();
        let size =
            widest.map_or((0, 0), |widest| (SAMPLE + widest + 3 * PADDING, units(entries.len()) * ROW + PADDING));
        Self { entries, size }
    }

    /// The corner of a place in the plot where the box covers no line and no symbol.
    pub(super) fn free_corner(&self, start: Pixel, end: Pixel, traces: &[Trace]) -> Option<Pixel> {
        let (width, height) = self.size;
        let (left, right) = (start.0 + PADDING, end.0 - PADDING - width);
        let (top, bottom) = (start.1 + PADDING, end.1 - PADDING - height);
        let (centre, middle) = ((left + right) / 2, (top + bottom) / 2);
        let corners = [(right, top), (left, top), (right, bottom), (left, bottom)];
        let others = [(right, middle), (left, middle), (centre, top), (centre, bottom)];
        let is_free = |&(x, y): &Pixel| {
            let covers = |p: Pixel| {
                (x - PADDING..=x + width + PADDING).contains(&p.0)
                    && (y - PADDING..=y + height + PADDING).contains(&p.1)
            };
            let crosses = |a: Pixel, b: Pixel| {
                let steps = (a.0.abs_diff(b.0).max(a.1.abs_diff(b.1)) / 40 + 1) as i32;
                (0..=steps).any(|k| covers((a.0 + (b.0 - a.0) * k / steps, a.1 + (b.1 - a.1) * k / steps)))
            };
            let mut segments = traces.iter().flat_map(|trace| &trace.runs).flat_map(|run| run.windows(2));
            !traces.iter().flat_map(Trace::symbols).any(covers) && !segments.any(|ends| crosses(ends[0], ends[1]))
        };
        let fits = |at: &Pixel| at.0 >= left && at.1 >= top;
        corners.into_iter().chain(others).filter(fits).find(is_free)
    }

    pub(super) fn draw(&self, canvas: &Canvas<'_>, (x, y): Pixel) -> Drawn {
        let (width, height) = self.size;
        if !self.entries.is_empty() {
            canvas.draw(&Rectangle::new([(x, y), (x + width, y + height)], WHITE.filled()))?;
            let outline = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)];
            canvas.draw(&PathElement::new(outline, GRID.stroke_width(8)))?;
        }
        for (k, (label, pen)) in self.entries.iter().enumerate() {
            let (start, row) = (x + PADDING, y + PADDING / 2 + units(k) * ROW + ROW / 2);
            if pen.has_line() {
                pen.line(canvas, &[(start, row), (start + SAMPLE, row)])?;
            }
            if pen.has_symbols() {
                pen.symbol(canvas, (start + SAMPLE / 2, row), Pen::RADIUS, pen.is_open())?;
            }
            let at = (start + SAMPLE + PADDING, row - TICK * 9 / 20);
            write(canvas, label, at, &font(TICK, label, WIDEST_LABEL, TEXT, HPos::Left))?;
        }
        Ok(())
    }
}
