//! Tells the program which compiler built it.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let version = version.map_or(String::new(), |o| {
        String::from_utf8_lossy(&o.stdout).trim().into()
    });
    println!("cargo::rustc-env=BUILD_RUSTC_VERSION={version}");
}
