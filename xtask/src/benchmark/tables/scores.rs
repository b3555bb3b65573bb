//! Tables I to III: means of scores, an entry a row.

use aps_metrics::Metric;

use super::super::analysis::{Analysis, is_better, latency_at};
use super::super::document::{Cell, Grid};
use super::super::paper::published;
use super::super::results::{Entry, EntryKind};
use super::super::words;
use super::kind;

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

fn is_learned(entry: &Entry) -> bool {
    matches!(
        entry.kind,
        EntryKind::Model | EntryKind::Ablation | EntryKind::External
    )
}
