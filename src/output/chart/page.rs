//! The parts that all pictures share: a page with a heading, text with sub- and superscripts, symbols, and a legend.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use svg::Document;
use svg::node::Node;
use svg::node::element::{Element, Marker, Path, Polyline, Rectangle};

use super::series::{Shape, Style};

pub(super) const WIDTH: f64 = 720.0;
pub(super) const MARGIN: f64 = 16.0;

pub(super) const TITLE: f64 = 18.0;
pub(super) const LABEL: f64 = 16.0;
pub(super) const TICK: f64 = 14.0;
pub(super) const SMALL: f64 = 13.0;

pub(super) const TEXT: &str = "#222";
pub(super) const PALE: &str = "#606060";

/// The size of a script, and how far a subscript and a superscript are moved down, relative to the size of their base.
const SCRIPT: f64 = 0.72;
const LOWERED: f64 = 0.22;
const RAISED: f64 = -0.36;

/// The width of the sample beside a label of a legend, the space around it and behind the label, and the height of a
/// row.
pub(super) const SAMPLE: f64 = 24.0;
const PADDING: f64 = 6.0;
const GAP: f64 = 10.0;
const ROW: f64 = 21.0;
/// A legend that would have more rows has smaller letters, down to the last of these sizes.
const ROWS: usize = 2;
const SIZES: [f64; 3] = [TICK, SMALL, 11.5];

/// A place in pixels.
pub(super) type At = (f64, f64);

/// A picture that is being drawn, on opaque white.
pub(super) struct Page {
    document: Document,
    symbols: BTreeSet<String>,
    /// The ordinate at which the rest of the picture begins.
    pub(super) top: f64,
}

