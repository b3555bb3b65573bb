//! Progress, cancellation and errors of the library.

#[path = "../../../tests/files.rs"]
mod files;
#[path = "../src/synthetic.rs"]
mod synthetic;

use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use files::files;
use map2aps::maps::choose;
use map2aps::{
    Control, Dataset, DatasetPlan, Domain, Error, Examples, Export, ExportLayout, MapError,
    MapSource, Part, Place, Prediction, Progress, Scoring, SettingsError, Split, Stored, Truth,
    Verify, Work, aps_metrics, relabel,
};

fn plan() -> DatasetPlan {
    synthetic::plan(3, 2, 10)
}

/// Makes the data set of [`plan`].
fn made(folder: &Path) -> Dataset {
    synthetic::made(&plan(), folder, &[0, 1, 2])
}

/// Counts the calls, and cancels when a map begins.
#[derive(Default)]
struct Recorder {
    begun: Mutex<Option<Work>>,
    units: Mutex<u64>,
    maps: Mutex<Vec<u32>>,
    cancel: AtomicBool,
    cancel_at: Option<u32>,
}

impl Progress for Recorder {
    fn begin(&self, work: Work) {
        *self.begun.lock().unwrap() = Some(work);
    }

    fn map(&self, id: u32) {
        self.maps.lock().unwrap().push(id);
        if self.cancel_at == Some(id) {
            self.cancel.store(true, Ordering::Relaxed);
        }
    }

    fn advance(&self, units: u64) {
        *self.units.lock().unwrap() += units;
    }
}

impl Recorder {
    fn control(&self) -> Control<'_> {
        Control {
            progress: self,
            cancel: &self.cancel,
            ..Control::default()
        }
    }
}

#[test]
fn progress_adds_up_to_the_work_that_was_announced() {
    let folder = tempfile::tempdir().unwrap();
    let recorder = Recorder::default();
    let made = plan()
        .make(folder.path(), &[0, 1, 2], &recorder.control())
        .unwrap();
    let work = Work {
        units: 60,
        name: "links",
        finished_maps: 0,
        maps: 3,
    };
    assert_eq!(*recorder.begun.lock().unwrap(), Some(work));
    assert_eq!(*recorder.units.lock().unwrap(), 60);
    assert_eq!(*recorder.maps.lock().unwrap(), [0, 1, 2]);
    let links = made.maps.iter().map(|&(id, links, _)| (id, links));
    assert!(links.eq([(0, 20), (1, 20), (2, 20)]), "{:?}", made.maps);
}

#[test]
fn a_cancelled_data_set_keeps_whole_maps_and_the_same_call_continues_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, stopped) = (folder.path().join("whole"), folder.path().join("stopped"));
    made(&whole);
    let recorder = Recorder {
        cancel_at: Some(1),
        ..Recorder::default()
    };
    let error = plan()
        .make(&stopped, &[0, 1, 2], &recorder.control())
        .unwrap_err();
    assert!(error.is_cancelled(), "{error}");
    assert!(
        matches!(&error, Error::Interrupted { kept: 1, .. }),
        "{error:?}"
    );
    assert!(!stopped.join("manifest.json").exists());

    let recorder = Recorder::default();
    plan()
        .make(&stopped, &[0, 1, 2], &recorder.control())
        .unwrap();
    assert_eq!(recorder.begun.lock().unwrap().unwrap().finished_maps, 1);
    assert_eq!(*recorder.maps.lock().unwrap(), [1, 2]);
    assert!(files(&whole) == files(&stopped), "other bytes");
}

#[test]
fn every_long_operation_can_be_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (data, other) = (at("data"), at("other"));
    let plan = DatasetPlan {
        stored: Stored {
            paths: true,
            ..Stored::default()
        },
        ..plan()
    };
    plan.make(&data, &[0, 1, 2], &Control::default()).unwrap();
    let dataset = Dataset::open(&data).unwrap();
    let cancelled = Recorder::default();
    cancelled.cancel.store(true, Ordering::Relaxed);
    let control = cancelled.control();
    let results = [
        relabel(&dataset, &other, &plan.label, plan.stored, &control).err(),
        Export::new(ExportLayout::Released)
            .run(&dataset, &at("exported"), &control)
            .err(),
        Verify::default().run(&dataset, &control, &mut |_| {}).err(),
    ];
    for error in results {
        assert!(error.as_ref().is_some_and(Error::is_cancelled), "{error:?}");
    }
}

