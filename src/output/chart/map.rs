//! Maps: panels of equal cells. Every kind of cell has a colour of different lightness and a sign, so that nothing is
//! shown by colour alone.

use std::collections::BTreeSet;

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::Look;
use super::canvas::{self, Canvas, Drawn, LABEL, MARGIN, PALE, PX, Pixel, SMALL, TEXT, WIDTH, extent, font, units};
use super::trace::draw_symbol;

/// Panels side by side.
const ACROSS: usize = 4;
const GAP: i32 = 12 * PX;
/// Room for the labels of the rows.
const LEFT: i32 = 70 * PX;
const CELL_HEIGHT: i32 = 14 * PX;
const PANEL_TITLE: i32 = 20 * PX;
const TICKS: i32 = 28 * PX;
const TICK_LABEL: i32 = 12 * PX;
const HEADING: i32 = 12 * PX;
/// Radius of the symbol of a panel's method, which is beside its heading.
const SYMBOL: i32 = 36;
const LEGEND_ROW: i32 = 22 * PX;

/// A sign in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// No sign, for the best kind of cell.
    Empty,
    /// ·
    Dot,
    /// ○
    Ring,
    /// A zigzag.
    Zigzag,
    /// ⁄
    Slash,
    /// ×
    Cross,
    /// −
    Bar,
    /// ■
    Square,
}

/// A kind of cell.
#[derive(Debug, Clone)]
pub struct Kind {
    /// Entry in the legend.
    pub label: String,
    /// Red, green, blue.
    pub fill: [u8; 3],
    /// The sign in the cell; it is white on dark colours.
    pub sign: Sign,
}

/// One of the small maps.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// Heading.
    pub title: String,
    /// The look of its method in other pictures, and whether symbols are open there.
    pub look: Option<(Look, bool)>,
    /// Number of columns.
    pub columns: usize,
    /// The cells: column, row counted from below, and index of the kind.
    pub cells: Vec<(usize, usize, usize)>,
    /// Labels and their places along the abscissa, in columns (0.5 is the middle of the first).
    pub ticks: Vec<(f64, String)>,
    /// A dashed line at this place.
    pub line: Option<f64>,
}

/// A map: panels with the same rows.
#[derive(Debug, Clone)]
pub struct Map {
    /// Heading, which says what the picture shows.
    pub title: String,
    /// A smaller line below it, if not empty, which says what was computed.
    pub subtitle: String,
    /// Name of the abscissa of all panels.
    pub x_label: String,
    /// Name of the ordinate.
    pub y_label: String,
    /// Labels of the rows, from below.
    pub rows: Vec<String>,
    /// The kinds of cells.
    pub kinds: Vec<Kind>,
    /// The kind for a place without a cell.
    pub absent: Kind,
    /// The panels, in reading order.
    pub panels: Vec<Panel>,
    /// Entry of the dashed line in the legend.
    pub line_label: String,
}

impl Map {
    /// The picture as an SVG document. It depends on the map alone.
    pub fn to_svg(&self) -> String {
        let mut svg = String::new();
        let height = self.height();
        self.draw(&mut svg, height).expect("writing to a string does not fail");
        canvas::finish(&svg, height)
    }

    fn panel_size(&self) -> (i32, i32) {
        let width = (WIDTH - LEFT - MARGIN - (ACROSS as i32 - 1) * GAP) / ACROSS as i32;
        (width, units(self.rows.len().max(1)) * CELL_HEIGHT)
    }

    fn top(&self) -> i32 {
        MARGIN + canvas::heading_height(&self.title, &self.subtitle)
    }

    fn rows_of_panels(&self) -> i32 {
        units(self.panels.len().div_ceil(ACROSS).max(1))
    }

    /// The ordinate of the lower end of the panels.
    fn base(&self) -> i32 {
        self.top() + self.rows_of_panels() * (PANEL_TITLE + self.panel_size().1 + TICKS)
    }

    fn height(&self) -> i32 {
        self.base() + LABEL * 2 + self.legend_rows() * LEGEND_ROW + MARGIN
    }

    fn entries(&self) -> usize {
        self.kinds.len() + 1 + usize::from(!self.line_label.is_empty())
    }

    fn legend_rows(&self) -> i32 {
        units(self.entries().div_ceil(ACROSS))
    }

