//! Charts, pictures of links, pages and tables: everything that shows results.
//!
//! - [`chart`]: charts as small SVG pictures; [`trade`]: error against time, with its front;
//! - [`link`]: a link as pictures need it: its paths, its spectrum, the lobes that the paths make;
//! - [`picture`]: a link drawn on its map, and its spectra;
//! - [`document`]: sections, tables, figures and verdicts, written as HTML or as Markdown;
//! - [`explain`]: a page that tells which path makes which lobe of a spectrum;
//! - [`gallery`]: links of a data set to look at, and statistics over many;
//! - [`benchmark`]: results of models, and the document made of them;
//! - [`theme`], [`drawing`], [`numbers`]: colours and styles, finished pictures, numbers as people read them;
//! - [`command_line`]: commands of the runner as one would type them.
//!
//! Nothing here is traced, labelled or measured. Of the tracer the crate takes points, areas, scenes, paths and the
//! speed of light, of the data set its table of paths and its sums, of the labels their formula and angles; it knows no map file and
//! no model.

pub mod benchmark;
pub mod chart;
pub mod command_line;
pub mod document;
pub mod drawing;
mod error;
pub mod explain;
pub mod gallery;
pub mod link;
pub mod numbers;
pub mod picture;
pub mod theme;
pub mod trade;

pub use error::ReportError;
