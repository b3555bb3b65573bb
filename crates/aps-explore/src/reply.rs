//! Answers over HTTP.

use std::convert::Infallible;
use std::pin::Pin;
use std::task::{Context, Poll};

use http_body_util::{Either, Full};
use hyper::body::{Body, Bytes, Frame};
use hyper::header::{self, HeaderName, HeaderValue};
use hyper::{Response, StatusCode};
use serde::Serialize;
use tokio::sync::mpsc;

use crate::fault::Fault;
use crate::request_handle::Held;

/// A body that is there, or one that comes in parts.
pub type ReplyBody = Either<Full<Bytes>, Parts>;

/// An answer.
pub type Reply = Response<ReplyBody>;

/// JSON.
pub const JSON: &str = "application/json";

/// Headers of every answer: nothing is kept, nothing from elsewhere is loaded, nobody else may show or read it. Styles inside of elements
/// are those of pictures.
const HEADERS: [(HeaderName, &str); 5] = [
    (header::CACHE_CONTROL, "no-store"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
];

/// An answer of one piece.
pub fn whole(status: StatusCode, media_type: &'static str, body: impl Into<Bytes>) -> Reply {
    reply(status, media_type, Either::Left(Full::new(body.into())))
}

/// A value as JSON.
pub fn json(value: &impl Serialize) -> Reply {
    match serde_json::to_vec(value) {
        Ok(text) => whole(StatusCode::OK, JSON, text),
        Err(_) => fault(&Fault::Broken),
    }
}

/// Lines that come one by one.
pub fn parts(parts: Parts) -> Reply {
    reply(StatusCode::OK, "application/x-ndjson", Either::Right(parts))
}

/// Marks a fault, whose status may be that of an answer.
const FAULT: HeaderName = HeaderName::from_static("x-fault");

/// A fault as JSON. What may have left a part of the body unread ends its connection.
pub fn fault(fault: &Fault) -> Reply {
    let text = serde_json::to_vec(&fault.reply()).unwrap_or_default();
    let mut reply = whole(fault.status(), JSON, text);
    reply
        .headers_mut()
        .insert(FAULT, HeaderValue::from_static("1"));
    if let Fault::TooLarge(_) | Fault::Slow(_) | Fault::Foreign(_) | Fault::MediaType = fault {
        let close = HeaderValue::from_static("close");
        reply.headers_mut().insert(header::CONNECTION, close);
    }
    reply
}

fn reply(status: StatusCode, media_type: &'static str, body: ReplyBody) -> Reply {
    let mut reply = Response::new(body);
    *reply.status_mut() = status;
    let media_type = (header::CONTENT_TYPE, media_type);
    for (name, value) in HEADERS.into_iter().chain([media_type]) {
        let value = HeaderValue::from_static(value);
        reply.headers_mut().insert(name, value);
    }
    reply
}

/// A body that comes in parts, as long as its reader is there.
#[derive(Debug)]
pub struct Parts {
    receiver: mpsc::Receiver<Bytes>,
    _held: Held,
}

impl Parts {
    /// A body whose parts are sent from elsewhere; `held` goes with it.
    pub fn new(receiver: mpsc::Receiver<Bytes>, held: Held) -> Self {
        Self {
            receiver,
            _held: held,
        }
    }
}

impl Body for Parts {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        let part = self.receiver.poll_recv(context);
        part.map(|part| part.map(|bytes| Ok(Frame::data(bytes))))
    }
}
