//! Series drawn over the axes.

use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Path, Rectangle, Title};

use super::frame::Frame;
use super::labels::Labels;
use crate::drawing::{anchored, circle, line, linked, plain, rectangle, through};
use crate::theme::Colour;

/// A named set of values in one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Shown in the key above the plot; empty for none.
    pub name: String,
    /// Its colour.
    pub colour: Colour,
    /// Its form.
    pub mark: Mark,
    /// Value of the attribute `data-path` of all its elements, by which a page links them to
    /// elements of other pictures.
    pub link: Option<String>,
}

/// Forms of a series. Values are (x, y) in the units of the axes; those that are not finite, or not
/// positive on a logarithmic axis, are left out.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line through the points, broken where one is left out.
    Line {
        /// Points in the order of drawing.
        points: Vec<[f64; 2]>,
        /// Dashed instead of solid.
        dashed: bool,
    },
    /// A line that keeps the height of each point until the next one: a distribution.
    Steps {
        /// Points by ascending x.
        points: Vec<[f64; 2]>,
    },
    /// Dots, each with a text beside it.
    Spots(Vec<Spot>),
    /// Bars standing on the axis side by side: a histogram.
    Bins {
        /// Ends of the bins, one more than there are heights.
        edges: Vec<f64>,
        /// Heights.
        heights: Vec<f64>,
    },
    /// Vertical lines from the bottom up to each point; those beyond the ends of the x axis, or below
    /// the bottom, are left out.
    Stems {
        /// Tips.
        points: Vec<[f64; 2]>,
        /// Dashed instead of solid.
        dashed: bool,
    },
    /// Numbers in circles just above the points, moved up until none covers another.
    Badges {
        /// The points they belong to.
        points: Vec<[f64; 2]>,
        /// The text in all of them.
        text: String,
        /// A ring instead of a disc.
        hollow: bool,
    },
    /// A vertical line over the whole height, with its name along it.
    Rule {
        /// Its place.
        x: f64,
    },
}

/// One dot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spot {
    /// Its place.
    pub at: [f64; 2],
    /// Text beside it; empty for none.
    pub label: String,
    /// Interval of y, drawn as a vertical bar.
    pub interval: Option<[f64; 2]>,
    /// A ring instead of a disc.
    pub hollow: bool,
}

impl Mark {
    /// Points that the axes must show.
    pub(super) fn extent(&self) -> Vec<[f64; 2]> {
        match self {
            Self::Line { points, .. }
            | Self::Steps { points }
            | Self::Stems { points, .. }
            | Self::Badges { points, .. } => points.clone(),
            Self::Spots(spots) => {
                let ends = |s: &Spot| {
                    let interval = s.interval.unwrap_or([s.at[1]; 2]);
                    [s.at, [s.at[0], interval[0]], [s.at[0], interval[1]]]
                };
                spots.iter().flat_map(ends).collect()
            }
            Self::Bins { edges, heights } => {
                let floor = edges.iter().map(|&x| [x, 0.0]);
                let tops = edges.iter().zip(heights).map(|(&x, &y)| [x, y]);
                floor.chain(tops).collect()
            }
            Self::Rule { x } => vec![[*x, f64::NAN]],
        }
    }
}

impl Series {
    /// A series that is linked to nothing.
    pub fn new(name: impl Into<String>, colour: Colour, mark: Mark) -> Self {
        Self {
            name: name.into(),
            colour,
            mark,
            link: None,
        }
    }

    /// A line through points: solid in ink, the colour of the main thing, and dashed in others.
    pub(crate) fn curve_in(name: impl Into<String>, colour: Colour, points: Vec<[f64; 2]>) -> Self {
        let dashed = colour != Colour::Ink;
        Self::new(name, colour, Mark::Line { points, dashed })
    }

    /// A vertical line up to a point.
    pub(crate) fn stem(colour: Colour, tip: [f64; 2], dashed: bool) -> Self {
        let points = vec![tip];
        Self::new("", colour, Mark::Stems { points, dashed })
    }

    /// Links the series to elements of other pictures.
    pub(crate) fn linked(self, link: Option<String>) -> Self {
        Self { link, ..self }
    }

