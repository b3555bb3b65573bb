//! The figure of a report, error against time, and the pictures of single links.

use aps_label::Protocol;
use aps_metrics::Metric;
use aps_raytrace::glam::DVec2;

use super::analysis::{Analysis, times};
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
            let colour = colour(analysis, entry);
            chart = chart.with(Series::new(entry.name.clone(), colour, solid(points)));
        }
    }
    (!chart.series.is_empty()).then_some(chart)
}

fn in_use(analysis: &Analysis<'_>, protocol: &str, metric: Metric) -> Option<Chart> {
    let mut chart = chart("time a link [ms]", metric);
    for entry in &analysis.results.entries {
        let times = times(entry);
        let mean = analysis.mean(entry, protocol, metric);
        let Some((mean, &fast)) = mean.zip(times.last()) else {
            continue;
        };
        let colour = colour(analysis, entry);
        if times.len() > 1 {
            let points = times.iter().map(|&ms| [ms, mean.mean]).collect();
            chart = chart.with(Series::new("", colour, solid(points)));
        }
        let name = entry.name.replace(" interactions", "");
        let spot = Spot {
            at: [fast, mean.mean],
            label: name.replace(" interaction", ""),
            interval: Some([mean.low, mean.high]),
            hollow: entry.kind == EntryKind::Shipped,
        };
        chart = chart.with(Series::new("", colour, Mark::Spots(vec![spot])));
    }
    (!chart.series.is_empty()).then_some(chart)
}

fn solid(points: Vec<[f64; 2]>) -> Mark {
    let dashed = false;
    Mark::Line { points, dashed }
}

fn chart(x: &str, metric: Metric) -> Chart {
    let (x, y) = (Axis::log(x), Axis::linear(metric.label()));
    Chart::new(x.tight(), y.tight()).sized(PANEL.0, PANEL.1)
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
    let sight = match link.line_of_sight {
        true => "in sight",
        false => "out of sight",
    };
    let distance = fixed(link.distance_m, 0);
    let place = format!(
        "The {} link: map {}, {distance} m, {sight}.",
        example.rank, link.map
    );
    let names = example.predictions.iter().map(|p| p.entry.as_str());
    let scores: Vec<String> = names.filter_map(score).collect();
    let file = |what: &str| svg(&format!("link-{}-{what}", stem(&example.rank)));
    let map = Figure::new(file("map"), place, map(example));
    let spectra = spectra(analysis, example)
        .map(|chart| Figure::new(file("spectrum"), scores.join(" "), chart.draw()));
    [map].into_iter().chain(spectra).collect()
}

fn map(example: &Example) -> Drawing {
    let ring = |ring: &Vec<[f64; 2]>| ring.iter().copied().map(DVec2::from).collect();
    let outlines = Outlines {
        rings: example.buildings.iter().map(ring).collect(),
        area: None,
    };
    let link = LinkView {
        tx: example.tx_m.into(),
        rx: example.rx_m.into(),
        paths: Vec::new(),
    };
    picture::map(&outlines, &link, &[], 300.0)
}

/// Truth and predictions over the angle.
fn spectra(analysis: &Analysis<'_>, example: &Example) -> Option<Chart> {
    let protocol: Protocol = analysis.results.data.protocol.parse().ok()?;
    let curve = |name: &str, colour, values: &[f64]| {
        let axis = aps_label::Axis {
            count: values.len(),
            ..protocol.angle_axis_deg()
        };
        let points = axis.values().zip(values).map(|(x, &y)| [x, y]);
        Series::curve_in(name, colour, points.collect())
    };
    let levels = Axis::linear("normalised power");
    let mut chart = Chart::new(picture::azimuth(protocol), levels)
        .sized(PANEL.0, 300.0)
        .with(curve("truth", Colour::Ink, &example.truth));
    for (i, p) in example.predictions.iter().enumerate() {
        chart = chart.with(curve(&p.entry, Colour::Series(i), &p.spectrum));
    }
    Some(chart)
}

/// The file of a figure.
fn svg(stem: &str) -> String {
    format!("figures/{stem}.svg")
}
