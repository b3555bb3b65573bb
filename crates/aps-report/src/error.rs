//! Errors of reading results and of writing reports.

use std::error::Error as StdError;
use std::fs;
use std::path::{Path, PathBuf};

/// A failure to read results, to explain a link, or to write a report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file that cannot be read or written; the source says why.
    #[error("cannot {doing} '{}'", path.display())]
    File {
        /// The attempt: `read the results`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Box<dyn StdError + Send + Sync>,
    },
    /// Results that do not fit together.
    #[error("{0}")]
    Results(String),
    /// Scores of an entry that cannot be used.
    #[error("scores of '{name}'")]
    Scores {
        /// Name of the entry.
        name: String,
        /// The reason.
        source: Box<ReportError>,
    },
    /// Settings that make no label.
    #[error(transparent)]
    Label(#[from] aps_label::ConfigError),
    /// A path that makes no label.
    #[error(transparent)]
    Path(#[from] aps_label::PathError),
}

impl ReportError {
    /// Makes errors of attempts at a file.
    pub(crate) fn at<E: Into<Box<dyn StdError + Send + Sync>>>(
        doing: &'static str,
        path: &Path,
    ) -> impl Fn(E) -> Self + use<E> {
        let path = path.to_owned();
        move |source| Self::File {
            doing,
            path: path.clone(),
            source: source.into(),
        }
    }
}

/// Writes a file under another name and renames it: a killed run leaves no half of it.
///
/// Nothing is synced, which would take longer than the writing; after a power cut a file may be short, so whoever
/// resumes must look at its length.
///
/// # Errors
/// The file that cannot be written, and why.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.partial"));
    fs::write(&partial, bytes).map_err(ReportError::at("write", &partial))?;
    fs::rename(&partial, path).map_err(ReportError::at("write", path))
}
