//! The report on one page: a sentence, a figure, a table, three links; everything else is folded.

use aps_metrics::Metric;

use super::analysis::{Analysis, times};
use super::results::{Entry, EntryKind};
use super::words::value;
use super::{figures, tables};
use crate::document::{Block, Document, Section};
use crate::numbers::{duration, three_digits};

/// The profile that only shows that everything runs.
const SMOKE: &str = "smoke";

/// The whole report.
pub fn document(analysis: &Analysis<'_>) -> Document {
    let results = analysis.results;
    let protocols = analysis.protocols();
    let protocol = protocols.first().map_or("", String::as_str);
    let title = format!("Map2APS benchmark, profile {}", results.profile);
    let mut document = Document::new(title);
    if results.profile == SMOKE {
        document = document.lead("A smoke test, models trained for a few steps and scored on a few links: the scores mean nothing.");
    }
    document = document.lead(sentence(analysis, protocol));
    for failure in &results.failed {
        document = document.lead(format!("Failed: {}: {}", failure.name, failure.message));
    }
    for reason in &results.left_out {
        document = document.lead(format!("Left out: {}: {}", reason.name, reason.message));
    }
    let mut front = Section::new("Error against time");
    front.figures(figures::error_against_time(analysis, protocol));
    let (table, others) = tables::front(analysis, protocol);
    front.table(table);
    front.text(format!(
        "{recall} alone misleads: a spectrum that is nearly flat has many peaks and so recalls most of the true ones. Read it beside {cosine}.",
        recall = Metric::Recall4Deg.label(),
        cosine = Metric::Cosine.label()
    ));
    if let Some(others) = others {
        front.table(others);
    }
    document.sections.push(front);
    if !results.examples.is_empty() {
        let mut links = Section::new("Best, median and worst link");
        for example in &results.examples {
            links.figures(figures::example(analysis, protocol, example));
        }
        document.sections.push(links);
    }
    document.section(details(analysis, &protocols))
}

/// The best of what was learnt, its price, and what stands beside it.
fn sentence(analysis: &Analysis<'_>, protocol: &str) -> String {
    let score = |entry: &Entry, metric| {
        let mean = analysis.mean(entry, protocol, metric);
        value(metric, mean.map_or(f64::NAN, |m| m.mean))
    };
    let cosine = |entry: &Entry| score(entry, Metric::Cosine);
    let price = |entry: &Entry| {
        let last = times(entry).pop();
        last.map(|ms| format!("{} ms a link", three_digits(ms)))
    };
    let ranked = analysis.ranked(protocol, Metric::Cosine);
    let Some(best) = ranked.iter().find(|e| e.kind.is_learned()) else {
        return "Nothing that learns was scored.".into();
    };
    let mut text = format!(
        "Best of what learns is {}, CosSim {} and {} {}",
        best.name,
        cosine(best),
        Metric::Recall4Deg.label(),
        score(best, Metric::Recall4Deg)
    );
    if let Some(training) = &best.training {
        text += &format!(" after {} of training", duration(training.seconds));
    }
    text += &price(best).map_or(String::new(), |price| format!(", at {price}"));
    // Ranked by score: the last of the tracer's settings above the model is the least that beats it.
    let at = ranked.iter().position(|e| e.name == best.name).unwrap_or(0);
    let is_tracer = |e: &&&Entry| e.kind == EntryKind::Tracer;
    let above = ranked[..at].iter().rfind(is_tracer);
    let tracer = above.or_else(|| ranked.iter().find(is_tracer));
    if let Some(tracer) = tracer {
        let price = price(tracer).map_or(String::new(), |price| format!(" at {price}"));
        text += &format!("; {}: {}{price}", tracer.name, cosine(tracer));
    }
    if let Some(baseline) = ranked.iter().find(|e| e.kind == EntryKind::Baseline) {
        text += &format!("; {}: {}", baseline.name, cosine(baseline));
    }
    text + "."
}

fn details(analysis: &Analysis<'_>, protocols: &[String]) -> Section {
    let mut section = Section::new("Details");
    for protocol in protocols {
        section.table(tables::scores(analysis, protocol));
    }
    if let Some(protocol) = protocols.first() {
        section.table(tables::groups(analysis, protocol));
    }
    section.table(tables::times(analysis));
    section.table(tables::training(analysis));
    section.table(tables::conditions(analysis));
    section.blocks.push(Block::Folded {
        title: "All settings".into(),
        text: serde_json::to_string_pretty(&analysis.results.configuration).unwrap_or_default(),
    });
    section
}
