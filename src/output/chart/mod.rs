//! Curves and points on linear or logarithmic axes, as SVG.

mod axis;
mod canvas;
mod isometric;
mod legend;
mod map;
mod series;
mod trace;
mod typeset;

pub use map::{Kind, Map, Panel, Sign};
pub use series::{Ink, Look, Mark, Series, Shape};

use plotters::coord::CoordTranslate;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use self::axis::{Axis, is_drawable};
use self::canvas::{Drawn, LABEL, MARGIN, PALE, PLOT_HEIGHT, PX, Pixel, Plane, SMALL, TEXT, TICK, WIDTH, units};
use self::isometric::isometric;
use self::legend::Legend;
use self::trace::{Pen, Trace, pens};

/// How the values of an axis are laid out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly, with 4 % of room at either end.
    #[default]
    Linear,
    /// By their decimal logarithm, over whole decades.
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
    /// Whether a unit has the same length along both axes, which are linear.
    pub is_isometric: bool,
    /// The series that are drawn.
    pub series: Vec<Series>,
}

impl Chart {
    /// The picture as an SVG document. It depends on the chart alone.
    pub fn to_svg(&self) -> String {
        let mut svg = String::new();
        let height = self.draw(&mut svg).expect("writing to a string does not fail");
        canvas::finish(&svg, height)
    }

    /// Draws into `svg` and returns the height in drawing units.
    fn draw(&self, svg: &mut String) -> Drawn<i32> {
        let points = self.series.iter().flat_map(|s| &s.points).copied();
        let (xs, ys): (Vec<f64>, Vec<f64>) = points.filter(|p| is_drawable(p.0) && is_drawable(p.1)).unzip();
        let (mut x, mut y) = (Axis::new(self.x_scale, &xs), Axis::new(self.y_scale, &ys));
        let x_remark = x.remark().map(|remark| format!("{}: {remark}", self.x_label));
        let remarks: Vec<String> = x_remark.into_iter().chain(y.remark()).collect();
        let line = SMALL * 3 / 2;
        let top = MARGIN + canvas::heading_height(&self.title, &self.subtitle);
        let base = top + PLOT_HEIGHT;
        let under = base + TICK + 2 * LABEL + 6 * PX;
        let (mut left, mut right) = (left_of(&y), WIDTH - MARGIN);
        if self.is_isometric {
            (x, y, left) = isometric((&x, &y), right, left_of);
        }

        // The legend is put where the plot is empty; if there is no such place, beside the plot.
        let plane = |x: &Axis, y: &Axis, left: i32, right: i32| {
            Plane::new(x.range.clone(), y.range.clone(), (left..right, base..top))
        };
        let legend = Legend::new(&self.series);
        let mut height = under + units(remarks.len()) * line + MARGIN / 2;
        let mut traces = self.traces(&x, &y, &plane(&x, &y, left, right));
        let corner = legend.free_corner((left, top), (right, base), &traces).unwrap_or_else(|| {
            right = WIDTH - MARGIN - legend.size.0;
            height = height.max(top + legend.size.1 + MARGIN);
            if self.is_isometric {
                let axes = (Axis::new(self.x_scale, &xs), Axis::new(self.y_scale, &ys));
                (x, y, left) = isometric((&axes.0, &axes.1), right, left_of);
            }
            traces = self.traces(&x, &y, &plane(&x, &y, left, right));
            (right + MARGIN / 2, top)
        });
        let plane = plane(&x, &y, left, right);

        let canvas = SVGBackend::with_string(svg, (WIDTH.unsigned_abs(), height.unsigned_abs())).into_drawing_area();
        canvas.fill(&WHITE)?;
        canvas::draw_axes(&canvas, &x, &y, &plane)?;
        let (middle, room) = ((left + right) / 2, right - left);
        let write = |text: &str, at: Pixel, size: i32, colour: RGBColor, side: HPos| {
            canvas::write(&canvas, text, at, &canvas::font(size, text, room, colour, side))
        };
        canvas::draw_heading(&canvas, &self.title, &self.subtitle)?;
        write(&self.x_label, (middle, base + TICK + 13 * PX), LABEL, TEXT, HPos::Center)?;
        let upright = canvas::font(LABEL, &self.y_label, PLOT_HEIGHT, TEXT, HPos::Center);
        let upright = upright.transform(FontTransform::Rotate270);
        canvas::write(&canvas, &self.y_label, (MARGIN / 2, (top + base) / 2), &upright)?;
        for (k, remark) in remarks.iter().enumerate() {
            write(remark, (right, under + units(k) * line), SMALL, PALE, HPos::Right)?;
        }
        if xs.is_empty() {
            write("no data", (middle, (top + base) / 2), LABEL, PALE, HPos::Center)?;
        }
        traces.iter().try_for_each(|trace| trace.draw(&canvas))?;
        Legend::draw_in_place(&canvas, &self.series, ((left, top), (right, base)), &traces)?;
        legend.draw(&canvas, corner)?;
        canvas.present()?;
        Ok(height)
    }

