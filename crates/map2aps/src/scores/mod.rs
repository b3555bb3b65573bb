//! Predictions of any model scored against labels.

mod array_file;
mod domain;
mod error;
mod links;
mod scoring;
mod truth;

pub use array_file::ArrayFile;
pub use domain::Domain;
pub use error::ScoreError;
pub use links::{LINK_COLUMNS, check_links, link_labels, link_line, links_file};
pub use scoring::{Prediction, Scores, Scoring};
pub use truth::{Labels, Truth};
