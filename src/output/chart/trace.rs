//! Lines and symbols of the series, and how they are thinned.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::canvas::{Canvas, Drawn, PX, Pixel};
use super::{Ink, Mark, Series};

/// Okabe and Ito's colours without yellow, which is too faint on white.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const NEUTRAL: RGBColor = RGBColor(128, 128, 128);
const PALE_BAND: RGBColor = RGBColor(222, 222, 222);

/// A series with more points is thinned.
const MOST_POINTS: usize = 2000;

/// How a series is drawn.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    mark: Mark,
    colour: RGBColor,
    shape: usize,
}

/// The pens of some series.
pub(super) fn pens(series: &[Series]) -> Vec<Pen> {
    let mut used = 0;
    let mut last = None;
    let pen = |series: &Series| {
        let (colour, shape) = match (series.ink, last) {
            (Ink::Neutral, _) => (NEUTRAL, 0),
            (Ink::Fixed { colour, shape }, _) => (PALETTE[colour % PALETTE.len()], shape),
            (Ink::Previous, Some(last)) => last,
            _ => {
                used += 1;
                (PALETTE[(used - 1) % PALETTE.len()], used - 1)
            }
        };
        last = Some((colour, shape));
        Pen { mark: series.mark, colour, shape }
    };
    series.iter().map(pen).collect()
}

impl Pen {
    /// Radius of a symbol where there are few.
    pub(super) const RADIUS: i32 = 34;

    pub(super) fn has_line(self) -> bool {
        self.mark != Mark::Points
    }

    pub(super) fn has_symbols(self) -> bool {
        matches!(self.mark, Mark::Points | Mark::LineAndPoints | Mark::DashedAndOpenPoints)
    }

    /// Whether all its symbols are open.
    pub(super) fn is_open(self) -> bool {
        self.mark == Mark::DashedAndOpenPoints
    }

    pub(super) fn line(self, canvas: &Canvas<'_>, run: &[Pixel]) -> Drawn {
        let stroke = self.colour.stroke_width(16);
        match (self.mark, run) {
            (_, [alone]) => canvas.draw(&Circle::new(*alone, 12, self.colour.filled())),
            (Mark::Band, _) => canvas.draw(&PathElement::new(run.to_vec(), PALE_BAND.stroke_width(110))),
            (Mark::DashedAndOpenPoints, _) => {
                let stroke = stroke.stroke_width(12);
                canvas.draw(&DashedPathElement::new(run.iter().copied(), 50, 30, stroke))
            }
            (Mark::Dashed, _) => canvas.draw(&DashedPathElement::new(run.iter().copied(), 80, 50, stroke)),
            (Mark::Dotted, _) => {
                let stroke = stroke.stroke_width(13);
                canvas.draw(&DashedPathElement::new(run.iter().copied(), 20, 35, stroke))
            }
            _ => canvas.draw(&PathElement::new(run.to_vec(), stroke)),
        }
    }

    pub(super) fn symbol(self, canvas: &Canvas<'_>, at: Pixel, radius: i32, open: bool) -> Drawn {
        let outline = self.colour.stroke_width(12);
        // Corners, direction of the first in turns, and a size that makes all shapes look alike.
        let (corners, first, size) = match self.shape % 4 {
            0 if open => return canvas.draw(&Circle::new(at, radius, outline)),
            0 => return canvas.draw(&Circle::new(at, radius, self.colour.filled())),
            1 => (4, 0.125, 1.25),
            2 => (3, 0.25, 1.5),
            _ => (4, 0.0, 1.35),
        };
        let corner = |k: i32| {
            let (sin, cos) = (TAU * (f64::from(k) / f64::from(corners) + first)).sin_cos();
            let offset = |part: f64| (size * f64::from(radius) * part).round() as i32;
            (at.0 + offset(cos), at.1 - offset(sin))
        };
        if open {
            canvas.draw(&PathElement::new((0..=corners).map(corner).collect::<Vec<_>>(), outline))
        } else {
            canvas.draw(&Polygon::new((0..corners).map(corner).collect::<Vec<_>>(), self.colour.filled()))
        }
    }
}

/// A series in place, thinned if it has many points.
pub(super) struct Trace {
    pen: Pen,
    /// The lines.
    pub(super) runs: Vec<Vec<Pixel>>,
    marks: Vec<Pixel>,
    open: Vec<Pixel>,
}

