//! A finished picture: a file of its own, or a part of a page.

use std::path::Path;

use maud::{Markup, PreEscaped, Render};
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Line, Rectangle, SVG, Style, Text};

use crate::{ReportError, theme};

/// A picture of a fixed size, drawn with the classes of [`theme`].
#[derive(Debug, Clone)]
pub struct Drawing {
    content: Group,
    width: f64,
    height: f64,
    label: String,
}

impl Drawing {
    /// A picture of `width` x `height` px; `label` says what it shows to those who cannot see it.
    pub fn new(content: Group, width: f64, height: f64, label: impl Into<String>) -> Self {
        Self {
            content,
            width,
            height,
            // The writer of attributes leaves quotes as they are.
            label: plain(&label.into()).replace('"', "'"),
        }
    }

    /// Size \[px\].
    pub fn size(&self) -> (f64, f64) {
        (self.width, self.height)
    }

    /// The content, to be put into a larger picture.
    pub fn into_content(self) -> Group {
        self.content
    }

    /// The whole text of an SVG file: light colours, on white.
    pub fn to_file_text(&self) -> String {
        let background = Rectangle::new()
            .set("width", "100%")
            .set("height", "100%")
            .set("class", "paper");
        let root = self
            .root()
            .set("width", self.width)
            .set("height", self.height)
            .add(Style::new(theme::standalone_css()))
            .add(background)
            .add(self.content.clone());
        format!("{root}\n")
    }

    /// Writes an SVG file.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn save(&self, file: &Path) -> Result<(), ReportError> {
        let text = self.to_file_text();
        std::fs::write(file, text).map_err(ReportError::at("write the picture", file))
    }

    fn root(&self) -> SVG {
        SVG::new()
            .set("viewBox", (0, 0, self.width, self.height))
            .set("class", "picture")
            .set("role", "img")
            .set("aria-label", self.label.clone())
    }
}

/// Renders as part of a page, whose style it takes.
impl Render for Drawing {
    fn render(&self) -> Markup {
        PreEscaped(self.root().add(self.content.clone()).to_string())
    }
}

/// A coordinate to a tenth of a pixel: what the eye can see, and no more bytes than that.
pub fn px(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

/// A group moved to a place.
pub fn at(x: f64, y: f64, content: Group) -> Group {
    Group::new()
        .set("transform", format!("translate({} {})", px(x), px(y)))
        .add(content)
}

/// A line from one place to another \[px\].
pub(crate) fn line(x1: f64, y1: f64, x2: f64, y2: f64, class: &str) -> Line {
    Line::new()
        .set("x1", px(x1))
        .set("y1", px(y1))
        .set("x2", px(x2))
        .set("y2", px(y2))
        .set("class", class)
}

/// A rectangle by its upper left corner and its size \[px\].
pub(crate) fn rectangle([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Rectangle {
    Rectangle::new()
        .set("x", px(x))
        .set("y", px(y))
        .set("width", px(width))
        .set("height", px(height))
}

/// A circle around a place \[px\].
pub(crate) fn circle(x: f64, y: f64, radius: f64) -> Circle {
    Circle::new()
        .set("cx", px(x))
        .set("cy", px(y))
        .set("r", radius)
}

/// A text on a base line that begins at a place \[px\].
pub(crate) fn words(text: &str, x: f64, y: f64) -> Text {
    Text::new(plain(text)).set("x", px(x)).set("y", px(y))
}

/// A text on a base line of which a place \[px\] is the anchor: `start`, `middle` or `end`.
pub(crate) fn anchored(text: &str, x: f64, y: f64, anchor: &str) -> Text {
    words(text, x, y).set("text-anchor", anchor)
}

/// Goes on with a path through places, broken where there is none.
pub(crate) fn through(data: Data, places: impl IntoIterator<Item = Option<(f64, f64)>>) -> Data {
    let mut is_drawing = false;
    places.into_iter().fold(data, |data, place| {
        let was_drawing = std::mem::replace(&mut is_drawing, place.is_some());
        match place {
            Some(place) if was_drawing => data.line_to(place),
            Some(place) => data.move_to(place),
            None => data,
        }
    })
}

/// A group linked to elements of other pictures: all that have the same `data-path` light up together.
pub(crate) fn linked(group: Group, link: Option<&str>) -> Group {
    match link {
        Some(link) => group.set("data-path", link),
        None => group,
    }
}

/// Text without the control characters that no XML may hold.
pub fn plain(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect()
}

/// Width of a text of 13 px, estimated generously \[px\]: nothing here knows the reader's font.
pub fn text_width(text: &str) -> f64 {
    7.2 * text.chars().count() as f64
}