impl Page {
    /// A page with a title and a subtitle, of which either may be empty.
    pub(super) fn new(title: &str, subtitle: &str) -> Self {
        let ground = Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "#fff");
        let document = Document::new()
            .set("width", WIDTH)
            .set("font-family", "sans-serif")
            .set("stroke-linejoin", "round")
            .set("stroke-linecap", "round")
            .set("fill", "none")
            .set("xml:space", "preserve")
            .add(ground);
        let mut page = Self { document, symbols: BTreeSet::new(), top: MARGIN };
        for (text, size, colour) in [(title, TITLE, TEXT), (subtitle, SMALL, PALE)] {
            if !text.is_empty() {
                page.write(text, (WIDTH / 2.0, page.top + 0.76 * size), size, "middle", colour);
                page.top += 1.5 * size;
            }
        }
        page
    }

    /// The document, of this height.
    pub(super) fn finish(self, height: f64) -> String {
        let document = self.document.set("height", height).set("viewBox", (0, 0, WIDTH, height));
        // The library writes every script on a line of its own, which would be a space.
        document.to_string().replace("\n<tspan", "<tspan").replace("</tspan>\n", "</tspan>") + "\n"
    }

    /// Adds an element on top of the others.
    pub(super) fn add(&mut self, element: impl Into<Box<dyn Node>>) {
        self.document.append(element);
    }

    /// Draws lines.
    pub(super) fn stroke(&mut self, path: String, colour: &str, width: f64) {
        self.add(Path::new().set("d", path).set("stroke", colour).set("stroke-width", width));
    }

    /// Writes text in one line, whose letters stand at this place, with its start, middle or end.
    pub(super) fn write(&mut self, text: &str, at: At, size: f64, side: &str, colour: &str) {
        self.add(line_of_text(text, at, size, (side, WIDTH - 2.0 * MARGIN), colour));
    }

    /// Writes the name of an ordinate, which goes upwards between these two.
    pub(super) fn write_upright(&mut self, text: &str, top: f64, base: f64) {
        let (x, y) = (MARGIN / 2.0 + 0.76 * LABEL, (top + base) / 2.0);
        let mut line = line_of_text(text, (x, y), LABEL, ("middle", base - top), TEXT);
        line.assign("transform", format!("rotate(-90 {} {})", px(x), px(y)));
        self.add(line);
    }

    /// Writes labels below places along an abscissa, in order, but for those that would be nearer to the one before
    /// than `space`.
    pub(super) fn write_along(&mut self, labels: impl Iterator<Item = (f64, String)>, y: f64, size: f64, space: f64) {
        let mut free = f64::NEG_INFINITY;
        for (x, label) in labels {
            let half = extent(&label, size) / 2.0;
            if x - half > free {
                free = x + half + space;
                self.write(&label, (x, y), size, "middle", TEXT);
            }
        }
    }

    /// Draws symbols at these places.
    pub(super) fn symbols(&mut self, look: Style, radius: f64, is_open: bool, places: &[At]) {
        if places.is_empty() {
            return;
        }
        // The name says all of the look: where several pictures are in one document, the same name is the same symbol.
        let kind = if is_open { "open" } else { "full" };
        let name = format!("{:?}-{}-{kind}-{radius}", look.shape, &look.hex()[1..]);
        if !self.symbols.contains(&name) {
            let (half, size) = (2.0 * radius, 4.0 * radius);
            let marker = Marker::new().set("id", &*name).set("viewBox", (-half, -half, size, size));
            let marker = marker.set("markerUnits", "userSpaceOnUse").set("markerWidth", size).set("markerHeight", size);
            self.add(marker.add(symbol(look, radius, is_open)));
        }
        let link = format!("url(#{name})");
        // Not every viewer draws a symbol on a line that is a single point.
        let ends = [places[0]; 2];
        let line = Polyline::new().set("points", points(if places.len() == 1 { &ends } else { places }));
        self.add(line.set("marker-start", &*link).set("marker-mid", &*link).set("marker-end", link));
        self.symbols.insert(name);
    }

    /// Writes the labels of a legend in rows, to the right of this place, or of the margin if it needs the room, and
    /// returns the middles of their samples.
    pub(super) fn legend(&mut self, left: f64, labels: &[&str]) -> Vec<At> {
        let fits = |&(left, size): &(f64, f64)| rows(left, size, labels).last().is_none_or(|last| last.1 < ROWS);
        let narrow = SIZES.into_iter().map(|size| (MARGIN, size));
        let smallest = (MARGIN, SIZES[SIZES.len() - 1]);
        let (left, size) = std::iter::once((left, TICK)).chain(narrow).find(fits).unwrap_or(smallest);
        let mut places = Vec::new();
        for (label, (x, row, width)) in labels.iter().zip(rows(left, size, labels)) {
            let y = self.top + ROW * (row as f64 + 0.5);
            places.push((x + SAMPLE / 2.0, y));
            let at = (x + SAMPLE + PADDING, y + 0.35 * size);
            self.add(line_of_text(label, at, size, ("start", width), TEXT));
        }
        self.top = places.last().map_or(self.top, |&(_, y)| y + ROW / 2.0 + PADDING);
        places
    }
}

/// Of each label of a legend of this size, to the right of this place: where it begins, its row, and its width.
fn rows(left: f64, size: f64, labels: &[&str]) -> Vec<(f64, usize, f64)> {
    let (mut x, mut row, right) = (left, 0, WIDTH - MARGIN);
    let mut place = |label: &&str| {
        let width = extent(label, size).min(right - left - SAMPLE - PADDING);
        if x + SAMPLE + PADDING + width > right {
            (x, row) = (left, row + 1);
        }
        let from = x;
        x += SAMPLE + PADDING + width + GAP;
        (from, row, width)
    };
    labels.iter().map(&mut place).collect()
}

/// A coordinate to a tenth of a pixel.
pub(super) fn px(coordinate: f64) -> f64 {
    (10.0 * coordinate).round() / 10.0 + 0.0
}

/// The points of a line as an attribute.
pub(super) fn points(places: &[At]) -> String {
    let place = |&(x, y): &At| format!("{},{}", px(x), px(y));
    places.iter().map(place).collect::<Vec<_>>().join(" ")
}

/// The approximate width of a text in any usual font.
pub(super) fn extent(text: &str, size: f64) -> f64 {
    0.55 * size * text.chars().count() as f64
}

