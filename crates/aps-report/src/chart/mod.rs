//! Charts as small SVG pictures: lines, scatter, histograms, distributions.
//!
//! A [`Chart`] is two [`Axis`] and any number of [`Series`]. It gives a [`Drawing`], which is saved as a file or put into
//! a page, where it follows the reader's theme.
//!
//! ```
//! use aps_report::chart::{Axis, Chart, Spot};
//!
//! let models = [("fast", 0.1, 0.30), ("good", 2.0, 0.10), ("neither", 5.0, 0.35)];
//! let spots = models.map(|(name, ms, error)| Spot {
//!     at: [ms, error],
//!     label: name.into(),
//!     interval: Some([error - 0.02, error + 0.02]),
//!     hollow: false,
//! });
//! let chart = Chart::new(Axis::log("time a link [ms]"), Axis::linear("error"))
//!     .line("front", [[0.1, 0.30], [2.0, 0.10]])
//!     .spots("", spots);
//! let file = chart.draw().to_file_text();
//! assert!(file.starts_with("<svg") && file.contains("neither"));
//! ```
//!
//! # Why not a plotting crate
//!
//! `plotters` rounds every coordinate of its SVG to whole pixels, which shows as steps in spectra,
//! and knows neither classes nor titles, so that its pictures follow no theme and link to nothing.
//! Little is needed here: ticks, a frame, seven forms of series.

mod axis;
mod frame;
mod key;
mod labels;
mod series;
mod values;

use svg::node::element::Group;

pub use axis::{Axis, Scale};
pub use series::{Mark, Series, Spot};
pub use values::{Histogram, pareto_front};

pub(crate) use labels::Labels;
pub(crate) use series::badge;

use crate::drawing::{Drawing, anchored};
use crate::theme::Colour;
use frame::Frame;

/// A chart with two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title above the plot; empty for none, as in a figure with a caption.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Drawn in this order, later ones on top.
    pub series: Vec<Series>,
    /// Width and height of the picture \[px\]. The default, 480 x 320, can be read on a phone.
    pub size: (f64, f64),
}

