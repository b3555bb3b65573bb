//! Reports of made-up results, of which it is known what they must say.
//!
//! The first test leaves its report in `benchmark-report` of the target directory's `tmp`, to be looked at in a browser.

mod fixture;

use std::fs;
use std::path::Path;

use aps_report::benchmark::{EntryKind, FORMAT, Failure, Results, write_report};
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

    let inside = |file| Path::strip_prefix(file, &folder).unwrap();
    let mut names: Vec<&Path> = files.iter().map(|file| inside(file)).collect();
    let written = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), written, "two files of one name: {names:?}");
    for name in [
        "report.html",
        "report.md",
        "tables/front.csv",
        "tables/scores-paper.csv",
        "tables/scores-released.csv",
        "tables/groups.csv",
        "tables/time.csv",
        "figures/cossim-training.svg",
        "figures/cossim-time.svg",
        "figures/rec-4-training.svg",
        "figures/rec-4-time.svg",
        "figures/link-worst-spectrum.svg",
    ] {
        assert!(names.contains(&Path::new(name)), "no {name} in {names:?}");
    }
    for file in &files {
        let (text, place) = (fs::read_to_string(file).unwrap(), file.display());
        assert!(!text.contains("NaN") && !text.contains("inf,"), "{place}");
        match file.extension().unwrap().to_str().unwrap() {
            "svg" => assert!(roxmltree::Document::parse(&text).is_ok(), "{place}"),
            "csv" => {
                let rows: Vec<_> = csv::Reader::from_path(file).unwrap().records().collect();
                let is_sound = !rows.is_empty() && rows.iter().all(Result::is_ok);
                assert!(is_sound, "{place}");
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
    let [first, again] = [(); 2].map(|()| markdown(&results, folder.path()));
    assert_eq!(first, again);
}

/// The rows of the table in front: those of the first table.
fn front(text: &str) -> Vec<Vec<&str>> {
    let rows = text.lines().skip_while(|line| !line.starts_with("| ---"));
    let rows = rows.skip(1).take_while(|line| line.starts_with('|'));
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

#[test]
fn one_table_tells_the_best_and_its_price() {
    let folder = tempfile::tempdir().unwrap();
    let text = markdown(&results(folder.path(), &as_in_the_paper()), folder.path());
    let rows = front(&text);
    assert_eq!(rows.len(), 12, "{rows:?}");
    assert!(rows.iter().all(|row| row.len() == 6));
    let best = [1, 4, 5].map(|column| rows[0][column]);
    for (cell, begins) in best.into_iter().zip(["0.9", "1.30", "60.0 s"]) {
        assert!(cell.starts_with(begins), "{begins}: {cell}");
    }
    let names: Vec<&str> = rows.iter().map(|row| row[0]).collect();
    assert_eq!(
        names[..3],
        ["MS-AReg", "Polar-Reg, shipped", "MS-AReg, shipped"]
    );
    assert_eq!(names[11], "mean spectrum");
    let conditions = fs::read_to_string(folder.path().join("tables/conditions.csv")).unwrap();
    assert!(conditions.contains(", by mean CosSim"), "{conditions}");
    // The rest is there for who asks, and no more than named here.
    assert!(text.contains("[groups.csv](tables/groups.csv)"), "{text}");
    assert_eq!(text.matches("\n| --- |").count(), 1, "{text}");
}

/// However many settings of the tracer and predictions from elsewhere are better.
#[test]
fn every_model_and_the_mean_spectrum_are_in_front_and_the_rest_is_folded() {
    let folder = tempfile::tempdir().unwrap();
    let mut entries = as_in_the_paper();
    entries.retain(|entry| entry.kind != EntryKind::External);
    let text = markdown(&results(folder.path(), &entries), folder.path());
    let rows = front(&text);
    let names: Vec<&str> = rows.iter().map(|row| row[0]).collect();
    assert_eq!((names.len(), names[0]), (12, "tracer, 3 interactions"));
    for entry in &entries {
        let is_first_of_all = entry.kind == EntryKind::Model || entry.name == "mean spectrum";
        let is_next = entry.kind == EntryKind::Shipped;
        assert!(!(is_first_of_all || is_next) || names.contains(&entry.name));
    }
    let others = fs::read_to_string(folder.path().join("tables/others.csv")).unwrap();
    let mut others = csv::Reader::from_reader(others.as_bytes());
    let others: Vec<String> = others.records().map(|r| r.unwrap()[0].to_owned()).collect();
    assert_eq!(
        others,
        [
            "strongest path",
            "tracer, 2 interactions",
            "tracer, 1 interaction",
            "tracer, 0 interactions",
            "line of sight"
        ]
    );
    assert_eq!(names.len() + others.len(), entries.len());
}

#[test]
fn weights_from_before_have_the_colour_of_their_model_and_a_ring() {
    let folder = tempfile::tempdir().unwrap();
    markdown(&results(folder.path(), &as_in_the_paper()), folder.path());
    let text = fs::read_to_string(folder.path().join("figures/cossim-time.svg")).unwrap();
    let picture = roxmltree::Document::parse(&text).unwrap();
    let class = |name: &str| {
        let of = |n: &roxmltree::Node<'_, '_>| n.has_tag_name("title") && n.text() == Some(name);
        let title = picture.descendants().find(of).unwrap();
        title.parent().unwrap().attribute("class").unwrap()
    };
    for model in ["MS-AReg", "Polar-Reg"] {
        let colour = class(model).strip_prefix("fill-").unwrap();
        assert!(colour.starts_with('s'), "{model}: {colour}");
        let ring = format!("paper stroke-{colour}");
        assert_eq!(class(&format!("{model}, shipped")), ring);
    }
}

#[test]
fn a_page_of_what_little_was_scored_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let mut entries = as_in_the_paper();
    entries.retain(|e| e.name == "mean spectrum");
    let mut results = results(folder.path(), &entries);
    results.examples.clear();
    results.failed.push(Failure {
        name: "MS-AReg".into(),
        message: "the loss became infinite in step 2".into(),
    });
    let text = markdown(&results, folder.path());
    let names: Vec<&str> = front(&text).iter().map(|row| row[0]).collect();
    assert_eq!(names, ["mean spectrum"]);
    let failed = "Failed: MS-AReg: the loss became infinite in step 2";
    assert!(text.contains(failed), "{text}");
}

#[test]
fn an_empty_or_foreign_folder_is_an_error_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let error = Results::load(folder.path()).unwrap_err().to_string();
    assert!(error.contains("results.json"), "{error}");
    let mut results = results(folder.path(), &as_in_the_paper());
    fs::remove_file(folder.path().join(&results.entries[2].scores[0].file)).unwrap();
    let refused = |results: &Results| write_report(results, folder.path()).unwrap_err();
    let error = refused(&results).to_string();
    assert!(error.contains("ResNet-MLP"), "{error}");
    results.links.clear();
    let error = refused(&results).to_string();
    assert!(error.contains("no test links"), "{error}");
}

#[test]
fn results_of_another_format_are_refused_and_unknown_fields_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path(), &as_in_the_paper());
    let mut json = serde_json::to_value(&results).unwrap();
    json["colour"] = "green".into();
    json["machine"].as_object_mut().unwrap().remove("commit");
    let entry = json["entries"][0].as_object_mut().unwrap();
    entry.remove("substituted_links");
    let file = folder.path().join("results.json");
    fs::write(&file, json.to_string()).unwrap();
    assert_eq!(Results::load(folder.path()).unwrap(), results);
    for format in [FORMAT - 1, 99] {
        json["format"] = format.into();
        fs::write(&file, json.to_string()).unwrap();
        let error = Results::load(folder.path()).unwrap_err().to_string();
        assert!(error.contains(&format!("format {format}")), "{error}");
    }
}

#[test]
fn a_smoke_test_says_so_and_recall_is_not_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut results = results(folder.path(), &as_in_the_paper());
    let text = markdown(&results, folder.path());
    assert!(!text.contains("smoke test") && text.contains("nearly flat"));
    results.profile = "smoke".into();
    let text = markdown(&results, folder.path());
    assert!(text.contains("smoke test") && text.contains("mean nothing"));
}
