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
//! # Ok::<(), aps_explore::ServeError>(())
//! ```
//!
//! [`Server`] takes connections, `guard` refuses requests that the server's own page did not send, `app` maps addresses to work
//! on threads. A ticket cancels a request that a newer one replaces. The stock keeps prepared maps and terminals while they are in
//! use. Nothing is traced, labelled or drawn here: `map2aps` and `aps-report` do that.

#![forbid(unsafe_code)]

mod app;
mod command;
mod compare;
mod coverage;
mod fault;
mod files;
mod guard;
mod houses;
mod link;
mod page;
mod prediction;
mod recent;
mod reply;
mod request;
mod server;
mod stock;
mod ticket;
mod workers;

pub use server::{ServeError, Server};
pub use stock::Maps;
