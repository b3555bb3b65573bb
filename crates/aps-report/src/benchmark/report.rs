//! The report on one page: figures, a table, three links; everything else is folded.

use super::analysis::Analysis;
use super::{figures, tables};
use crate::document::{Block, Document, Section};

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
