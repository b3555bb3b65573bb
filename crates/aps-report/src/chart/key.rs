//! The key: the names of the series above the plot.

use svg::node::element::{Group, Rectangle};

use super::frame::{line, words};
use super::series::{Mark, Series};
use crate::drawing::{plain, px, text_width};

/// The named series in rows that fit into `width` px.
pub fn rows(series: &[Series], width: f64) -> Vec<Vec<&Series>> {
    let mut rows: Vec<Vec<&Series>> = Vec::new();
    let mut used = f64::INFINITY;
    for s in series {
        if s.name.is_empty() || matches!(s.mark, Mark::Rule { .. }) {
            continue;
        }
        let wide = width_of(s);
        if used + wide > width - 60.0 {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += wide;
        rows.last_mut().expect("a row was begun").push(s);
    }
    rows
}

fn width_of(series: &Series) -> f64 {
    38.0 + text_width(&series.name)
}

/// A row of the key.
pub fn draw(row: &[&Series], left: f64, top: f64) -> Group {
    let mut group = Group::new();
    let mut x = left;
    for series in row {
        let class = format!("line {}", series.colour.stroke());
        let sample: Box<dyn svg::Node> = match &series.mark {
            Mark::Line { dashed: true, .. } | Mark::Stems { dashed: true, .. } => Box::new(line(
                x,
                top + 6.0,
                x + 18.0,
                top + 6.0,
                &format!("{class} dashed"),
            )),
            Mark::Line { .. } | Mark::Steps { .. } | Mark::Stems { .. } => {
                Box::new(line(x, top + 6.0, x + 18.0, top + 6.0, &class))
            }
            _ => Box::new(
                Rectangle::new()
                    .set("x", px(x + 4.0))
                    .set("y", px(top + 1.0))
                    .set("width", 10)
                    .set("height", 10)
                    .set("rx", 2)
                    .set("class", series.colour.fill()),
            ),
        };
        group = group
            .add(sample)
            .add(words(&plain(&series.name), x + 23.0, top + 10.5, "start"));
        x += width_of(series);
    }
    group
}
