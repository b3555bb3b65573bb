//! Horizontal bars with names: scores of models, counts of kinds.

use svg::node::element::{Group, Rectangle};

use super::axis::{Axis, Scale};
use super::frame::{Frame, Margins, line, words};
use crate::drawing::{Drawing, px, text_width};
use crate::theme::Colour;

/// Height of one bar with its gap \[px\].
const ROW: f64 = 24.0;

/// One bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Its name, to the left.
    pub name: String,
    /// Its length; a value that is not finite leaves only the name.
    pub value: f64,
    /// Confidence interval, drawn across its end.
    pub interval: Option<[f64; 2]>,
    /// The value in words, behind the bar; empty for none.
    pub text: String,
    /// Its colour.
    pub colour: Colour,
}

/// A chart of horizontal bars, first on top.
#[derive(Debug, Clone, PartialEq)]
pub struct Bars {
    /// Above the plot; empty for none.
    pub title: String,
    /// The axis of the values. Linear: bars start at 0 if the axis has it.
    pub axis: Axis,
    /// The bars.
    pub bars: Vec<Bar>,
    /// Width of the picture \[px\]; its height follows from the number of bars.
    pub width: f64,
}

impl Bars {
    /// Bars over an axis, 480 px wide.
    pub fn new(axis: Axis, bars: Vec<Bar>) -> Self {
        Self {
            title: String::new(),
            axis,
            bars,
            width: 480.0,
        }
    }

    /// Draws the chart.
    pub fn draw(&self) -> Drawing {
        let ends = |bar: &Bar| {
            let [low, high] = bar.interval.unwrap_or([bar.value; 2]);
            [bar.value, low, high]
        };
        let zero = (self.axis.scale == Scale::Linear).then_some(0.0);
        let values = self.bars.iter().flat_map(ends).chain(zero);
        let widest = |text: fn(&Bar) -> &String| {
            let widths = self.bars.iter().map(|b| text_width(text(b)));
            widths.fold(0.0, f64::max)
        };
        let title_height = if self.title.is_empty() { 0.0 } else { 24.0 };
        let margins = Margins {
            left: (14.0 + widest(|b| &b.name)).min(0.5 * self.width),
            right: 16.0 + widest(|b| &b.text).min(0.3 * self.width),
            top: 8.0 + title_height,
            bottom: 48.0,
        };
        let size = (
            self.width,
            margins.top + margins.bottom + ROW * self.bars.len().max(1) as f64,
        );
        let x = self.axis.fit(values, 5);
        let frame = Frame::new(x.clone(), x, size, margins);
        let mut group = Group::new();
        if !self.title.is_empty() {
            group = group.add(words(&self.title, 8.0, 20.0, "start").set("class", "title"));
        }
        group = group.add(frame.draw_x(&self.axis));
        for (i, bar) in self.bars.iter().enumerate() {
            let top = frame.top + ROW * i as f64;
            group = group.add(words(
                &bar.name,
                frame.left - 6.0,
                top + ROW / 2.0 + 4.5,
                "end",
            ));
            if self.axis.shows(bar.value) {
                group = draw_bar(group, bar, &frame, top);
            }
        }
        let label = match self.title.is_empty() {
            true => self.axis.label.clone(),
            false => self.title.clone(),
        };
        Drawing::new(group, size.0, size.1, label)
    }
}

fn draw_bar(group: Group, bar: &Bar, frame: &Frame, top: f64) -> Group {
    let (from, to) = (frame.across(frame.x.base()), frame.across(bar.value));
    let rectangle = Rectangle::new()
        .set("x", px(from.min(to)))
        .set("y", px(top + 4.0))
        .set("width", px((to - from).abs()))
        .set("height", px(ROW - 8.0))
        .set("class", bar.colour.fill());
    let mut group = group.add(rectangle);
    let mut end = from.max(to);
    if let Some([low, high]) = bar.interval
        && low.is_finite()
        && high.is_finite()
    {
        let (low, high, middle) = (frame.across(low), frame.across(high), top + ROW / 2.0);
        let class = "line stroke-ink";
        group = group.add(line(low, middle, high, middle, class));
        for x in [low, high] {
            group = group.add(line(x, middle - 4.0, x, middle + 4.0, class));
        }
        end = end.max(high);
    }
    group.add(words(&bar.text, end + 6.0, top + ROW / 2.0 + 4.5, "start"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_values() {
        let bar = |name: &str, value: f64| Bar {
            name: name.into(),
            value,
            interval: Some([value - 0.1, value + 0.1]),
            text: format!("{value:.1}"),
            colour: Colour::Series(0),
        };
        let bars = vec![bar("one <1>", 1.0), bar("two", 2.0), bar("none", f64::NAN)];
        let text = Bars::new(Axis::linear("score"), bars).draw().to_file_text();
        let document = roxmltree::Document::parse(&text).unwrap();
        let widths: Vec<f64> = document
            .descendants()
            .filter(|n| n.attribute("class") == Some("fill-s1"))
            .map(|n| n.attribute("width").unwrap().parse().unwrap())
            .collect();
        assert_eq!(widths.len(), 2);
        assert!((widths[1] / widths[0] - 2.0).abs() < 0.01, "{widths:?}");
    }
}
