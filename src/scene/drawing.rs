//! A drawing as a list of areas, lines and texts, whatever it is written as.

/// A point in pixels, from the upper left.
pub(crate) type Place = [f64; 2];

/// What something is drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Paint {
    /// Text and outlines.
    Ink,
    /// What is said beside.
    Soft,
    /// Thin lines that guide the eye.
    Rule,
    Paper,
    /// Edges of cells, on what has a colour.
    Edge,
    /// Supports.
    Held,
    /// Displacements that are imposed.
    Moved,
    /// Forces.
    Pushed,
    /// Interfaces.
    Joint,
    /// A colour of a map: red, green, blue.
    Color([u8; 3]),
}

impl Paint {
    /// The colour on a light screen.
    pub fn color(self) -> [u8; 3] {
        match self {
            Paint::Ink => [0x1e, 0x1e, 0x1e],
            Paint::Soft => [0x4a, 0x4a, 0x4a],
            Paint::Rule => [0xb0, 0xb0, 0xb0],
            Paint::Paper => [0xff, 0xff, 0xff],
            Paint::Edge => [0x2f, 0x3b, 0x45],
            Paint::Held => [0x00, 0x5f, 0x73],
            Paint::Moved => [0x80, 0x44, 0x00],
            Paint::Pushed => [0xa1, 0x1f, 0x18],
            Paint::Joint => [0xa4, 0x00, 0x6d],
            Paint::Color(color) => color,
        }
    }

    /// The colour in the dark; none where it is the same.
    pub fn in_the_dark(self) -> Option<&'static str> {
        match self {
            Paint::Ink => Some("#e6e6e6"),
            Paint::Soft => Some("#b8b8b8"),
            Paint::Rule => Some("#5a5e66"),
            Paint::Paper => Some("#15171a"),
            Paint::Held => Some("#5cc7d6"),
            Paint::Moved => Some("#ffb454"),
            Paint::Pushed => Some("#ff8a80"),
            Paint::Joint => Some("#ff7ac6"),
            Paint::Edge | Paint::Color(_) => None,
        }
    }

    /// The colour as a word; those that change in the dark in capitals, and no others.
    pub fn word(self) -> String {
        let [r, g, b] = self.color();
        match self {
            Paint::Color(_) => format!("#{r:02x}{g:02x}{b:02x}"),
            _ => format!("#{r:02X}{g:02X}{b:02X}"),
        }
    }

    /// All that have a name.
    pub const NAMED: [Paint; 9] = [
        Paint::Ink,
        Paint::Soft,
        Paint::Rule,
        Paint::Paper,
        Paint::Edge,
        Paint::Held,
        Paint::Moved,
        Paint::Pushed,
        Paint::Joint,
    ];
}

/// A line's paint and width in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    pub paint: Paint,
    pub width: f64,
}

impl Stroke {
    pub fn new(paint: Paint, width: f64) -> Self {
        Self { paint, width }
    }
}

/// On which side of its place a text lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Align {
    Left,
    Middle,
}

/// Something drawn; what comes later lies above.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Item {
    Area {
        points: Vec<Place>,
        fill: Paint,
        edge: Option<Stroke>,
        /// Areas of one patch do not cover each other.
        patch: u32,
    },
    Line {
        points: Vec<Place>,
        stroke: Stroke,
    },
    /// The middle of its height is at its place.
    Text {
        text: String,
        at: Place,
        size: f64,
        paint: Paint,
        align: Align,
    },
}

/// Heights of text in pixels.
pub(crate) const TITLE: f64 = 16.0;
pub(crate) const TEXT: f64 = 13.5;

/// A drawing of a size in pixels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Drawing {
    pub width: f64,
    pub height: f64,
    /// What it shows, for who cannot see it.
    pub words: String,
    pub items: Vec<Item>,
}

impl Drawing {
    pub fn new(width: f64) -> Self {
        Self { width, height: 0.0, words: String::new(), items: Vec::new() }
    }

    pub fn line(&mut self, points: Vec<Place>, stroke: Stroke) {
        self.items.push(Item::Line { points, stroke });
    }

    pub fn area(&mut self, points: Vec<Place>, fill: Paint, edge: Option<Stroke>) {
        self.items.push(Item::Area { points, fill, edge, patch: u32::MAX });
    }

    pub fn text(&mut self, text: impl Into<String>, at: Place, align: Align) {
        self.write(text, at, TEXT, Paint::Ink, align);
    }

    /// As [`Drawing::text`], with all that can be chosen.
    pub fn write(
        &mut self,
        text: impl Into<String>,
        at: Place,
        size: f64,
        paint: Paint,
        align: Align,
    ) {
        self.items.push(Item::Text { text: text.into(), at, size, paint, align });
    }
}
