//! Reports of made-up results, of which it is known what they must say.
//!
//! The first test leaves its report in `benchmark-report` of the target directory's `tmp`, to be looked at in a browser.

mod fixture;

use std::fs;
use std::path::Path;

use aps_report::benchmark::{EntryKind, Failure, Results, write_report};
use fixture::{as_in_the_paper, results};

/// Report of results as Markdown.
fn markdown(results: &Results, folder: &Path) -> String {
    write_report(results, folder).unwrap();
    fs::read_to_string(folder.join("report.md")).unwrap()
}

#[test]
fn everything_is_written_and_well_formed() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("benchmark-report");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let results = results(&folder, &as_in_the_paper());
    results.save(&folder).unwrap();
    let files = write_report(&Results::load(&folder).unwrap(), &folder).unwrap();

    let mut names: Vec<_> = files
        .iter()
        .map(|f| f.strip_prefix(&folder).unwrap())
        .collect();
    let written = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), written, "two files of one name: {names:?}");
    for name in [
        "report.html",
        "report.md",
        "tables/table-1-paper.csv",
        "tables/table-1-released.csv",
        "tables/table-2-paper.csv",
        "tables/table-3-paper.csv",
        "tables/error-time-released.csv",
        "tables/by-peaks.csv",
        "figures/cossim-time-batch-256.svg",
        "figures/ple-time-batch-1.svg",
        "figures/rec-4-time-batch-256.svg",
        "figures/ple-ccdf.svg",
        "figures/cossim-sight.svg",
        "figures/example-3-worst-ablation.svg",
    ] {
        assert!(names.contains(&Path::new(name)), "no {name} in {names:?}");
    }
    for file in &files {
        let text = fs::read_to_string(file).unwrap();
        assert!(
            !text.contains("NaN") && !text.contains("inf,"),
            "{}",
            file.display()
        );
        match file.extension().unwrap().to_str().unwrap() {
            "svg" => assert!(
                roxmltree::Document::parse(&text).is_ok(),
                "{}",
                file.display()
            ),
            "csv" => {
                let rows: Vec<_> = csv::Reader::from_path(file).unwrap().records().collect();
                assert!(
                    !rows.is_empty() && rows.iter().all(Result::is_ok),
                    "{}",
                    file.display()
                );
            }
            _ => {}
        }
    }
    let html = fs::read_to_string(folder.join("report.html")).unwrap();
    let outside = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!outside.contains("http") && !outside.contains("<script") && !outside.contains("src="));
    assert!(html.contains("Someone's &lt;model&gt; &amp; co") && !html.contains("<model>"));
    // Files that the Markdown links to exist.
    let text = fs::read_to_string(folder.join("report.md")).unwrap();
    for link in text.split("](").skip(1).filter_map(|t| t.split(')').next()) {
        assert!(folder.join(link).is_file(), "{link}");
    }
}

#[test]
fn the_same_results_make_the_same_report() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path(), &as_in_the_paper());
    assert_eq!(
        markdown(&results, folder.path()),
        markdown(&results, folder.path())
    );
}

/// The line of the verdict on a finding.
#[track_caller]
fn verdict<'a>(text: &'a str, claim: &str) -> &'a str {
    let mut lines = text
        .lines()
        .filter(|l| l.starts_with("- **") && l.contains(claim));
    lines
        .next()
        .unwrap_or_else(|| panic!("no verdict on '{claim}' in {text}"))
}

#[test]
fn findings_of_the_paper_pass_in_results_made_like_them() {
    let folder = tempfile::tempdir().unwrap();
    let text = markdown(&results(folder.path(), &as_in_the_paper()), folder.path());
    for claim in [
        "MS-AReg is first",
        "Multi-scale encoding helps",
        "The training-only regularizer helps",
    ] {
        let line = verdict(&text, claim);
        assert!(line.starts_with("- **PASS** "), "{line}");
        assert!(line.ends_with("comparisons better, 0 worse"), "{line}");
    }
    let row = text
        .lines()
        .find(|l| l.starts_with("| MS-AReg | + + + | + + + |"));
    assert!(row.is_some(), "MS-AReg beats both baselines: {text}");
}

