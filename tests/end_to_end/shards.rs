//! `dataset --shard` and `dataset merge`: many runs make what one would.

use std::fs;

use crate::folder::Folder;
use crate::{fail, succeed};

const SETTINGS: &str =
    "--profile full --tx-per-map 2 --rx-per-map 9 --store aps,paths --threads 1 --maps";

#[test]
fn shards_in_folders_of_their_own_join_into_one_run() {
    let (folder, maps) = Folder::with_maps(7);
    folder.make("whole", &[SETTINGS, &maps]);
    for i in ["1", "2", "3"] {
        let told = folder.make(i, &[SETTINGS, &maps, &format!("--shard {i}/3")]);
        assert!(told.contains("dataset merge"), "{told}");
    }
    assert!(!folder.path("1/manifest.json").exists());
    let [a, b, c, merged] = ["3", "1", "2", "merged"].map(|name| folder.arg(name));
    // The second time there is nothing to do.
    for _ in 0..2 {
        succeed(&format!("dataset merge {a} {b} {c} --out {merged}"));
        folder.assert_same("whole", "merged");
    }
}

#[test]
fn shards_in_one_folder_are_joined_where_they_are() {
    let (folder, maps) = Folder::with_maps(5);
    folder.make("whole", &[SETTINGS, &maps]);
    for i in ["2/2", "1/2"] {
        folder.make("shared", &[SETTINGS, &maps, "--shard", i]);
    }
    succeed(&format!("dataset merge --out {}", folder.arg("shared")));
    folder.assert_same("whole", "shared");
}

/// Runs the commands that the error message of a refused merge ends with; returns the message and their number.
#[track_caller]
fn refused_and_followed(merge: &str) -> (String, usize) {
    let told = fail(merge);
    let lines = told.lines();
    let commands = lines.filter_map(|line| line.trim().strip_prefix("cargo xtask "));
    let count = commands.map(succeed).count();
    (told, count)
}

#[test]
fn missing_shards_are_told_with_the_commands_that_make_them() {
    let (folder, maps) = Folder::with_maps(6);
    folder.make("whole", &[SETTINGS, &maps]);
    folder.make("part", &[SETTINGS, &maps, "--shard 2/3"]);
    let (part, merged) = (folder.arg("part"), folder.arg("merged"));
    let merge = format!("dataset merge {part} --out {merged}");
    fail(&merge);
    assert!(!folder.path("merged/manifest.json").exists());
    let (told, commands) = refused_and_followed(&merge);
    assert!(told.contains("maps [0, 2, 3, 5] are in none of"), "{told}");
    assert_eq!(commands, 3, "{told}");
    folder.assert_same("whole", "merged");
}

#[test]
fn a_shard_missing_in_the_folder_of_the_result_is_made_there() {
    let (folder, maps) = Folder::with_maps(4);
    folder.make("whole", &[SETTINGS, &maps]);
    folder.make("shared", &[SETTINGS, &maps, "--shard 1/2"]);
    refused_and_followed(&format!("dataset merge --out {}", folder.arg("shared")));
    folder.assert_same("whole", "shared");
}

#[test]
fn a_whole_run_that_has_not_finished_is_told_with_its_command() {
    let (folder, maps) = Folder::with_maps(3);
    folder.make("whole", &[SETTINGS, &maps]);
    folder.make("part", &[SETTINGS, &maps, "--shard 1/1"]);
    fs::remove_dir_all(folder.path("part/map_0001")).unwrap();
    let part = folder.arg("part");
    let (told, _) = refused_and_followed(&format!("dataset merge --out {part}"));
    assert!(told.contains("maps [1]"), "{told}");
    folder.assert_same("whole", "part");
}

#[test]
fn shards_of_different_settings_are_not_joined() {
    let (folder, maps) = Folder::with_maps(2);
    folder.make("1", &[SETTINGS, &maps, "--shard 1/2"]);
    folder.make("2", &[SETTINGS, &maps, "--shard 2/2 --frequency-hz 28e9"]);
    let [a, b, merged] = ["1", "2", "merged"].map(|name| folder.arg(name));
    let told = fail(&format!("dataset merge {a} {b} --out {merged}"));
    let difference = "configuration.trace.frequency_hz is 28000000000.0 there, 3500000000.0 here";
    assert!(told.contains(difference), "{told}");
}

#[test]
fn shards_that_are_none_are_told() {
    for shard in ["0/2", "3/2", "1", "a/b", "1/0"] {
        let told = fail(&format!("dataset --shard {shard}"));
        assert!(told.contains("is not a shard"), "{shard}: {told}");
    }
    let folder = Folder::new();
    let told = fail(&format!("dataset merge --out {}", folder.arg("new")));
    assert!(told.contains("give the folders"), "{told}");
}
