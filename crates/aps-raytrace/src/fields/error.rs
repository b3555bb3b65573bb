//! Errors of the fields.

use glam::DVec2;
use thiserror::Error;

use crate::error::TerminalError;

/// Reason for which fields cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The grid has no pixels, too many, or no size.
    #[error("{width} x {height} pixels of {pixel_m} m from {first_m}: {problem}")]
    Grid {
        /// Columns asked for.
        width: usize,
        /// Rows asked for.
        height: usize,
        /// Side of a pixel \[m\].
        pixel_m: f64,
        /// Centre of the first pixel \[m\].
        first_m: DVec2,
        /// Fault of the grid.
        problem: &'static str,
    },
    /// The fan of rays has no directions or ranges, too many, or ranges that do not rise.
    #[error("a fan of {directions} directions and {ranges} ranges: {problem}")]
    Fan {
        /// Directions asked for.
        directions: usize,
        /// Number of ranges asked for.
        ranges: usize,
        /// Fault of the fan.
        problem: &'static str,
    },
    /// The views of a map's corners, and their pairs, would grow beyond the limit.
    #[error(
        "views and pairs of the corners take more than {limit} bytes; cut the map into smaller ones or simplify round buildings"
    )]
    TooManyCorners {
        /// The limit \[bytes\].
        limit: usize,
    },
    /// No terminal can stand there.
    #[error("no fields of a terminal there")]
    Terminal(#[source] TerminalError),
    /// More places that light pixels than a picture can name.
    #[error(
        "the transmitter at {position} lights the pixels from {sources} places, its images and corners; at most {limit} can be told apart: take a smaller grid or larger pixels"
    )]
    TooManySources {
        /// Position \[m\].
        position: DVec2,
        /// Number of places.
        sources: usize,
        /// The limit.
        limit: usize,
    },
    /// A slice for results of the wrong length.
    #[error("{what} of {links} links take {expected} numbers, the slice for them has {found}")]
    Length {
        /// Name of the result.
        what: &'static str,
        /// Number of links.
        links: usize,
        /// Numbers that the results take.
        expected: usize,
        /// Length of the slice.
        found: usize,
    },
    /// Links of one batch with fans of different size.
    #[error("link {link} of the batch has another number of directions or ranges than the first")]
    MixedFans {
        /// Index of the link.
        link: usize,
    },
    /// A terminal whose fields were made on another grid or with another fan, or of another map.
    #[error("the {terminal} was not prepared by these fields")]
    Foreign {
        /// The terminal.
        terminal: &'static str,
    },
}
