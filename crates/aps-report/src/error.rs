//! Errors of reading results and of writing reports.

use std::error::Error as StdError;
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
