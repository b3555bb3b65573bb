//! Arrays of a map that a data set may store.

use aps_data::{Dataset, PathTable, Profile};

use crate::error::Result;

/// The delay profiles of a map, if the data set stores any.
pub fn stored_pdp(dataset: &Dataset, id: u32) -> Result<Option<Profile>> {
    let pdp = dataset.manifest().layout.pdp;
    Ok(pdp.map(|_| dataset.pdp(id)).transpose()?)
}

/// The paths of a map, if the data set stores any.
pub fn stored_paths(dataset: &Dataset, id: u32) -> Result<Option<PathTable>> {
    let paths = dataset.manifest().layout.paths;
    Ok(paths.then(|| dataset.paths(id)).transpose()?)
}
