//! A series of a chart: points that belong together, and their look.

/// The colours of Okabe and Ito, for series that are not methods; without yellow, which is too faint on white.
const PALETTE: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [0, 0, 0]];
const NEUTRAL: Look = Look { colour: [128, 128, 128], shape: Shape::Circle };
const BAND: Look = Look { colour: [222, 222, 222], shape: Shape::Circle };

/// The look of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A solid line.
    Line,
    /// A dashed line, as for a fit.
    Dashed,
    /// A thin dotted line, as for a reference.
    Dotted,
    /// Symbols. Colour and shape belong together.
    Points,
    /// Symbols on a solid line.
    LineAndPoints,
    /// Open symbols.
    OpenPoints,
    /// Open symbols on a dashed line, as for a method to compare with.
    DashedAndOpenPoints,
    /// A broad pale line behind the others.
    Band,
}

/// The colour of a series, and the shape of its symbols.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Ink {
    /// The next one of the palette.
    #[default]
    Next,
    /// The one of the previous series, as for a fit that follows its data.
    Previous,
    /// Grey, as for a reference. It does not advance the palette.
    Neutral,
    /// A given one. It does not advance the palette.
    Fixed(Look),
}

/// The colour and the shape that something has in every picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// The shape of its symbols.
    pub shape: Shape,
}

impl Look {
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
}

impl Shape {
    /// All of them.
    pub const ALL: [Self; 8] =
        [Self::Circle, Self::Square, Self::Triangle, Self::Diamond, Self::Nabla, Self::Star, Self::Cross, Self::Plus];
}

/// Points that belong together.
///
/// A point with a coordinate that is not finite, or beyond ±10³⁰⁰, is left out and interrupts a line. Of thousands of
/// points only those that can be told apart are drawn; the extremes are always among them.
#[derive(Debug, Clone)]
pub struct Series {
    /// Entry in the legend, if not empty.
    pub label: String,
    /// Its look.
    pub mark: Mark,
    /// Its colour.
    pub ink: Ink,
    /// Abscissae and ordinates, in the order in which a line joins them.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series in the next colour.
    pub fn new(label: impl Into<String>, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), mark, ink: Ink::Next, points }
    }

    /// The same series in another colour.
    #[must_use]
    pub fn with_ink(self, ink: Ink) -> Self {
        Self { ink, ..self }
    }
}

/// The looks of the series of a chart.
pub(super) fn looks(series: &[Series]) -> Vec<Look> {
    let mut used = 0;
    let mut last = None;
    let look = |series: &Series| {
        let look = match (series.ink, last) {
            _ if series.mark == Mark::Band => BAND,
            (Ink::Neutral, _) => NEUTRAL,
            (Ink::Fixed(look), _) | (Ink::Previous, Some(look)) => look,
            _ => {
                used += 1;
                Look { colour: PALETTE[(used - 1) % PALETTE.len()], shape: Shape::ALL[(used - 1) % 4] }
            }
        };
        last = Some(look);
        look
    };
    series.iter().map(look).collect()
}

impl Mark {
    /// The width and the dashes of its line, if it has one.
    pub(super) fn line(self) -> Option<(f64, &'static str)> {
        match self {
            Self::Points | Self::OpenPoints => None,
            Self::Line | Self::LineAndPoints => Some((1.8, "none")),
            Self::Dashed => Some((1.8, "6 7")),
            Self::Dotted => Some((1.3, "1 4.5")),
            Self::DashedAndOpenPoints => Some((1.2, "4 4")),
            Self::Band => Some((11.0, "none")),
        }
    }

    /// Returns true if its symbols are open, if it has some.
    pub(super) fn symbols(self) -> Option<bool> {
        match self {
            Self::Line | Self::Dashed | Self::Dotted | Self::Band => None,
            Self::Points | Self::LineAndPoints => Some(false),
            Self::OpenPoints | Self::DashedAndOpenPoints => Some(true),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_shares_the_colour_of_its_data() {
        let inks = [Ink::Previous, Ink::Next, Ink::Previous, Ink::Neutral, Ink::Next];
        let series = inks.map(|ink| Series::new("", Mark::Line, Vec::new()).with_ink(ink));
        let colours: Vec<[u8; 3]> = looks(&series).iter().map(|look| look.colour).collect();
        assert_eq!(colours, [PALETTE[0], PALETTE[1], PALETTE[1], NEUTRAL.colour, PALETTE[2]]);
    }
}