    fn draw(&self, svg: &mut String, height: i32) -> Drawn {
        let canvas = SVGBackend::with_string(svg, (WIDTH.unsigned_abs(), height.unsigned_abs())).into_drawing_area();
        canvas.fill(&WHITE)?;
        let middle = (LEFT + WIDTH - MARGIN) / 2;
        let write = |text: &str, at: Pixel, size: i32, room: i32, side: HPos| {
            canvas::write(&canvas, text, at, &font(size, text, room, TEXT, side))
        };
        canvas::draw_heading(&canvas, &self.title, &self.subtitle)?;
        let (width, panel_height) = self.panel_size();
        for (index, panel) in self.panels.iter().enumerate() {
            let (across, down) = ((index % ACROSS) as i32, units(index / ACROSS));
            let left = LEFT + across * (width + GAP);
            let top = self.top() + down * (PANEL_TITLE + panel_height + TICKS);
            let room = if panel.look.is_some() { width - 14 * PX } else { width };
            let style = font(HEADING, &panel.title, room, TEXT, HPos::Left);
            canvas::write(&canvas, &panel.title, (left + width - room, top + 4 * PX), &style)?;
            if let Some((look, open)) = panel.look {
                draw_symbol(&canvas, look, (left + 6 * PX, top + 4 * PX + HEADING / 2), SYMBOL, open)?;
            }
            self.draw_panel(&canvas, panel, (left, top + PANEL_TITLE), across == 0)?;
        }
        let base = self.base();
        write(&self.x_label, (middle, base), SMALL, WIDTH - LEFT, HPos::Center)?;
        let upright = font(LABEL, &self.y_label, base - self.top(), TEXT, HPos::Center);
        let upright = upright.transform(FontTransform::Rotate270);
        canvas::write(&canvas, &self.y_label, (MARGIN / 2, (self.top() + base) / 2), &upright)?;
        self.draw_legend(&canvas, base + LABEL * 2)?;
        canvas.present()
    }

    fn draw_panel(&self, canvas: &Canvas<'_>, panel: &Panel, (left, top): Pixel, labelled: bool) -> Drawn {
        let (width, height) = self.panel_size();
        let column = |place: f64| left + (place / panel.columns.max(1) as f64 * f64::from(width)).round() as i32;
        let bottom = top + height;
        let known: BTreeSet<(usize, usize)> = panel.cells.iter().map(|&(x, y, _)| (x, y)).collect();
        let everywhere = (0..self.rows.len()).flat_map(|y| (0..panel.columns).map(move |x| (x, y)));
        let absent = everywhere.filter(|at| !known.contains(at)).map(|(x, y)| (x, y, &self.absent));
        let present = panel.cells.iter().filter_map(|&(x, y, kind)| Some((x, y, self.kinds.get(kind)?)));
        for (x, y, kind) in present.chain(absent) {
            let (from, to) = (column(x as f64), column(x as f64 + 1.0));
            let below = bottom - units(y) * CELL_HEIGHT;
            draw_cell(canvas, kind, (from, below - CELL_HEIGHT), (to, below))?;
        }
        let line = TEXT.stroke_width(8);
        let frame = [(left, top), (left + width, top), (left + width, bottom), (left, bottom), (left, top)];
        canvas.draw(&PathElement::new(frame.to_vec(), line))?;
        let mut free = i32::MIN;
        for (place, label) in &panel.ticks {
            let at = column(*place);
            canvas.draw(&PathElement::new(vec![(at, bottom), (at, bottom + 3 * PX)], line))?;
            let half = extent(label, TICK_LABEL) / 2;
            if at - half > free {
                free = at + half + 4 * PX;
                canvas::write(
                    canvas,
                    label,
                    (at, bottom + 5 * PX),
                    &font(TICK_LABEL, label, width, TEXT, HPos::Center),
                )?;
            }
        }
        if labelled {
            for (row, label) in self.rows.iter().enumerate() {
                let at = (left - 5 * PX, bottom - units(row) * CELL_HEIGHT - CELL_HEIGHT / 2 - TICK_LABEL * 2 / 5);
                canvas::write(canvas, label, at, &font(TICK_LABEL, label, LEFT, TEXT, HPos::Right))?;
            }
        }
        if let Some(place) = panel.line.filter(|place| (0.0..=panel.columns as f64).contains(place)) {
            draw_limit(canvas, (column(place), top - 2 * PX), (column(place), bottom + 2 * PX))?;
        }
        Ok(())
    }

    fn draw_legend(&self, canvas: &Canvas<'_>, top: i32) -> Drawn {
        let room = (WIDTH - LEFT - MARGIN) / ACROSS as i32;
        let place = |index: usize| (LEFT + (index % ACROSS) as i32 * room, top + units(index / ACROSS) * LEGEND_ROW);
        let text = |(left, top): Pixel, label: &str, colour: RGBColor| {
            let style = font(SMALL, label, room - 24 * PX, colour, HPos::Left);
            canvas::write(canvas, label, (left + 20 * PX, top + CELL_HEIGHT / 2 - SMALL * 2 / 5), &style)
        };
        for (index, kind) in self.kinds.iter().chain([&self.absent]).enumerate() {
            let (left, top) = place(index);
            draw_cell(canvas, kind, (left, top), (left + CELL_HEIGHT, top + CELL_HEIGHT))?;
            text((left, top), &kind.label, TEXT)?;
        }
        if !self.line_label.is_empty() {
            let (left, top) = place(self.kinds.len() + 1);
            let x = left + CELL_HEIGHT / 2;
            draw_limit(canvas, (x, top - 2 * PX), (x, top + CELL_HEIGHT + 2 * PX))?;
            text((left, top), &self.line_label, PALE)?;
        }
        Ok(())
    }
}