    /// Draws the series; `shown` tells what the axes can show, `labels` keeps texts apart.
    pub(super) fn draw(
        &self,
        frame: &Frame,
        shown: &dyn Fn([f64; 2]) -> bool,
        labels: &mut Labels,
    ) -> Group {
        let mut group = linked(Group::new(), self.link.as_deref());
        match &self.mark {
            Mark::Line { points, dashed } => {
                let places = points.iter().map(|&p| shown(p).then(|| frame.place(p)));
                group.add(self.curve(places, *dashed))
            }
            Mark::Steps { points } => {
                let mut corners = Vec::new();
                let mut level = None;
                for &p in points.iter().filter(|&&p| shown(p)) {
                    let (x, y) = frame.place(p);
                    corners.extend(level.map(|level| Some((x, level))));
                    corners.push(Some((x, y)));
                    level = Some(y);
                }
                group.add(self.curve(corners, false))
            }
            Mark::Spots(spots) => {
                let seen = |s: &&Spot| {
                    shown(s.at) && frame.x.contains(s.at[0]) && frame.y.contains(s.at[1])
                };
                for spot in spots.iter().filter(seen) {
                    group = self.spot(group, spot, frame, labels);
                }
                group
            }
            Mark::Bins { edges, heights } => {
                for (ends, &height) in edges.windows(2).zip(heights) {
                    if height.is_finite() && height != 0.0 {
                        group = group.add(self.bin([ends[0], ends[1]], height, frame));
                    }
                }
                group
            }
            Mark::Stems { points, dashed } => {
                let seen = |p: &&[f64; 2]| {
                    shown(**p) && frame.x.contains(p[0]) && frame.y.part(p[1]) > 0.0
                };
                for &p in points.iter().filter(seen) {
                    let (x, y) = frame.place(p);
                    group = group.add(line(x, frame.bottom(), x, y, &self.line_class(*dashed)));
                }
                group
            }
            Mark::Badges {
                points,
                text,
                hollow,
            } => {
                for &p in points.iter().filter(|&&p| shown(p)) {
                    let (x, y) = frame.place(p);
                    let up = labels.above(x, y);
                    if y - up > 20.0 {
                        group = group.add(line(x, up + 9.0, x, y - 2.0, "line stroke-soft"));
                    }
                    group = group.add(badge(x, up, text, self.colour, *hollow));
                }
                group
            }
            Mark::Rule { x } => {
                if !shown([*x, 1.0]) {
                    return group;
                }
                let at = frame.across(*x);
                let (side, anchor) = match frame.x.part(*x) > 0.5 {
                    true => (-5.0, "end"),
                    false => (5.0, "start"),
                };
                let name = anchored(&self.name, at + side, frame.top + 14.0, anchor);
                let class = self.line_class(true);
                group
                    .add(line(at, frame.top, at, frame.bottom(), &class))
                    .add(name.set("class", "small halo"))
            }
        }
    }

    /// The class of its lines.
    pub(super) fn line_class(&self, dashed: bool) -> String {
        let dashes = if dashed { " dashed" } else { "" };
        format!("line {}{dashes}", self.colour.stroke())
    }

    /// A line through places, broken where there is none.
    fn curve(&self, places: impl IntoIterator<Item = Option<(f64, f64)>>, dashed: bool) -> Path {
        Path::new()
            .set("d", through(Data::new(), places))
            .set("class", self.line_class(dashed))
    }

    fn spot(&self, mut group: Group, spot: &Spot, frame: &Frame, labels: &mut Labels) -> Group {
        let (x, y) = frame.place(spot.at);
        if let Some([low, high]) = spot.interval {
            let class = self.line_class(false);
            group = group.add(line(x, frame.down(low), x, frame.down(high), &class));
        }
        let dot = filled(circle(x, y, 4.5), self.colour, spot.hollow);
        if spot.label.is_empty() {
            return group.add(dot);
        }
        group = group.add(dot.add(Title::new(plain(&spot.label))));
        let (left, base, anchor) = labels.beside(x, y, &spot.label);
        if (base - 4.5 - y).abs() > 20.0 {
            group = group.add(line(x, y, left, base - 4.5, "frame"));
        }
        group.add(anchored(&spot.label, left, base, anchor).set("class", "halo"))
    }

    fn bin(&self, [from, to]: [f64; 2], height: f64, frame: &Frame) -> Rectangle {
        let (left, right) = (frame.across(from), frame.across(to));
        let (base, top) = (frame.down(frame.y.base()), frame.down(height));
        // A gap of one pixel, if there is room for it.
        let gap = if right - left > 4.0 { 1.0 } else { 0.0 };
        let size = [(right - left - gap).max(0.2), (base - top).abs()];
        rectangle([left + gap / 2.0, top.min(base)], size).set("class", self.colour.fill())
    }
}

/// A number in a circle.
pub(crate) fn badge(x: f64, y: f64, text: &str, colour: Colour, hollow: bool) -> Group {
    let disc = filled(circle(x, y, 8.5), colour, hollow);
    let number = anchored(text, x, y + 4.0, "middle").set("class", "number");
    let group = Group::new().add(disc).add(number);
    match hollow {
        true => group.set("class", "hollow"),
        false => group,
    }
}

/// A circle as a disc, or as a ring.
fn filled(circle: Circle, colour: Colour, hollow: bool) -> Circle {
    match hollow {
        true => circle
            .set("class", format!("paper {}", colour.stroke()))
            .set("stroke-width", 2),
        false => circle.set("class", colour.fill()),
    }
}
