//! What is drawn in a chart: points that belong together, and what they look like.

use plotters::style::RGBColor;

/// What a series looks like.
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
    /// A broad pale line behind the others, with its label beside it and not in the legend.
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
    /// The colour.
    pub(super) fn rgb(self) -> RGBColor {
        let [red, green, blue] = self.colour;
        RGBColor(red, green, blue)
    }
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
/// points only those that can be told apart are drawn; the extremes in every column of pixels are always among them.
#[derive(Debug, Clone)]
pub struct Series {
    /// Entry in the legend, if not empty.
    pub label: String,
    /// What it looks like.
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
