//! The files of the published data as a data set.

mod buildings;
mod dataset;
mod named;
mod propbin;
mod released;
mod samples;
#[cfg(test)]
mod tests;

pub use dataset::{Imported, LeftOut};
pub use propbin::ImportPropbin;
pub use released::ImportReleased;
pub use samples::ImportSamples;