#[test]
fn findings_that_do_not_show_fail() {
    let folder = tempfile::tempdir().unwrap();
    let mut entries = as_in_the_paper();
    for entry in &mut entries {
        match entry.name {
            "MS-AReg" => (entry.places, entry.level) = (0.5, 0.4),
            "MS-MLP" => entry.places = 0.6,
            _ => {}
        }
    }
    let text = markdown(&results(folder.path(), &entries), folder.path());
    for claim in ["MS-AReg is first", "Multi-scale encoding helps"] {
        let line = verdict(&text, claim);
        assert!(line.starts_with("- **FAIL** "), "{line}");
        assert!(line.contains(": 0 of "), "{line}");
    }
    let line = verdict(&text, "The training-only regularizer helps");
    assert!(line.contains("2 of 4 comparisons better"), "{line}");
    let worse = text
        .lines()
        .filter(|l| l.starts_with("| 2 |") && l.ends_with("| worse |"));
    assert_eq!(worse.count(), 6, "{text}");
}

#[test]
fn a_model_that_does_not_beat_a_baseline_has_a_minus() {
    let folder = tempfile::tempdir().unwrap();
    let mut entries = as_in_the_paper();
    for entry in &mut entries {
        if entry.name == "ViT-Reg" {
            entry.places = 0.36;
        }
    }
    let text = markdown(&results(folder.path(), &entries), folder.path());
    let line = text
        .lines()
        .find(|l| l.starts_with("| ViT-Reg | + + + | \u{2212} "));
    assert!(line.is_some(), "{text}");
}

#[test]
fn equal_models_leave_the_question_open() {
    let folder = tempfile::tempdir().unwrap();
    let mut entries = as_in_the_paper();
    for entry in &mut entries {
        if entry.kind == EntryKind::Model || entry.kind == EntryKind::Ablation {
            (entry.places, entry.level) = (0.8, 0.8);
        }
    }
    let mut results = results(folder.path(), &entries);
    // Every model gets the scores of one entry: differences are exactly 0.
    let scores = results.entries[0].scores.clone();
    for entry in &mut results.entries[1..7] {
        entry.scores = scores.clone();
    }
    let text = markdown(&results, folder.path());
    assert_eq!(text.matches("- **OPEN** ").count(), 3, "{text}");
}

#[test]
fn what_was_not_run_is_said_to_be_missing() {
    let folder = tempfile::tempdir().unwrap();
    let entries: Vec<_> = as_in_the_paper()
        .into_iter()
        .filter(|e| ["ResNet-MLP", "MS-MLP", "mean spectrum"].contains(&e.name))
        .collect();
    let mut results = results(folder.path(), &entries);
    results.failed.push(Failure {
        name: "MS-AReg".into(),
        message: "the loss became infinite in epoch 2".into(),
    });
    let text = markdown(&results, folder.path());
    assert!(
        text.contains("- **FAIL** MS-AReg: the loss became infinite in epoch 2"),
        "{text}"
    );
    let line = verdict(&text, "Multi-scale encoding helps");
    assert!(
        line.starts_with("- **OPEN** ") && line.ends_with("no scores of Adv-MLP and MS-AReg"),
        "{line}"
    );
}

#[test]
fn an_empty_or_foreign_folder_is_an_error_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let error = Results::load(folder.path()).unwrap_err().to_string();
    assert!(error.contains("results.json"), "{error}");
    let mut results = results(folder.path(), &as_in_the_paper());
    fs::remove_file(folder.path().join(&results.entries[2].scores[0].file)).unwrap();
    let error = write_report(&results, folder.path())
        .unwrap_err()
        .to_string();
    assert!(error.contains("ResNet-MLP"), "{error}");
    results.links.clear();
    let error = write_report(&results, folder.path())
        .unwrap_err()
        .to_string();
    assert!(error.contains("no test links"), "{error}");
}

#[test]
fn results_of_a_later_format_are_refused_and_unknown_fields_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path(), &as_in_the_paper());
    let mut json = serde_json::to_value(&results).unwrap();
    json["colour"] = "green".into();
    json["machine"].as_object_mut().unwrap().remove("commit");
    json["entries"][0]
        .as_object_mut()
        .unwrap()
        .remove("substituted_links");
    let file = folder.path().join("results.json");
    fs::write(&file, json.to_string()).unwrap();
    assert_eq!(Results::load(folder.path()).unwrap(), results);
    json["format"] = 99.into();
    fs::write(&file, json.to_string()).unwrap();
    let error = Results::load(folder.path()).unwrap_err().to_string();
    assert!(error.contains("format 99"), "{error}");
}
