//! `slurm`: its scripts, run by bash where no Slurm is. `tests/slurm.sh` runs them on a real one.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Output};

use crate::folder::Folder;
use crate::{assert_told, fail, succeed, xtask};

const SETTINGS: &str = "--profile full --tx-per-map 2 --rx-per-map 9";

/// Runs `slurm` for so many maps; returns its output.
fn campaign(folder: &Folder, maps: &str, more: &str) -> String {
    let out = folder.arg("shards");
    succeed(&format!(
        "slurm --nodes 2 {SETTINGS} --maps {maps} --out {out} {more}"
    ))
}

fn read(folder: &Folder, script: &str) -> String {
    fs::read_to_string(folder.path(&format!("shards-slurm/{script}"))).unwrap()
}

/// A program of the cluster that writes down its arguments.
fn stand_in(folder: &Folder, name: &str, says: &str) {
    let path = folder.path("bin").join(name);
    fs::create_dir_all(folder.path("bin")).unwrap();
    let log = folder.arg("called");
    fs::write(
        &path,
        format!("#!/bin/sh\necho {name} \"$@\" >> {log}\n{says}\n"),
    )
    .unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
}

fn called(folder: &Folder) -> String {
    fs::read_to_string(folder.path("called")).unwrap_or_default()
}

/// Runs a script as Slurm would run task `task`, started again so many times.
fn run(folder: &Folder, script: &str, task: u32, restarts: u32) -> Output {
    let path = std::env::var("PATH").unwrap();
    Command::new("bash")
        .arg(folder.path(&format!("shards-slurm/{script}")))
        .env("PATH", format!("{}:{path}", folder.arg("bin")))
        .env("SLURM_ARRAY_JOB_ID", "70")
        .env("SLURM_ARRAY_TASK_ID", task.to_string())
        .env("SLURM_RESTART_COUNT", restarts.to_string())
        .env("SLURM_CPUS_ON_NODE", "1")
        .output()
        .unwrap()
}

#[test]
fn tasks_and_merge_make_what_one_run_makes() {
    let (folder, maps) = Folder::with_maps(5);
    folder.make("whole", &[SETTINGS, "--maps", &maps]);

    campaign(&folder, &maps, "--tasks 3");
    for task in [2, 3, 1] {
        let output = run(&folder, "array.sh", task, 0);
        assert!(output.status.success(), "{output:?}");
    }
    let output = run(&folder, "merge.sh", 0, 0);
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("90 links computed anew"), "{said}");
    folder.assert_same("whole", "shards");
}

#[test]
fn a_failing_task_goes_back_alone_until_it_is_given_up() {
    let (folder, maps) = Folder::with_maps(3);
    campaign(&folder, &maps, "--tasks 3 --retries 2");
    stand_in(&folder, "scontrol", "");
    fs::remove_file(folder.path("maps/1.json")).unwrap();
    for restarts in [0, 1] {
        assert!(run(&folder, "array.sh", 2, restarts).status.success());
    }
    assert_eq!(called(&folder), "scontrol requeue 70_2\n".repeat(2));
    let output = run(&folder, "array.sh", 2, 2);
    assert!(!output.status.success());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("maps [1] are not there"), "{said}");
    assert!(said.contains("shard 2/3: exit code 1; given up"), "{said}");
    assert_eq!(called(&folder), "scontrol requeue 70_2\n".repeat(2));
}

#[test]
fn only_shards_that_lack_maps_are_asked_for_again() {
    let (folder, maps) = Folder::with_maps(8);
    let said = campaign(&folder, &maps, "");
    assert_told(&said, &["8 maps, 144 links; 8 of 8 tasks to do, 2 at once"]);
    assert!(read(&folder, "array.sh").contains("#SBATCH --array=1-8%2\n"));
    for task in [1, 4, 5] {
        assert!(run(&folder, "array.sh", task, 0).status.success());
    }
    campaign(&folder, &maps, "");
    assert!(read(&folder, "array.sh").contains("#SBATCH --array=2-3,6-8%2\n"));
    for task in [2, 3, 6, 7, 8] {
        assert!(run(&folder, "array.sh", task, 0).status.success());
    }
    assert_told(&campaign(&folder, &maps, ""), &["0 of 8 tasks"]);
    stand_in(&folder, "sbatch", "echo 71");
    assert!(run(&folder, "submit.sh", 0, 0).status.success());
    let merge = folder.path("shards-slurm/merge.sh");
    assert_eq!(
        called(&folder),
        format!("sbatch --parsable {}\n", merge.display())
    );
}

