//! Faults of requests, and the status that each is answered with.

use std::ops::RangeInclusive;

use hyper::{Method, StatusCode};
use map2aps::error::chain;
use serde::Serialize;

use crate::limits::{MANY_DIFFRACTIONS_RANGE_DB, MAX_VERTICES};

/// An end of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// The transmitter.
    Tx,
    /// The receiver.
    Rx,
}

/// A request that is not answered as it was meant.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// A request that no page of this server makes.
    #[error("{0}")]
    Foreign(&'static str),
    /// An address that is not there.
    #[error("there is nothing at this address")]
    NotFound,
    /// An address that is asked in another way.
    #[error("this address is asked with {0}")]
    Method(Method),
    /// A body that is no JSON by its own account.
    #[error("send the body as application/json")]
    MediaType,
    /// A body that is too large.
    #[error("the body is larger than {0} bytes")]
    TooLarge(usize),
    /// A body that does not end.
    #[error("the body did not arrive within {0} s")]
    Slow(u64),
    /// A connection that ends within the body.
    #[error("the body ends too early")]
    Cut,
    /// JSON of another form.
    #[error("the request cannot be read: {0}")]
    Form(String),
    /// A number outside of its range.
    #[error("{name} = {value} is not between {} and {}", range.start(), range.end())]
    Range {
        /// The setting.
        name: &'static str,
        /// The value asked for.
        value: f64,
        /// The values that are allowed.
        range: RangeInclusive<f64>,
    },
    /// Limits without an end of paths.
    #[error(
        "three diffractions need a dynamic range of {limit} dB at most: with more there are more paths than anybody can look at",
        limit = MANY_DIFFRACTIONS_RANGE_DB
    )]
    Endless,
    /// A material that does not exist.
    #[error("material")]
    Material(#[source] aps_raytrace::ConfigError),
    /// A house that the map does not have.
    #[error("the map has no house {house}, only {count}")]
    NoHouse {
        /// The house asked for.
        house: usize,
        /// Houses of the map.
        count: usize,
    },
    /// More drawn vertices than are traced here.
    #[error("the drawn houses have {0} vertices, more than {limit}", limit = MAX_VERTICES)]
    Vertices(usize),
    /// A terminal that cannot stand where it is.
    #[error("the terminal cannot be used")]
    Terminal {
        /// The end of the link.
        end: End,
        /// Fault of its place.
        source: aps_raytrace::TerminalError,
    },
    /// A map, a link or a label that cannot be made.
    #[error(transparent)]
    Library(#[from] map2aps::Error),
    /// An explanation that cannot be made.
    #[error(transparent)]
    Report(#[from] aps_report::ReportError),
    /// A link without a path has no picture.
    #[error("the link has no path that the protocol counts: there is nothing to explain")]
    NoSpectrum,
    /// A map that no file in a format of the command line holds.
    #[error("{0}")]
    NoFile(String),
    /// A newer request of the same page, or the page has gone.
    #[error("a newer request has overtaken this one")]
    Overtaken,
    /// A bug.
    #[error("the computation broke off: a bug, please report it with the page's address")]
    Broken,
}

impl Fault {
    /// The kind of the fault for the page, and the status of the answer. A question that was understood is answered, if only with
    /// the reason why there is no link: a browser writes every other status into its console.
    fn kind(&self) -> (&'static str, StatusCode) {
        match self {
            Self::Foreign(_) => ("foreign", StatusCode::FORBIDDEN),
            Self::NotFound => ("address", StatusCode::NOT_FOUND),
            Self::Method(_) => ("address", StatusCode::METHOD_NOT_ALLOWED),
            Self::MediaType => ("form", StatusCode::UNSUPPORTED_MEDIA_TYPE),
            Self::Cut | Self::Form(_) => ("form", StatusCode::BAD_REQUEST),
            Self::TooLarge(_) => ("size", StatusCode::PAYLOAD_TOO_LARGE),
            Self::Slow(_) => ("size", StatusCode::REQUEST_TIMEOUT),
            Self::Vertices(_) => ("size", StatusCode::OK),
            Self::Range { .. } | Self::Material(_) => ("setting", StatusCode::UNPROCESSABLE_ENTITY),
            Self::Endless => ("setting", StatusCode::OK),
            Self::NoHouse { .. } => ("house", StatusCode::UNPROCESSABLE_ENTITY),
            Self::Terminal { .. } => ("terminal", StatusCode::OK),
            Self::Library(_) | Self::Report(_) => ("library", StatusCode::OK),
            Self::NoSpectrum | Self::NoFile(_) => ("nothing", StatusCode::OK),
            Self::Overtaken => ("overtaken", StatusCode::OK),
            Self::Broken => ("broken", StatusCode::INTERNAL_SERVER_ERROR),
        }
    }

    /// The status of the answer.
    pub fn status(&self) -> StatusCode {
        self.kind().1
    }

    /// The fault as JSON.
    pub fn reply(&self) -> ErrorReply {
        let error = Error {
            kind: self.kind().0,
            message: chain(self),
            end: match self {
                Self::Terminal { end, .. } => Some(*end),
                _ => None,
            },
        };
        ErrorReply { error }
    }

    /// A library's fault.
    pub fn of(error: impl Into<map2aps::Error>) -> Self {
        Self::Library(error.into())
    }

    /// Refuses a number outside of a range, and NaN.
    pub fn range(name: &'static str, value: f64, range: RangeInclusive<f64>) -> Result<(), Self> {
        match range.contains(&value) {
            true => Ok(()),
            false => Err(Self::Range { name, value, range }),
        }
    }
}

/// A fault in an answer.
#[derive(Debug, Serialize)]
pub struct ErrorReply {
    error: Error,
}

#[derive(Debug, Serialize)]
struct Error {
    kind: &'static str,
    message: String,
    end: Option<End>,
}
