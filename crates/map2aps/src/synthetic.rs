//! Small data sets of synthetic cities, for tests in the crate and beside it.

use std::path::Path;

// Whatever takes this file has these beside it.
use super::{Control, Dataset, DatasetPlan, MapSource};

/// Plan of so many cities, with labels that every form of export takes.
pub fn plan(count: u32, tx_per_map: usize, rx_per_map: usize) -> DatasetPlan {
    DatasetPlan {
        maps: MapSource::Synthetic { count },
        tx_per_map,
        rx_per_map,
        label: aps_label::LabelConfig::released(),
        ..DatasetPlan::default()
    }
}

/// Makes the data set of some maps of a plan.
pub fn made(plan: &DatasetPlan, folder: &Path, maps: &[u32]) -> Dataset {
    plan.make(folder, maps, &Control::default()).unwrap();
    Dataset::open(folder).unwrap()
}
