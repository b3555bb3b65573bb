//! One of each chart on a page: `cargo run -p aps-report --example charts > charts.html`.

use aps_report::chart::{Axis, Bar, Bars, Chart, Histogram, Spot, pareto_front};
use aps_report::document::{Document, Figure, Section, Table};
use aps_report::theme::Colour;

fn main() {
    let methods = [
        ("mean spectrum", 0.001, 0.71),
        ("line of sight", 0.002, 0.62),
        ("small net", 0.4, 0.31),
        ("large net", 9.0, 0.12),
        ("wide net", 11.0, 0.16),
        ("tracer, 1 reflection", 0.05, 0.25),
        ("tracer, 2 reflections", 0.12, 0.05),
    ];
    let points = methods.map(|(_, ms, error)| [ms, error]);
    let front = pareto_front(&points, 0.0);
    let front: Vec<[f64; 2]> = front.into_iter().map(|i| points[i]).collect();
    let spots = methods.map(|(name, ms, error)| Spot {
        at: [ms, error],
        label: name.into(),
        interval: Some([error * 0.9, error * 1.1]),
    });
    let scatter = Chart::new(Axis::log("time a link [ms]"), Axis::log("error"))
        .line("Pareto front", front)
        .spots("method", spots);

    let wave = |k: f64| -> Vec<f64> {
        (1..400)
            .map(|i| -(f64::from(i) * k).sin().abs().ln())
            .collect()
    };
    let ccdf = Chart::new(
        Axis::linear("error"),
        Axis::log("share above").over(1e-3, 1.0),
    )
    .ccdf("first", &wave(0.37))
    .ccdf("second", &wave(0.021));
    let histogram = Chart::new(Axis::linear("error"), Axis::linear("share [%]"))
        .histogram("", &Histogram::around(&wave(0.37), 24))
        .rule("mean", 0.7);

    let order = |p: i32| -> Vec<[f64; 2]> {
        (0..9)
            .map(|i| 2_f64.powi(i))
            .map(|n| [n * 1e-6, n.powi(-p)])
            .collect()
    };
    let mut lines = Chart::new(Axis::log("time [s]"), Axis::log("error"));
    for p in 1..=8 {
        lines = lines.line(format!("order {p}"), order(p));
    }

    let bar = |(i, (name, _, error)): (usize, (&str, f64, f64))| Bar {
        name: name.into(),
        value: error,
        interval: Some([error - 0.04, error + 0.04]),
        text: format!("{error:.2}"),
        colour: Colour::Series(usize::from(i > 4)),
    };
    let bars = Bars::new(
        Axis::linear("error"),
        methods.into_iter().enumerate().map(bar).collect(),
    );

    let mut section = Section::new("Charts");
    let figures = [
        (
            "Error against time, both logarithmic, with the Pareto front.",
            scatter.draw(),
        ),
        ("Bars with intervals.", bars.draw()),
        ("Distributions.", ccdf.draw()),
        ("A histogram.", histogram.draw()),
        ("Work and precision.", lines.draw()),
    ];
    let figures = figures.map(|(caption, drawing)| Figure::shown(caption, drawing));
    section.figures(figures.to_vec());
    let mut table = Table::new("", ["method", "time [ms]", "error"]);
    for (name, ms, error) in methods {
        table.push([name.to_owned(), ms.to_string(), error.to_string()]);
    }
    section.table(table);
    println!("{}", Document::new("Charts").section(section).to_html());
}