impl Chart {
    /// A chart without data.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            title: String::new(),
            x,
            y,
            series: Vec::new(),
            size: (480.0, 320.0),
        }
    }

    /// Sets the title.
    #[must_use]
    pub fn titled(self, title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..self
        }
    }

    /// Sets width and height \[px\].
    #[must_use]
    pub fn sized(self, width: f64, height: f64) -> Self {
        Self {
            size: (width, height),
            ..self
        }
    }

    /// Adds any series.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds a mark in the next free series colour.
    #[must_use]
    pub fn mark(self, name: impl Into<String>, mark: Mark) -> Self {
        let is_coloured = |s: &&Series| matches!(s.colour, Colour::Series(_));
        let colour = Colour::Series(self.series.iter().filter(is_coloured).count());
        self.with(Series::new(name, colour, mark))
    }

    /// Adds a line in the next free colour; after eight the colours repeat, dashed.
    #[must_use]
    pub fn line(self, name: impl Into<String>, points: impl Into<Vec<[f64; 2]>>) -> Self {
        let dashed = self.series.len() >= crate::theme::SERIES_COLOURS;
        let points = points.into();
        self.mark(name, Mark::Line { points, dashed })
    }

    /// Adds dots with labels in the next free colour.
    #[must_use]
    pub fn spots(self, name: impl Into<String>, spots: impl Into<Vec<Spot>>) -> Self {
        self.mark(name, Mark::Spots(spots.into()))
    }

    /// Adds a histogram, in percent of all values counted.
    #[must_use]
    pub fn histogram(self, name: impl Into<String>, histogram: &Histogram) -> Self {
        let mark = Mark::Bins {
            edges: histogram.edges.clone(),
            heights: histogram.percent(),
        };
        self.mark(name, mark)
    }

    /// Adds a vertical line with a name.
    #[must_use]
    pub fn rule(self, name: impl Into<String>, x: f64) -> Self {
        self.with(Series::new(name, Colour::Ink, Mark::Rule { x }))
    }

    /// Draws the chart.
    pub fn draw(&self) -> Drawing {
        let (width, height) = self.size;
        let extents = self.series.iter().flat_map(|s| s.mark.extent());
        let points: Vec<[f64; 2]> = extents.filter(|p| self.x.shows(p[0])).collect();
        let x = self.x.fit(points.iter().map(|p| p[0]), 7);
        let y = self.y.fit(points.iter().map(|p| p[1]), 5);
        let key = key::rows(&self.series, width - 16.0);
        let title_height = if self.title.is_empty() { 0.0 } else { 24.0 };
        let left = 30.0 + frame::tick_width(&y).max(16.0);
        let top = 10.0 + title_height + 20.0 * key.len() as f64;
        let frame = Frame {
            x,
            y,
            left,
            top,
            width: width - left - 19.0,
            height: height - top - 48.0,
        };
        let mut group = Group::new();
        if !self.title.is_empty() {
            let title = anchored(&self.title, left, 20.0, "start");
            group = group.add(title.set("class", "title"));
        }
        for (i, row) in key.iter().enumerate() {
            let y = 8.0 + title_height + 20.0 * i as f64;
            group = group.add(key::draw(row, left, y));
        }
        group = group.add(frame.draw(&self.x, &self.y));
        // Texts may stand above the plot up to the key.
        let ceiling = if key.is_empty() { 2.0 } else { top - 8.0 };
        let mut labels = Labels::inside(left, ceiling, width, frame.bottom());
        for series in &self.series {
            match &series.mark {
                Mark::Spots(spots) => {
                    for spot in spots {
                        let (x, y) = frame.place(spot.at);
                        labels.dot((x, y));
                        for end in spot.interval.into_iter().flatten() {
                            labels.line(x, y, x, frame.down(end));
                        }
                    }
                }
                // Level lines, as from a dot to another; no rectangle is near one that rises.
                Mark::Line { points, .. } => {
                    for pair in points.windows(2) {
                        let [(x, y), (next_x, next_y)] = [0, 1].map(|i| frame.place(pair[i]));
                        if y == next_y {
                            labels.line(x, y, next_x, y);
                        }
                    }
                }
                // Short staircases, as Pareto fronts are; there is no way around a long distribution.
                Mark::Steps { points } if points.len() <= 32 => {
                    for pair in points.windows(2) {
                        let [(x, y), (next_x, next_y)] = [0, 1].map(|i| frame.place(pair[i]));
                        labels.line(x, y, next_x, y);
                        labels.line(next_x, y, next_x, next_y);
                    }
                }
                Mark::Steps { .. }
                | Mark::Bins { .. }
                | Mark::Stems { .. }
                | Mark::Badges { .. }
                | Mark::Rule { .. } => {}
            }
        }
        let shown = |p: [f64; 2]| self.x.shows(p[0]) && self.y.shows(p[1]);
        for series in &self.series {
            group = group.add(series.draw(&frame, &shown, &mut labels));
        }
        let label = match self.title.is_empty() {
            true => format!("{} over {}", self.y.label, self.x.label),
            false => self.title.clone(),
        };
        Drawing::new(group, width, height, label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_outside_cannot_break_the_picture() {
        let nasty = "<b>\"A & B\"</b>\u{0}\u{1b}'";
        let spots = [Spot {
            at: [1.0, 1.0],
            label: nasty.into(),
            ..Spot::default()
        }];
        let chart = Chart::new(Axis::linear(nasty), Axis::log(nasty))
            .titled(nasty)
            .line(nasty, [[0.0, 1.0], [2.0, 3.0]])
            .spots("", spots);
        let text = chart.draw().to_file_text();
        let document = roxmltree::Document::parse(&text).unwrap();
        let mut nodes = document.descendants();
        let seen = nodes.any(|n| n.text() == Some("<b>\"A & B\"</b>'"));
        assert!(seen, "{text}");
    }

    #[test]
    fn nothing_drawn_is_not_a_number() {
        let odd = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300, 1e-300];
        let points: Vec<[f64; 2]> = odd.iter().flat_map(|&x| odd.map(|y| [x, y])).collect();
        let spot = |&at: &[f64; 2]| Spot {
            at,
            label: "x".into(),
            interval: Some(at),
            ..Spot::default()
        };
        let bounded = Axis::linear("").over(0.0, 1.0);
        for axis in [Axis::linear(""), Axis::log(""), bounded] {
            let spots: Vec<Spot> = points.iter().map(spot).collect();
            let points = || points.clone();
            let marks = [
                Mark::Steps { points: points() },
                Mark::Stems {
                    points: points(),
                    dashed: true,
                },
                Mark::Badges {
                    points: points(),
                    text: "1".into(),
                    hollow: true,
                },
                Mark::Bins {
                    edges: odd.to_vec(),
                    heights: odd.to_vec(),
                },
            ];
            let chart = Chart::new(axis.clone(), axis).line("", points());
            let chart = marks.into_iter().fold(chart, |chart, m| chart.mark("", m));
            let chart = chart.rule("", f64::NAN).spots("", spots);
            let text = chart.draw().to_file_text();
            roxmltree::Document::parse(&text).unwrap();
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }

    #[test]
    fn names_keep_off_level_lines_and_intervals() {
        // Each name would stand to the right of its dot, where the line or the bar of the other is.
        let spots = [
            Spot {
                at: [1.0, 0.5],
                label: "first".into(),
                interval: Some([0.1, 0.9]),
                hollow: false,
            },
            Spot {
                at: [0.9, 0.7],
                label: "second".into(),
                ..Spot::default()
            },
        ];
        let (x, y) = (
            Axis::linear("").over(0.0, 3.0),
            Axis::linear("").over(0.0, 1.0),
        );
        let chart = Chart::new(x, y).line("", [[1.0, 0.5], [2.0, 0.5]]);
        let text = chart.spots("", spots).draw().to_file_text();
        let document = roxmltree::Document::parse(&text).unwrap();
        for name in ["first", "second"] {
            let is_it = |n: &roxmltree::Node<'_, '_>| {
                n.has_tag_name("text") && n.text().map(str::trim) == Some(name)
            };
            let found = document.descendants().find(is_it).unwrap();
            assert_eq!(found.attribute("text-anchor"), Some("end"), "{name}");
        }
    }

    #[test]
    fn a_line_breaks_where_a_value_is_missing() {
        let points = [[0.0, 0.0], [1.0, f64::NAN], [2.0, 1.0], [3.0, 2.0]];
        let chart = Chart::new(Axis::linear(""), Axis::linear("")).line("", points);
        let text = chart.draw().to_file_text();
        let document = roxmltree::Document::parse(&text).unwrap();
        let mut nodes = document.descendants();
        let path = nodes.find(|n| n.has_tag_name("path")).unwrap();
        let data = path.attribute("d").unwrap();
        assert_eq!(data.matches('M').count(), 2, "{data}");
    }

    #[test]
    fn bars_of_a_histogram_are_as_high_as_their_share() {
        let histogram = Histogram::counts([1, 1, 1, 2].into_iter());
        let percent = Axis::linear("").over(0.0, 100.0);
        let chart = Chart::new(Axis::linear(""), percent).histogram("", &histogram);
        let text = chart.draw().to_file_text();
        let document = roxmltree::Document::parse(&text).unwrap();
        let heights: Vec<f64> = document
            .descendants()
            .filter(|n| n.attribute("class") == Some("fill-s1"))
            .map(|n| n.attribute("height").unwrap().parse().unwrap())
            .collect();
        assert_eq!(heights.len(), 2);
        assert!((heights[0] / heights[1] - 3.0).abs() < 0.01, "{heights:?}");
    }
}
