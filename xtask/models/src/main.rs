//! The commands of `cargo xtask` that need models. The runner builds and starts this program when one is asked for.

fn main() {}
