//! The tables of a report.

use aps_metrics::{Better, Metric};

use super::analysis::{Analysis, Group, HEADLINE, Verdict, is_better, latency_at};
use super::document::{Cell, Grid};
use super::paper::published;
use super::results::{Entry, EntryKind};
use super::words;

/// Columns of Table I, the mirror-aware error beside the paper's.
pub const MAIN: [Metric; 7] = [
    Metric::Mae,
    Metric::PsnrDb,
    Metric::Cosine,
    Metric::NmseDb,
    Metric::SpectralAngleDeg,
    Metric::PleDeg,
    Metric::MirrorPleDeg,
];

/// Columns of Table II, the mirror-aware hits beside the paper's.
pub const DIRECTIONS: [Metric; 6] = [
    Metric::Hit2Deg,
    Metric::Hit4Deg,
    Metric::MirrorHit2Deg,
    Metric::MirrorHit4Deg,
    Metric::Recall2Deg,
    Metric::Recall4Deg,
];

/// Columns of Table III.
pub const ABLATION: [Metric; 8] = [
    Metric::Cosine,
    Metric::PsnrDb,
    Metric::NmseDb,
    Metric::PleDeg,
    Metric::Hit2Deg,
    Metric::Hit4Deg,
    Metric::Recall2Deg,
    Metric::Recall4Deg,
];

/// Means of some metrics, an entry a row: interval and the paper's figure below each. The best mean
/// of what was learned stands out.
pub fn scores(
    analysis: &Analysis<'_>,
    (stem, caption): (&str, String),
    entries: &[&Entry],
    protocol: &str,
    metrics: &[Metric],
) -> Grid {
    let learned: Vec<&Entry> = entries.iter().copied().filter(|e| is_learned(e)).collect();
    let mut head = vec!["entry".to_owned()];
    head.extend(metrics.iter().map(|&m| words::heading(m)));
    let mut keys = vec!["entry".to_owned(), "kind".into()];
    for metric in metrics {
        let key = metric.key();
        keys.extend([
            key.into(),
            format!("{key}_low"),
            format!("{key}_high"),
            format!("{key}_paper"),
        ]);
    }
    let mut grid = Grid {
        stem: format!("{stem}-{protocol}"),
        caption,
        head,
        data: vec![keys],
        ..Grid::default()
    };
    for entry in entries {
        let mut row = vec![Cell::text(&entry.name)];
        let mut data = vec![entry.name.clone(), kind(entry.kind).into()];
        for &metric in metrics {
            let mean = analysis.mean(entry, protocol, metric);
            let paper = published(&entry.name).and_then(|p| p.of(metric));
            let mut cell = mean.map_or_else(Cell::nothing, |mean| {
                Cell::text(words::value(metric, mean.mean))
                    .note(words::short_interval(metric, &mean))
            });
            if let Some(paper) = paper {
                cell = cell.note(format!("paper {}", words::value(metric, paper)));
            }
            let best = analysis.best(&learned, protocol, metric);
            let best = best.and_then(|b| analysis.mean(b, protocol, metric));
            cell.is_best = is_learned(entry)
                && matches!((best, mean), (Some(b), Some(m)) if !is_better(metric, b.mean, m.mean));
            row.push(cell);
            let text = |v: Option<f64>| v.map(|v| v.to_string()).unwrap_or_default();
            data.extend([
                text(mean.map(|m| m.mean)),
                text(mean.map(|m| m.low)),
                text(mean.map(|m| m.high)),
                text(paper),
            ]);
        }
        grid.rows.push(row);
        grid.data.push(data);
    }
    grid
}

/// Adds what Table I has beside the scores: time a link and number of parameters.
pub fn with_cost(mut grid: Grid, analysis: &Analysis<'_>, entries: &[&Entry]) -> Grid {
    let Some(&batch) = analysis.batches().last() else {
        return grid;
    };
    grid.head
        .extend(["ms a link \u{2193}".into(), "parameters".into()]);
    grid.data[0].extend([
        "ms_per_link".into(),
        "ms_per_link_paper".into(),
        "parameters".into(),
    ]);
    for (i, entry) in entries.iter().enumerate() {
        let time = latency_at(entry, batch).map(|l| l.total_ms_per_link());
        let paper = published(&entry.name).and_then(|p| p.ms_per_link);
        let mut cell = time.map_or_else(Cell::nothing, |t| Cell::text(words::three_digits(t)));
        if let Some(paper) = paper {
            cell = cell.note(format!("paper {paper}, GPU"));
        }
        let parameters = entry.parameters;
        grid.rows[i].push(cell);
        grid.rows[i].push(parameters.map_or_else(Cell::nothing, |n| Cell::text(words::count(n))));
        let text = |v: Option<f64>| v.map(|v| v.to_string()).unwrap_or_default();
        grid.data[i + 1].extend([
            text(time),
            text(paper),
            parameters.map(|n| n.to_string()).unwrap_or_default(),
        ]);
    }
    grid
}

