//! Tests of interruptions: kills, full disks, folders that cannot be written, maps that vanish.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::command::words;
use crate::folder::{Folder, assert_same, files, map};
use crate::{PROGRAM, assert_told, fail};

/// A small data set with every kind of array.
const SETTINGS: &str = "--tx-per-map 2 --rx-per-map 12 --store aps,pdp,paths --profile full --maps";

/// The command that makes one.
fn dataset(maps: &str, out: &str) -> String {
    format!("dataset {SETTINGS} {maps} --out {out}")
}

/// Measures the progress of a run: counts every byte, file and folder.
fn progress(folder: &Path) -> u64 {
    let Ok(entries) = fs::read_dir(folder) else {
        return 0;
    };
    let of_entry = |path: &Path| match fs::metadata(path) {
        Ok(found) if found.is_dir() => 1 + progress(path),
        Ok(found) => 1 + found.len(),
        Err(_) => 0, // renamed meanwhile
    };
    entries.flatten().map(|entry| of_entry(&entry.path())).sum()
}

/// Kills the process as soon as the folder has got this far; returns true when it was still running.
fn kill_at(child: &mut Child, folder: &Path, wanted: u64) -> bool {
    loop {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        if progress(folder) >= wanted {
            child.kill().unwrap(); // SIGKILL on Unix
            return child.wait().unwrap().code().is_none();
        }
        std::thread::yield_now();
    }
}

/// Kills and resumes runs, each until it ends and equals an undisturbed one. Returns how many of so many kills came amid a
/// map, and how many after a map.
fn killed_and_resumed_equals_undisturbed(wanted_kills: usize) -> [usize; 2] {
    let (folder, maps) = Folder::with_maps(5);
    folder.make("whole", &[SETTINGS, &maps, "--threads 1"]);
    folder.make("two", &[SETTINGS, &maps, "--threads 2"]);
    let expected = files(&folder.path("whole"));
    assert_same(&expected, &files(&folder.path("two")));
    let all = progress(&folder.path("whole"));

    let mut rng = ChaCha8Rng::seed_from_u64(50);
    let (mut kills, mut with_half_a_map, mut with_whole_maps) = (0, 0, 0);
    while kills < wanted_kills {
        let out = folder.path("killed");
        // Killed and resumed until a run gets to its end.
        loop {
            let done = progress(&out);
            let wanted = done + rng.random_range(0..=all - all.min(done) + all / 20);
            let threads = ["1", "2"][rng.random_range(0..2)];
            let mut child = Command::new(PROGRAM)
                .args(words(&dataset(&maps, &folder.arg("killed"))))
                .args(["--threads", threads])
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            if !kill_at(&mut child, &out, wanted) {
                assert!(child.wait().unwrap().success());
                break;
            }
            kills += 1;
            let names: Vec<String> = fs::read_dir(&out)
                .map(|entries| entries.map(|e| e.unwrap().file_name().into_string().unwrap()))
                .map(Iterator::collect)
                .unwrap_or_default();
            let has = |beginning: &str| names.iter().any(|name| name.starts_with(beginning));
            with_half_a_map += usize::from(has(".map_"));
            with_whole_maps += usize::from(has("map_"));
        }
        assert_same(&expected, &files(&out));
        fs::remove_dir_all(&out).unwrap();
    }
    [with_half_a_map, with_whole_maps]
}

