//! Maps: panels of equal cells. Every kind of cell has a colour of different lightness and a sign, so that nothing is
//! shown by colour alone.

use std::collections::BTreeSet;

use svg::node::element::Path;

use super::bar::Bar;
use super::page::{At, LABEL, MARGIN, Page, SAMPLE, SMALL, TEXT, WIDTH, extent, px};
use super::series::hex;
use super::{RADIUS, Style};

/// Panels side by side.
const ACROSS: usize = 4;
const GAP: f64 = 12.0;
/// The least room for the labels of the rows, and what is left of them for the name of the ordinate.
const LEFT: f64 = 70.0;
const NAME: f64 = 34.0;
/// A colour bar: its distance from the panel, its width, and its distance from its labels.
const BAR: [f64; 3] = [14.0, 16.0, 7.0];
/// The height of cells, and the most and the least of those of a single panel, which is about so high.
const CELL_HEIGHT: f64 = 14.0;
const CELL_HEIGHTS: [f64; 2] = [2.0, 28.0];
const PANEL_HEIGHT: f64 = 420.0;
/// Smaller cells have no gaps between them.
const WITH_GAPS: f64 = 8.0;
const PANEL_TITLE: f64 = 20.0;
const TICKS: f64 = 28.0;
/// Labels of ticks and rows, and headings of panels.
const TINY: f64 = 12.0;

/// A sign in a cell: its strokes, in eighths of the cell around its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sign(&'static [&'static [At]]);

/// The coordinates of a point of a ring of radius 2 between the axes.
const ROUND: f64 = 1.41;

impl Sign {
    /// No sign, for the best kind of cell.
    pub const EMPTY: Self = Self(&[]);
    /// ·
    pub const DOT: Self = Self(&[&[(0.0, 0.0), (0.0, 0.0)]]);
    /// ○
    pub const RING: Self = Self(&[&[
        (2.0, 0.0),
        (ROUND, ROUND),
        (0.0, 2.0),
        (-ROUND, ROUND),
        (-2.0, 0.0),
        (-ROUND, -ROUND),
        (0.0, -2.0),
        (ROUND, -ROUND),
        (2.0, 0.0),
    ]]);
    /// A zigzag.
    pub const ZIGZAG: Self =
        Self(&[&[(-3.0, 1.0), (-2.0, -1.0), (-1.0, 1.0), (0.0, -1.0), (1.0, 1.0), (2.0, -1.0), (3.0, 1.0)]]);
    /// ⁄
    pub const SLASH: Self = Self(&[&[(-2.0, 2.0), (2.0, -2.0)]]);
    /// ×
    pub const CROSS: Self = Self(&[&[(-2.0, -2.0), (2.0, 2.0)], &[(-2.0, 2.0), (2.0, -2.0)]]);
    /// −
    pub const BAR: Self = Self(&[&[(-2.0, 0.0), (2.0, 0.0)]]);
    /// ■
    pub const SQUARE: Self = Self(&[&[(-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6), (-0.6, -0.6)]]);
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
    pub look: Option<(Style, bool)>,
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
    /// The number of rows.
    pub rows: usize,
    /// Labels and their places along the ordinate, in rows (0.5 is the middle of the lowest).
    pub row_ticks: Vec<(f64, String)>,
    /// The kinds of cells. What has no label is not in the legend.
    pub kinds: Vec<Kind>,
    /// The colour bar, if colours are values.
    pub bar: Option<Bar>,
    /// The kind for a place without a cell.
    pub absent: Kind,
    /// The panels, in reading order.
    pub panels: Vec<Panel>,
    /// Entry of the dashed line in the legend.
    pub line_label: String,
}

impl Map {
    /// Panels side by side; a single one takes the whole width.
    fn across(&self) -> usize {
        if self.panels.len() == 1 { 1 } else { ACROSS }
    }

    /// Where panels begin, to the right of the labels of the rows.
    fn left(&self) -> f64 {
        self.row_ticks.iter().map(|(_, label)| NAME + extent(label, TINY)).fold(LEFT, f64::max)
    }

    /// Where panels end, to the left of a colour bar.
    fn right(&self) -> f64 {
        let labels = self.bar.iter().flat_map(Bar::ticks).map(|(_, label)| extent(&label, TINY));
        let room = self.bar.as_ref().map_or(0.0, |_| BAR.iter().sum::<f64>() + labels.fold(0.0, f64::max));
        WIDTH - MARGIN - room
    }

    fn panel_width(&self) -> f64 {
        let across = self.across() as f64;
        (self.right() - self.left() - (across - 1.0) * GAP) / across
    }

    fn cell_height(&self) -> f64 {
        let [least, most] = CELL_HEIGHTS;
        let filling = (PANEL_HEIGHT / self.rows.max(1) as f64).clamp(least, most);
        if self.panels.len() == 1 { filling } else { CELL_HEIGHT }
    }

