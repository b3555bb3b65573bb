//! Exchange of data sets with the files of the published data.

mod error;
mod export;
mod import;

pub use error::ExchangeError;
pub use export::{Export, ExportLayout, Exported};
pub use import::{ImportPropbin, ImportReleased, ImportSamples, Imported, LeftOut};
