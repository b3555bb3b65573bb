//! Entries by groups of links, and against each other.

use aps_metrics::Metric;

use super::super::analysis::{Analysis, Group, HEADLINE, Verdict};
use super::super::results::EntryKind;
use super::super::words;
use super::{digits, kind, or_nothing, table};
use crate::document::Table;
use crate::numbers;

/// Means over groups of links, an entry and a group a row.
pub fn groups(
    analysis: &Analysis<'_>,
    (stem, caption): (&str, &str),
    groups: &[Group],
    metrics: &[Metric],
    protocol: &str,
) -> Table {
    let mut head = ["entry", "group", "links"].map(String::from).to_vec();
    head.extend(metrics.iter().map(|&m| words::heading(m)));
    let mut keys = ["entry", "kind", "group", "links"]
        .map(String::from)
        .to_vec();
    for key in metrics.iter().map(|m| m.key()) {
        keys.extend([key.into(), format!("{key}_low"), format!("{key}_high")]);
    }
    let mut table = table(stem, caption, head, keys);
    table.is_folded = true;
    for entry in &analysis.results.entries {
        for group in groups {
            let n = group.links.len() as u64;
            let mut row = vec![entry.name.clone(), group.name.clone(), numbers::count(n)];
            let (name, group_name) = (entry.name.clone(), group.name.clone());
            let mut data = vec![name, kind(entry.kind).into(), group_name, n.to_string()];
            for &metric in metrics {
                let mean = analysis.mean_in(group, entry, protocol, metric);
                row.push(or_nothing(mean.map(|m| words::estimate(metric, &m))));
                data.extend(
                    [
                        mean.map(|m| m.mean),
                        mean.map(|m| m.low),
                        mean.map(|m| m.high),
                    ]
                    .map(digits),
                );
            }
            table.push(row);
            table.data.push(data);
        }
    }
    table
}

/// Every learned entry against everything that learns nothing.
pub fn against(analysis: &Analysis<'_>, protocol: &str) -> Table {
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
    let caption = format!(
        "In {}, in this order: + the model is better, \u{2212} worse, ? the interval of the difference holds 0",
        numbers::list(&names)
    );
    let mut table = table(&format!("against-{protocol}"), caption, head, keys);
    for model in analysis.learned() {
        let mut row = vec![model.name.clone()];
        for other in &others {
            let mut signs = Vec::new();
            for metric in HEADLINE {
                let Some(gain) = analysis.gain(model, other, protocol, metric) else {
                    signs.push(" ");
                    continue;
                };
                let verdict = gain.verdict();
                signs.push(match verdict {
                    Verdict::Better => "+",
                    Verdict::Worse => "\u{2212}",
                    Verdict::Undecided => "?",
                });
                let e = gain.estimate;
                let mut data = vec![model.name.clone(), other.name.clone(), metric.key().into()];
                data.extend([e.mean, e.low, e.high].map(|v| v.to_string()));
                data.push(verdict.word().into());
                table.data.push(data);
            }
            row.push(signs.join(" "));
        }
        table.push(row);
    }
    table
}
