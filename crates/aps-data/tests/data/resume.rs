use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use aps_data::{Access, Dataset, DatasetConfig, DatasetWriter, Error, Plan, Split, Survey};

use crate::sample::{self, LINKS, Rows};

fn names(root: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(root)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn dropped_map_leaves_nothing() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let mut map = writer.begin_map(0, &sample::input()).unwrap();
    map.push(&Rows::of(0, 0..3).as_rows()).unwrap();
    assert_eq!(names(root.path()).len(), 2);
    drop(map);
    assert_eq!(names(root.path()), [".lock"]);
}

#[test]
fn map_with_missing_links_is_refused_and_leaves_nothing() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let mut map = writer.begin_map(0, &sample::input()).unwrap();
    map.push(&Rows::of(0, 0..3).as_rows()).unwrap();
    assert_eq!(
        map.finish().unwrap_err().to_string(),
        "map 0: only 3 of its 6 links were written"
    );
    assert_eq!(names(root.path()), [".lock"]);
}

#[test]
fn a_map_begun_twice_is_written_by_whoever_is_first() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let begin = || writer.begin_map(0, &sample::input()).unwrap();
    let [mut first, mut second] = [begin(), begin()];
    for map in [&mut first, &mut second] {
        map.push(&Rows::of(0, 0..LINKS).as_rows()).unwrap();
    }
    first.finish().unwrap();
    assert!(second.finish().is_err());
    let dataset = writer.finish(&Split::of_maps([0], 0)).unwrap();
    assert_eq!(dataset.totals.links, LINKS as u64);
    assert!(Dataset::open(root.path()).unwrap().verify().is_empty());
}

#[test]
fn leftovers_of_a_killed_run_are_removed() {
    let root = tempfile::tempdir().unwrap();
    drop(sample::writer(&root));
    let partial = root.path().join(".map_0003.partial-4242");
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join("tx.npy"), b"half").unwrap();
    fs::write(root.path().join(".manifest.json.partial-4242"), b"{").unwrap();
    drop(sample::writer(&root));
    assert_eq!(names(root.path()), [".lock"]);
}

