//! `cargo xtask COMMAND`: see [`xtask::cli`].

fn main() -> std::process::ExitCode {
    xtask::cli::run()
}