    /// The picture as an SVG document. It depends on the map alone.
    pub fn to_svg(&self) -> String {
        let mut page = Page::new(&self.title, &self.subtitle);
        self.draw_legend(&mut page);
        let (top, across, cell_height) = (page.top, self.across(), self.cell_height());
        let panel_height = self.rows.max(1) as f64 * cell_height;
        for (index, panel) in self.panels.iter().enumerate() {
            let left = self.left() + (index % across) as f64 * (self.panel_width() + GAP);
            let top = top + (index / across) as f64 * (PANEL_TITLE + panel_height + TICKS);
            let mut room = self.panel_width();
            if let Some((look, is_open)) = panel.look {
                page.symbols(look, RADIUS, is_open, &[(left + 6.0, top + 10.0)]);
                room -= SAMPLE / 2.0;
            }
            let size = TINY * (room / extent(&panel.title, TINY)).min(1.0);
            page.write(&panel.title, (left + self.panel_width() - room, top + 14.0), size, "start", TEXT);
            let top = top + PANEL_TITLE;
            self.draw_panel(&mut page, panel, (left, top), panel_height);
            if index % across == 0 {
                self.draw_row_ticks(&mut page, (left, top + panel_height));
            }
            self.draw_bar(&mut page, top, panel_height);
        }
        let rows = self.panels.len().div_ceil(across).max(1) as f64;
        let base = top + rows * (PANEL_TITLE + panel_height + TICKS);
        page.write(&self.x_label, ((self.left() + self.right()) / 2.0, base + SMALL), SMALL, "middle", TEXT);
        page.write_upright(&self.y_label, top, base);
        page.finish(base + LABEL + MARGIN)
    }

    fn draw_legend(&self, page: &mut Page) {
        let kinds = || self.kinds.iter().chain([&self.absent]).filter(|kind| !kind.label.is_empty());
        let line_label = Some(&*self.line_label).filter(|label| !label.is_empty());
        let labels: Vec<&str> = kinds().map(|kind| &*kind.label).chain(line_label).collect();
        let places = page.legend(self.left(), &labels);
        let half = CELL_HEIGHT / 2.0;
        for (kind, &(x, y)) in kinds().zip(&places) {
            draw_cells(page, kind, &[((x - half, y - half), (x + half, y + half))], false);
        }
        if let (Some(_), Some(&(x, y))) = (line_label, places.last()) {
            draw_limit(page, x, y - half, y + half);
        }
    }

    /// Writes the labels of the rows of a panel whose lower left corner is there, but for those that would touch the
    /// one before.
    fn draw_row_ticks(&self, page: &mut Page, (left, bottom): At) {
        let (mut free, mut strokes) = (f64::INFINITY, String::new());
        for (place, label) in &self.row_ticks {
            let y = bottom - place * self.cell_height();
            strokes += &format!("M{} {}h-3", px(left), px(y));
            if y + 0.5 * TINY < free {
                free = y - 0.5 * TINY;
                page.write(label, (left - 5.0, y + 0.36 * TINY), TINY, "end", TEXT);
            }
        }
        if self.bar.is_some() {
            page.stroke(strokes, TEXT, 0.8);
        }
    }

    fn draw_bar(&self, page: &mut Page, top: f64, height: f64) {
        let Some(bar) = &self.bar else { return };
        let (left, right) = (self.right() + BAR[0], self.right() + BAR[0] + BAR[1]);
        let (bottom, step) = (top + height, height / self.kinds.len().max(1) as f64);
        for (k, kind) in self.kinds.iter().enumerate() {
            let below = bottom - k as f64 * step;
            draw_cells(page, kind, &[((left, below - step), (right, below))], true);
        }
        let mut lines = format!("M{} {}H{}V{}H{0}z", px(left), px(top), px(right), px(bottom));
        for (share, label) in bar.ticks() {
            let y = bottom - share * height;
            lines += &format!("M{} {}h3", px(right), px(y));
            page.write(&label, (right + BAR[2], y + 0.36 * TINY), TINY, "start", TEXT);
        }
        page.stroke(lines, TEXT, 0.8);
    }

    fn draw_panel(&self, page: &mut Page, panel: &Panel, (left, top): At, height: f64) {
        let (width, cell_height) = (self.panel_width(), self.cell_height());
        let column = |place: f64| left + place / panel.columns.max(1) as f64 * width;
        let bottom = top + height;
        let cell = |x: usize, y: usize| {
            let below = bottom - y as f64 * cell_height;
            ((column(x as f64), below - cell_height), (column(x as f64 + 1.0), below))
        };
        let has_cell: BTreeSet<(usize, usize)> = panel.cells.iter().map(|at| (at.0, at.1)).collect();
        let everywhere = (0..self.rows).flat_map(|y| (0..panel.columns).map(move |x| (x, y)));
        let absent = everywhere.filter(|at| !has_cell.contains(at));
        let is_seamless = self.bar.is_some();
        draw_cells(page, &self.absent, &absent.map(|(x, y)| cell(x, y)).collect::<Vec<_>>(), is_seamless);
        for (index, kind) in self.kinds.iter().enumerate() {
            let cells = panel.cells.iter().filter(|at| at.2 == index).map(|at| cell(at.0, at.1));
            draw_cells(page, kind, &cells.collect::<Vec<_>>(), is_seamless);
        }
        let mut lines = format!("M{} {}h{}v{}H{0}z", px(left), px(top), px(width), px(height));
        lines.extend(panel.ticks.iter().map(|(place, _)| format!("M{} {}v3", px(column(*place)), px(bottom))));
        let labels = panel.ticks.iter().map(|(place, label)| (column(*place), label.clone()));
        page.write_along(labels, bottom + 14.0, TINY, 4.0);
        page.stroke(lines, TEXT, 0.8);
        if let Some(place) = panel.line.filter(|place| (0.0..=panel.columns as f64).contains(place)) {
            draw_limit(page, column(place), top, bottom);
        }
    }
}