#[test]
fn the_merge_waits_for_all_tasks() {
    let (folder, maps) = Folder::with_maps(2);
    campaign(
        &folder,
        &maps,
        "--cpus 4 --sbatch=--partition=long --sbatch --account=radio",
    );
    stand_in(&folder, "sbatch", "echo '71;cluster'");
    let output = run(&folder, "submit.sh", 0, 0);
    assert!(output.status.success(), "{output:?}");
    let scripts = folder.arg("shards-slurm");
    assert_eq!(
        called(&folder),
        format!(
            "sbatch --parsable {scripts}/array.sh\n\
             sbatch --parsable --dependency=afterok:71 --kill-on-invalid-dep=yes {scripts}/merge.sh\n"
        )
    );
    for script in ["array.sh", "merge.sh"] {
        let text = read(&folder, script);
        assert!(
            text.contains("\n#SBATCH --partition=long\n#SBATCH --account=radio\n"),
            "{text}"
        );
    }
    assert!(read(&folder, "array.sh").contains("#SBATCH --cpus-per-task=4\n"));
}

#[test]
fn no_more_tasks_are_submitted_than_the_cluster_numbers() {
    let folder = Folder::new();
    let out = folder.arg("shards");
    let said = succeed(&format!(
        "slurm --nodes 300 --maps synthetic:5000 --profile full --out {out}"
    ));
    assert!(said.contains("1000 of 1000 tasks"), "{said}");
    assert!(read(&folder, "array.sh").contains("#SBATCH --array=1-1000%300\n"));

    let folder = Folder::new();
    let out = folder.arg("shards");
    let output = xtask(&format!(
        "slurm --nodes 300 --tasks 1200 --maps synthetic:5000 --profile full --out {out}"
    ));
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_told(&said, &["1200", "MaxArraySize"]);
    stand_in(&folder, "sbatch", "echo 71");
    for (limit, is_enough) in [("1001", false), ("1200", false), ("1201", true)] {
        stand_in(
            &folder,
            "scontrol",
            &format!("echo 'MaxArraySize            = {limit}'"),
        );
        let output = run(&folder, "submit.sh", 0, 0);
        assert_eq!(output.status.success(), is_enough, "{limit}: {output:?}");
        assert_eq!(called(&folder).contains("sbatch"), is_enough);
    }
    let remedy = format!("--tasks {} or less", 1001 - 1);
    stand_in(&folder, "scontrol", "echo 'MaxArraySize            = 1001'");
    let said = run(&folder, "submit.sh", 0, 0).stderr;
    assert!(String::from_utf8_lossy(&said).contains(&remedy), "{said:?}");
}

#[test]
fn what_every_task_would_refuse_is_refused_at_once() {
    let (folder, maps) = Folder::with_maps(3);
    let out = folder.arg("shards");
    let refused = |more: &str| fail(&format!("slurm --nodes 2 {more} --maps {maps} --out {out}"));
    assert_told(&refused("--tasks 4"), &["4 tasks for 3 maps"]);
    assert_told(&refused("--frequency-hz 0"), &["frequency"]);
    let told = refused("--map-ids 0-7");
    assert_told(&told, &["maps [3, 4, 5, 6, 7] are not there"]);
    assert!(!folder.path("shards-slurm").exists());
    succeed(&format!(
        "dataset --profile smoke --maps {maps} --out {out}"
    ));
    assert_told(&refused("--seed 1"), &["other settings"]);
}
