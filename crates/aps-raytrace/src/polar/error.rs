//! Errors of the polar view.

use thiserror::Error;

use crate::error::TerminalError;

/// Reason for which a scene cannot be looked at along rays.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PolarError {
    /// The fan of rays has no directions, or too many.
    #[error("a fan of {directions} directions with {max_bounces} bounces: {problem}")]
    Fan {
        /// Directions asked for.
        directions: usize,
        /// Bounces asked for.
        max_bounces: usize,
        /// Fault of the fan.
        problem: &'static str,
    },
    /// The pairs of a map's corners would grow beyond the limit.
    #[error(
        "pairs of corners in sight of each other take more than {limit} bytes; cut the map into smaller ones or simplify round buildings"
    )]
    TooManyCorners {
        /// The limit \[bytes\].
        limit: usize,
    },
    /// The ways of a transmitter to the corners would grow beyond the limit.
    #[error(
        "ways of the transmitter to the corners take more than {limit} bytes; cut the map into smaller ones or simplify round buildings"
    )]
    TooManyWays {
        /// The limit \[bytes\].
        limit: usize,
    },
    /// No terminal can stand there.
    #[error("no terminal can look at the city from there")]
    Terminal(#[source] TerminalError),
    /// A terminal that another map prepared.
    #[error("the {terminal} was prepared by another map; prepare it by the one of the link")]
    Foreign {
        /// The terminal.
        terminal: &'static str,
    },
}
