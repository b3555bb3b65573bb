//! `dataset --shard` and `dataset merge`: many runs make what one would.

use std::fs;

use crate::folder::{Folder, assert_same, files};
use crate::{fail, succeed};

fn make(folder: &Folder, maps: &str, out: &str, more: &[&str]) -> String {
    let out = folder.arg(out);
    let fixed =
        "dataset --profile full --tx-per-map 2 --rx-per-map 9 --store aps,paths --threads 1";
    let fixed = fixed.split(' ').chain(["--maps", maps, "--out", &out]);
    succeed(&fixed.chain(more.iter().copied()).collect::<Vec<_>>())
}

#[test]
fn shards_in_folders_of_their_own_join_into_one_run() {
    let folder = Folder::new();
    let maps = folder.maps(7);
    make(&folder, &maps, "whole", &[]);
    for i in ["1", "2", "3"] {
        let told = make(&folder, &maps, i, &["--shard", &format!("{i}/3")]);
        assert!(told.contains("dataset merge"), "{told}");
    }
    assert!(!folder.path("1/manifest.json").exists());
    let parts = ["3", "1", "2"].map(|i| folder.arg(i));
    let [a, b, c] = parts.each_ref().map(String::as_str);
    succeed(&["dataset", "merge", a, b, c, "--out", &folder.arg("merged")]);
    assert_same(
        &files(&folder.path("whole")),
        &files(&folder.path("merged")),
    );
    // Once more there is nothing to do.
    succeed(&["dataset", "merge", a, b, c, "--out", &folder.arg("merged")]);
    assert_same(
        &files(&folder.path("whole")),
        &files(&folder.path("merged")),
    );
}

#[test]
fn shards_in_one_folder_are_joined_where_they_are() {
    let folder = Folder::new();
    let maps = folder.maps(5);
    make(&folder, &maps, "whole", &[]);
    for i in ["2/2", "1/2"] {
        make(&folder, &maps, "shared", &["--shard", i]);
    }
    succeed(&["dataset", "merge", "--out", &folder.arg("shared")]);
    assert_same(
        &files(&folder.path("whole")),
        &files(&folder.path("shared")),
    );
}

/// The commands that an error message ends with, as arguments of the runner.
fn commands(told: &str) -> Vec<Vec<&str>> {
    let lines = told
        .lines()
        .filter_map(|line| line.trim().strip_prefix("cargo xtask "));
    lines.map(|line| line.split(' ').collect()).collect()
}

#[test]
fn missing_shards_are_told_with_the_commands_that_make_them() {
    let folder = Folder::new();
    let maps = folder.maps(6);
    make(&folder, &maps, "whole", &[]);
    make(&folder, &maps, "part", &["--shard", "2/3"]);
    let (part, merged) = (folder.arg("part"), folder.arg("merged"));
    let told = fail(&["dataset", "merge", &part, "--out", &merged]);
    assert!(told.contains("maps [0, 2, 3, 5] are in none of"), "{told}");
    assert!(!folder.path("merged/manifest.json").exists());
    let commands = commands(&told);
    assert_eq!(commands.len(), 2, "{told}");
    for command in &commands {
        succeed(command);
    }
    let other = commands.iter().map(|command| *command.last().unwrap());
    let merge: Vec<&str> = ["dataset", "merge", &part]
        .into_iter()
        .chain(other)
        .chain(["--out", &merged])
        .collect();
    succeed(&merge);
    assert_same(
        &files(&folder.path("whole")),
        &files(&folder.path("merged")),
    );
}

#[test]
fn a_whole_run_that_has_not_finished_is_told_with_its_command() {
    let folder = Folder::new();
    let maps = folder.maps(3);
    make(&folder, &maps, "whole", &[]);
    make(&folder, &maps, "part", &["--shard", "1/1"]);
    fs::remove_dir_all(folder.path("part/map_0001")).unwrap();
    let part = folder.arg("part");
    let told = fail(&["dataset", "merge", "--out", &part]);
    assert!(told.contains("maps [1]"), "{told}");
    for command in commands(&told) {
        succeed(&command);
    }
    succeed(&["dataset", "merge", "--out", &part]);
    assert_same(&files(&folder.path("whole")), &files(&folder.path("part")));
}

#[test]
fn shards_of_different_settings_are_not_joined() {
    let folder = Folder::new();
    let maps = folder.maps(2);
    make(&folder, &maps, "1", &["--shard", "1/2"]);
    make(
        &folder,
        &maps,
        "2",
        &["--shard", "2/2", "--frequency-hz", "28e9"],
    );
    let [a, b] = ["1", "2"].map(|i| folder.arg(i));
    let told = fail(&["dataset", "merge", &a, &b, "--out", &folder.arg("merged")]);
    assert!(
        told.contains("configuration.trace.frequency_hz is 28000000000.0 there, 3500000000.0 here"),
        "{told}"
    );
}

#[test]
fn shards_that_are_none_are_told() {
    for shard in ["0/2", "3/2", "1", "a/b", "1/0"] {
        let told = fail(&["dataset", "--shard", shard]);
        assert!(told.contains("is not a shard"), "{shard}: {told}");
    }
    let folder = Folder::new();
    let told = fail(&["dataset", "merge", "--out", &folder.arg("new")]);
    assert!(told.contains("give the folders"), "{told}");
}
