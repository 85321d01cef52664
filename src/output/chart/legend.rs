//! The legend, a box with a sample and a label for each series; and labels in the plot itself.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::Series;
use super::canvas::{Canvas, Drawn, GRID, PALE, PX, Pixel, TEXT, TICK, WIDTH, extent, font, units, write};
use super::trace::{Pen, Trace, pens};

const ROW: i32 = 21 * PX;
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
        let labelled = series
            .iter()
            .zip(pens(series))
            .filter(|(series, pen)| !series.label.is_empty() && !pen.is_labelled_in_place());
        let entries: Vec<(String, Pen)> = labelled.map(|(series, pen)| (series.label.clone(), pen)).collect();
        let widest = entries.iter().map(|(label, _)| extent(label, TICK).min(WIDEST_LABEL)).max();
        let size =
            widest.map_or((0, 0), |widest| (SAMPLE + widest + 3 * PADDING, units(entries.len()) * ROW + PADDING));
        Self { entries, size }
    }

    /// The upper left corner of a place in the plot where the box covers no line and no symbol, if there is one.
    pub(super) fn free_corner(&self, start: Pixel, end: Pixel, traces: &[Trace]) -> Option<Pixel> {
        let (width, height) = self.size;
        let (left, right) = (start.0 + PADDING, end.0 - PADDING - width);
        let (top, bottom) = (start.1 + PADDING, end.1 - PADDING - height);
        let (centre, middle) = ((left + right) / 2, (top + bottom) / 2);
        let corners = [(right, top), (left, top), (right, bottom), (left, bottom)];
        let others = [(right, middle), (left, middle), (centre, top), (centre, bottom)];
        let is_free = |&(x, y): &Pixel| {
            let around = ((x - PADDING, y - PADDING), (x + width + PADDING, y + height + PADDING));
            traces.iter().all(|trace| trace.is_clear_of(around))
        };
        let fits = |at: &Pixel| at.0 >= left && at.1 >= top;
        corners.into_iter().chain(others).filter(fits).find(is_free)
    }

    /// Draws the labels of series that have them in the plot: below the line, where nothing else is.
    pub(super) fn draw_in_place(
        canvas: &Canvas<'_>,
        series: &[Series],
        (start, end): (Pixel, Pixel),
        traces: &[Trace],
    ) -> Drawn {
        for ((one, pen), trace) in series.iter().zip(pens(series)).zip(traces) {
            if !pen.is_labelled_in_place() || one.label.is_empty() {
                continue;
            }
            let (width, height) = (extent(&one.label, TICK), TICK * 5 / 4);
            let line: Vec<Pixel> = trace.runs.concat();
            let middle = line.len() / 2;
            let mut order: Vec<usize> = (0..line.len()).collect();
            order.sort_by_key(|&k| k.abs_diff(middle));
            let under = |k: usize| {
                let x = (line[k].0 - width / 2).clamp(start.0 + PADDING, (end.0 - PADDING - width).max(start.0));
                (x, line[k].1 + 9 * PX)
            };
            let is_free = |&(x, y): &Pixel| {
                let around = ((x, y), (x + width, y + height));
                y + height < end.1 && traces.iter().all(|trace| trace.is_clear_of(around))
            };
            let places = || order.iter().map(|&k| under(k));
            let above = |(x, y): Pixel| (x, (y - 9 * PX - 2 * height).max(start.1));
            if let Some(at) = places().find(is_free).or_else(|| places().next().map(above)) {
                write(canvas, &one.label, at, &font(TICK, &one.label, WIDEST_LABEL, PALE, HPos::Left))?;
            }
        }
        Ok(())
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
