//! Data sets whose training maps are copied in other orientations.

#[path = "../src/synthetic.rs"]
mod synthetic;

use std::collections::BTreeSet;
use std::fs;

use map2aps::maps::{COPY_STRIDE, SceneSettings};
use map2aps::{Access, Control, Dataset, DatasetPlan, MapSource, Verify, merge};

fn plan() -> DatasetPlan {
    DatasetPlan {
        scene: SceneSettings {
            orientations: 8,
            ..SceneSettings::default()
        },
        ..synthetic::plan(3, 2, 10)
    }
}

#[test]
fn copies_of_training_maps_are_turned_and_stay_in_training() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = synthetic::made(&plan(), folder.path(), &[0, 1, 2]);
    let split = &dataset.manifest().split;
    let [map] = split.train[..1].try_into().unwrap();
    let copies: Vec<u32> = (0..8).map(|k| k * COPY_STRIDE + map).collect();
    assert_eq!(split.train, copies);
    assert_eq!((split.develop.len(), split.test.len()), (1, 1));

    // Corners of the buildings, in millimetres.
    let corners = |k: u32| -> BTreeSet<[i64; 2]> {
        let rings = plan().outlines(k * COPY_STRIDE + map).unwrap();
        let corners = rings.iter().flatten();
        corners
            .map(|p| p.map(|x| (x * 1e3).round() as i64))
            .collect()
    };
    let upright = corners(0);
    for k in 1..8 {
        let turned = |&[x, y]: &[i64; 2]| {
            let mirrored = if k >= 4 { [256_000 - x, y] } else { [x, y] };
            (0..k % 4).fold(mirrored, |[x, y], _| [256_000 - y, x])
        };
        assert_eq!(corners(k), upright.iter().map(turned).collect(), "{k}");
    }

    // The links are those of the turned maps: all are computed again.
    let mut found = Vec::new();
    let verify = Verify {
        maps: Some(plan().maps),
        sample: Some(200),
        ..Verify::default()
    };
    let verified = verify
        .run(&dataset, &Control::default(), &mut |finding| {
            found.push(finding)
        })
        .unwrap();
    assert_eq!((found, verified.sampled), (vec![], 200));
}

#[test]
fn shards_of_a_data_set_with_copies_join_to_the_bytes_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let maps = [0, 1, 2];
    plan()
        .make(&at("whole"), &maps, &Control::default())
        .unwrap();
    for index in 0..2 {
        let shard = Access::Shard { index, count: 2 };
        plan()
            .make_shard(&at("shards"), &maps, shard, &Control::default())
            .unwrap();
    }
    merge(&[], &at("shards"), &Control::default()).unwrap();
    let split = Dataset::open(at("whole")).unwrap().manifest().split.clone();
    let copy = split.train.last().unwrap();
    for name in ["manifest.json", &format!("map_{copy:04}/aps_db.npy")] {
        let read = |set: &str| fs::read(at(set).join(name)).unwrap();
        assert!(read("whole") == read("shards"), "{name}");
    }
}

#[test]
fn maps_that_take_a_copys_map_out_of_the_training_are_refused_before_they_are_made() {
    let folder = tempfile::tempdir().unwrap();
    let plan = DatasetPlan {
        scene: SceneSettings {
            orientations: 2,
            ..SceneSettings::default()
        },
        ..synthetic::plan(40, 1, 1)
    };
    let few = [0, 1, 2, 3];
    let dataset = synthetic::made(&plan, folder.path(), &few);
    let mut last = dataset.manifest().clone();
    // More maps until one of those is trained on no more.
    let grown = (5..40).find_map(|count| {
        let all: Vec<u32> = (0..count).collect();
        let made = plan.make(folder.path(), &all, &Control::default());
        if made.is_ok() {
            last = Dataset::open(folder.path()).unwrap().manifest().clone();
        }
        made.err().map(|error| (count, error.chain()))
    });
    let (count, told) = grown.expect("of forty maps others are trained on than of four");
    assert!(told.contains("are copies of maps"), "{told}");
    assert_eq!(*Dataset::open(folder.path()).unwrap().manifest(), last);
    assert!(!folder.path().join(format!("map_{:04}", count - 1)).exists());
}
