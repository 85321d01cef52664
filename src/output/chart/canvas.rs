//! Sizes, colours, text and the frame, which all pictures have in common.

use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use super::typeset::{self, Level, SCRIPT};

/// Drawing units per pixel. The backend only has whole units, and a pixel would be too coarse for curves.
pub(super) const PX: i32 = 10;
pub(super) const WIDTH: i32 = 720 * PX;
pub(super) const PLOT_HEIGHT: i32 = 360 * PX;
pub(super) const MARGIN: i32 = 16 * PX;

pub(super) const TITLE: i32 = 18 * PX;
pub(super) const LABEL: i32 = 16 * PX;
pub(super) const TICK: i32 = 14 * PX;
pub(super) const SMALL: i32 = 13 * PX;

pub(super) const TEXT: RGBColor = RGBColor(34, 34, 34);
pub(super) const PALE: RGBColor = RGBColor(96, 96, 96);
pub(super) const GRID: RGBColor = RGBColor(218, 218, 218);
const FINE_GRID: RGBColor = RGBColor(240, 240, 240);

pub(super) type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Plane = Cartesian2d<RangedCoordf64, RangedCoordf64>;
pub(super) type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;
pub(super) type Pixel = (i32, i32);

/// The finished document: scaled to its size in pixels, and with its sub- and superscripts set. `height` is in drawing
/// units.
pub(super) fn finish(svg: &str, height: i32) -> String {
    let size = |width: i32, height: i32| format!("width=\"{width}\" height=\"{height}\"");
    let shown = format!("{} stroke-linejoin=\"round\"", size(WIDTH / PX, height / PX));
    typeset::typeset(&svg.replacen(&size(WIDTH, height), &shown, 1))
}

/// The height of the heading, in drawing units.
pub(super) fn heading_height(title: &str, subtitle: &str) -> i32 {
    let row = |text: &str, size: i32| if text.is_empty() { 0 } else { size * 3 / 2 };
    row(title, TITLE) + row(subtitle, SMALL)
}

/// Draws the heading: the title, and the subtitle below it.
pub(super) fn draw_heading(canvas: &Canvas<'_>, title: &str, subtitle: &str) -> Drawn {
    let room = WIDTH - 2 * MARGIN;
    write(canvas, title, (WIDTH / 2, MARGIN), &font(TITLE, title, room, TEXT, HPos::Center))?;
    let under = MARGIN + heading_height(title, "");
    write(canvas, subtitle, (WIDTH / 2, under), &font(SMALL, subtitle, room, PALE, HPos::Center))
}

/// Draws the grid lines, the frame, the ticks and their labels.
pub(super) fn draw_axes(canvas: &Canvas<'_>, x: &Axis, y: &Axis, plane: &Plane) -> Drawn {
    let (left, bottom) = plane.translate(&(x.range.start, y.range.start));
    let (right, top) = plane.translate(&(x.range.end, y.range.end));
    let column = |v: f64| plane.translate(&(v, y.range.start)).0;
    let row = |v: f64| plane.translate(&(x.range.start, v)).1;
    let stroke = |from: Pixel, to: Pixel, style: ShapeStyle| canvas.draw(&PathElement::new(vec![from, to], style));
    for (xs, ys, colour) in [(&x.fine, &y.fine, FINE_GRID), (&x.labelled, &y.labelled, GRID)] {
        xs.iter().try_for_each(|&v| stroke((column(v), top), (column(v), bottom), colour.stroke_width(7)))?;
        ys.iter().try_for_each(|&v| stroke((left, row(v)), (right, row(v)), colour.stroke_width(7)))?;
    }
    let line = TEXT.stroke_width(9);
    let mut free = 0;
    for &v in &x.labelled {
        let (at, label) = (column(v), x.label(v));
        stroke((at, bottom), (at, bottom + 5 * PX), line)?;
        // A label that would overlap the one before is left out.
        let half = extent(&label, TICK) / 2;
        if at - half > free {
            free = at + half;
            write(canvas, &label, (at, bottom + 8 * PX), &font(TICK, &label, WIDTH, TEXT, HPos::Center))?;
        }
    }
    for &v in &y.labelled {
        let (at, label) = (row(v), y.label(v));
        stroke((left, at), (left - 5 * PX, at), line)?;
        let place = (left - 8 * PX, at - TICK * 2 / 5);
        write(canvas, &label, place, &font(TICK, &label, WIDTH, TEXT, HPos::Right))?;
    }
    let frame = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    canvas.draw(&PathElement::new(frame, line))
}

/// Writes text. The top of the letters is at `at`.
pub(super) fn write(canvas: &Canvas<'_>, text: &str, at: Pixel, style: &TextStyle<'_>) -> Drawn {
    // XML allows no control characters, not even escaped ones.
    let is_text = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let text: String = text.chars().map(|c| if is_text(c) { c } else { ' ' }).collect();
    if text.trim().is_empty() { Ok(()) } else { canvas.draw_text(&text, style, at) }
}

/// The font for a text. It is made smaller if the text is wider than `room`.
pub(super) fn font(size: i32, text: &str, room: i32, colour: RGBColor, side: HPos) -> TextStyle<'static> {
    let size = f64::from(size) * (f64::from(room) / f64::from(extent(text, size).max(1))).min(1.0);
    // The backend divides sizes by 1.24.
    ("sans-serif", 1.24 * size).into_font().color(&colour).pos(Pos::new(side, VPos::Top))
}

/// The approximate width of a text in any usual font.
pub(super) fn extent(text: &str, size: i32) -> i32 {
    let is_accent = |c: char| ('\u{300}'..='\u{36f}').contains(&c);
    // In halves of a usual letter.
    let halves = |c: char| if "mwMW".contains(c) { 3 } else { 2 };
    let count = |text: &str| units(text.chars().filter(|&c| !is_accent(c)).map(halves).sum()) * size * 11 / 40;
    let width = |(level, part): (Level, &str)| match level {
        Level::Line => count(part),
        _ => (SCRIPT * f64::from(count(part))) as i32,
    };
    typeset::parts(text).into_iter().map(width).sum()
}

/// A count as a coordinate. It is limited to ten thousand, more than fit on any canvas.
pub(super) fn units(count: usize) -> i32 {
    count.min(10_000) as i32
}
