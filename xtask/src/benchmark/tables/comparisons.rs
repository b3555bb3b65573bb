//! Entries by groups of links, and against each other.

use aps_metrics::Metric;

use super::super::analysis::{Analysis, Group, HEADLINE, Verdict};
use super::super::document::{Cell, Grid};
use super::super::results::EntryKind;
use super::super::words;
use super::kind;

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
