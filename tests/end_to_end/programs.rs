//! Commands of other packages are handed over as they were typed.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use crate::PROGRAM;

#[test]
fn commands_of_other_packages_reach_them_with_all_arguments() {
    let folder = tempfile::tempdir().unwrap();
    let cargo = folder.path().join("cargo");
    fs::write(&cargo, "#!/bin/sh\nprintf '%s ' \"$@\"\n").unwrap();
    fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).unwrap();
    for (package, command) in [
        ("xtask-studies", "report"),
        ("xtask-models", "train"),
        ("xtask-models", "bench-models"),
        ("xtask-models", "export-onnx"),
        ("xtask-explore", "explore"),
    ] {
        let mut runner = Command::new(PROGRAM);
        runner
            .env("CARGO", &cargo)
            .args([command, "--seed", "7", "--help"]);
        let output = runner.output().unwrap();
        let given = String::from_utf8(output.stdout).unwrap();
        let run = format!("run --release --package {package} ");
        assert!(
            output.status.success() && given.starts_with(&run),
            "{given}"
        );
        let rest = format!("-- {command} --seed 7 --help ");
        assert!(given.ends_with(&rest), "{given}");
    }
}
