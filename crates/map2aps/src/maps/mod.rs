//! Maps: a folder of RadioMapSeer files, tiles of a city in GeoJSON, or synthetic cities.

#[cfg(feature = "geojson")]
mod city;
mod error;
pub(crate) mod identity;
mod ids;
#[cfg(feature = "geojson")]
mod named;
mod orientation;
mod outlines;
mod radiomapseer;
mod ranges;
mod scene_settings;
mod source;

#[cfg(feature = "geojson")]
pub use city::{City, TileSettings, load_bytes, load_file};
pub use error::MapError;
pub(crate) use ids::ascending;
pub use ids::{choose, parse_ids};
#[cfg(feature = "geojson")]
pub use named::NamedMaps;
pub(crate) use orientation::split_of_imported;
pub use orientation::{COPY_STRIDE, MAX_ORIENTATIONS, Orientation, split, with_copies};
pub(crate) use outlines::outlines;
pub use outlines::raster;
pub use radiomapseer::file_of;
pub use ranges::ranges;
pub use scene_settings::SceneSettings;
pub use source::MapSource;
