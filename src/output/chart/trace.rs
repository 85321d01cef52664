//! Lines and symbols of the series, and how they are thinned.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::canvas::{Canvas, Drawn, PX, Pixel};
use super::{Ink, Look, Mark, Series, Shape};

/// The colours of Okabe and Ito, for series that are not methods; without yellow, which is too faint on white.
const PALETTE: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [0, 0, 0]];
const NEUTRAL: Look = Look { colour: [128, 128, 128], shape: Shape::Circle };
const PALE_BAND: RGBColor = RGBColor(222, 222, 222);

/// A series with more points than this is thinned.
const MOST_POINTS: usize = 2000;

/// How a series is drawn.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    mark: Mark,
    look: Look,
}

/// One pen for each of the series of a chart.
pub(super) fn pens(series: &[Series]) -> Vec<Pen> {
    let mut used = 0;
    let mut last = None;
    let pen = |series: &Series| {
        let look = match (series.ink, last) {
            (Ink::Neutral, _) => NEUTRAL,
            (Ink::Fixed(look), _) | (Ink::Previous, Some(look)) => look,
            _ => {
                used += 1;
                Look { colour: PALETTE[(used - 1) % PALETTE.len()], shape: Shape::ALL[(used - 1) % 4] }
            }
        };
        last = Some(look);
        Pen { mark: series.mark, look }
    };
    series.iter().map(pen).collect()
}

impl Pen {
    /// Radius of a symbol in a series that has few of them.
    pub(super) const RADIUS: i32 = 34;

    pub(super) fn has_line(self) -> bool {
        !matches!(self.mark, Mark::Points | Mark::OpenPoints)
    }

    pub(super) fn has_symbols(self) -> bool {
        use Mark::{DashedAndOpenPoints, LineAndPoints, OpenPoints, Points};
        matches!(self.mark, Points | OpenPoints | LineAndPoints | DashedAndOpenPoints)
    }

    /// Whether all its symbols are open.
    pub(super) fn is_open(self) -> bool {
        matches!(self.mark, Mark::DashedAndOpenPoints | Mark::OpenPoints)
    }

    /// Whether its label is beside its line and not in the legend.
    pub(super) fn is_labelled_in_place(self) -> bool {
        self.mark == Mark::Band
    }

    fn colour(self) -> RGBColor {
        self.look.rgb()
    }

    pub(super) fn line(self, canvas: &Canvas<'_>, run: &[Pixel]) -> Drawn {
        let stroke = self.colour().stroke_width(18);
        match (self.mark, run) {
            (_, [alone]) => canvas.draw(&Circle::new(*alone, 12, self.colour().filled())),
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
        draw_symbol(canvas, self.look, at, radius, open)
    }
}

/// A symbol, filled or open.
pub(super) fn draw_symbol(canvas: &Canvas<'_>, look: Look, at: Pixel, radius: i32, open: bool) -> Drawn {
    let colour = look.rgb();
    let outline = colour.stroke_width(13);
    // The point in a direction, given in turns, and at a distance, given in radii.
    let corner = |turn: f64, distance: f64| {
        let (sin, cos) = (TAU * turn).sin_cos();
        let offset = |part: f64| (distance * f64::from(radius) * part).round() as i32;
        (at.0 + offset(cos), at.1 - offset(sin))
    };
    let stroke = |turn: f64| {
        let ends = vec![corner(turn, 1.3), corner(turn + 0.5, 1.3)];
        // Strokes cannot be filled; instead they are thicker.
        canvas.draw(&PathElement::new(ends, colour.stroke_width(if open { 13 } else { 20 })))
    };
    // Number of corners, direction of the first in turns, and a factor that makes all shapes look equally large.
    let (corners, first, size) = match look.shape {
        Shape::Circle if open => return canvas.draw(&Circle::new(at, radius, outline)),
        Shape::Circle => return canvas.draw(&Circle::new(at, radius, colour.filled())),
        Shape::Cross => return [0.125, 0.375].into_iter().try_for_each(stroke),
        Shape::Plus => return [0.0, 0.25].into_iter().try_for_each(stroke),
        Shape::Square => (4, 0.125, 1.25),
        Shape::Triangle => (3, 0.25, 1.5),
        Shape::Diamond => (4, 0.0, 1.35),
        Shape::Nabla => (3, 0.75, 1.5),
        Shape::Star => (10, 0.25, 1.7),
    };
    let place = |k: i32| {
        // Every other corner of a star is an inner one.
        let inner = if look.shape == Shape::Star && k % 2 == 1 { 0.45 } else { 1.0 };
        corner(f64::from(k) / f64::from(corners) + first, inner * size)
    };
    if open {
        canvas.draw(&PathElement::new((0..=corners).map(place).collect::<Vec<_>>(), outline))
    } else {
        canvas.draw(&Polygon::new((0..corners).map(place).collect::<Vec<_>>(), colour.filled()))
    }
}

/// A series in pixels, thinned if it has many points.
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

    /// The places of the symbols.
    pub(super) fn symbols(&self) -> impl Iterator<Item = Pixel> {
        self.marks.iter().chain(&self.open).copied()
    }

    /// Whether no part of it is inside a box.
    pub(super) fn is_clear_of(&self, (start, end): (Pixel, Pixel)) -> bool {
        let is_inside = |p: Pixel| (start.0..=end.0).contains(&p.0) && (start.1..=end.1).contains(&p.1);
        let crosses = |a: Pixel, b: Pixel| {
            let steps = (a.0.abs_diff(b.0).max(a.1.abs_diff(b.1)) / 40 + 1) as i32;
            (0..=steps).any(|k| is_inside((a.0 + (b.0 - a.0) * k / steps, a.1 + (b.1 - a.1) * k / steps)))
        };
        let mut segments = self.runs.iter().flat_map(|run| run.windows(2));
        !self.symbols().any(is_inside) && !segments.any(|ends| crosses(ends[0], ends[1]))
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

/// Keeps, of successive points in the same column of pixels, the first, the extremes and the last. The picture does not
/// change.
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

/// Keeps the extremes in every column of pixels, and one point in every square of three by three pixels. The picture
/// hardly changes.
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
        let colours: Vec<[u8; 3]> = pens(&series).iter().map(|pen| pen.look.colour).collect();
        assert_eq!(colours, [PALETTE[0], PALETTE[1], PALETTE[1], NEUTRAL.colour, PALETTE[2]]);
    }

    #[test]
    fn every_shape_is_another_picture() {
        let picture = |shape: Shape, open: bool| {
            let mut svg = String::new();
            let canvas = SVGBackend::with_string(&mut svg, (100, 100)).into_drawing_area();
            draw_symbol(&canvas, Look { colour: [1, 2, 3], shape }, (50, 50), 34, open).unwrap();
            drop(canvas);
            svg
        };
        let pictures: BTreeSet<String> =
            Shape::ALL.into_iter().flat_map(|shape| [picture(shape, true), picture(shape, false)]).collect();
        assert_eq!(pictures.len(), 2 * Shape::ALL.len());
    }
}
