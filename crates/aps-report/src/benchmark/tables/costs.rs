//! Costs of entries: time a link, training, and the front of error against time.

use aps_metrics::{Better, Metric};

use super::super::analysis::{Analysis, HEADLINE, latency_at};
use super::super::results::Entry;
use super::super::words;
use super::{digits, kind, or_nothing, table};
use crate::chart::pareto_front;
use crate::document::Table;
use crate::numbers::{count, duration, three_digits};

/// Run times of all entries.
pub fn times(analysis: &Analysis<'_>) -> Table {
    let head = [
        "entry",
        "batch",
        "device",
        "prediction [ms]",
        "p95 [ms]",
        "input [ms]",
        "sum [ms]",
        "links a second",
    ];
    let keys = [
        "entry",
        "kind",
        "batch",
        "device",
        "median_ms_per_link",
        "p95_ms_per_link",
        "input_ms_per_link",
        "total_ms_per_link",
    ];
    let caption =
        "Time a link: median and 95th percentile of the prediction, and the building of its input";
    let mut table = table("time", caption, head, keys);
    for entry in &analysis.results.entries {
        for l in &entry.latency {
            let total = l.total_ms_per_link();
            let times = [
                l.median_ms_per_link,
                l.p95_ms_per_link,
                l.input_ms_per_link,
                total,
            ];
            let rate = (total > 0.0).then(|| three_digits(1000.0 / total));
            let mut row = vec![entry.name.clone(), l.batch.to_string(), l.device.clone()];
            row.extend(times.map(three_digits));
            row.push(or_nothing(rate));
            table.push(row);
            let (name, batch) = (entry.name.clone(), l.batch.to_string());
            let mut data = vec![name, kind(entry.kind).into(), batch, l.device.clone()];
            data.extend(times.map(|t| t.to_string()));
            table.data.push(data);
        }
    }
    table
}

/// Costs of training.
pub fn training(analysis: &Analysis<'_>) -> Table {
    let head = [
        "entry",
        "parameters",
        "time",
        "epochs",
        "best epoch",
        "links seen",
        "best CosSim on development maps",
    ];
    let keys = [
        "entry",
        "parameters",
        "seconds",
        "epochs",
        "best_epoch",
        "links_seen",
        "dev_cosine",
    ];
    let mut table = table("training", "Training", head, keys);
    for entry in &analysis.results.entries {
        let Some(training) = &entry.training else {
            continue;
        };
        let best = training
            .curve
            .iter()
            .find(|p| Some(p.epoch) == training.best_epoch);
        let at_best = best.and_then(|p| p.dev_cosine);
        table.push([
            entry.name.clone(),
            or_nothing(entry.parameters.map(count)),
            duration(training.seconds),
            training.epochs.to_string(),
            or_nothing(training.best_epoch.map(|e| e.to_string())),
            count(training.links_seen),
            or_nothing(at_best.map(|v| words::value(Metric::Cosine, v))),
        ]);
        table.data.push(vec![
            entry.name.clone(),
            digits(entry.parameters),
            training.seconds.to_string(),
            training.epochs.to_string(),
            digits(training.best_epoch),
            training.links_seen.to_string(),
            digits(at_best),
        ]);
    }
    table
}

/// Points of the figures of error against run time, all metrics and batches.
pub fn trade(analysis: &Analysis<'_>, protocol: &str) -> Table {
    let keys = [
        "batch",
        "entry",
        "kind",
        "ms_per_link",
        "training_seconds",
        "metric",
        "mean",
        "low",
        "high",
        "on_front",
    ];
    let head = ["metric", "batch", "entries, the fastest first"];
    let caption = "Not beaten by anything that is as fast";
    let mut table = table(&format!("error-time-{protocol}"), caption, head, keys);
    for metric in HEADLINE {
        for batch in analysis.batches() {
            let front = front(analysis, protocol, metric, batch);
            let names: Vec<&str> = front.iter().map(|e| e.name.as_str()).collect();
            table.push([
                metric.label().to_owned(),
                batch.to_string(),
                names.join(", "),
            ]);
            for entry in &analysis.results.entries {
                let (Some(l), Some(mean)) = (
                    latency_at(entry, batch),
                    analysis.mean(entry, protocol, metric),
                ) else {
                    continue;
                };
                table.data.push(vec![
                    batch.to_string(),
                    entry.name.clone(),
                    kind(entry.kind).into(),
                    l.total_ms_per_link().to_string(),
                    digits(entry.training.as_ref().map(|t| t.seconds)),
                    metric.key().into(),
                    mean.mean.to_string(),
                    mean.low.to_string(),
                    mean.high.to_string(),
                    names.contains(&entry.name.as_str()).to_string(),
                ]);
            }
        }
    }
    table
}

/// The entries that nothing as fast beats, the fastest first.
pub fn front<'a>(
    analysis: &Analysis<'a>,
    protocol: &str,
    metric: Metric,
    batch: usize,
) -> Vec<&'a Entry> {
    let sign = match metric.better() {
        Better::Lower => 1.0,
        Better::Higher => -1.0,
    };
    let timed = analysis.results.entries.iter().filter_map(|entry| {
        let time = latency_at(entry, batch)?.total_ms_per_link();
        Some((
            entry,
            [time, sign * analysis.mean(entry, protocol, metric)?.mean],
        ))
    });
    let (entries, points): (Vec<&Entry>, Vec<[f64; 2]>) = timed.unzip();
    let front = pareto_front(&points, 0.0);
    front.into_iter().map(|i| entries[i]).collect()
}
