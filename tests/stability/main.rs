//! Extreme and stiff cases, grouped by what they strain. Each test says what it expects and why;
//! `docs/stability.md` lists them with what was measured.

mod coordinates;
mod kernels;
mod label;
mod orders;
mod scores;
mod shapes;
mod storage;
mod terminals;