impl Trace {
    pub(super) fn new(pen: Pen, runs: Vec<Vec<Pixel>>, marks: Vec<Pixel>, open: Vec<Pixel>) -> Self {
        let mut runs: Vec<_> = runs.into_iter().filter(|run| pen.has_line() && !run.is_empty()).collect();
        if runs.iter().map(Vec::len).sum::<usize>() > MOST_POINTS {
            runs = runs.iter().map(|run| thin_line(run)).collect();
        }
        let thin = |marks: Vec<Pixel>| match marks.len() {
            _ if !pen.has_symbols() => Vec::new(),
            ..=MOST_POINTS => marks,
            _ => thin_marks(&marks),
        };
        let (marks, open) = if pen.is_open() { (Vec::new(), [marks, open].concat()) } else { (marks, open) };
        Self { pen, runs, marks: thin(marks), open: thin(open) }
    }

    /// Where the symbols are.
    pub(super) fn symbols(&self) -> impl Iterator<Item = Pixel> {
        self.marks.iter().chain(&self.open).copied()
    }

    pub(super) fn draw(&self, canvas: &Canvas<'_>) -> Drawn {
        let radius = match self.symbols().count() {
            ..=80 => Pen::RADIUS,
            81..=400 => 24,
            _ => 18,
        };
        self.runs.iter().try_for_each(|run| self.pen.line(canvas, run))?;
        self.marks.iter().try_for_each(|&at| self.pen.symbol(canvas, at, radius, false))?;
        self.open.iter().try_for_each(|&at| self.pen.symbol(canvas, at, radius, true))
    }
}

/// Of successive points in a column of pixels, the first, the extremes and the last: the same picture.
fn thin_line(run: &[Pixel]) -> Vec<Pixel> {
    let column = |points: &[Pixel]| {
        let rows = || points.iter().map(|p| p.1).enumerate();
        let least = rows().min_by_key(|row| row.1).map_or(0, |row| row.0);
        let greatest = rows().max_by_key(|row| row.1).map_or(0, |row| row.0);
        let kept = BTreeSet::from([0, least, greatest, points.len() - 1]);
        kept.into_iter().map(|k| points[k]).collect::<Vec<_>>()
    };
    run.chunk_by(|a, b| a.0 / PX == b.0 / PX).flat_map(column).collect()
}

/// The extremes of every column of pixels, and one point of every square of three pixels: about the same picture.
fn thin_marks(marks: &[Pixel]) -> Vec<Pixel> {
    let mut columns = BTreeMap::new();
    for &(x, y) in marks {
        let (low, high) = columns.entry(x / PX).or_insert(((x, y), (x, y)));
        if y < low.1 {
            *low = (x, y);
        }
        if y > high.1 {
            *high = (x, y);
        }
    }
    let square = |p: Pixel| (p.0 / (3 * PX), p.1 / (3 * PX));
    let extremes: BTreeSet<Pixel> = columns.into_values().flat_map(|(low, high)| [low, high]).collect();
    let mut squares: BTreeSet<Pixel> = extremes.iter().map(|&p| square(p)).collect();
    let others = marks.iter().copied().filter(|&p| squares.insert(square(p))).collect::<Vec<_>>();
    extremes.into_iter().chain(others).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave over 50 columns with a spike.
    fn wave() -> Vec<Pixel> {
        let spike = |k: i32| if k == 4321 { 5000 } else { 0 };
        (0..10_000).map(|k| (k / 20, (400.0 * (f64::from(k) / 300.0).sin()) as i32 + spike(k))).collect()
    }

    fn extremes(points: &[Pixel]) -> BTreeMap<i32, (i32, i32)> {
        let mut columns = BTreeMap::new();
        for &(x, y) in points {
            let ends = columns.entry(x / PX).or_insert((y, y));
            *ends = (y.min(ends.0), y.max(ends.1));
        }
        columns
    }

    #[test]
    fn thinning_keeps_the_extremes_of_every_column() {
        let points = wave();
        for thinned in [thin_line(&points), thin_marks(&points)] {
            assert!(thinned.len() < 1000);
            assert!(thinned.iter().all(|p| points.contains(p)));
            assert_eq!(extremes(&thinned), extremes(&points));
        }
    }

    #[test]
    fn a_thinned_line_keeps_its_order_and_ends() {
        let points = wave();
        let thinned = thin_line(&points);
        assert!(thinned.is_sorted_by_key(|p| p.0));
        assert_eq!((thinned.first(), thinned.last()), (points.first(), points.last()));
        let there_and_back = [(0, 0), (50, 10), (0, 20), (50, 30)];
        assert_eq!(thin_line(&there_and_back), there_and_back);
    }

    #[test]
    fn a_fit_shares_the_colour_of_its_data() {
        let inks = [Ink::Previous, Ink::Next, Ink::Previous, Ink::Neutral, Ink::Next];
        let series = inks.map(|ink| Series::new("", Mark::Line, Vec::new()).with_ink(ink));
        let colours: Vec<RGBColor> = pens(&series).iter().map(|pen| pen.colour).collect();
        assert_eq!(colours, [PALETTE[0], PALETTE[1], PALETTE[1], NEUTRAL, PALETTE[2]]);
    }
}
