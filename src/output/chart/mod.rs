//! Curves and points on linear or logarithmic axes, as SVG.

mod axis;
mod bar;
mod map;
mod page;
mod series;
mod thin;

pub(crate) use bar::{Bar, ticks_of_cells};
pub use map::{Kind, Map, Panel, Sign};
pub(crate) use series::colour;
pub use series::{Mark, Series, Shape, Style};

use svg::node::element::Polyline;

use self::axis::{Axis, is_drawable};
use self::page::{At, LABEL, MARGIN, PALE, Page, SAMPLE, SMALL, TEXT, TICK, WIDTH, extent, points, px};
use self::series::looks;

const PLOT_HEIGHT: f64 = 360.0;
const GRID: &str = "#dadada";
const FINE_GRID: &str = "#f0f0f0";
/// The radius of a symbol in a series that has few of them.
const RADIUS: f64 = 3.4;
/// A chart has about so many symbols at most, shared by its series.
const MOST_SYMBOLS: usize = 5000;

/// The scale of an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly, with 4 % of room at either end.
    #[default]
    Linear,
    /// By their decimal logarithm, over whole decades if these are few.
    ///
    /// Values that are zero or negative have no logarithm. They are drawn with open symbols at a floor, a decade below
    /// that of the least positive value. Its tick reads "0", "< 0" or "≤ 0", and a line below the axis says where the
    /// floor is.
    Log,
}

/// A picture with two axes.
///
/// Series are drawn in order, later ones on top, on opaque white. Text may be any Unicode; it is escaped for XML, and
/// set smaller if it is too long. `γ_f`, `V_{eff}` and `G^t` are set with sub- and superscripts.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    /// Heading, if not empty. It says what the picture shows.
    pub title: String,
    /// A smaller line below it, if not empty. It says what was computed.
    pub subtitle: String,
    /// Name of the abscissa.
    pub x_label: String,
    /// Name of the ordinate.
    pub y_label: String,
    /// Scale of the abscissa.
    pub x_scale: Scale,
    /// Scale of the ordinate.
    pub y_scale: Scale,
    /// True if a unit has the same length along both axes, which are linear.
    pub is_isometric: bool,
    /// The series that are drawn.
    pub series: Vec<Series>,
}

impl Chart {
    /// A picture on linear axes with these names.
    pub fn new(title: impl Into<String>, subtitle: &str, [x_label, y_label]: [&str; 2], series: Vec<Series>) -> Self {
        let [subtitle, x_label, y_label] = [subtitle, x_label, y_label].map(str::to_owned);
        Self { title: title.into(), subtitle, x_label, y_label, series, ..Self::default() }
    }

    /// The same picture on two logarithmic axes.
    #[must_use]
    pub fn log_log(self) -> Self {
        Self { x_scale: Scale::Log, y_scale: Scale::Log, ..self }
    }

    /// The picture as an SVG document. It depends on the chart alone.
    pub fn to_svg(&self) -> String {
        let mut page = Page::new(&self.title, &self.subtitle);
        let (x, y, left) = self.axes();
        let looks = looks(&self.series);
        let labelled: Vec<_> = self.series.iter().zip(&looks).filter(|(series, _)| !series.label.is_empty()).collect();
        let labels: Vec<&str> = labelled.iter().map(|(series, _)| &*series.label).collect();
        for ((series, look), (x, y)) in labelled.iter().zip(page.legend(left, &labels)) {
            let ends = [(x - SAMPLE / 2.0, y), (x + SAMPLE / 2.0, y)];
            draw(&mut page, series.mark, **look, (&[ends.to_vec()], &[(x, y)], &[]), RADIUS);
        }
        let frame = Frame { x, y, left, top: page.top };
        let under = self.draw_frame(&mut page, &frame);
        let most = MOST_SYMBOLS / self.series.len().max(1);
        for (series, look) in self.series.iter().zip(looks) {
            let points: Vec<Option<(At, bool)>> = series.points.iter().map(|&point| frame.place(point)).collect();
            let runs: Vec<Vec<At>> =
                points.split(Option::is_none).map(|run| run.iter().flatten().map(|p| p.0).collect()).collect();
            let marks = |is_open: bool| {
                let places = points.iter().flatten().filter(|p| p.1 == is_open).map(|p| p.0);
                thin::marks(places.collect(), most)
            };
            let (full, open) = (marks(false), marks(true));
            let radius = match full.len() + open.len() {
                ..=80 => RADIUS,
                81..=400 => 2.4,
                _ => 1.8,
            };
            draw(&mut page, series.mark, look, (&runs, &full, &open), radius);
        }
        page.finish(under + MARGIN / 2.0)
    }

