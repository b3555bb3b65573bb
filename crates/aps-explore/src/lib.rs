//! A city in a browser: one page on the loopback address that asks for paths, spectra and coverage while somebody drags a
//! terminal.
//!
//! ```no_run
//! use aps_explore::{Maps, Server};
//! use map2aps::{MapSource, SceneSettings};
//!
//! let maps = Maps::new(MapSource::Synthetic { count: 3 }, 42, SceneSettings::default())?;
//! let server = Server::bind(maps, 0)?;
//! // To be told to whoever looks: http://127.0.0.1:PORT/
//! let address = server.address();
//! server.serve()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Server`] takes connections, `guard` refuses requests that the server's own page did not send, `app` maps addresses to work
//! on threads. A handle cancels a request that a newer one replaces. The cache keeps prepared maps and terminals while they are in
//! use. Nothing is traced, labelled or drawn here: `map2aps` and `aps-report` do that.

#![forbid(unsafe_code)]

mod app;
mod cache;
mod command;
mod compare;
mod coverage;
mod curve;
mod fault;
mod files;
mod guard;
mod houses;
mod limits;
mod link;
mod lru_cache;
mod map_file;
mod page;
mod prediction;
mod reply;
mod request;
mod request_handle;
mod server;
mod times;
mod workers;

pub use cache::Maps;
pub use server::{ServeError, Server};