#[test]
fn run_killed_at_five_moments_and_resumed_equals_an_undisturbed_one() {
    killed_and_resumed_equals_undisturbed(5);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_run_with_the_status_of_shells() {
    let (folder, maps) = Folder::with_maps(5);
    let child = Command::new(PROGRAM)
        .args(words(&dataset(&maps, &folder.arg("stopped"))))
        .args(["--threads", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while progress(&folder.path("stopped")) == 0 {
        std::thread::yield_now();
    }
    let id = child.id().to_string();
    let sent = Command::new("sh")
        .args(["-c", "kill -INT $0", &id])
        .status();
    assert!(sent.unwrap().success());
    let ended = child.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{told}");
    assert!(told.contains("error: interrupted"), "{told}");
    assert!(told.contains("Ctrl-C once more ends at once"), "{told}");
}

#[test]
#[ignore = "long: fifty kills"]
fn run_killed_at_fifty_moments_and_resumed_equals_an_undisturbed_one() {
    let amid_and_after = killed_and_resumed_equals_undisturbed(50);
    // They came at different moments indeed.
    assert!(amid_and_after.iter().all(|&n| n > 0), "{amid_and_after:?}");
}

/// Runs a shell script that may mount folders in memory, with the runner as `$0` and the words of a line as `$@`. `.ci/run`
/// leaves out the tests that need it, all named `mounted_...`, on systems that do not let them.
fn mounting(script: &str, line: &str) -> Output {
    let mut command = Command::new("unshare");
    command.args([
        "--user",
        "--map-root-user",
        "--mount",
        "sh",
        "-c",
        script,
        PROGRAM,
    ]);
    command.args(words(line)).output().unwrap()
}

#[test]
fn mounted_disk_that_is_full_is_told_and_loses_no_finished_map() {
    let (folder, maps) = Folder::with_maps(5);
    folder.make("whole", &[SETTINGS, &maps]);
    let disk = folder.path("disk");
    fs::create_dir(&disk).unwrap();
    // Room for less than half of it; then for all.
    let out = folder.arg("disk/data");
    let script = format!(
        "set -e; mount -t tmpfs -o size=320k tmpfs '{disk}'
         if \"$0\" \"$@\"; then exit 7; fi
         ls '{out}' >&2
         mount -o remount,size=64m '{disk}'
         \"$0\" \"$@\"
         cp -r '{out}' '{copy}'",
        disk = disk.display(),
        copy = folder.arg("copy")
    );
    let output = mounting(&script, &dataset(&maps, &out));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
    assert_told(&told, &["No space left on device", "whole maps are kept"]);
    assert!(
        told.contains("map_0000") && !told.contains("map_0004"),
        "{told}"
    );
    folder.assert_same("whole", "copy");
}

#[test]
fn file_that_may_not_grow_is_told_and_loses_no_finished_map() {
    let (folder, maps) = Folder::with_maps(3);
    folder.make("whole", &[SETTINGS, &maps]);
    folder.make("data", &[SETTINGS, &maps, "--map-ids 0-1"]);
    // 40 blocks of 512 bytes, or of 1024 in some shells; the image of the buildings has 64 KiB.
    let output = Command::new("sh")
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 40; exec \"$0\" \"$@\"",
            PROGRAM,
        ])
        .args(words(&dataset(&maps, &folder.arg("data"))))
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert_told(
        &told,
        &["buildings.npy", "too large", "2 whole maps are kept"],
    );
    assert!(!folder.path("data/map_0002").exists());
    folder.make("data", &[SETTINGS, &maps]);
    folder.assert_same("whole", "data");
}

#[test]
fn folder_that_cannot_be_written_is_told() {
    let (folder, maps) = Folder::with_maps(1);
    fs::write(folder.path("file"), "").unwrap();
    let told = fail(&dataset(&maps, &folder.arg("file/data")));
    assert_told(&told, &["cannot create", "file/data"]);
}

#[test]
fn mounted_folder_that_is_read_only_is_told() {
    let (folder, maps) = Folder::with_maps(1);
    let read_only = folder.path("read-only");
    fs::create_dir(&read_only).unwrap();
    let script = format!(
        "mount -t tmpfs -o ro tmpfs '{}' && exec \"$0\" \"$@\"",
        read_only.display()
    );
    let output = mounting(&script, &dataset(&maps, &folder.arg("read-only/data")));
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert_told(&told, &["Read-only file system", "read-only/data"]);
}

#[cfg(unix)]
#[test]
fn map_that_vanishes_during_a_run_is_told_and_the_run_goes_on_when_it_is_back() {
    let (folder, maps) = Folder::with_maps(4);
    folder.make("whole", &[SETTINGS, &maps]);
    // Listed when the run begins, and not there when its turn comes.
    let gone = folder.path("maps/2.json");
    fs::remove_file(&gone).unwrap();
    std::os::unix::fs::symlink("nowhere.json", &gone).unwrap();
    let told = fail(&dataset(&maps, &folder.arg("data")));
    assert_told(
        &told,
        &["maps/2.json", "No such file", "2 whole maps are kept"],
    );
    assert!(!folder.path("data/manifest.json").exists());
    fs::remove_file(&gone).unwrap();
    fs::write(&gone, map(2)).unwrap();
    folder.make("data", &[SETTINGS, &maps]);
    folder.assert_same("whole", "data");
}

#[test]
fn map_cut_short_by_somebody_else_is_told_with_its_file() {
    let (folder, maps) = Folder::with_maps(2);
    folder.make("data", &[SETTINGS, &maps]);
    let array = folder.path("data/map_0001/aps_db.npy");
    let bytes = fs::read(&array).unwrap();
    fs::write(&array, &bytes[..bytes.len() - 1]).unwrap();
    let told = fail(&dataset(&maps, &folder.arg("data")));
    assert_told(&told, &["map_0001/aps_db.npy", "remove its map folder"]);
    fs::remove_dir_all(folder.path("data/map_0001")).unwrap();
    folder.make("data", &[SETTINGS, &maps]);
    assert_eq!(fs::read(&array).unwrap(), bytes);
}

#[test]
fn data_set_of_a_newer_format_is_refused_by_every_command() {
    let (folder, maps) = Folder::with_maps(1);
    folder.make("data", &[SETTINGS, &maps]);
    let manifest = folder.path("data/manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    let newer = text.replace("\"format_version\": 4", "\"format_version\": 5");
    fs::write(&manifest, newer).unwrap();
    let (data, other) = (folder.arg("data"), folder.arg("other"));
    for command in [
        dataset(&maps, &data),
        format!("info {data}"),
        format!("verify {data}"),
        format!("relabel {data} --out {other}"),
        format!("dataset merge {data} --out {other}"),
    ] {
        let told = fail(&command);
        assert!(told.contains("format version 5"), "{command}: {told}");
    }
}