    /// The axes, and where the plot begins, to the right of the labels of the second one.
    fn axes(&self) -> (Axis, Axis, f64) {
        let points = self.series.iter().flat_map(|s| &s.points).copied();
        let (xs, ys): (Vec<f64>, Vec<f64>) = points.filter(|p| is_drawable(p.0) && is_drawable(p.1)).unzip();
        let (mut x, mut y) = (Axis::new(self.x_scale, &xs), Axis::new(self.y_scale, &ys));
        let left_of = |y: &Axis| {
            let labels = y.labelled.iter().map(|&v| extent(&y.label(v), TICK));
            MARGIN + LABEL + labels.fold(0.0, f64::max) + 16.0
        };
        let mut left = left_of(&y);
        // The labels depend on the range, which depends on the room that the labels leave.
        for _ in 0..if self.is_isometric { 2 } else { 0 } {
            left = left_of(&y);
            let width = WIDTH - MARGIN - left;
            let unit = (x.span() / width).max(y.span() / PLOT_HEIGHT);
            (x, y) = (x.widened(unit * width), y.widened(unit * PLOT_HEIGHT));
        }
        (x, y, left)
    }

    /// Draws grid lines, frame, ticks and all that is written around the plot; returns where this ends below it.
    fn draw_frame(&self, page: &mut Page, frame: &Frame) -> f64 {
        let Frame { x, y, left, top } = frame;
        let (right, base) = (WIDTH - MARGIN, top + PLOT_HEIGHT);
        for (xs, ys, colour) in [(&x.fine, &y.fine, FINE_GRID), (&x.labelled, &y.labelled, GRID)] {
            let columns = xs.iter().map(|&v| format!("M{} {}V{}", px(frame.column(v)), px(*top), px(base)));
            let rows = ys.iter().map(|&v| format!("M{} {}H{right}", px(*left), px(frame.row(v))));
            page.stroke(columns.chain(rows).collect(), colour, 0.7);
        }
        let mut ticks = format!("M{} {}H{right}V{}H{0}z", px(*left), px(*top), px(base));
        ticks.extend(x.labelled.iter().map(|&v| format!("M{} {}v5", px(frame.column(v)), px(base))));
        page.write_along(x.labelled.iter().map(|&v| (frame.column(v), x.label(v))), base + 19.0, TICK, 0.0);
        for &v in &y.labelled {
            ticks += &format!("M{} {}h-5", px(*left), px(frame.row(v)));
            page.write(&y.label(v), (left - 8.0, frame.row(v) + 0.36 * TICK), TICK, "end", TEXT);
        }
        page.stroke(ticks, TEXT, 0.9);
        page.write(&self.x_label, ((left + right) / 2.0, base + 40.0), LABEL, "middle", TEXT);
        page.write_upright(&self.y_label, *top, base);
        if !self.series.iter().flat_map(|series| &series.points).any(|&point| frame.place(point).is_some()) {
            page.write("no data", ((left + right) / 2.0, (top + base) / 2.0), LABEL, "middle", PALE);
        }
        let mut under = base + TICK + 2.0 * LABEL + 6.0;
        for remark in x.remark().map(|remark| format!("{}: {remark}", self.x_label)).into_iter().chain(y.remark()) {
            page.write(&remark, (right, under + 0.76 * SMALL), SMALL, "end", PALE);
            under += 1.5 * SMALL;
        }
        under
    }
}