    /// The series in pixels.
    fn traces(&self, x: &Axis, y: &Axis, plane: &Plane) -> Vec<Trace> {
        let place = |&(a, b): &(f64, f64)| {
            let at = plane.translate(&(x.position(a)?, y.position(b)?));
            Some((at, x.is_at_floor(a) || y.is_at_floor(b)))
        };
        let trace = |(series, pen): (&Series, Pen)| {
            let points: Vec<Option<(Pixel, bool)>> = series.points.iter().map(place).collect();
            let marks = |open: bool| points.iter().flatten().filter(|p| p.1 == open).map(|p| p.0).collect();
            let runs = points.split(Option::is_none).map(|run| run.iter().flatten().map(|p| p.0).collect());
            Trace::new(pen, runs.collect(), marks(false), marks(true))
        };
        self.series.iter().zip(pens(&self.series)).map(trace).collect()
    }
}

/// Where a plot begins, to the right of the labels of this axis.
fn left_of(y: &Axis) -> i32 {
    let ticks = y.labelled.iter().map(|&v| canvas::extent(&y.label(v), TICK)).max().unwrap_or(0);
    MARGIN + LABEL + ticks + 16 * PX
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
        assert!(open.is_empty() && svg.starts_with("<svg width=\"720\""));
    }

    /// The centres of the circles of a colour.
    fn circles(svg: &str, colour: &str) -> Vec<(i32, i32)> {
        let number = |tag: &str, name: &str| tag.split(&format!("{name}=\"")).nth(1)?.split('"').next()?.parse().ok();
        let tags = svg.split('<').filter(|tag| tag.starts_with("circle") && tag.contains(colour));
        tags.map(|tag| (number(tag, " cx").unwrap(), number(tag, " cy").unwrap())).collect()
    }

    #[test]
    fn degenerate_data_are_drawn() {
        let cases: [&[(f64, f64)]; 9] = [
            &[],
            &[(0.0, 0.0)],
            &[(1.0, 2.0)],
            &[(1.0, 2.0), (1.0, 2.0)],
            &[(f64::NAN, 1.0), (1.0, f64::INFINITY)],
            &[(-1e308, 1e308), (1e308, -1e308)],
            &[(-1e300, 1e300), (1e300, -1e300)],
            &[(5e-324, 5e-324), (1e300, -0.0)],
            &[(1.0, 1.0), (1.0 + f64::EPSILON, 1.0 - f64::EPSILON)],
        ];
        for points in cases {
            for (x, y) in [(Scale::Linear, Scale::Log), (Scale::Log, Scale::Linear), (Scale::Log, Scale::Log)] {
                let series = vec![
                    Series::new("", Mark::Dashed, points.to_vec()),
                    Series::new("b", Mark::LineAndPoints, points.to_vec()),
                ];
                check(&chart(x, y, series).to_svg());
            }
        }
        let svg = chart(Scale::Linear, Scale::Linear, Vec::new()).to_svg();
        assert!(svg.contains("no data") && svg.contains("A &lt; B &amp; &quot;C&quot; "));
    }

    proptest! {
        #[test]
        fn any_data_are_drawn(
            points in prop::collection::vec((prop::num::f64::ANY, prop::num::f64::ANY), 0..40),
            logs in any::<(bool, bool)>(),
            label in ".{0,20}",
        ) {
            let scale = |log| if log { Scale::Log } else { Scale::Linear };
            let chart = chart(scale(logs.0), scale(logs.1), vec![Series::new(label, Mark::LineAndPoints, points)]);
            let svg = chart.to_svg();
            check(&svg);
            prop_assert_eq!(svg, chart.to_svg());
        }
    }

    #[test]
    fn places_follow_values() {
        let points: Vec<(f64, f64)> = (1..20).map(|k| (f64::from(k), f64::from(k * k))).collect();
        for scale in [Scale::Linear, Scale::Log] {
            let svg = chart(scale, scale, vec![Series::new("", Mark::Points, points.clone())]).to_svg();
            let places = circles(&svg, "#0072B2");
            assert_eq!(places.len(), points.len());
            assert!(places.windows(2).all(|p| p[0].0 < p[1].0 && p[0].1 > p[1].1));
        }
    }

    #[test]
    fn a_circle_is_round_where_units_are_alike() {
        let turn = |k: i32| std::f64::consts::TAU * f64::from(k) / 60.0;
        for (scale, label) in
            [(1.0, ""), (1e-3, "a legend that has no room in the plot, because the circle fills it all")]
        {
            let ring: Vec<(f64, f64)> = (0..60).map(|k| (7.0 + scale * turn(k).cos(), scale * turn(k).sin())).collect();
            let series = vec![Series::new(label, Mark::Points, ring)];
            let picture = Chart { is_isometric: true, ..chart(Scale::Linear, Scale::Linear, series) };
            let places = circles(&picture.to_svg(), "#0072B2");
            let extent = |value: fn(&(i32, i32)) -> i32| {
                let values = || places.iter().take(60).map(value);
                values().max().unwrap() - values().min().unwrap()
            };
            let (width, height) = (extent(|p| p.0), extent(|p| p.1));
            assert!((width - height).abs() <= 2 && height > 2000, "{width} {height}");
        }
    }

    #[test]
    fn zeros_are_open_symbols_at_the_floor() {
        let points = vec![(0.0, 3e-16), (1.0, 0.0), (2.0, 6e-2), (3.0, 0.0)];
        let svg = chart(Scale::Linear, Scale::Log, vec![Series::new("", Mark::Points, points)]).to_svg();
        let (open, filled) = (circles(&svg, "stroke=\"#0072B2\""), circles(&svg, "fill=\"#0072B2\""));
        assert_eq!((open.len(), filled.len()), (2, 2));
        assert_eq!(open[0].1, open[1].1);
        assert!(filled.iter().all(|p| p.1 < open[0].1));
        assert!(svg.contains("zeros drawn at 10⁻¹⁷"));
    }

    #[test]
    fn a_legend_without_room_is_beside_the_plot() {
        let dense = |n: i32| (0..n).map(|k| (f64::from(k), f64::from(k * 7 % 31))).collect();
        let right = |n| {
            let svg = chart(Scale::Linear, Scale::Linear, vec![Series::new("label", Mark::Points, dense(n))]).to_svg();
            circles(&svg, "#0072B2").iter().take(usize::try_from(n).unwrap()).map(|p| p.0).max().unwrap()
        };
        assert!(right(1000) < right(3) - 500);
    }

    #[test]
    fn the_background_is_opaque_white_and_texts_have_their_scripts() {
        let line = Series::new("front", Mark::Band, vec![(1.0, 1.0), (2.0, 2.0)]);
        let chart = Chart {
            title: "γ_f".into(),
            subtitle: "of my_case".into(),
            y_label: "|ΔQ_t|".into(),
            ..chart(Scale::Linear, Scale::Linear, vec![line])
        };
        let svg = chart.to_svg();
        check(&svg);
        let first = svg.lines().nth(1).unwrap();
        let size = svg.split("viewBox=\"0 0 ").nth(1).unwrap().split('"').next().unwrap().replace(' ', "\" height=\"");
        let full = format!("<rect x=\"0\" y=\"0\" width=\"{size}\" opacity=\"1\" fill=\"#FFFFFF\" stroke=\"none\"/>");
        assert_eq!(first, full);
        assert!(svg.contains(">f</tspan>") && svg.contains(">t</tspan>") && svg.contains("of my_case"), "{svg}");
        assert!(!svg.contains("γ_f") && !svg.contains("Q_t"));
        // A band is labelled once, in the plot: there is no legend.
        assert_eq!((svg.matches("front").count(), svg.matches("<rect").count()), (1, 1), "{svg}");
    }

    #[test]
    fn many_points_make_a_small_picture() {
        let wave: Vec<_> = (0..100_000)
            .map(|k| (f64::from(k), (f64::from(k) * 1e-3).sin() + if k == 777 { 9.0 } else { 0.0 }))
            .collect();
        let sparse =
            |mark| chart(Scale::Linear, Scale::Linear, vec![Series::new("", mark, wave.clone())]).to_svg().len();
        assert!(sparse(Mark::Line) < 60_000 && sparse(Mark::Points) < 600_000);
    }
}
