//! A data set on one page: links to look at, and statistics over many.

mod charts;
mod link_panel;
mod statistics;

pub use link_panel::{LinkPanel, legend};
pub use statistics::Statistics;
