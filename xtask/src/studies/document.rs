//! One document of all studies in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use super::study::{Block, Study};
use super::{Conditions, Profile};
use crate::benchmark::{Machine, words};
use crate::whole_files;

const LEAD: &str = "\
Error against run time, measured. Every number below was written by the program that measured it, and can be measured again by \
the commands at the end; times are medians on one thread after a warm-up. \"On the front\" means: nothing else in the \
comparison is both as fast and as accurate, errors within a hundredth of each other being equal; what is off the front is \
dominated, and there is no reason to use it.";

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
    whole_files::write(&document, text.as_bytes())?;
    Ok(document)
}

/// The text of a document, in GitHub's Markdown, that shows all studies of `folder` by links that begin with `prefix`.
///
/// # Errors
/// A folder without studies, and studies that cannot be read.
pub fn join(folder: &Path, prefix: &str) -> Result<String> {
    let studies = read_all(folder)?;
    let mut out = format!("# Numerics: error against run time\n\n{LEAD}\n");
    if studies
        .iter()
        .filter_map(|s| s.conditions.as_ref())
        .any(|c| c.profile == Profile::Smoke)
    {
        out += "\n**Some of this was measured with the profile `smoke`, which is too short for times to mean anything.**\n";
    }
    for study in &studies {
        out += &format!("\n## {}\n", escape(&study.title));
        for block in &study.blocks {
            out += "\n";
            out += &markdown(block, prefix);
        }
    }
    out += &provenance(&studies);
    Ok(out)
}

fn read_all(folder: &Path) -> Result<Vec<Study>> {
    let place = || format!("folder of studies '{}'", folder.display());
    let entries = fs::read_dir(folder).with_context(place)?;
    let paths: Vec<PathBuf> = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()
        .with_context(place)?;
    let is_study = |path: &&PathBuf| path.extension().is_some_and(|e| e == "json");
    let mut studies: Vec<Study> = paths
        .iter()
        .filter(is_study)
        .map(|path| Study::read(path))
        .collect::<Result<_>>()?;
    ensure!(!studies.is_empty(), "{} holds none", place());
    studies.sort_by(|a, b| (a.place, &a.name).cmp(&(b.place, &b.name)));
    Ok(studies)
}

fn markdown(block: &Block, prefix: &str) -> String {
    let row = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|c| escape(c)).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    match block {
        Block::Heading(text) => format!("### {}\n", escape(text)),
        Block::Text(text) => format!("{}\n", escape(text)),
        Block::Points(points) => points
            .iter()
            .map(|p| format!("- {}\n", escape(p)))
            .collect(),
        Block::Figure { file, caption } => {
            let caption = escape(caption);
            format!("![{caption}]({prefix}/{file})\n\n*{caption}*\n")
        }
        Block::Data { file, caption } => {
            format!("{}: [{file}]({prefix}/{file})\n", escape(caption))
        }
        Block::Table {
            caption,
            head,
            rows,
        } => {
            let rule: Vec<String> = head.iter().map(|_| "---".into()).collect();
            let rows: String = rows.iter().map(|r| row(r)).collect();
            format!("{}\n\n{}{}{rows}", escape(caption), row(head), row(&rule))
        }
    }
}

/// How each study came about.
fn provenance(studies: &[Study]) -> String {
    let mut out = String::from("\n## How it was measured\n\n");
    let known: Vec<(&Study, &Conditions)> = studies
        .iter()
        .filter_map(|study| Some((study, study.conditions.as_ref()?)))
        .collect();
    for (study, c) in known {
        let m = &c.machine;
        let build = match m.commit.is_empty() {
            true => m.version.clone(),
            false => format!("{} ({})", m.version, m.commit),
        };
        out += &format!(
            "- {}: `{}`; profile {}, seed {}; {}; version {}, {}; {}, took {}\n",
            escape(&study.title),
            c.command.replace('`', "'"),
            c.profile.name(),
            c.seed,
            escape(&hardware(m)),
            escape(&build),
            escape(&m.rustc),
            escape(&m.started),
            words::duration(m.seconds_total),
        );
    }
    out
}

fn hardware(m: &Machine) -> String {
    let cpu = if m.cpu.is_empty() {
        "unknown processor"
    } else {
        &m.cpu
    };
    let memory = m.memory_bytes as f64 / f64::from(1 << 30);
    format!("{cpu}, {} cores, {memory:.0} GiB, {}", m.cores, m.os)
}

/// Text that Markdown takes for nothing else, on one line.
fn escape(text: &str) -> String {
    crate::benchmark::escape_markdown(text)
}