/// Draws a series: its lines, and its symbols, of which some may be open.
fn draw(page: &mut Page, mark: Mark, look: Style, (runs, full, open): (&[Vec<At>], &[At], &[At]), radius: f64) {
    if let Some((width, dashes)) = mark.line {
        for run in runs.iter().filter(|run| !run.is_empty()) {
            let mut run = thin::line(run);
            // A line to where it begins is a dot.
            run.extend((run.len() == 1).then(|| run[0]));
            let line = Polyline::new().set("points", points(&run)).set("stroke", look.hex());
            page.add(line.set("stroke-width", width).set("stroke-dasharray", dashes));
        }
    }
    if let Some(is_open) = mark.symbols {
        page.symbols(look, radius, is_open, full);
        page.symbols(look, radius, true, open);
    }
}

/// The axes of a plot, and where it is on the page.
struct Frame {
    x: Axis,
    y: Axis,
    left: f64,
    top: f64,
}

impl Frame {
    fn column(&self, at: f64) -> f64 {
        self.left + self.x.share(at) * (WIDTH - MARGIN - self.left)
    }

    fn row(&self, at: f64) -> f64 {
        self.top + (1.0 - self.y.share(at)) * PLOT_HEIGHT
    }

    /// Where a point is drawn, if it is, and whether at a floor.
    fn place(&self, (a, b): (f64, f64)) -> Option<(At, bool)> {
        let at = (self.column(self.x.position(a)?), self.row(self.y.position(b)?));
        Some((at, self.x.is_at_floor(a) || self.y.is_at_floor(b)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn chart(x_scale: Scale, y_scale: Scale, series: Vec<Series>) -> Chart {
        Chart { title: "A < B & \"C\"\u{7}".into(), x_label: "γ".into(), x_scale, y_scale, series, ..Chart::default() }
    }

    /// Checks that every tag is closed and that every number is finite.
    fn check(svg: &str) {
        let mut open = Vec::new();
        for tag in svg.split('<').skip(1) {
            let (tag, text) = tag.split_once('>').unwrap();
            assert!(!text.contains('>') && !text.contains(|c: char| c.is_control() && c != '\n'), "{text:?}");
            assert!(!tag.contains("NaN") && !tag.contains("inf"), "{tag}");
            if let Some(closed) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(closed));
            } else if !tag.ends_with('/') {
                open.push(tag.split(' ').next().unwrap());
            }
        }
        assert!(open.is_empty() && svg.starts_with("<svg "));
    }

    /// Where symbols are drawn, full or open.
    fn symbols(svg: &str, kind: &str) -> Vec<(f64, f64)> {
        let lines = svg.lines().filter(|line| line.contains("marker-mid") && line.contains(kind));
        let points = lines.filter_map(|line| line.split("points=\"").nth(1)?.split('"').next());
        let number = |text: &str| text.parse().unwrap();
        let place = |pair: &str| pair.split_once(',').map(|(x, y)| (number(x), number(y))).unwrap();
        points.flat_map(|points| points.split(' ').map(place)).collect()
    }

    /// Any number, and often those that are hard to draw, alone or side by side.
    fn numbers() -> impl Strategy<Value = f64> {
        let hard = [0.0, -0.0, 1.0, 1.0 + f64::EPSILON, 5e-324, 1e300, -1e300, 1e308, -1e308, f64::INFINITY, f64::NAN];
        prop_oneof![1 => prop::num::f64::ANY, 3 => prop::sample::select(hard.to_vec())]
    }

    proptest! {
        #[test]
        fn any_data_are_drawn(
            points in prop_oneof![
                prop::collection::vec((numbers(), numbers()), 0..4),
                prop::collection::vec((numbers(), numbers()), 0..40),
            ],
            logs in any::<(bool, bool)>(),
            label in ".{0,20}",
        ) {
            let scale = |log| if log { Scale::Log } else { Scale::Linear };
            let series = vec![
                Series::new("", Mark::DASHED, points.clone()),
                Series::new(label, Mark::LINE_AND_POINTS, points),
            ];
            let chart = chart(scale(logs.0), scale(logs.1), series);
            let svg = chart.to_svg();
            check(&svg);
            prop_assert_eq!(svg, chart.to_svg());
        }
    }

    #[test]
    fn a_chart_without_data_says_so() {
        let svg = chart(Scale::Linear, Scale::Linear, Vec::new()).to_svg();
        assert!(svg.contains("no data") && svg.contains("A &lt; B &amp; \"C\" "));
    }

    #[test]
    fn places_follow_values() {
        let points: Vec<(f64, f64)> = (1..20).map(|k| (f64::from(k), f64::from(k * k))).collect();
        for scale in [Scale::Linear, Scale::Log] {
            let svg = chart(scale, scale, vec![Series::new("", Mark::POINTS, points.clone())]).to_svg();
            let places = symbols(&svg, "full");
            assert_eq!(places.len(), points.len());
            assert!(places.windows(2).all(|p| p[0].0 < p[1].0 && p[0].1 > p[1].1));
        }
    }

    #[test]
    fn a_circle_is_round_where_units_are_alike() {
        let turn = |k: i32| std::f64::consts::TAU * f64::from(k) / 60.0;
        for scale in [1.0, 1e-3] {
            let ring: Vec<(f64, f64)> = (0..60).map(|k| (7.0 + scale * turn(k).cos(), scale * turn(k).sin())).collect();
            let series = vec![Series::new("", Mark::POINTS, ring)];
            let picture = Chart { is_isometric: true, ..chart(Scale::Linear, Scale::Linear, series) };
            let places = symbols(&picture.to_svg(), "full");
            let extent = |value: fn(&(f64, f64)) -> f64| {
                let values = || places.iter().map(value);
                values().fold(0.0, f64::max) - values().fold(WIDTH, f64::min)
            };
            let (width, height) = (extent(|p| p.0), extent(|p| p.1));
            assert!((width - height).abs() <= 0.2 && height > 300.0, "{width} {height}");
        }
    }

    #[test]
    fn zeros_are_open_symbols_at_the_floor() {
        let points = vec![(0.0, 3e-16), (1.0, 0.0), (2.0, 6e-2), (3.0, 0.0)];
        let svg = chart(Scale::Linear, Scale::Log, vec![Series::new("", Mark::POINTS, points)]).to_svg();
        let (open, full) = (symbols(&svg, "open"), symbols(&svg, "full"));
        assert_eq!((open.len(), full.len()), (2, 2));
        assert_eq!(open[0].1, open[1].1);
        assert!(full.iter().all(|p| p.1 < open[0].1));
        assert!(svg.contains("zeros drawn at 10⁻¹⁷"));
    }

    #[test]
    fn the_background_is_opaque_white_and_texts_have_their_scripts() {
        let line = Series::new("front", Mark::BAND, vec![(1.0, 1.0), (2.0, 2.0)]);
        let chart = Chart { y_label: "|ΔQ_t|".into(), ..chart(Scale::Linear, Scale::Linear, vec![line]) };
        let svg = chart.to_svg();
        check(&svg);
        let ground = svg.lines().nth(1).unwrap();
        assert_eq!(ground, "<rect fill=\"#fff\" height=\"100%\" width=\"100%\"/>");
        assert!(svg.contains(">t</tspan>") && !svg.contains("Q_t") && svg.matches(">front<").count() == 1, "{svg}");
    }
}
