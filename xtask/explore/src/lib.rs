//! A city in a browser: one page on the loopback address that asks for paths, spectra and coverage while somebody drags a
//! terminal.
//!
//! [`Server`] takes connections, [`guard`] refuses what no page of its own asks, [`App`] knows the addresses and hands the
//! work to threads. A [`Ticket`] ends what a newer request has overtaken. [`Stock`] keeps maps and terminals that were prepared,
//! as long as they are of use. Nothing is traced, labelled or drawn here: `map2aps` and `aps-report` do that.

// Both panic when the reader has gone away: see `xtask::output`.
#![warn(clippy::print_stdout, clippy::print_stderr)]
// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]
#![forbid(unsafe_code)]

pub mod app;
pub mod command;
mod compare;
mod coverage;
pub mod fault;
mod files;
pub mod guard;
pub mod houses;
mod link;
mod page;
mod prediction;
mod recent;
mod reply;
pub mod request;
pub mod server;
pub mod stock;
pub mod ticket;
mod workers;

pub use app::App;
pub use server::Server;
pub use stock::Stock;
pub use ticket::Ticket;
