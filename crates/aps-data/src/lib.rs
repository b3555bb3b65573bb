//! Angle power spectrum data sets on disk: written whole, opened by NumPy.
//!
//! A data set is a folder with a manifest and one folder a map, each holding `.npy` arrays: link
//! table, angle power spectra (APS), and optionally power delay profiles (PDP) and the propagation
//! paths. The page `data-spec/README.md` of the workspace states the format; this crate is the only
//! one that knows it. It takes and returns plain slices of numbers; of labels it knows their settings, axes and what they see
//! of a path, of tracers nothing but, with the feature `raytrace`, their path records.
//!
//! - Writing: [`DatasetWriter`] makes a [`MapWriter`] a map, which takes [`LinkRows`] in any portions.
//! - Reading: [`Dataset`] loads a map at a time as [`MapData`], and its [`PathTable`].
//! - For training: [`Split`] says which maps train and test, [`ConditionImages`] makes a model's input from a
//!   [`Raster`] of buildings and the ends of a link.
//! - Without a manifest: [`Survey`] tells what an unfinished data set has and lacks.
//! - [`npy`] reads and writes single arrays.
//! - [`propbin`] and [`released`] read and write the files of the data published with the benchmark.
//!
//! ```
//! use aps_data::*;
//!
//! let root = tempfile::tempdir()?;
//! let config = DatasetConfig { seed: 7, ..DatasetConfig::default() };
//! let writer = DatasetWriter::open(root.path(), config)?;
//! let split = Split::of_maps(0..3, 7);
//! for id in 0..3 {
//!     if writer.has_map(id) {
//!         continue; // an earlier run got this far
//!     }
//!     let house = vec![[100.0, 100.0], [140.0, 100.0], [140.0, 120.0], [100.0, 120.0]];
//!     let buildings = Raster::of_outlines(&[house], RasterGrid::default())?;
//!     let (tx_m, rx_m) = ([[10.0, 10.0]], [[50.0, 60.0], [110.0, 110.0]]);
//!     let input = MapInput { buildings: &buildings, tx_m: &tx_m, rx_m: &rx_m, links: Links::Grid };
//!     let mut map = writer.begin_map(id, &input)?;
//!     let aps_db: Vec<f64> = (0..2 * 180).map(|i| -90.0 - f64::from(i % 180)).collect();
//!     map.push(&LinkRows {
//!         status: &[LinkStatus::Valid, LinkStatus::RxInBuilding],
//!         aps: Some(ProfileRows { db: &aps_db, argmax: None }),
//!         ..LinkRows::default()
//!     })?;
//!     map.finish()?;
//! }
//! writer.finish(&split)?;
//!
//! let dataset = Dataset::open(root.path())?;
//! for map in dataset.maps_of(Part::Train) {
//!     let map = map?;
//!     let aps = map.aps.as_ref().expect("the default layout stores it");
//!     let mut row = [0.0; 180];
//!     for link in map.valid_links() {
//!         aps.read_relative_db(link, &mut row);
//!         assert_eq!((row[0], row[179], aps.max_db()[link]), (0.0, -179.0, -90.0));
//!     }
//! }
//! assert!(dataset.verify().is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Why folders that appear whole
//!
//! A full data set takes hours to make, and anything may end a run. A map is therefore the unit of
//! work: it is written under a hidden name, synced to disk and renamed, so that a folder with a
//! map's name is complete. Each carries all settings in its `map.json`. What is finished is thus
//! plain from the folders alone: a run is resumed by being started again, shards are joined by
//! writing the manifest over all of them, and other settings are refused by name. Nothing that
//! depends on time, machine or number of threads is stored, so all these ways end in the same
//! bytes.
//!
//! # Features
//!
//! - `raytrace` (off by default): path records of `aps-raytrace` as rows of a [`PathTable`] and as samples of a label.
//!
//! The JSON of a data set needs `serde` in any case, and the types that stand in it implement it.
//!
//! # Foreign bytes
//!
//! Whatever a file holds, reading returns a typed [`Error`] or sound values: no panic, no NaN, no
//! index out of range, and no memory taken for sizes that the file's length does not bear out.

#![forbid(unsafe_code)]

mod adopt;
mod array_files;
mod arrays;
mod condition;
mod dataset_folder;
mod durable;
mod error;
mod json;
mod layout;
mod manifest;
mod map_data;
mod map_writer;
pub mod npy;
mod paths;
mod plan;
mod profile;
pub mod propbin;
mod raster;
mod reader;
#[cfg(feature = "raytrace")]
mod records;
pub mod released;
mod round;
mod split;
mod status;
mod survey;
mod writer;

pub use aps_label::Axis;
pub use condition::{ConditionConfig, ConditionImages};
pub use durable::{
    LOCK_FILE, PartialFile, is_partial, lock_folder, replace_file, replace_unsynced, sha256_of,
    size_and_sha256,
};
pub use error::{Difference, Error};
pub use json::differences;
pub use layout::{Layout, Precision, ProfileLayout, Stored};
pub use manifest::{DatasetConfig, FORMAT_VERSION, FileEntry, Manifest, MapEntry, Totals};
pub use map_data::MapData;
pub use map_writer::{LinkRows, Links, MapInput, MapWriter};
pub use paths::{InteractionKind, PathTable, UNKNOWN_ID};
pub use plan::Plan;
pub use profile::{FILL_DB, Profile, ProfileRows, Samples};
pub use raster::{Raster, RasterError, RasterGrid};
pub use reader::Dataset;
#[cfg(feature = "raytrace")]
pub use records::sample_of;
pub use split::{Part, Split, UnknownPart};
pub use status::LinkStatus;
pub use survey::Survey;
pub use writer::{Access, DatasetWriter};

/// Threads can share readers, and writers can be sent to one.
const _: fn() = || {
    fn is_shared<T: Clone + Send + Sync>() {}
    fn is_sent<T: Send>() {}
    is_shared::<(Dataset, Survey, MapData, ConditionImages, LinkRows<'_>)>();
    is_sent::<(DatasetWriter, MapWriter<'_>, Error)>();
};
