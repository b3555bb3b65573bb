//! The tracer against independent references and physical laws.

mod against_brute_force;
mod closed_forms;
mod continuity;
mod corners;
mod dynamic_range;
mod enclosure;
mod exact_wedge;
mod fullwave;
mod fuzz;
mod laws;
mod mirror;
mod mixed_sequences;
mod omission;
mod one_city;
mod polar;
mod polar_paths;
mod reciprocity;
mod slits;
mod ties;