/// A dashed line on a broader white one, so that it is visible on every colour.
fn draw_limit(page: &mut Page, x: f64, top: f64, bottom: f64) {
    let line = format!("M{} {}V{}", px(x), px(top - 2.0), px(bottom + 2.0));
    page.stroke(line.clone(), "#fff", 3.4);
    page.add(Path::new().set("d", line).set("stroke", TEXT).set("stroke-width", 1.6).set("stroke-dasharray", "3 4"));
}

/// Draws cells of a kind, each from its upper left to its lower right corner, with white lines between them where they
/// are not too small for it.
fn draw_cells(page: &mut Page, kind: &Kind, cells: &[(At, At)], is_seamless: bool) {
    if cells.is_empty() {
        return;
    }
    let cell = |&((left, top), (right, bottom)): &(At, At)| {
        format!("M{} {}H{}V{}H{0}z", px(left), px(top), px(right), px(bottom))
    };
    let ground = Path::new().set("d", cells.iter().map(cell).collect::<String>()).set("fill", hex(kind.fill));
    let ((left, top), (right, bottom)) = cells[0];
    let has_gaps = !is_seamless && (right - left).min(bottom - top) >= WITH_GAPS;
    page.add(match has_gaps {
        true => ground.set("stroke", "#fff").set("stroke-width", 0.7),
        // Neighbours are to leave no seam.
        false => ground.set("stroke", hex(kind.fill)).set("stroke-width", 0.2),
    });
    let sign = |&((left, top), (right, bottom)): &(At, At)| {
        let size = (right - left).min(bottom - top) / 8.0;
        let place = |&(a, b): &(f64, f64)| {
            format!("{} {}", px((left + right) / 2.0 + a * size), px((top + bottom) / 2.0 + b * size))
        };
        let stroke = |points: &&[At]| format!("M{}", points.iter().map(place).collect::<Vec<_>>().join("L"));
        kind.sign.0.iter().map(stroke).collect::<String>()
    };
    let [red, green, blue] = kind.fill.map(u32::from);
    let is_dark = 299 * red + 587 * green + 114 * blue < 128_000;
    let width = if kind.sign == Sign::SQUARE { 2.2 } else { 1.1 };
    let signs: String = cells.iter().map(sign).collect();
    if !signs.is_empty() {
        page.stroke(signs, if is_dark { "#fff" } else { TEXT }, width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_and_every_sign_is_drawn() {
        let signs = [Sign::EMPTY, Sign::RING, Sign::ZIGZAG, Sign::SLASH, Sign::CROSS, Sign::BAR, Sign::SQUARE];
        let kind =
            |(k, sign): (usize, Sign)| Kind { label: format!("kind {k} <"), fill: [200 - 25 * k as u8; 3], sign };
        let look = Style { colour: [1, 2, 3], shape: crate::output::chart::Shape::Diamond };
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
            rows: 2,
            row_ticks: vec![(0.5, "1".into()), (1.5, "2".into())],
            bar: None,
            kinds: signs.into_iter().enumerate().map(kind).collect(),
            absent: Kind { label: "none".into(), fill: [251; 3], sign: Sign::DOT },
            panels: vec![panel, Panel::default()],
            line_label: "limit".into(),
        };
        let svg = map.to_svg();
        assert_eq!(svg, map.to_svg());
        // Every kind has cells in the panel and one in the legend; each of both is a path.
        let paths = |grey: usize| svg.matches(&format!("fill=\"#{grey:02x}{grey:02x}{grey:02x}\"")).count();
        assert!((0..7).all(|k: usize| paths(200 - 25 * k) == 2), "{svg}");
        assert!(svg.contains("kind 6 &lt;") && svg.contains("limit") && !svg.contains("NaN"));
        // Six places of the panel have no cell.
        let absent: Vec<&str> = svg.lines().filter(|line| line.contains("#fbfbfb")).collect();
        assert_eq!(absent.iter().map(|line| line.matches('M').count()).collect::<Vec<_>>(), [1, 6], "{svg}");
        assert!(svg.contains("fill=\"#010203\"") && svg.contains("my_case") && svg.contains(">f</tspan>"), "{svg}");
        let empty = Map { panels: Vec::new(), rows: 0, kinds: Vec::new(), line_label: String::new(), ..map };
        assert!(empty.to_svg().contains("A &lt; B"));
    }
}
