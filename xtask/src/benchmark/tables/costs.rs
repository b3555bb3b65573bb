//! What entries cost: time a link, training, and the front of error against time.

use aps_metrics::{Better, Metric};

use super::super::analysis::{Analysis, HEADLINE, is_better, latency_at};
use super::super::document::{Cell, Grid};
use super::super::results::Entry;
use super::super::words;
use super::kind;

/// Run times of all entries, and what their training took.
pub fn times(analysis: &Analysis<'_>) -> Grid {
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
    let mut grid = Grid {
        stem: "time".into(),
        caption: "Time a link: median and 95th percentile of the prediction, and the building of its input".into(),
        head: head.map(Into::into).to_vec(),
        data: vec![keys.map(Into::into).to_vec()],
        ..Grid::default()
    };
    for entry in &analysis.results.entries {
        for l in &entry.latency {
            let total = l.total_ms_per_link();
            let rate = match total > 0.0 {
                true => Cell::text(words::three_digits(1000.0 / total)),
                false => Cell::nothing(),
            };
            grid.rows.push(vec![
                Cell::text(&entry.name),
                Cell::text(l.batch.to_string()),
                Cell::text(&l.device),
                Cell::text(words::three_digits(l.median_ms_per_link)),
                Cell::text(words::three_digits(l.p95_ms_per_link)),
                Cell::text(words::three_digits(l.input_ms_per_link)),
                Cell::text(words::three_digits(total)),
                rate,
            ]);
            grid.data.push(vec![
                entry.name.clone(),
                kind(entry.kind).into(),
                l.batch.to_string(),
                l.device.clone(),
                l.median_ms_per_link.to_string(),
                l.p95_ms_per_link.to_string(),
                l.input_ms_per_link.to_string(),
                total.to_string(),
            ]);
        }
    }
    grid
}

/// What training took.
pub fn training(analysis: &Analysis<'_>) -> Grid {
    let mut grid = Grid {
        stem: "training".into(),
        caption: "Training".into(),
        head: [
            "entry",
            "parameters",
            "time",
            "epochs",
            "best epoch",
            "links seen",
            "best CosSim on development maps",
        ]
        .map(Into::into)
        .to_vec(),
        data: vec![
            [
                "entry",
                "parameters",
                "seconds",
                "epochs",
                "best_epoch",
                "links_seen",
                "dev_cosine",
            ]
            .map(Into::into)
            .to_vec(),
        ],
        ..Grid::default()
    };
    for entry in &analysis.results.entries {
        let Some(training) = &entry.training else {
            continue;
        };
        let at_best = training
            .curve
            .iter()
            .find(|p| Some(p.epoch) == training.best_epoch)
            .and_then(|p| p.dev_cosine);
        let or_nothing = |text: Option<String>| text.map_or_else(Cell::nothing, Cell::text);
        grid.rows.push(vec![
            Cell::text(&entry.name),
            or_nothing(entry.parameters.map(words::count)),
            Cell::text(words::duration(training.seconds)),
            Cell::text(training.epochs.to_string()),
            or_nothing(training.best_epoch.map(|e| e.to_string())),
            Cell::text(words::count(training.links_seen)),
            or_nothing(at_best.map(|v| words::value(Metric::Cosine, v))),
        ]);
        grid.data.push(vec![
            entry.name.clone(),
            entry.parameters.map(|n| n.to_string()).unwrap_or_default(),
            training.seconds.to_string(),
            training.epochs.to_string(),
            training
                .best_epoch
                .map(|e| e.to_string())
                .unwrap_or_default(),
            training.links_seen.to_string(),
            at_best.map(|v| v.to_string()).unwrap_or_default(),
        ]);
    }
    grid
}

/// Points of the figures of error against run time, all metrics and batches.
pub fn trade(analysis: &Analysis<'_>, protocol: &str) -> Grid {
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
    let mut grid = Grid {
        stem: format!("error-time-{protocol}"),
        caption: "Not beaten by anything that is as fast".into(),
        head: ["metric", "batch", "entries, the fastest first"]
            .map(Into::into)
            .to_vec(),
        data: vec![keys.map(Into::into).to_vec()],
        ..Grid::default()
    };
    for metric in HEADLINE {
        for batch in analysis.batches() {
            let front = front(analysis, protocol, metric, batch);
            let names: Vec<&str> = front.iter().map(|e| e.name.as_str()).collect();
            grid.rows.push(vec![
                Cell::text(metric.label()),
                Cell::text(batch.to_string()),
                Cell::text(names.join(", ")),
            ]);
            for entry in &analysis.results.entries {
                let (Some(l), Some(mean)) = (
                    latency_at(entry, batch),
                    analysis.mean(entry, protocol, metric),
                ) else {
                    continue;
                };
                let training = entry.training.as_ref().map(|t| t.seconds.to_string());
                grid.data.push(vec![
                    batch.to_string(),
                    entry.name.clone(),
                    kind(entry.kind).into(),
                    l.total_ms_per_link().to_string(),
                    training.unwrap_or_default(),
                    metric.key().into(),
                    mean.mean.to_string(),
                    mean.low.to_string(),
                    mean.high.to_string(),
                    names.contains(&entry.name.as_str()).to_string(),
                ]);
            }
        }
    }
    grid
}

/// The entries that nothing as fast beats, the fastest first.
pub fn front<'a>(
    analysis: &Analysis<'a>,
    protocol: &str,
    metric: Metric,
    batch: usize,
) -> Vec<&'a Entry> {
    let mut timed: Vec<(f64, f64, &Entry)> = analysis
        .results
        .entries
        .iter()
        .filter_map(|entry| {
            let time = latency_at(entry, batch)?.total_ms_per_link();
            let mean = analysis.mean(entry, protocol, metric)?.mean;
            Some((time, mean, entry))
        })
        .collect();
    // Of equally fast ones the better first.
    let better_first = |a: f64, b: f64| match metric.better() {
        Better::Lower => a.total_cmp(&b),
        Better::Higher => b.total_cmp(&a),
    };
    timed.sort_by(|a, b| a.0.total_cmp(&b.0).then(better_first(a.1, b.1)));
    let mut front: Vec<(f64, &Entry)> = Vec::new();
    for (_, value, entry) in timed {
        if front
            .last()
            .is_none_or(|&(best, _)| is_better(metric, value, best))
        {
            front.push((value, entry));
        }
    }
    front.into_iter().map(|f| f.1).collect()
}
