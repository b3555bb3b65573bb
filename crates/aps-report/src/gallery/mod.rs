//! A data set on one page: links to look at, and statistics over many.

mod charts;
mod exhibit;
mod statistics;

pub use exhibit::{Exhibit, legend};
pub use statistics::Statistics;