/// A line of text, which is set smaller if it is wider than its room.
fn line_of_text(text: &str, (x, y): At, size: f64, (side, room): (&str, f64), colour: &str) -> Element {
    // XML allows no control characters, not even escaped ones.
    let is_text = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let text: String = text.chars().map(|c| if is_text(c) { c } else { ' ' }).collect();
    let size = size * (room / extent(&text, size)).min(1.0);
    let mut line = Element::new("text");
    for (name, value) in [("x", x), ("y", y), ("font-size", size)] {
        line.assign(name, px(value));
    }
    line.assign("fill", colour);
    line.assign("text-anchor", side);
    // A script is moved by `dy`, which every viewer knows, unlike `baseline-shift`. It applies to the rest of the text
    // as well, so that the next part has to undo it.
    let mut height = 0.0;
    for (shift, part) in parts(&text) {
        let part = svg::node::Text::new(part);
        if shift == height {
            line.append(part);
            continue;
        }
        let mut script = Element::new("tspan");
        script.assign("dy", px((shift - height) * size));
        script.assign("font-size", px(if shift == 0.0 { size } else { SCRIPT * size }));
        script.append(part);
        line.append(script);
        height = shift;
    }
    line
}

/// Splits a text into parts that are moved down by a share of its size: `γ_f`, `p_{φ}`, `G^t` and `10^{−16}` have
/// scripts.
///
/// The base of a script is a single letter, which may have a capital delta before it, or for a superscript a number or
/// a bracket. The script itself is a single letter or digit, or anything in braces. Names of files and columns such as
/// `delta_q_t` or `x_final` are left as they are.
fn parts(text: &str) -> Vec<(f64, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut parts, mut from, mut at) = (Vec::new(), 0, 0);
    while let Some(mark) = text[at..].find(['_', '^']).map(|k| at + k) {
        at = mark + 1;
        let shift = if text[mark..].starts_with('_') { LOWERED } else { RAISED };
        let mut back = text[..mark].chars().rev();
        let (base, before) = (back.next().unwrap_or(' '), back.next().unwrap_or(' '));
        let has_base = base.is_alphabetic() && (!is_word(before) || before == 'Δ')
            || shift == RAISED && (base.is_ascii_digit() || base == ')');
        let (script, braces) = match text[at..].strip_prefix('{').map(|inner| inner.split_once('}')) {
            Some(inside) => (inside.map_or("", |(script, _)| script), 2),
            None => {
                (text[at..].split(|c| !is_word(c)).next().filter(|word| word.chars().count() == 1).unwrap_or(""), 0)
            }
        };
        if has_base && !script.is_empty() && script != "_" {
            parts.extend([(0.0, &text[from..mark]), (shift, script)]);
            at += script.len() + braces;
            from = at;
        }
    }
    parts.push((0.0, &text[from..]));
    parts.retain(|(_, part)| !part.is_empty());
    parts
}

