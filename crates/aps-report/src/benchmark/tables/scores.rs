//! Tables I to III: means of scores, an entry a row.

use aps_metrics::Metric;

use super::super::analysis::{Analysis, is_better, latency_at};
use super::super::paper::published;
use super::super::results::{Entry, EntryKind};
use super::super::words;
use super::{digits, kind, or_nothing, table};
use crate::document::Table;
use crate::numbers::{count, three_digits};

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
) -> Table {
    let learned: Vec<&Entry> = entries.iter().copied().filter(|e| is_learned(e)).collect();
    let mut head = vec!["entry".to_owned()];
    head.extend(metrics.iter().map(|&m| words::heading(m)));
    let mut keys = vec!["entry".to_owned(), "kind".into()];
    for key in metrics.iter().map(|m| m.key()) {
        keys.extend(["", "_low", "_high", "_paper"].map(|end| format!("{key}{end}")));
    }
    let mut table = table(&format!("{stem}-{protocol}"), caption, head, keys);
    for (i, entry) in entries.iter().enumerate() {
        let mut row = vec![entry.name.clone()];
        let mut data = vec![entry.name.clone(), kind(entry.kind).into()];
        for (j, &metric) in metrics.iter().enumerate() {
            let mean = analysis.mean(entry, protocol, metric);
            let paper = published(&entry.name).and_then(|p| p.of(metric));
            let mut cell = or_nothing(mean.map(|mean| {
                let value = words::value(metric, mean.mean);
                format!("{value}\n{}", words::short_interval(metric, &mean))
            }));
            if let Some(paper) = paper {
                cell += &format!("\npaper {}", words::value(metric, paper));
            }
            row.push(cell);
            let best = analysis.best(&learned, protocol, metric);
            let best = best.and_then(|b| analysis.mean(b, protocol, metric));
            if is_learned(entry)
                && matches!((best, mean), (Some(b), Some(m)) if !is_better(metric, b.mean, m.mean))
            {
                table.best.push((i, j + 1));
            }
            let ends = [
                mean.map(|m| m.mean),
                mean.map(|m| m.low),
                mean.map(|m| m.high),
                paper,
            ];
            data.extend(ends.map(digits));
        }
        table.push(row);
        table.data.push(data);
    }
    table
}

/// Adds the costs that Table I has beside the scores: time a link and number of parameters.
pub fn with_cost(mut table: Table, analysis: &Analysis<'_>, entries: &[&Entry]) -> Table {
    let Some(&batch) = analysis.batches().last() else {
        return table;
    };
    let head = ["ms a link \u{2193}", "parameters"];
    table.head.extend(head.map(String::from));
    let keys = ["ms_per_link", "ms_per_link_paper", "parameters"];
    table.data[0].extend(keys.map(String::from));
    for (i, entry) in entries.iter().enumerate() {
        let time = latency_at(entry, batch).map(|l| l.total_ms_per_link());
        let paper = published(&entry.name).and_then(|p| p.ms_per_link);
        let mut cell = or_nothing(time.map(three_digits));
        if let Some(paper) = paper {
            cell += &format!("\npaper {paper}, GPU");
        }
        table.rows[i].extend([cell, or_nothing(entry.parameters.map(count))]);
        table.data[i + 1].extend([digits(time), digits(paper), digits(entry.parameters)]);
    }
    table
}

/// Adds the parts that Table III has before the scores: multi-scale encoder and regularizer.
pub fn with_parts(mut table: Table, entries: &[&Entry]) -> Table {
    table.head.splice(1..1, ["MS".into(), "Reg.".into()]);
    table.data[0].splice(1..1, ["multi_scale".into(), "regularizer".into()]);
    for (i, entry) in entries.iter().enumerate() {
        let parts = published(&entry.name)
            .and_then(|p| p.ablation)
            .unwrap_or_default();
        let mark = |has: bool| String::from(if has { "\u{2713}" } else { "\u{00d7}" });
        table.rows[i].splice(1..1, parts.map(mark));
        table.data[i + 1].splice(1..1, parts.map(|has| has.to_string()));
    }
    for place in &mut table.best {
        place.1 += 2;
    }
    table
}

fn is_learned(entry: &Entry) -> bool {
    matches!(
        entry.kind,
        EntryKind::Model | EntryKind::Ablation | EntryKind::External
    )
}
