//! City maps to ray-traced paths to angle power spectra.
#![forbid(unsafe_code)]

pub mod control;
mod dataset;
pub mod error;
mod examples;
mod exchange;
pub mod maps;
pub mod path_list;
pub mod path_sample;
mod plan;
pub mod sampling;
mod scores;
pub mod settings;
mod tally;
pub mod targets;

pub use aps_data;
pub use aps_label;
pub use aps_metrics;
pub use aps_raytrace;

pub use control::{Control, Progress, Work};
pub use dataset::{Made, MergeError, MissingPart, Verified, Verify, is_near, merge, relabel};
pub use error::{Error, Place, Result};
pub use examples::{Example, Examples};
pub use exchange::{
    ExchangeError, Export, ExportLayout, Exported, ImportPropbin, ImportReleased, ImportSamples,
    Imported, LeftOut,
};
pub use maps::{MapError, MapSource, SceneSettings};
pub use plan::DatasetPlan;
pub use sampling::Receivers;
pub use scores::{ArrayFile, Domain, Labels, Prediction, ScoreError, Scores, Scoring, Truth};
pub use settings::{SettingsError, Stored};
pub use tally::Tally;