/// A symbol around the origin, filled or open.
fn symbol(look: Style, radius: f64, is_open: bool) -> Path {
    // The point in a direction, given in turns, and at a distance, given in radii.
    let corner = |turn: f64, distance: f64| {
        let (sin, cos) = (TAU * turn).sin_cos();
        (distance * radius * cos, -distance * radius * sin)
    };
    let stroke = |turn: f64| format!("M{}", points(&[corner(turn, 1.3), corner(turn + 0.5, 1.3)]));
    // Number of corners, direction of the first in turns, and a factor that makes all shapes look equally large.
    let polygon = |corners: u32, first: f64, size: f64| {
        // Every other corner of a star is an inner one.
        let inner = |k: u32| if look.shape == Shape::Star && k % 2 == 1 { 0.45 } else { 1.0 };
        let at = |k: u32| corner(f64::from(k) / f64::from(corners) + first, inner(k) * size);
        format!("M{}z", points(&(0..corners).map(at).collect::<Vec<_>>()))
    };
    let path = match look.shape {
        Shape::Circle => {
            format!("M-{radius},0a{radius},{radius} 0 1 0 {0},0a{radius},{radius} 0 1 0-{0},0z", 2.0 * radius)
        }
        Shape::Cross => stroke(0.125) + &stroke(0.375),
        Shape::Plus => stroke(0.0) + &stroke(0.25),
        Shape::Asterisk => (0..3).map(|k| stroke(0.25 + f64::from(k) / 6.0)).collect(),
        Shape::Square => polygon(4, 0.125, 1.25),
        Shape::Triangle => polygon(3, 0.25, 1.5),
        Shape::Diamond => polygon(4, 0.0, 1.35),
        Shape::Nabla => polygon(3, 0.75, 1.5),
        Shape::Star => polygon(10, 0.25, 1.7),
        Shape::Pentagon => polygon(5, 0.25, 1.25),
    };
    let path = Path::new().set("d", path);
    match (is_open, look.shape) {
        (true, _) => path.set("stroke", look.hex()).set("stroke-width", 1.3),
        // Strokes cannot be filled; instead they are thicker.
        (false, Shape::Cross | Shape::Plus | Shape::Asterisk) => path.set("stroke", look.hex()).set("stroke-width", 2),
        (false, _) => path.set("fill", look.hex()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_have_scripts_and_names_have_none() {
        let shown = |text: &str| -> String {
            let brackets =
                |shift: f64| [("", ""), ("[", "]"), ("<", ">")][(shift > 0.0) as usize + 2 * (shift < 0.0) as usize];
            parts(text).iter().map(|&(shift, part)| [brackets(shift).0, part, brackets(shift).1].concat()).collect()
        };
        assert_eq!(shown("γ_f − γ_i"), "γ[f] − γ[i]");
        assert_eq!(shown("|ΔQ_t| and ε_x(γ_f)"), "|ΔQ[t]| and ε[x](γ[f])");
        assert_eq!(shown("|ΔG^t|, λ_7/H_N, V_{eff}, 10^{−16}"), "|ΔG<t>|, λ[7]/H[N], V[eff], 10<−16>");
        for name in
            ["delta_q_t.svg", "my_case", "x_final", "run1_2", "t_", "_x", "a__b", "γ_{", "γ_{}", "^", "x^−2", "snake_c"]
        {
            assert_eq!(shown(name), name);
        }
    }

    #[test]
    fn the_line_goes_on_at_its_height() {
        let mut page = Page::new("", "");
        page.write("γ_f − 1 < x", (0.0, 0.0), 10.0, "start", TEXT);
        let text = "γ<tspan dy=\"2.2\" font-size=\"7.2\">f</tspan>\
                    <tspan dy=\"-2.2\" font-size=\"10\"> − 1 &lt; x</tspan></text>";
        let svg = page.finish(100.0);
        assert!(svg.contains(text), "{svg}");
    }

    #[test]
    fn a_legend_has_two_rows_if_small_letters_make_that_possible() {
        let rows = |count: usize| {
            let mut page = Page::new("", "");
            let places = page.legend(80.0, &vec!["SBP strong"; count]);
            let ordinates: BTreeSet<i64> = places.iter().map(|(_, y)| *y as i64).collect();
            assert!(places.iter().all(|(x, _)| (MARGIN..WIDTH - MARGIN).contains(x)));
            ordinates.len()
        };
        assert_eq!([1, 5, 12, 24].map(rows), [1, 1, 2, 4]);
        // Those of all methods of `work-precision`, with the ones of other programs.
        let all = "SBP strong,SBP weak,GLL weak,accuracy,march,tolerance,RK4,Verlet,Kahan–Li,Gauss,DOP853,Radau5,\
                   Taylor,SciPy,heyoka,heyoka×2";
        let all: Vec<&str> = all.split(',').collect();
        assert_eq!(super::rows(MARGIN, SIZES[2], &all).last().map(|last| last.1), Some(1));
    }

    #[test]
    fn every_shape_is_another_picture() {
        let look = |shape| Style { colour: [1, 2, 3], shape };
        let picture = |(shape, is_open): (Shape, bool)| symbol(look(shape), 3.4, is_open).to_string();
        let kinds = Shape::ALL.into_iter().flat_map(|shape| [(shape, true), (shape, false)]);
        assert_eq!(kinds.map(picture).collect::<BTreeSet<_>>().len(), 2 * Shape::ALL.len());
    }
}
