//! A reader that goes away, as `head` does, ends no command and is no error; a full disk behind the output is one.

use std::fs;
use std::process::{Command, Output, Stdio};

use crate::folder::Folder;
use crate::{succeed, xtask};

/// A pipe that nobody reads.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

/// Runs the runner with nobody at its standard output.
fn unheard(command: &str) -> Output {
    let mut xtask = Command::new(env!("CARGO_BIN_EXE_xtask"));
    xtask.args(command.split(' ')).stdout(closed());
    xtask.output().unwrap()
}

#[track_caller]
fn assert_silent_success(command: &str) {
    let output = unheard(command);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{command}: {said}");
    assert!(
        !said.contains("panicked") && !said.contains("error"),
        "{command}: {said}"
    );
}

#[test]
fn every_command_ends_as_if_it_had_been_read() {
    let folder = Folder::new();
    let maps = folder.maps(2);
    let arg = |name| folder.arg(name);
    let (made, shard) = (arg("made"), arg("shard"));
    assert_silent_success(&format!(
        "dataset --maps {maps} --profile smoke --store aps,paths --out {made}"
    ));
    assert_silent_success(&format!("verify {made} --maps {maps}"));
    assert_silent_success(&format!("info {made}"));
    assert_silent_success(&format!("info {made} --json"));
    assert_silent_success(&format!(
        "relabel {made} --protocol paper --out {}",
        arg("anew")
    ));
    assert_silent_success(&format!(
        "export {made} --layout samples --limit 2 --out {}",
        arg("samples")
    ));
    assert_silent_success(&format!(
        "import samples {} --out {}",
        arg("samples"),
        arg("back")
    ));
    assert_silent_success(&format!(
        "gallery {made} --maps {maps} --out {}",
        arg("page.html")
    ));
    assert_silent_success(&format!(
        "explain {made} --link 0,0,0 --out {}",
        arg("link.html")
    ));
    assert_silent_success(&format!(
        "dataset --maps {maps} --profile smoke --shard 1/1 --out {shard}"
    ));
    assert_silent_success(&format!("dataset merge --out {shard}"));
    assert_silent_success(&format!(
        "slurm --nodes 1 --maps {maps} --profile smoke --out {}",
        arg("cluster")
    ));
    let trace = format!("trace --map {maps}/0.json --tx 5,5 --rx 200,200 --format");
    for form in ["json", "csv", "table"] {
        let picture = arg(form);
        assert_silent_success(&format!("{trace} {form} --svg {picture}.svg"));
        assert!(
            fs::metadata(format!("{picture}.svg")).is_ok(),
            "{form}: no picture"
        );
    }
    assert!(succeed(&format!("verify {shard} --maps {maps}")).contains("as it should be"));
}

#[test]
fn findings_that_nobody_reads_are_findings() {
    let folder = Folder::new();
    let out = folder.arg("made");
    succeed(&format!("dataset --profile smoke --out {out}"));
    let file = folder.path("made/map_0000/aps_db.npy");
    let mut bytes = fs::read(&file).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&file, bytes).unwrap();
    let output = unheard(&format!("verify {out}"));
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("1 findings"), "{said}");
}

#[test]
fn errors_that_nobody_reads_are_errors() {
    for command in ["verify nowhere", "trace --tx 5,5 --rx 5,5", "trace --tx 1"] {
        let mut xtask = Command::new(env!("CARGO_BIN_EXE_xtask"));
        let xtask = xtask
            .args(command.split(' '))
            .stdout(closed())
            .stderr(closed());
        let code = xtask.status().unwrap().code();
        assert!(matches!(code, Some(1 | 2)), "{command}: {code:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_the_output_is_told_and_the_data_set_is_whole() {
    let folder = Folder::new();
    let out = folder.arg("made");
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let mut dataset = Command::new(env!("CARGO_BIN_EXE_xtask"));
    dataset.args(["dataset", "--profile", "smoke", "--out", &out]);
    let output = dataset.stdout(full).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write to standard output"), "{said}");
    assert!(xtask(&format!("verify {out}")).status.success());
}
