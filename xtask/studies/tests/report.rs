//! `cargo xtask report` at its smallest: what is written, and how studies are joined. Never times.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use aps_report::chart::{Axis, Chart};
use aps_report::document::Verdict;
use clap::ValueEnum;
use tempfile::TempDir;
use xtask_studies::{Conditions, Profile, Study, StudyName, join};

/// The command at its smallest, with the words of a line.
fn report(line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask-studies"));
    command.args(["report", "--profile", "smoke"]);
    command.args(line.split_whitespace());
    command
}

#[track_caller]
fn succeed(mut command: Command) -> String {
    let output = command.output().expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

fn folder() -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().to_str().unwrap().to_owned();
    (folder, name)
}

/// Files of the folder of studies.
fn files(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder.join("numerics")).unwrap();
    let name =
        |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    entries.map(name).collect()
}

/// Writes a study of another program, with a figure.
fn write_foreign(folder: &Path, stem: &str) {
    let mut study = Study::new("models", "From | elsewhere");
    study.place = 4;
    study
        .section
        .verdict(Verdict::decided(true, "A <b>bold</b> claim", ""));
    let chart =
        Chart::new(Axis::log("time [ms]"), Axis::log("error")).line("a", [[1.0, 0.5], [2.0, 0.25]]);
    study.figure(stem, "Error.", chart.draw());
    let conditions = Conditions::now(Profile::Smoke, 1, "cargo xtask elsewhere");
    study.write(folder, conditions).unwrap();
}

#[test]
fn every_study_is_written_whole_and_joined() {
    let (folder, out) = folder();
    let own = StudyName::value_variants().iter();
    let own = own.filter(|study| **study != StudyName::Models);
    let own: Vec<String> = own.map(|study| study.name()).collect();
    let asked: String = own.iter().map(|name| format!("--study {name} ")).collect();
    succeed(report(&format!("--out {out} {asked}")));
    let text = fs::read_to_string(folder.path().join("numerics.md")).unwrap();
    assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
    assert!(text.contains("profile smoke"), "a report of smoke says so");
    let found = files(folder.path());
    for name in &own {
        let own = |extension: &str| {
            let is_own = |f: &&String| f.starts_with(name) && f.ends_with(extension);
            found.iter().filter(is_own).count()
        };
        assert!(found.contains(&format!("{name}.json")), "{found:?}");
        assert!(own(".csv") > 0, "{name} has no data: {found:?}");
        assert!(text.contains(&format!(
            "cargo xtask report --study {name} --profile smoke --seed 42"
        )));
    }
    for file in &found {
        let path = folder.path().join("numerics").join(file);
        let content = fs::read_to_string(&path).unwrap();
        match path.extension().unwrap().to_str().unwrap() {
            "svg" => {
                assert!(roxmltree::Document::parse(&content).is_ok(), "{file}");
                assert!(!content.contains("NaN"), "{file}");
            }
            "csv" => {
                let mut reader = csv::Reader::from_reader(content.as_bytes());
                let rows = reader.records().map(Result::unwrap).count();
                assert!(rows > 0, "{file} is empty");
                assert!(
                    !content.contains("NaN") && !content.contains("inf"),
                    "{file}"
                );
            }
            _ => {}
        }
    }
    // Every file that the document links to exists, and every file there has a link.
    let links: BTreeSet<&str> = text
        .split("](numerics/")
        .skip(1)
        .filter_map(|t| t.split(')').next())
        .collect();
    let shown: BTreeSet<&str> = found
        .iter()
        .map(|f| &**f)
        .filter(|f| !f.ends_with(".json"))
        .collect();
    assert_eq!(links, shown);
}

#[test]
fn a_study_from_elsewhere_keeps_its_place_beside_a_new_run() {
    let (folder, out) = folder();
    let studies = folder.path().join("numerics");
    write_foreign(&studies, "time");
    succeed(report(&format!("--study diffraction --out {out}")));
    let text = fs::read_to_string(folder.path().join("numerics.md")).unwrap();
    let place = |words: &str| {
        let found = text.find(words);
        found.unwrap_or_else(|| panic!("no {words} in {text}"))
    };
    assert!(place("## Diffraction") < place("## From \\| elsewhere"));
    place("A &lt;b&gt;bold&lt;/b&gt; claim");
    place("numerics/models-time.svg");
    assert!(
        !text.contains("## Tracer"),
        "a study that never ran is not there"
    );
}

/// The study of models is another program's: it is built and given what it needs, after the others are published.
#[cfg(unix)]
#[test]
fn the_study_of_models_is_handed_over() {
    use std::os::unix::fs::PermissionsExt;

    let (folder, out) = folder();
    let cargo = folder.path().join("cargo");
    fs::write(&cargo, "#!/bin/sh\nprintf '%s\\n' \"$@\"\n").unwrap();
    fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).unwrap();
    let run = |line: &str| -> String {
        let mut command = report(&format!("{line} --out {out}"));
        command.env("CARGO", &cargo);
        succeed(command).replace('\n', " ")
    };
    let own = ["run", "--release", "--package", "xtask-models"].join(" ");
    let alone = run("--study models --seed 7 --work w");
    assert!(alone.starts_with(&own), "{alone}");
    let given = format!("-- report --profile smoke --seed 7 --out {out} --work w ");
    assert!(alone.ends_with(&given), "{alone}");
    assert!(!folder.path().join("numerics.md").exists());

    let both = run("--study models --study rounding");
    let report = folder.path().join("numerics.md");
    let published = format!("report '{}' {own}", report.display());
    assert!(both.starts_with(&published), "{both}");
    assert!(report.is_file());
}

#[test]
fn a_study_measured_anew_leaves_no_file_of_its_last_run() {
    let (folder, _) = folder();
    write_foreign(folder.path(), "old");
    write_foreign(folder.path(), "new");
    assert!(!folder.path().join("models-old.svg").exists());
    assert!(folder.path().join("models-new.svg").is_file());
}

#[test]
fn studies_that_cannot_be_read_are_named() {
    let (folder, _) = folder();
    let at = folder.path();
    let error = |folder: &Path| format!("{:#}", join(folder, "numerics").unwrap_err());
    assert!(error(at).contains("holds none"), "{}", error(at));
    write_foreign(at, "time");
    let json = fs::read_to_string(at.join("models.json")).unwrap();
    let write = |text: &str| fs::write(at.join("models.json"), text).unwrap();
    write(&json.replace("\"format\": 2", "\"format\": 99"));
    assert!(error(at).contains("format 99"), "{}", error(at));
    write(&json.replace("models-time.svg", "../models-time.svg"));
    assert!(error(at).contains("not one of its own"), "{}", error(at));
    write(&json[..json.len() / 2]);
    assert!(error(at).contains("models.json"), "{}", error(at));
    write(&json);
    fs::remove_file(at.join("models-time.svg")).unwrap();
    assert!(
        error(at).contains("lacks its file 'models-time.svg'"),
        "{}",
        error(at)
    );
}

#[test]
fn maps_that_cannot_be_used_are_refused_before_anything_is_measured() {
    let (_keep, out) = folder();
    for (maps, told) in [
        ("--ids 3", "--ids"),
        ("--maps city.geojson", "folder of RadioMapSeer"),
        ("--maps no/such/folder", "no/such/folder"),
    ] {
        let mut command = report(&format!("--study tracer --out {out} {maps}"));
        let output = command.output().unwrap();
        assert!(!output.status.success(), "{maps} succeeded");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(stderr.contains(told), "{maps}: {stderr}");
    }
}
