//! The plot area: axes, grid and ticks around it, and where a value lies in it.

use svg::node::element::Group;

use super::axis::{Axis, Fitted};
use crate::drawing::{anchored, line, px, rectangle, text_width};

/// A plot area with fitted axes.
pub(super) struct Frame {
    pub x: Fitted,
    pub y: Fitted,
    /// Plot area \[px\].
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    /// The place of a pair of values \[px\].
    pub fn place(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        (self.across(x), self.down(y))
    }

    pub fn across(&self, x: f64) -> f64 {
        px(self.left + self.x.part(x) * self.width)
    }

    pub fn down(&self, y: f64) -> f64 {
        px(self.top + (1.0 - self.y.part(y)) * self.height)
    }

    /// Bottom of the plot area \[px\].
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// Grid lines and ticks of both axes, below the data.
    pub fn draw(&self, x: &Axis, y: &Axis) -> Group {
        let mut group = self.draw_x(x);
        for (value, text) in &self.y.ticks {
            let at = self.down(*value);
            group = group
                .add(line(self.left, at, self.left + self.width, at, "grid"))
                .add(anchored(text, self.left - 6.0, at + 4.5, "end"));
        }
        let (left, middle) = (13.0, self.top + self.height / 2.0);
        let turn = format!("translate({left} {}) rotate(-90)", px(middle));
        group.add(anchored(&y.label, 0.0, 0.0, "middle").set("transform", turn))
    }

    /// Grid lines and ticks of the x axis, and the border.
    fn draw_x(&self, x: &Axis) -> Group {
        let mut group = Group::new();
        let below = self.bottom() + 18.0;
        // Texts that would run into the one before are left out.
        let mut free_from = f64::NEG_INFINITY;
        for (value, text) in &self.x.ticks {
            let at = self.across(*value);
            group = group.add(line(at, self.top, at, self.bottom(), "grid"));
            let half = text_width(text) / 2.0;
            if at - half >= free_from {
                group = group.add(anchored(text, at, below, "middle"));
                free_from = at + half + 6.0;
            }
        }
        let border = rectangle([self.left, self.top], [self.width, self.height]);
        let middle = self.left + self.width / 2.0;
        let title = anchored(&x.label, middle, self.bottom() + 38.0, "middle");
        group.add(border.set("class", "frame")).add(title)
    }
}

/// Space that the texts of an axis need to its left \[px\].
pub(super) fn tick_width(fitted: &Fitted) -> f64 {
    let widths = fitted.ticks.iter().map(|(_, text)| text_width(text));
    widths.fold(0.0, f64::max)
}