/// Adds what Table III has before the scores: which of the two parts an entry has.
pub fn with_parts(mut grid: Grid, entries: &[&Entry]) -> Grid {
    grid.head.splice(1..1, ["MS".into(), "Reg.".into()]);
    grid.data[0].splice(1..1, ["multi_scale".into(), "regularizer".into()]);
    for (i, entry) in entries.iter().enumerate() {
        let parts = published(&entry.name)
            .and_then(|p| p.ablation)
            .unwrap_or_default();
        let mark = |has: bool| Cell::text(if has { "\u{2713}" } else { "\u{00d7}" });
        grid.rows[i].splice(1..1, parts.map(mark));
        grid.data[i + 1].splice(1..1, parts.map(|has| has.to_string()));
    }
    grid
}

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

/// Means over groups of links, an entry and a group a row.
pub fn groups(
    analysis: &Analysis<'_>,
    (stem, caption): (&str, String),
    groups: &[Group],
    metrics: &[Metric],
    protocol: &str,
) -> Grid {
    let mut head = vec!["entry".to_owned(), "group".into(), "links".into()];
    head.extend(metrics.iter().map(|&m| words::heading(m)));
    let mut keys = vec![
        "entry".to_owned(),
        "kind".into(),
        "group".into(),
        "links".into(),
    ];
    for metric in metrics {
        let key = metric.key();
        keys.extend([key.into(), format!("{key}_low"), format!("{key}_high")]);
    }
    let mut grid = Grid {
        stem: stem.into(),
        caption,
        head,
        data: vec![keys],
        is_folded: true,
        ..Grid::default()
    };
    for entry in &analysis.results.entries {
        for group in groups {
            let n = group.links.len() as u64;
            let mut row = vec![
                Cell::text(&entry.name),
                Cell::text(&group.name),
                Cell::text(words::count(n)),
            ];
            let mut data = vec![
                entry.name.clone(),
                kind(entry.kind).into(),
                group.name.clone(),
                n.to_string(),
            ];
            for &metric in metrics {
                let Some(mean) = analysis.mean_in(group, entry, protocol, metric) else {
                    row.push(Cell::nothing());
                    data.extend([String::new(), String::new(), String::new()]);
                    continue;
                };
                row.push(Cell::text(words::estimate(metric, &mean)));
                data.extend([mean.mean, mean.low, mean.high].map(|v| v.to_string()));
            }
            grid.rows.push(row);
            grid.data.push(data);
        }
    }
    grid
}

/// Every learned entry against everything that learns nothing.
pub fn against(analysis: &Analysis<'_>, protocol: &str) -> Grid {
    let others = analysis.of_kinds(&[EntryKind::Baseline, EntryKind::Tracer]);
    let names: Vec<&str> = HEADLINE.iter().map(|m| m.label()).collect();
    let mut head = vec!["model".to_owned()];
    head.extend(others.iter().map(|o| o.name.clone()));
    let keys = [
        "entry",
        "against",
        "metric",
        "better_by",
        "low",
        "high",
        "verdict",
    ];
    let mut grid = Grid {
        stem: format!("against-{protocol}"),
        caption: format!(
            "In {}, in this order: + the model is better, \u{2212} worse, ? the interval of the difference holds 0",
            words::list(&names)
        ),
        head,
        data: vec![keys.map(Into::into).to_vec()],
        ..Grid::default()
    };
    for model in analysis.learned() {
        let mut row = vec![Cell::text(&model.name)];
        for other in &others {
            let mut signs = Vec::new();
            for metric in HEADLINE {
                let Some(gain) = analysis.gain(model, other, protocol, metric) else {
                    signs.push(" ");
                    continue;
                };
                let (sign, verdict) = match gain.verdict() {
                    Verdict::Better => ("+", "better"),
                    Verdict::Worse => ("\u{2212}", "worse"),
                    Verdict::Undecided => ("?", "undecided"),
                };
                signs.push(sign);
                let e = gain.estimate;
                let mut data = vec![model.name.clone(), other.name.clone(), metric.key().into()];
                data.extend([e.mean, e.low, e.high].map(|v| v.to_string()));
                data.push(verdict.into());
                grid.data.push(data);
            }
            row.push(Cell::text(signs.join(" ")));
        }
        grid.rows.push(row);
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

fn is_learned(entry: &Entry) -> bool {
    matches!(
        entry.kind,
        EntryKind::Model | EntryKind::Ablation | EntryKind::External
    )
}

/// A kind as a word in CSV.
fn kind(kind: EntryKind) -> &'static str {
    match kind {
        EntryKind::Model => "model",
        EntryKind::Ablation => "ablation",
        EntryKind::Baseline => "baseline",
        EntryKind::Tracer => "tracer",
        EntryKind::External => "external",
    }
}
