//! Errors of lists of paths.

use std::io;

use aps_label::Protocol;

/// Fault of a list of paths.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PathListError {
    /// A file that cannot be read.
    #[error("cannot be read")]
    Io(#[from] io::Error),
    /// Text of another form; the message names the link, the path and the field.
    #[error(
        "{0}; expected {{\"links\": [{{\"paths\": [{{\"delay_s\": 2e-7, \"arrival_azimuth_rad\": 0.5, \
         \"gain_db\": -90}}]}}]}}, all numbers finite: leave out a path that has no gain, as NaN, null and \
         -Infinity say"
    )]
    Form(String),
    /// Text after the list.
    #[error("more text follows the list; give one list a file")]
    MoreText(#[source] serde_json::Error),
    /// Links without a path that counts.
    #[error(
        "links {links:?} have no path that the {protocol} protocol counts, so no label; remove them"
    )]
    NoLabel {
        /// The links.
        links: Vec<usize>,
        /// Protocol of the labels.
        protocol: Protocol,
    },
    /// An azimuth that must be meant in degrees.
    #[error("{field} = {azimuth_rad} is more than a turn, 2 pi; are the units radians?")]
    Azimuth {
        /// Name of the angle.
        field: &'static str,
        /// Its value \[rad\].
        azimuth_rad: f64,
    },
}
