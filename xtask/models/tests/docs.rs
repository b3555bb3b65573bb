//! The commands of the documentation that need models run; the others are run by the test `docs` of package `xtask`.
#![cfg(unix)]

#[path = "../../../tests/documentation/mod.rs"]
mod documentation;

use std::path::Path;

use documentation::{Runner, run_all};

#[test]
fn commands_of_the_pages_run() {
    let models = Path::new(env!("CARGO_BIN_EXE_xtask-models"));
    // Data sets are made by the runner itself, which is built into the same folder.
    let own = &models.with_file_name("xtask");
    assert!(
        own.is_file(),
        "'{}' is not there: cargo build --package xtask",
        own.display()
    );
    run_all(
        "sh models",
        Runner {
            own,
            models: Some(models),
        },
    );
}
