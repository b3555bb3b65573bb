//! The figures of a report over all links: error against time, distributions, groups of links.

use aps_metrics::{Estimate, Metric};

use super::analysis::{Analysis, Group, HEADLINE, is_better, latency_at};
use super::paper::PUBLISHED;
use super::results::{Entry, EntryKind};
use super::tables::front;
use super::words;
use crate::chart::{Axis, Chart, Mark, Series, Spot, ccdf_points};
use crate::document::Figure;
use crate::numbers::{count, stem};
use crate::theme::Colour;

/// Kinds in the order of the key, with name and colour.
const KINDS: [(EntryKind, &str, Colour); 5] = [
    (EntryKind::Model, "model", Colour::Series(0)),
    (EntryKind::Ablation, "ablation", Colour::Series(2)),
    (EntryKind::External, "external", Colour::Series(4)),
    (EntryKind::Baseline, "baseline", Colour::Soft),
    (EntryKind::Tracer, "tracer", Colour::Series(1)),
];

/// The metrics shown over groups of links.
const GROUPED: [Metric; 4] = [
    Metric::Cosine,
    Metric::PleDeg,
    Metric::Recall4Deg,
    Metric::MirrorHit4Deg,
];

/// The colour of an entry: the same in all figures of all reports for the models of the paper.
pub fn colour(analysis: &Analysis<'_>, entry: &Entry) -> Colour {
    if let Some(i) = PUBLISHED.iter().position(|p| p.name == entry.name) {
        return Colour::Series(i);
    }
    let same: Vec<&Entry> = analysis.of_kinds(&[entry.kind]);
    let i = same.iter().position(|e| e.name == entry.name).unwrap_or(0);
    match entry.kind {
        EntryKind::Tracer => Colour::Ink,
        EntryKind::Baseline if i == 0 => Colour::Soft,
        // Colours of the paper's ablations, which no figure shows beside baselines or others.
        EntryKind::Baseline => Colour::Series(4 + i),
        _ => Colour::Series(6 + i),
    }
}

/// The entries that figures with a curve an entry show: models, those from outside, baselines, and
/// the tracer setting that is best in CosSim.
pub fn shown<'a>(analysis: &Analysis<'a>, protocol: &str) -> Vec<&'a Entry> {
    let mut entries =
        analysis.of_kinds(&[EntryKind::Model, EntryKind::External, EntryKind::Baseline]);
    let tracers = analysis.of_kinds(&[EntryKind::Tracer]);
    entries.extend(analysis.best(&tracers, protocol, Metric::Cosine));
    entries
}

fn is_compared(entry: &Entry) -> bool {
    matches!(entry.kind, EntryKind::Baseline | EntryKind::Tracer)
}

/// The headline metrics against the time a link takes in batches of a size.
pub fn error_against_time(analysis: &Analysis<'_>, protocol: &str, batch: usize) -> Vec<Figure> {
    let time = |entry: &Entry| Some(latency_at(entry, batch)?.total_ms_per_link());
    let figure = |metric: Metric| {
        let front = front(analysis, protocol, metric, batch);
        let front: Vec<[f64; 2]> = front
            .iter()
            .filter_map(|e| Some([time(e)?, analysis.mean(e, protocol, metric)?.mean]))
            .collect();
        let x = format!("time a link, batch {batch} [ms]");
        let chart = scatter(analysis, protocol, metric, &x, time, front)?;
        Some(Figure::new(
            svg(&format!("{}-time-batch-{batch}", stem(metric.label()))),
            format!(
                "{} against time a link, building of the input included, in batches of {batch}; \
                 bars are 95 % intervals. The grey steps are the Pareto front: the best there is \
                 for the time. {}",
                metric.label(),
                better(metric)
            ),
            chart.draw(),
        ))
    };
    HEADLINE.into_iter().filter_map(figure).collect()
}

/// CosSim against the time training took.
pub fn error_against_training(analysis: &Analysis<'_>, protocol: &str) -> Option<Figure> {
    let metric = Metric::Cosine;
    let time = |entry: &Entry| Some(entry.training.as_ref()?.seconds);
    let chart = scatter(analysis, protocol, metric, "training [s]", time, Vec::new())?;
    Some(Figure::new(
        svg("cossim-training"),
        "CosSim against the time training took.",
        chart.draw(),
    ))
}

fn scatter(
    analysis: &Analysis<'_>,
    protocol: &str,
    metric: Metric,
    x: &str,
    time: impl Fn(&Entry) -> Option<f64>,
    front: Vec<[f64; 2]>,
) -> Option<Chart> {
    let spot = |entry: &&Entry| {
        let mean = analysis.mean(entry, protocol, metric)?;
        Some(Spot {
            at: [time(entry).filter(|&t| t > 0.0)?, mean.mean],
            label: entry.name.trim_start_matches("tracer ").into(),
            interval: Some([mean.low, mean.high]),
        })
    };
    let mut chart = Chart::new(Axis::log(x), Axis::linear(words::axis(metric))).sized(520.0, 400.0);
    let mut series = Vec::new();
    for (kind, name, colour) in KINDS {
        let spots: Vec<Spot> = analysis.of_kinds(&[kind]).iter().filter_map(spot).collect();
        if !spots.is_empty() {
            series.push(Series::new(name, colour, Mark::Spots(spots)));
        }
    }
    if series.is_empty() {
        return None;
    }
    let spots = series.iter().flat_map(|s| match &s.mark {
        Mark::Spots(spots) => &spots[..],
        _ => &[],
    });
    // Errors over several decades, none of them 0, are told apart on a logarithmic axis only.
    let lows: Vec<f64> = spots
        .clone()
        .map(|s| s.interval.map_or(s.at[1], |i| i[0]))
        .collect();
    let highs = spots.clone().map(|s| s.at[1]).fold(0.0, f64::max);
    if metric == Metric::PleDeg
        && lows.iter().all(|&v| v > 0.0 && highs / v > 1.0)
        && highs / lows.iter().copied().fold(f64::INFINITY, f64::min) > 20.0
    {
        chart.y = Axis::log(words::axis(metric));
    }
    let slowest = spots.map(|s| s.at[0]).fold(0.0, f64::max);
    if let Some(&[_, last]) = front.last() {
        let mut points = front;
        points.push([slowest, last]);
        let mark = Mark::Steps { points };
        chart = chart.with(Series::new("Pareto front", Colour::Soft, mark));
    }
    Some(series.into_iter().fold(chart, Chart::with))
}

