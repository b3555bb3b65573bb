//! City maps to ray-traced paths to angle power spectra: data sets made, checked, labelled anew, exchanged and scored.
//!
//! This crate joins `aps-raytrace`, `aps-label`, `aps-data` and `aps-metrics`, which do not know each other, and exports
//! them. It is what `cargo xtask` runs, without the command line: it prints nothing, and reads no argument.
//!
//! | from | by | to |
//! |---|---|---|
//! | a folder of maps, a city in GeoJSON, synthetic cities | [`MapSource`], [`DatasetPlan`] | a data set |
//! | a data set that stores paths | [`relabel`] | a data set with other labels |
//! | shards of a data set | [`merge`] | the data set that one run would have made |
//! | a data set, its maps | [`Verify`] | findings |
//! | a data set | [`Examples`], [`DrawnExamples`] | condition images and targets |
//! | a scene or a data set's maps, links | [`PolarViews`] | the geometry that Polar-Reg is given |
//! | a data set | `training` (feature `models`) | trained weights, predictions |
//! | a scene, links | `training::LinkModel` (feature `models`) | predictions without a data set |
//! | labels, predictions of any model | [`Truth`], [`Scoring`] | [`Scores`] |
//! | a tracer, many terminals | [`trace_links`], [`trace_pairs`], [`label_links`] | paths and labels in memory |
//! | a data set, its maps | [`LinkSource`] | paths of single links |
//! | a folder with a data set, finished or not | [`Overview`] | sums over its maps |
//! | a data set | [`Export`] | the files of the published data |
//! | the files of the published data | [`ImportPropbin`], [`ImportReleased`], [`ImportSamples`] | a data set |
//! | paths of any program in JSON | [`path_list`] | spectra |
//!
//! A data set in a few lines:
//!
//! ```no_run
#![doc = include_str!("../examples/make_dataset.rs")]
//! ```
//!
//! # Long operations
//!
//! They take a [`Control`]: a receiver of their progress and a flag that ends them. Data sets appear map by map, each
//! whole or not at all, and the same call continues what was interrupted, to the same bytes, with any number of threads.
//! All of them run on the threads of the current rayon pool.
//!
//! # Errors
//!
//! Every function returns an [`Error`], which wraps a typed cause in its places. [`Error::cause`] gives the cause,
//! [`Error::chain`] the whole as a line. Nothing panics at bytes from outside.
//!
//! # Features
//!
//! - `geojson` (on by default): maps cut from a city in GeoJSON.
//! - `parquet`: export as Parquet files with a card for hubs of data sets.
//! - `models`: training and prediction with the models of `aps-model`, in candle; `cuda` and `metal`: these on a GPU.
#![forbid(unsafe_code)]

mod batch;
pub mod control;
mod counted;
mod dataset;
mod differences;
mod drawn;
pub mod error;
mod examples;
mod exchange;
mod in_order;
mod limits;
mod links;
pub mod maps;
mod mirror;
mod overview;
pub mod path_list;
mod plan;
mod polar;
pub mod sampling;
mod scenes;
mod scores;
pub mod settings;
#[cfg(test)]
mod synthetic;
mod tally;
pub mod targets;
#[cfg(feature = "models")]
pub mod training;

pub use aps_data;
pub use aps_data::{Access, Dataset, Part, Split, Stored};
pub use aps_label;
pub use aps_label::LabelConfig;
pub use aps_metrics;
pub use aps_metrics::Metric;
#[cfg(feature = "models")]
pub use aps_model;
pub use aps_raytrace;
pub use aps_raytrace::TraceConfig;

pub use batch::{LinkLabels, label_links, trace_links, trace_pairs};
pub use control::{Control, Progress, Work};
pub use counted::counted;
pub use dataset::{Made, MergeError, MissingPart, Verified, Verify, is_near, merge, relabel};
pub use differences::Difference;
pub use drawn::DrawnExamples;
pub use error::{Error, Place, Result};
pub use examples::{Draw, Example, Examples};
pub use exchange::{
    ExchangeError, Export, ExportLayout, Exported, ImportPropbin, ImportReleased, ImportSamples,
    Imported, LeftOut,
};
pub use limits::{Limits, UnknownLimits};
pub use links::{LinkMap, LinkSource};
pub use maps::{MapError, MapSource, SceneSettings};
pub use mirror::MirrorError;
pub use overview::Overview;
pub use plan::DatasetPlan;
pub use polar::{PolarViews, SeenLink, padded};
pub use sampling::{Receivers, SEED};
pub use scores::{
    ArrayFile, Domain, LINK_COLUMNS, Labels, Prediction, ScoreError, Scores, Scoring, Truth,
    check_links, link_labels, link_line, links_file,
};
pub use settings::SettingsError;
pub use tally::Tally;

/// Threads can share all but a training, which is sent to one.
const _: fn() = || {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<(Control<'_>, DatasetPlan, Examples, PolarViews)>();
    is_shared::<(Export, Verify, LinkSource, Truth, Scores, Error)>();
    #[cfg(feature = "models")]
    {
        fn is_sent<T: Send>() {}
        is_shared::<(training::Training, training::Trained)>();
        is_sent::<training::Run>();
    }
};