/// A dashed line on a broader white one, so that it is visible on every colour.
fn draw_limit(canvas: &Canvas<'_>, from: Pixel, to: Pixel) -> Drawn {
    canvas.draw(&PathElement::new(vec![from, to], WHITE.stroke_width(34)))?;
    canvas.draw(&plotters::element::DashedPathElement::new([from, to], 45, 25, TEXT.stroke_width(16)))
}

fn draw_cell(canvas: &Canvas<'_>, kind: &Kind, (left, top): Pixel, (right, bottom): Pixel) -> Drawn {
    let [r, g, b] = kind.fill;
    canvas.draw(&Rectangle::new([(left, top), (right, bottom)], RGBColor(r, g, b).filled()))?;
    let outline = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    canvas.draw(&PathElement::new(outline, WHITE.stroke_width(7)))?;
    let dark = 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) < 128_000;
    let colour = if dark { WHITE } else { TEXT };
    let pen = colour.stroke_width(11);
    let (x, y) = ((left + right) / 2, (top + bottom) / 2);
    let size = (right - left).min(bottom - top) / 4;
    let path = |points: &[(i32, i32)]| {
        let points: Vec<Pixel> = points.iter().map(|&(a, b)| (x + a * size / 2, y + b * size / 2)).collect();
        canvas.draw(&PathElement::new(points, pen))
    };
    match kind.sign {
        Sign::Empty => Ok(()),
        Sign::Dot => canvas.draw(&Circle::new((x, y), 9, PALE.filled())),
        Sign::Ring => canvas.draw(&Circle::new((x, y), size, pen)),
        Sign::Zigzag => path(&[(-3, 1), (-2, -1), (-1, 1), (0, -1), (1, 1), (2, -1), (3, 1)]),
        Sign::Slash => path(&[(-2, 2), (2, -2)]),
        Sign::Cross => {
            path(&[(-2, -2), (2, 2)])?;
            path(&[(-2, 2), (2, -2)])
        }
        Sign::Bar => path(&[(-2, 0), (2, 0)]),
        Sign::Square => {
            let half = size * 2 / 3;
            canvas.draw(&Rectangle::new([(x - half, y - half), (x + half, y + half)], colour.filled()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_and_every_sign_is_drawn() {
        let signs = [Sign::Empty, Sign::Ring, Sign::Zigzag, Sign::Slash, Sign::Cross, Sign::Bar, Sign::Square];
        let kind =
            |(k, sign): (usize, Sign)| Kind { label: format!("kind {k} <"), fill: [200 - 25 * k as u8; 3], sign };
        let look = Look { colour: [1, 2, 3], shape: crate::output::chart::Shape::Diamond };
        let panel = Panel {
            title: "panel".into(),
            look: Some((look, false)),
            columns: 7,
            cells: (0..7).map(|k| (k, k % 2, k)).chain([(0, 1, 99)]).collect(),
            ticks: vec![(0.5, "0.1".into()), (6.5, "1".into())],
            line: Some(3.3),
        };
        let map = Map {
            title: "A < B".into(),
            subtitle: "of my_case with γ_f".into(),
            x_label: "Δγω".into(),
            y_label: "length".into(),
            rows: vec!["1".into(), "2".into()],
            kinds: signs.into_iter().enumerate().map(kind).collect(),
            absent: Kind { label: "none".into(), fill: [251; 3], sign: Sign::Dot },
            panels: vec![panel, Panel::default()],
            line_label: "limit".into(),
        };
        let svg = map.to_svg();
        assert_eq!(svg, map.to_svg());
        // Every kind has a cell in the panel and one in the legend.
        let cells = (0..7).map(|k: usize| format!("fill=\"#{0:02X}{0:02X}{0:02X}\"", 200 - 25 * k));
        assert!(cells.into_iter().all(|fill| svg.matches(&fill).count() >= 2), "{svg}");
        assert!(svg.contains("kind 6 &lt;") && svg.contains("limit") && svg.starts_with("<svg width=\"720\""));
        assert!(!svg.contains("NaN"));
        // Places without a cell: six in the panel, and one in the legend.
        assert_eq!(svg.matches("fill=\"#FBFBFB\"").count(), 7, "{svg}");
        assert!(svg.contains("fill=\"#010203\"") && svg.contains("my_case") && svg.contains(">f</tspan>"), "{svg}");
        let empty = Map { panels: Vec::new(), rows: Vec::new(), kinds: Vec::new(), line_label: String::new(), ..map };
        assert!(empty.to_svg().contains("A &lt; B"));
    }
}