#[test]
fn resumed_run_skips_whole_maps_and_equals_an_undisturbed_one() {
    let (whole, resumed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let split = sample::write(whole.path());
    let writer = DatasetWriter::open(resumed.path(), sample::config()).unwrap();
    sample::write_map(&writer, 2, LINKS).unwrap();
    drop(writer); // killed after map 2
    let writer = DatasetWriter::open(resumed.path(), sample::config()).unwrap();
    assert_eq!(writer.map_ids(), [2]);
    for id in (0..4).filter(|&id| !writer.has_map(id)) {
        sample::write_map(&writer, id, LINKS).unwrap();
    }
    writer.finish(&split).unwrap();
    assert_eq!(
        sample::contents(whole.path()),
        sample::contents(resumed.path())
    );
}

#[test]
fn unfinished_data_set_tells_what_is_missing_until_it_is_finished() {
    let root = tempfile::tempdir().unwrap();
    assert!(matches!(
        Survey::of(root.path()),
        Err(Error::NotADataset { .. })
    ));
    let writer = sample::writer(&root);
    let plan = Plan {
        maps: vec![0, 1, 2, 3],
        shards: Some(2),
        command: ["make", "it"].map(Into::into).to_vec(),
    };
    writer.set_plan(&plan).unwrap();
    let survey = Survey::of(root.path()).unwrap();
    assert_eq!((survey.config, survey.plan), (None, Some(plan.clone())));
    sample::write_map(&writer, 2, LINKS).unwrap();
    let survey = Survey::of(root.path()).unwrap();
    assert_eq!(survey.missing(), [0, 1, 3]);
    assert_eq!(survey.config.as_ref(), Some(writer.config()));
    for id in survey.missing() {
        sample::write_map(&writer, id, LINKS).unwrap();
    }
    writer.finish(&Split::of_maps(0..4, 0)).unwrap();
    let survey = Survey::of(root.path()).unwrap();
    assert_eq!((survey.missing(), survey.plan), (vec![], None));
    assert_eq!(survey.manifest.unwrap().maps, survey.maps);
}

#[test]
fn finished_map_is_not_written_twice() {
    let root = sample::written();
    let writer = sample::writer(&root);
    let error = sample::write_map(&writer, 1, LINKS).unwrap_err();
    assert_eq!(
        error.to_string(),
        "map 1: already written; ask has_map first"
    );
}

/// Opens the sample data set with other settings; returns what the refusal says differs.
fn mismatch(change: fn(&mut DatasetConfig)) -> String {
    let root = sample::written();
    // Also without the manifest, as after a kill, the maps know their settings.
    fs::remove_file(root.path().join("manifest.json")).unwrap();
    let mut config = sample::config();
    change(&mut config);
    let error = DatasetWriter::open(root.path(), config).unwrap_err();
    assert!(matches!(error, Error::ConfigMismatch { .. }), "{error:?}");
    let message = error.to_string();
    let (_, differences) = message.split_once("other settings: ").unwrap();
    differences.split_once(';').unwrap().0.to_owned()
}

#[test]
fn other_settings_are_refused_by_name() {
    type Case = (fn(&mut DatasetConfig), &'static str);
    let cases: [Case; 4] = [
        (
            |config| config.configuration["tracer"]["max_reflections"] = 3.into(),
            "configuration.tracer.max_reflections is 2 there, 3 here",
        ),
        (
            |config| config.configuration["label"]["protocol"] = "released".into(),
            "configuration.label.protocol is \"paper\" there, \"released\" here",
        ),
        (
            |config| config.configuration["tracer"]["max_diffractions"] = 1.into(),
            "configuration.tracer.max_diffractions is nothing there, 1 here",
        ),
        (
            |config| (config.seed, config.layout.raster.width) = (1, 5),
            "layout.raster.width is 10 there, 5 here, seed is 18446744073709551615 there, 1 here",
        ),
    ];
    for (change, message) in cases {
        assert_eq!(mismatch(change), message);
    }
}

#[test]
fn settings_in_another_order_are_the_same() {
    let root = sample::written();
    let mut config = sample::config();
    config.configuration =
        serde_json::from_str(r#"{"label":{"spacing":1e-1,"protocol":"paper"},"tracer":{"frequency_hz":3500000000.0,"max_reflections":2}}"#)
            .unwrap();
    assert_eq!(
        DatasetWriter::open(root.path(), config).unwrap().map_ids(),
        [0, 1, 2, 3]
    );
}

#[test]
fn second_writer_is_refused_while_the_first_is_at_work() {
    let root = tempfile::tempdir().unwrap();
    let first = sample::writer(&root);
    assert!(matches!(
        DatasetWriter::open(root.path(), sample::config()),
        Err(Error::Locked { .. })
    ));
    let shard = Access::Shard { index: 0, count: 2 };
    let refused = DatasetWriter::open_with(root.path(), sample::config(), shard);
    assert!(matches!(refused, Err(Error::Locked { .. })));
    drop(first);
    sample::writer(&root);
}

#[test]
fn shards_side_by_side_equal_one_run() {
    let (whole, sharded) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let split = sample::write(whole.path());
    let open = |index| {
        let access = Access::Shard { index, count: 2 };
        DatasetWriter::open_with(sharded.path(), sample::config(), access)
    };
    let shards = [open(0).unwrap(), open(1).unwrap()];
    assert!(
        matches!(open(1), Err(Error::Locked { .. })),
        "the same shard twice"
    );
    for id in 0..4 {
        assert!(
            sample::write_map(&shards[1 - id as usize % 2], id, LINKS).is_err(),
            "a map of the other shard"
        );
        sample::write_map(&shards[id as usize % 2], id, LINKS).unwrap();
    }
    assert!(matches!(
        DatasetWriter::open(sharded.path(), sample::config()),
        Err(Error::Locked { .. })
    ));
    drop(shards);
    DatasetWriter::open(sharded.path(), sample::config())
        .unwrap()
        .finish(&split)
        .unwrap();
    assert_eq!(
        sample::contents(whole.path()),
        sample::contents(sharded.path())
    );
}

#[test]
fn shards_in_folders_of_their_own_join_into_one_run() {
    let folders = [(); 4].map(|()| tempfile::tempdir().unwrap());
    let [whole, even, odd, joined] = folders.each_ref().map(|folder| folder.path());
    let split = sample::write(whole);
    for (index, root) in [(0, even), (1, odd)] {
        let access = Access::Shard { index, count: 2 };
        let writer = DatasetWriter::open_with(root, sample::config(), access).unwrap();
        for id in (0..4).filter(|&id| access.covers(id)) {
            sample::write_map(&writer, id, LINKS).unwrap();
        }
    }
    let writer = DatasetWriter::open(joined, sample::config()).unwrap();
    for (part, ids) in [(odd, [1, 3]), (even, [0, 2])] {
        for id in ids {
            writer.adopt_map(part, id).unwrap();
        }
    }
    let again = writer.adopt_map(even, 2);
    assert!(matches!(again, Err(Error::Input { map: 2, .. })));
    writer.finish(&split).unwrap();
    assert_eq!(sample::contents(whole), sample::contents(joined));
}

#[test]
fn damaged_or_different_maps_are_not_adopted() {
    let (source, target) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    sample::write(source.path());
    let adopt =
        |writer: &DatasetWriter| (0..4).try_for_each(|id| writer.adopt_map(source.path(), id));
    let other = DatasetConfig {
        seed: 5,
        ..sample::config()
    };
    let writer = DatasetWriter::open(target.path(), other).unwrap();
    assert!(matches!(adopt(&writer), Err(Error::ConfigMismatch { .. })));
    drop(writer);
    let path = source.path().join("map_0001/rx.npy");
    sample::damage_end(&path);
    let writer = DatasetWriter::open(target.path(), sample::config()).unwrap();
    assert!(matches!(adopt(&writer), Err(Error::Checksum { .. })));
    assert_eq!(names(target.path()), [".lock", "map_0000"]);
}

#[test]
fn split_must_name_the_finished_maps() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    sample::write_map(&writer, 4, LINKS).unwrap();
    let error = writer
        .finish(&Split::of_maps([3], 0))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("not finished: [3], not in the split: [4]"),
        "{error}"
    );
    assert!(matches!(
        Dataset::open(root.path()),
        Err(Error::NotADataset { .. })
    ));
}

#[test]
fn folder_of_other_things_is_left_alone() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("thesis.tex"), b"").unwrap();
    let refused = DatasetWriter::open(root.path(), sample::config());
    assert!(matches!(refused, Err(Error::NotADataset { .. })));
    assert_eq!(names(root.path()), ["thesis.tex"]);
}

#[test]
fn a_lock_alone_makes_no_data_set() {
    for other in [OsStr::new("run.json"), OsStr::from_bytes(b"\xff")] {
        let root = tempfile::tempdir().unwrap();
        for name in [OsStr::new(".lock"), other] {
            fs::write(root.path().join(name), b"").unwrap();
        }
        let refused = DatasetWriter::open(root.path(), sample::config());
        assert!(
            matches!(refused, Err(Error::NotADataset { .. })),
            "{other:?}"
        );
    }
}

#[test]
fn folder_that_is_a_file_is_an_error_with_its_name() {
    let root = tempfile::tempdir().unwrap();
    let file = root.path().join("data");
    fs::write(&file, b"").unwrap();
    let error = DatasetWriter::open(&file, sample::config()).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with(&format!("cannot create {}", file.display())),
        "{error}"
    );
}
