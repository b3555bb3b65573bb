//! The key: the names of the series above the plot.

use svg::node::element::Group;

use super::series::{Mark, Series};
use crate::drawing::{anchored, line, rectangle, text_width};

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
        let dashed = match series.mark {
            Mark::Line { dashed, .. } | Mark::Stems { dashed, .. } => Some(dashed),
            Mark::Steps { .. } => Some(false),
            Mark::Spots(_) | Mark::Bins { .. } | Mark::Badges { .. } | Mark::Rule { .. } => None,
        };
        group = match dashed.map(|dashed| series.line_class(dashed)) {
            Some(class) => group.add(line(x, top + 6.0, x + 18.0, top + 6.0, &class)),
            None => {
                let square = rectangle([x + 4.0, top + 1.0], [10.0; 2]).set("rx", 2);
                group.add(square.set("class", series.colour.fill()))
            }
        };
        group = group.add(anchored(&series.name, x + 23.0, top + 10.5, "start"));
        x += width_of(series);
    }
    group
}
