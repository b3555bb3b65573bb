//! The figure of a report, error against time, and the pictures of single links.

use aps_label::Protocol;
use aps_metrics::Metric;
use aps_raytrace::glam::DVec2;

use super::analysis::{Analysis, latencies};
use super::paper::PUBLISHED;
use super::results::{CurvePoint, Entry, EntryKind, Example};
use super::words;
use crate::chart::{Axis, Chart, Mark, Series, Spot};
use crate::document::Figure;
use crate::drawing::Drawing;
use crate::link::LinkView;
use crate::numbers::{fixed, stem};
use crate::picture::{self, Outlines};
use crate::theme::Colour;

/// Width and height of a panel \[px\].
const PANEL: (f64, f64) = (440.0, 340.0);

/// A value in a curve of training.
type OfPoint = fn(&CurvePoint) -> Option<f64>;

/// The metrics shown.
const SHOWN: [(Metric, OfPoint); 2] = [
    (Metric::Cosine, |p| p.dev_cosine),
    (Metric::Recall4Deg, |p| p.dev_recall),
];

/// Error against time, in four panels: each metric while the models learn, and against the time a link takes.
pub fn error_against_time(analysis: &Analysis<'_>, protocol: &str) -> Vec<Figure> {
    let panels = SHOWN.into_iter().flat_map(|(metric, of)| {
        let name = stem(metric.label());
        let learning = learning(analysis, metric, of).map(|chart| {
            let caption = "While learning, on development maps.";
            Figure::new(svg(&format!("{name}-training")), caption, chart.draw())
        });
        let in_use = in_use(analysis, protocol, metric).map(|chart| {
            let caption = "In use, on test maps: dots at the largest batch with 95 % intervals, lines to one link at a time.";
            Figure::new(svg(&format!("{name}-time")), caption, chart.draw())
        });
        [learning, in_use]
    });
    panels.flatten().collect()
}

fn learning(
    analysis: &Analysis<'_>,
    metric: Metric,
    of: impl Fn(&CurvePoint) -> Option<f64>,
) -> Option<Chart> {
    let mut chart = chart("training [s]", metric);
    for entry in &analysis.results.entries {
        let curve = entry.training.iter().flat_map(|t| &t.curve);
        let points: Vec<[f64; 2]> = curve.filter_map(|p| Some([p.seconds, of(p)?])).collect();
        if !points.is_empty() {
            let dashed = false;
            let mark = Mark::Line { points, dashed };
            chart = chart.with(Series::new(
                entry.name.clone(),
                colour(analysis, entry),
                mark,
            ));
        }
    }
    (!chart.series.is_empty()).then_some(chart)
}

fn in_use(analysis: &Analysis<'_>, protocol: &str, metric: Metric) -> Option<Chart> {
    let mut chart = chart("time a link [ms]", metric);
    for entry in &analysis.results.entries {
        let (Some(mean), times) = (
            analysis.mean(entry, protocol, metric),
            latencies(entry)
                .into_iter()
                .map(|l| l.total_ms_per_link())
                .collect::<Vec<f64>>(),
        ) else {
            continue;
        };
        let Some(&fast) = times.last() else {
            continue;
        };
        let colour = colour(analysis, entry);
        if times.len() > 1 {
            let points = times.iter().map(|&ms| [ms, mean.mean]).collect();
            let dashed = false;
            chart = chart.with(Series::new("", colour, Mark::Line { points, dashed }));
        }
        let spot = Spot {
            at: [fast, mean.mean],
            label: entry
                .name
                .replace(" interactions", "")
                .replace(" interaction", ""),
            interval: Some([mean.low, mean.high]),
            hollow: entry.kind == EntryKind::Shipped,
        };
        chart = chart.with(Series::new("", colour, Mark::Spots(vec![spot])));
    }
    (!chart.series.is_empty()).then_some(chart)
}

fn chart(x: &str, metric: Metric) -> Chart {
    Chart::new(Axis::log(x), Axis::linear(metric.label())).sized(PANEL.0, PANEL.1)
}