#[test]
fn errors_tell_what_and_where_by_their_types() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let dataset = made(&data);
    let (label, stored, control) = (plan().label, Stored::default(), Control::default());

    let error = relabel(&dataset, &data, &label, stored, &control).unwrap_err();
    assert!(
        matches!(error.cause(), Error::Settings(SettingsError::NoPaths)),
        "{error:?}"
    );

    let verify = Verify {
        maps: Some(MapSource::Folder(data.clone())),
        ..Verify::default()
    };
    let error = verify.run(&dataset, &control, &mut |_| {}).unwrap_err();
    assert!(
        matches!(error.cause(), Error::Map(MapError::OtherMaps { .. })),
        "{error:?}"
    );

    // Behind the place stands the cause.
    fs::write(folder.path().join("3.json"), "[]").unwrap();
    let plan = DatasetPlan {
        maps: MapSource::Folder(folder.path().into()),
        ..plan()
    };
    let error = plan.outlines(3).unwrap_err();
    assert!(
        matches!(error.cause(), Error::Map(MapError::NoBuilding)),
        "{error:?}"
    );
    let Error::At {
        place: Place::MapFile(file),
        ..
    } = &error
    else {
        panic!("{error:?}");
    };
    assert!(file.ends_with("3.json"));
    assert!(
        error.chain().ends_with("3.json': no building in it"),
        "{}",
        error.chain()
    );

    let (missing, available) = (vec![5], vec![0, 1]);
    let expected = MapError::Missing { missing, available };
    assert_eq!(choose(&[0, 1], &[5, 1]), Err(expected));
    assert_eq!(choose(&[0, 1, 2], &[2, 0, 2]), Ok(vec![0, 2]));
}

#[test]
fn plans_that_name_maps_twice_or_store_delay_profiles_need_no_care() {
    let folder = tempfile::tempdir().unwrap();
    let (once, twice) = (folder.path().join("once"), folder.path().join("twice"));
    let control = Control::default();
    let mut plan = plan();
    plan.stored.pdp = true;
    plan.make(&once, &[0, 1], &control).unwrap();
    plan.make(&twice, &[1, 0, 1], &control).unwrap();
    assert!(files(&once) == files(&twice), "other bytes");
    let dataset = Dataset::open(&once).unwrap();
    assert!(dataset.manifest().layout.pdp.is_some());

    let split = Split {
        train: vec![0, 1],
        develop: vec![],
        test: vec![1],
    };
    let error = plan.make_split(&once, &split, &control).unwrap_err();
    assert!(
        matches!(error.cause(), Error::Map(MapError::Twice(1))),
        "{error:?}"
    );
    plan.tx_per_map = usize::MAX;
    let error = plan.make(&folder.path().join("large"), &[0], &control);
    let error = error.unwrap_err();
    assert!(
        matches!(error.cause(), Error::Map(MapError::NoRoom { .. })),
        "{error:?}"
    );
}

#[test]
fn a_prediction_with_an_incomplete_row_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    made(folder.path());
    let mut truth = Truth::dataset(folder.path(), Part::Test, Domain::Linear).unwrap();
    let shape = truth.shape();
    let values = &vec![0.5; shape.samples * shape.bins + 1];
    let bins = shape.bins;
    let error = Scoring::default()
        .score(&mut truth, Prediction::Values { values, bins })
        .unwrap_err();
    assert!(
        matches!(
            error.cause(),
            Error::Metrics(aps_metrics::Error::IncompleteRow { .. })
        ),
        "{error:?}"
    );
}

#[test]
fn verification_counts_the_links_that_it_computes() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = made(folder.path());
    let verify = Verify {
        maps: Some(plan().maps),
        sample: Some(usize::MAX),
        ..Verify::default()
    };
    let verified = verify
        .run(&dataset, &Control::default(), &mut |_| {})
        .unwrap();
    assert_eq!((verified.findings, verified.sampled), (0, 60));
}

#[test]
#[should_panic(expected = "a value for each bin")]
fn a_row_of_another_length_takes_no_target() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = made(folder.path());
    let examples = Examples::load(&dataset, Part::Train, Domain::Linear).unwrap();
    let _ = examples.write_target(1, &mut vec![0.0; examples.bins() / 2]);
}
