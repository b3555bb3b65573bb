//! Code that the cross-crate tests share: reference implementations that avoid the tricks of the
//! crates they check, and real cities.

pub mod brute_force;
pub mod double_complex;
pub mod double_double;
pub mod fullwave;
pub mod label;
pub mod links;
pub mod maps;
pub mod mixed;
pub mod motion;
pub mod shapes;
pub mod ulps;
pub mod utd;
pub mod wedge;
