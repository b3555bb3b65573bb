//! Series drawn over the axes.

use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Path, Rectangle, Title};

use super::frame::{Frame, line, words};
use super::labels::Labels;
use crate::drawing::{plain, px};
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
        /// In the order of drawing.
        points: Vec<[f64; 2]>,
        /// Dashed instead of solid.
        dashed: bool,
    },
    /// A line that keeps the height of each point until the next one: a distribution.
    Steps {
        /// By ascending x.
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

    /// Draws the series; `shown` tells what the axes can show, `labels` keeps texts apart.
    pub(super) fn draw(
        &self,
        frame: &Frame,
        shown: &dyn Fn([f64; 2]) -> bool,
        labels: &mut Labels,
    ) -> Group {
        let mut group = Group::new();
        if let Some(link) = &self.link {
            group = group.set("data-path", link.as_str());
        }
        let stroke = |dashed: bool| {
            let dashes = if dashed { " dashed" } else { "" };
            format!("line {}{dashes}", self.colour.stroke())
        };
        match &self.mark {
            Mark::Line { points, dashed } => {
                let data = polyline(points.iter().map(|&p| shown(p).then(|| frame.place(p))));
                group.add(curve(data, &stroke(*dashed)))
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
                group.add(curve(polyline(corners.into_iter()), &stroke(false)))
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
                    if !(height.is_finite() && height != 0.0) {
                        continue;
                    }
                    group = group.add(self.bin([ends[0], ends[1]], height, frame));
                }
                group
            }
            Mark::Stems { points, dashed } => {
                let seen = |p: &&[f64; 2]| {
                    shown(**p) && frame.x.contains(p[0]) && frame.y.part(p[1]) > 0.0
                };
                for &p in points.iter().filter(seen) {
                    let (x, y) = frame.place(p);
                    group = group.add(line(x, frame.bottom(), x, y, &stroke(*dashed)));
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
                group
                    .add(line(at, frame.top, at, frame.bottom(), &stroke(true)))
                    .add(
                        words(&self.name, at + side, frame.top + 14.0, anchor)
                            .set("class", "small halo"),
                    )
            }
        }
    }

    fn spot(&self, group: Group, spot: &Spot, frame: &Frame, labels: &mut Labels) -> Group {
        let (x, y) = frame.place(spot.at);
        let mut group = group;
        if let Some([low, high]) = spot.interval {
            let class = format!("line {}", self.colour.stroke());
            group = group.add(line(x, frame.down(low), x, frame.down(high), &class));
        }
        let mut dot = Circle::new().set("cx", x).set("cy", y).set("r", 4.5);
        dot = filled(dot, self.colour, spot.hollow);
        if !spot.label.is_empty() {
            dot = dot.add(Title::new(plain(&spot.label)));
        }
        group = group.add(dot);
        if !spot.label.is_empty() {
            let dot = (x, y);
            let (x, y, anchor) = labels.beside(x, y, &spot.label);
            if (y - 4.5 - dot.1).abs() > 20.0 {
                group = group.add(line(dot.0, dot.1, x, y - 4.5, "frame"));
            }
            group = group.add(words(&spot.label, x, y, anchor).set("class", "halo"));
        }
        group
    }

    fn bin(&self, [from, to]: [f64; 2], height: f64, frame: &Frame) -> Rectangle {
        let (left, right) = (frame.across(from), frame.across(to));
        let (base, top) = (frame.down(frame.y.base()), frame.down(height));
        // A gap of one pixel, if there is room for it.
        let gap = if right - left > 4.0 { 1.0 } else { 0.0 };
        Rectangle::new()
            .set("x", px(left + gap / 2.0))
            .set("y", px(top.min(base)))
            .set("width", px((right - left - gap).max(0.2)))
            .set("height", px((base - top).abs()))
            .set("class", self.colour.fill())
    }
}

/// A number in a circle.
pub(crate) fn badge(x: f64, y: f64, text: &str, colour: Colour, hollow: bool) -> Group {
    let circle = Circle::new()
        .set("cx", px(x))
        .set("cy", px(y))
        .set("r", 8.5);
    let circle = filled(circle, colour, hollow);
    let number = words(text, x, y + 4.0, "middle").set("class", "number");
    let group = Group::new().add(circle).add(number);
    if hollow {
        group.set("class", "hollow")
    } else {
        group
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

/// A path through places, broken where there is none.
fn polyline(places: impl Iterator<Item = Option<(f64, f64)>>) -> Data {
    let mut data = Data::new();
    let mut is_drawing = false;
    for place in places {
        data = match (place, is_drawing) {
            (Some(place), false) => data.move_to(place),
            (Some(place), true) => data.line_to(place),
            (None, _) => data,
        };
        is_drawing = place.is_some();
    }
    data
}

fn curve(data: Data, class: &str) -> Path {
    Path::new().set("d", data).set("class", class)
}
