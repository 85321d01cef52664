//! A series of a chart: points that belong together, and their look.

/// The colours of Okabe and Ito, for series that are not methods; without yellow, which is too faint on white.
const PALETTE: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [0, 0, 0]];

/// The colour of the series with this number.
pub(crate) fn colour(number: usize) -> [u8; 3] {
    PALETTE[number % PALETTE.len()]
}

/// How the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// The width and the dashes of its line, if it has one.
    pub(super) line: Option<(f64, &'static str)>,
    /// True if its symbols are open, if it has some.
    pub(super) symbols: Option<bool>,
}

impl Mark {
    /// A solid line.
    pub const LINE: Self = Self { line: Some((1.8, "none")), symbols: None };
    /// A dashed line, as for a fit.
    pub const DASHED: Self = Self { line: Some((1.8, "6 7")), symbols: None };
    /// A thin dotted line, as for a reference.
    pub const DOTTED: Self = Self { line: Some((1.3, "1 4.5")), symbols: None };
    /// A hairline, as for the error of a point.
    pub const HAIRLINE: Self = Self { line: Some((0.9, "none")), symbols: None };
    /// A broad pale line behind the others.
    pub const BAND: Self = Self { line: Some((11.0, "none")), symbols: None };
    /// Symbols. Colour and shape belong together.
    pub const POINTS: Self = Self { line: None, symbols: Some(false) };
    /// Symbols on a solid line.
    pub const LINE_AND_POINTS: Self = Self { symbols: Some(false), ..Self::LINE };
    /// Open symbols.
    pub const OPEN_POINTS: Self = Self { line: None, symbols: Some(true) };
    /// Open symbols on a dashed line, as for a method to compare with.
    pub const DASHED_AND_OPEN_POINTS: Self = Self { line: Some((1.2, "4 4")), symbols: Some(true) };
}

/// The colour and the shape that something has in every picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// The shape of its symbols.
    pub shape: Shape,
}

impl Style {
    /// Grey, as for a reference.
    pub const NEUTRAL: Self = Self { colour: [128, 128, 128], shape: Shape::Circle };
    /// Pale grey, as for a band behind others.
    pub const PALE: Self = Self { colour: [222, 222, 222], shape: Shape::Circle };

    /// The colour as an attribute.
    pub(super) fn hex(self) -> String {
        hex(self.colour)
    }
}

/// A colour as an attribute.
pub(super) fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The shape of a symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ▼
    Nabla,
    /// ★
    Star,
    /// ×
    Cross,
    /// +
    Plus,
    /// ⬟
    Pentagon,
    /// ∗
    Asterisk,
}

impl Shape {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Circle,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Nabla,
        Self::Star,
        Self::Cross,
        Self::Plus,
        Self::Pentagon,
        Self::Asterisk,
    ];
}

/// Points that belong together.
///
/// A point with a coordinate that is not finite, or beyond ±10³⁰⁰, is left out and interrupts a line. Of thousands of
/// points only those that can be told apart are drawn; the extremes are always among them.
#[derive(Debug, Clone)]
pub struct Series {
    /// Entry in the legend, if not empty.
    pub label: String,
    /// How its points are drawn.
    pub mark: Mark,
    /// Its colour and the shape of its symbols; those of a series without are the next ones of a palette.
    pub look: Option<Style>,
    /// Abscissae and ordinates, in the order in which a line joins them.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series in the next colour of the palette.
    pub fn new(label: impl Into<String>, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), mark, look: None, points }
    }

    /// The same series with a look of its own.
    #[must_use]
    pub fn with_look(self, look: Style) -> Self {
        Self { look: Some(look), ..self }
    }
}

/// The looks of the series of a chart.
pub(super) fn looks(series: &[Series]) -> Vec<Style> {
    let mut palette = PALETTE.into_iter().cycle().zip(Shape::ALL.into_iter().take(4).cycle());
    let mut next = || palette.next().map_or(Style::NEUTRAL, |(colour, shape)| Style { colour, shape });
    series.iter().map(|series| series.look.unwrap_or_else(&mut next)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_with_a_look_takes_no_colour_of_the_palette() {
        let series = || Series::new("", Mark::LINE, Vec::new());
        let looks = looks(&[series(), series().with_look(Style::NEUTRAL), series()]);
        let colours: Vec<[u8; 3]> = looks.iter().map(|look| look.colour).collect();
        assert_eq!(colours, [PALETTE[0], Style::NEUTRAL.colour, PALETTE[1]]);
    }
}
