//! One document of all studies in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use aps_data::replace_unsynced;
use aps_report::document::{Document, Section, Table};
use aps_report::numbers::duration;

use crate::profile::Profile;
use crate::study::Study;

const LEAD: &str = "\
Times are medians on one thread after a warm-up. On the front is what nothing else in the comparison beats in both time and \
error; errors within a hundredth of each other are equal.";

/// Name of the document without `.md`, and of the folder of its studies beside it.
const DOCUMENT: &str = "numerics";

/// The folder in which a document in `out` finds its studies.
pub fn studies_folder(out: &Path) -> PathBuf {
    out.join(DOCUMENT)
}

/// Writes the document of all studies in [`studies_folder`] into `out`; returns its file.
///
/// # Errors
/// As [`join`], and a file that cannot be written.
pub fn publish(out: &Path) -> Result<PathBuf> {
    let document = out.join(format!("{DOCUMENT}.md"));
    let text = join(&studies_folder(out), DOCUMENT)?;
    replace_unsynced(&document, text.as_bytes())?;
    Ok(document)
}

/// The text of a document, in GitHub's Markdown, that shows all studies of `folder` by links that begin with `prefix`.
///
/// # Errors
/// A folder without studies, and studies that cannot be read.
pub fn join(folder: &Path, prefix: &str) -> Result<String> {
    let studies = read_all(folder)?;
    let mut document = Document::new("Numerics: error against run time").lead(LEAD);
    let mut conditions = studies.iter().flat_map(|study| &study.conditions);
    if conditions.any(|c| c.profile == Profile::Smoke) {
        document = document.lead("Some of this is of the profile smoke: its times mean nothing.");
    }
    let provenance = provenance(&studies);
    document.sections = studies.into_iter().map(|study| study.section).collect();
    Ok(document
        .section(provenance)
        .to_markdown(&format!("{prefix}/")))
}

fn read_all(folder: &Path) -> Result<Vec<Study>> {
    let place = || format!("folder of studies '{}'", folder.display());
    let mut studies = Vec::new();
    for entry in fs::read_dir(folder).with_context(place)? {
        let path = entry.with_context(place)?.path();
        if path.extension().is_some_and(|e| e == "json") {
            studies.push(Study::read(&path)?);
        }
    }
    ensure!(!studies.is_empty(), "{} holds none", place());
    studies.sort_by(|a, b| (a.place, &a.name).cmp(&(b.place, &b.name)));
    Ok(studies)
}

/// Command, machine and version of each study.
fn provenance(studies: &[Study]) -> Section {
    let row = |study: &Study| {
        let c = study.conditions.as_ref()?;
        let m = &c.machine;
        let memory = m.memory_bytes as f64 / f64::from(1 << 30);
        Some(vec![
            study.name.clone(),
            c.command.clone(),
            format!("{}, {} cores, {memory:.0} GiB, {}", m.cpu, m.cores, m.os),
            format!("{} {}, {}", m.version, m.commit, m.rustc),
            m.started.clone(),
            duration(m.seconds_total),
        ])
    };
    let head = ["study", "command", "machine", "version", "begun", "took"];
    let mut section = Section::new("How it was measured");
    section.table(Table::new("Studies", head).rows(studies.iter().filter_map(row)));
    section
}