/// The share of links whose peak location error is larger.
pub fn ple_ccdf(analysis: &Analysis<'_>, protocol: &str) -> Option<Figure> {
    let links = analysis.results.links.len();
    let mut chart = Chart::new(
        Axis::linear("PLE [deg]").over(0.0, 60.0).every(10.0),
        Axis::log("share of links with a larger PLE").over(smallest_share(links), 1.0),
    )
    .sized(520.0, 380.0);
    for entry in shown(analysis, protocol) {
        let Some(values) = analysis.column(entry, protocol, Metric::PleDeg) else {
            continue;
        };
        let points: Vec<[f64; 2]> = ccdf_points(values)
            .into_iter()
            .filter(|p| p[0] <= 60.0)
            .collect();
        let mark = match is_compared(entry) {
            true => Mark::Line {
                points: steps(&points),
                dashed: true,
            },
            false => Mark::Steps { points },
        };
        chart = chart.with(Series::new(
            entry.name.clone(),
            colour(analysis, entry),
            mark,
        ));
    }
    (!chart.series.is_empty()).then(|| Figure::new(svg("ple-ccdf"), format!(
            "Share of the {} test links whose peak location error is larger than the value on the axis. Lower is better.",
            count(links as u64)
        ), chart.draw()))
}

/// The power of ten at or below one link of many, 0.001 at least: less is not worth the room.
fn smallest_share(links: usize) -> f64 {
    let share = 1.0 / links.max(10) as f64;
    10_f64.powf(share.log10().floor()).max(1e-3)
}

/// The corners of a distribution, since only lines can be dashed.
fn steps(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let corner = |w: &[[f64; 2]]| [w[0], [w[1][0], w[0][1]]];
    let corners = points.windows(2).flat_map(corner);
    corners.chain(points.last().copied()).collect()
}

/// The metrics of [`GROUPED`] over groups of links that have a place on an axis `step` apart.
pub fn by_group(
    analysis: &Analysis<'_>,
    protocol: &str,
    groups: &[Group],
    (key, x): (&str, Axis),
    step: f64,
    is_connected: bool,
) -> Vec<Figure> {
    let entries = shown(analysis, protocol);
    let figure = |metric: Metric| {
        let mut chart =
            Chart::new(x.clone(), Axis::linear(words::axis(metric))).sized(520.0, 380.0);
        for (i, entry) in entries.iter().enumerate() {
            // Side by side, so that intervals do not hide each other.
            let aside = 0.6 * step * ((i as f64 + 0.5) / entries.len() as f64 - 0.5);
            let means: Vec<(f64, Estimate)> = groups
                .iter()
                .filter_map(|g| Some((g.at + aside, analysis.mean_in(g, entry, protocol, metric)?)))
                .collect();
            let colour = colour(analysis, entry);
            let points = means.iter().map(|(x, m)| [*x, m.mean]).collect();
            if is_connected {
                chart = chart.with(Series::new(
                    entry.name.clone(),
                    colour,
                    Mark::Line {
                        points,
                        dashed: is_compared(entry),
                    },
                ));
            }
            let spots = means.iter().map(|(x, m)| Spot {
                at: [*x, m.mean],
                label: String::new(),
                interval: Some([m.low, m.high]),
            });
            chart = chart.with(Series::new(
                match is_connected {
                    true => String::new(),
                    false => entry.name.clone(),
                },
                colour,
                Mark::Spots(spots.collect()),
            ));
        }
        Figure::new(
            svg(&format!("{}-{key}", stem(metric.label()))),
            format!("{} by {}. {}", metric.label(), x.label, better(metric)),
            chart.draw(),
        )
    };
    GROUPED.into_iter().map(figure).collect()
}

/// CosSim on the development maps, an epoch a point.
pub fn training_curves(analysis: &Analysis<'_>) -> Option<Figure> {
    let mut chart = Chart::new(
        Axis::linear("epoch"),
        Axis::linear("CosSim on the development maps"),
    )
    .sized(520.0, 340.0);
    for entry in &analysis.results.entries {
        let Some(training) = &entry.training else {
            continue;
        };
        let point = |p: &super::results::CurvePoint| Some([f64::from(p.epoch), p.dev_cosine?]);
        let points: Vec<[f64; 2]> = training.curve.iter().filter_map(point).collect();
        if points.is_empty() {
            continue;
        }
        let mark = Mark::Line {
            points,
            dashed: entry.kind == EntryKind::Ablation,
        };
        chart = chart.with(Series::new(
            entry.name.clone(),
            colour(analysis, entry),
            mark,
        ));
    }
    (!chart.series.is_empty()).then(|| Figure::new(svg("training"), "CosSim on the development maps after each epoch; the weights of the best epoch were kept.", chart.draw()))
}

/// The file of a figure.
pub fn svg(stem: &str) -> String {
    format!("figures/{stem}.svg")
}

fn better(metric: Metric) -> &'static str {
    match is_better(metric, 1.0, 0.0) {
        true => "Higher is better.",
        false => "Lower is better.",
    }
}