/// The colour of an entry: the same in all reports for the models of the paper; weights have that of their model.
fn colour(analysis: &Analysis<'_>, entry: &Entry) -> Colour {
    match (entry.kind, &entry.model) {
        (EntryKind::Model, _) => of_model(analysis, &entry.name),
        (EntryKind::Shipped, Some(model)) => of_model(analysis, model),
        (EntryKind::Shipped | EntryKind::External, _) => Colour::Ink,
        (EntryKind::Baseline | EntryKind::Tracer | EntryKind::Ceiling, _) => Colour::Soft,
    }
}

/// The colour of a model: those of the paper have theirs in all reports, others one of those behind.
fn of_model(analysis: &Analysis<'_>, name: &str) -> Colour {
    let is_published = |name: &str| PUBLISHED.iter().any(|p| p.name == name);
    let models = analysis.results.entries.iter();
    let models = models.filter(|e| e.kind == EntryKind::Model);
    let others = models.map(|e| &*e.name).filter(|name| !is_published(name));
    let known = PUBLISHED.iter().map(|p| p.name).chain(others);
    let at = known.into_iter().position(|known| known == name);
    Colour::Series(at.unwrap_or(PUBLISHED.len()))
}

/// Map and spectra of an example.
pub fn example(analysis: &Analysis<'_>, protocol: &str, example: &Example) -> Vec<Figure> {
    let link = &analysis.results.links[example.link];
    let entry = |name: &str| analysis.results.entries.iter().find(|e| e.name == name);
    let score = |name: &str| {
        let column = analysis.column(entry(name)?, protocol, Metric::Cosine)?;
        let cosine = words::value(Metric::Cosine, column[example.link]);
        Some(format!("{name}: CosSim {cosine}."))
    };
    let place = format!(
        "The {} link: map {}, {} m, {}.",
        example.rank,
        link.map,
        fixed(link.distance_m, 0),
        match link.line_of_sight {
            true => "in sight",
            false => "out of sight",
        }
    );
    let names = example.predictions.iter().map(|p| p.entry.as_str());
    let scores: Vec<String> = names.filter_map(score).collect();
    let file = |what: &str| svg(&format!("link-{}-{what}", stem(&example.rank)));
    let mut figures = vec![Figure::new(file("map"), place, map(example))];
    figures.extend(
        spectra(analysis, example)
            .map(|chart| Figure::new(file("spectrum"), scores.join(" "), chart.draw())),
    );
    figures
}

fn map(example: &Example) -> Drawing {
    let point = |[x, y]: [f64; 2]| DVec2::new(x, y);
    let ring = |ring: &Vec<[f64; 2]>| ring.iter().copied().map(point).collect();
    let outlines = Outlines {
        rings: example.buildings.iter().map(ring).collect(),
        area: None,
    };
    let link = LinkView {
        tx: point(example.tx_m),
        rx: point(example.rx_m),
        paths: Vec::new(),
    };
    picture::map(&outlines, &link, &[], 300.0)
}

/// Truth and predictions over the angle.
fn spectra(analysis: &Analysis<'_>, example: &Example) -> Option<Chart> {
    let protocol: Protocol = analysis.results.data.protocol.parse().ok()?;
    let line = |values: &[f64], dashed: bool| {
        let axis = aps_label::Axis {
            count: values.len(),
            ..protocol.angle_axis_deg()
        };
        let points = axis.values().zip(values).map(|(x, &y)| [x, y]).collect();
        Mark::Line { points, dashed }
    };
    let axes = (picture::azimuth(protocol), Axis::linear("normalised power"));
    let truth = Series::new("truth", Colour::Ink, line(&example.truth, false));
    let chart = Chart::new(axes.0, axes.1).sized(PANEL.0, 300.0).with(truth);
    let add = |chart: Chart, (i, p): (usize, &super::Prediction)| {
        let mark = line(&p.spectrum, true);
        chart.with(Series::new(p.entry.clone(), Colour::Series(i), mark))
    };
    Some(example.predictions.iter().enumerate().fold(chart, add))
}

/// The file of a figure.
fn svg(stem: &str) -> String {
    format!("figures/{stem}.svg")
}
