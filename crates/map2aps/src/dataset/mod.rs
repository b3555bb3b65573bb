//! Data sets made, labelled anew, joined and checked.

mod builder;
mod error;
mod link;
mod map;
mod merge;
mod receivers;
mod relabel;
mod rows;
mod stored;
mod verify;

pub use builder::Made;
pub use error::{MergeError, MissingPart};
pub use map::is_near;
pub use merge::merge;
pub use relabel::relabel;
pub use verify::{Verified, Verify};

pub(crate) use builder::{DatasetBuilder, or_kept};
pub(crate) use link::LinkMaker;
pub(crate) use map::Run;
pub(crate) use receivers::Choice;
pub(crate) use rows::Rows;
pub(crate) use stored::{stored_paths, stored_pdp};
