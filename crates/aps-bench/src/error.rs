//! The errors of this crate.

use std::error::Error as StdError;
use std::path::{Path, PathBuf};

use aps_model::ModelKind;
use map2aps::Error as Library;
use map2aps::training::TrainingError;

/// Result of a function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Error of making a benchmark or a part of it. The message does not repeat its cause, which is its source.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or folder that cannot be read or written, or holds something else.
    #[error("{what} '{}'", path.display())]
    File {
        /// Kind of the file, or the action that failed.
        what: &'static str,
        /// Its path.
        path: PathBuf,
        /// The reason.
        source: Box<dyn StdError + Send + Sync>,
    },
    /// A setting with a value that it cannot have, or a key that is none; both are named. Also settings that ask for more maps than
    /// there are, for maps without a labelled link, or for a name twice.
    #[error("{0}")]
    Setting(String),
    /// A folder with other files than a benchmark's: nothing in it was touched.
    #[error("'{}' holds other files than a benchmark's", .0.display())]
    ForeignFolder(PathBuf),
    /// Predictions that are of other links than the test maps', or cannot be scored.
    #[error("{0}")]
    Scores(String),
    /// No entry was left to be reported.
    #[error("nothing could be scored")]
    NothingScored,
    /// A choice of settings by trainings that are no share of a budget.
    #[error("settings are chosen for a budget: training.budget is not given")]
    NoBudget,
    /// A share of the budget without a training in it.
    #[error("{share} of the budget of {budget_s} s leaves no training of a millisecond")]
    Share {
        /// The share.
        share: f64,
        /// The budget \[s\].
        budget_s: f64,
    },
    /// Every training of a model failed, so that there is nothing to choose settings by.
    #[error("every training of {model} failed, nothing is written for it; the last one")]
    NoTraining {
        /// The model.
        model: ModelKind,
        /// Error of the last training.
        source: Option<Box<Error>>,
    },
    /// The work was ended from outside.
    #[error("what is finished is kept, and the same benchmark goes on from there")]
    Interrupted(#[source] Box<Error>),
    /// A data set, a training, a model, a trace or a label.
    #[error(transparent)]
    Library(#[from] Library),
    /// Scores or the report.
    #[error(transparent)]
    Report(#[from] aps_report::ReportError),
    /// Settings that TOML cannot hold.
    #[error(transparent)]
    Toml(#[from] toml::ser::Error),
}

/// Errors of the crates that `map2aps` joins are its own.
macro_rules! of_the_library {
    ($($error:ty),* $(,)?) => {
        $(impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::Library(error.into())
            }
        })*
    };
}

of_the_library!(
    aps_data::Error,
    aps_label::ConfigError,
    aps_label::NormalizationError,
    aps_label::PathError,
    aps_metrics::Error,
    aps_model::Error,
    aps_raytrace::ConfigError,
    aps_raytrace::TerminalError,
    aps_raytrace::TraceError,
    serde_json::Error,
);

impl From<aps_model::candle_core::Error> for Error {
    fn from(error: aps_model::candle_core::Error) -> Self {
        aps_model::Error::from(error).into()
    }
}

impl Error {
    /// Makes errors of a file or folder.
    pub(crate) fn file<E: Into<Box<dyn StdError + Send + Sync>>>(
        what: &'static str,
        path: &Path,
    ) -> impl FnOnce(E) -> Self {
        let path = path.to_owned();
        move |source| Self::File {
            what,
            path,
            source: source.into(),
        }
    }

    /// Returns true when something was not scored because it predicts labels of another meaning, which is no failure.
    pub(crate) fn is_of_other_labels(&self) -> bool {
        let Self::Library(error) = self else {
            return false;
        };
        matches!(
            error.cause(),
            Library::Training(TrainingError::OtherLabels { .. })
        )
    }
}
