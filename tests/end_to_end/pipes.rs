//! A reader that goes away, as `head` does, ends no command and is no error; a full disk behind the output is one.

use std::fs;
use std::process::{Command, Stdio};

use crate::command::words;
use crate::folder::Folder;
use crate::{PROGRAM, assert_told, succeed, xtask};

/// A pipe that nobody reads.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

/// The runner in a folder, with nobody at its standard output.
fn unheard(folder: &Folder, line: &str) -> Command {
    let mut xtask = Command::new(PROGRAM);
    xtask.args(words(line)).current_dir(folder.path(""));
    xtask.stdout(closed());
    xtask
}

#[test]
fn every_command_ends_as_if_it_had_been_read() {
    let folder = Folder::new();
    folder.maps(2);
    for line in [
        "dataset --maps maps --profile smoke --protocol released --store aps,paths --out made",
        "verify made --maps maps",
        "info made",
        "info made --json",
        "relabel made --protocol paper --out anew",
        "export made --layout samples --limit 2 --out samples",
        "import samples samples --out back",
        "gallery made --maps maps --out page.html",
        "explain made --link 0,0,0 --out link.html",
        "dataset --maps maps --profile smoke --shard 1/1 --out shard",
        "dataset merge --out shard",
        "slurm --nodes 1 --maps maps --profile smoke --out cluster",
        "trace --map maps/0.json --tx 5,5 --rx 200,200 --format json --svg json.svg",
        "trace --map maps/0.json --tx 5,5 --rx 200,200 --format csv --svg csv.svg",
        "trace --map maps/0.json --tx 5,5 --rx 200,200 --format table --svg table.svg",
    ] {
        let output = unheard(&folder, line).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{line}: {said}");
        let is_silent = !said.contains("panicked") && !said.contains("error");
        assert!(is_silent, "{line}: {said}");
    }
    for picture in ["json.svg", "csv.svg", "table.svg"] {
        assert!(folder.path(picture).is_file(), "no {picture}");
    }
    let [shard, maps] = ["shard", "maps"].map(|name| folder.arg(name));
    let told = succeed(&format!("verify {shard} --maps {maps}"));
    assert_told(&told, &["as it should be"]);
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
    let output = unheard(&folder, "verify made").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("1 findings"), "{said}");
}

#[test]
fn errors_that_nobody_reads_are_errors() {
    let folder = Folder::new();
    for command in ["verify nowhere", "trace --tx 5,5 --rx 5,5", "trace --tx 1"] {
        let mut xtask = unheard(&folder, command);
        let code = xtask.stderr(closed()).status().unwrap().code();
        assert!(matches!(code, Some(1 | 2)), "{command}: {code:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_the_output_is_told_and_the_data_set_is_whole() {
    let folder = Folder::new();
    let out = folder.arg("made");
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let mut dataset = Command::new(PROGRAM);
    dataset.args(["dataset", "--profile", "smoke", "--out", &out]);
    let output = dataset.stdout(full).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write to standard output"), "{said}");
    assert!(xtask(&format!("verify {out}")).status.success());
}
