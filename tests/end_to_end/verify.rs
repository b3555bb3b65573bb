//! `verify`: whatever is changed in a data set is found, also when the checksums were made to fit.

#[path = "../src/maps.rs"]
mod maps;

use std::fs;

use aps_data::{Dataset, Raster, RasterGrid, sha256_of};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{CityConfig, Location};

use crate::folder::{Folder, map};
use crate::{assert_told, succeed, xtask};

const SETTINGS: &str = "--profile full --tx-per-map 2 --rx-per-map 15 --store aps,pdp,paths --maps";

/// A folder with a data set in `data` of so many maps, and those.
fn made(count: u32) -> (Folder, String) {
    let (folder, maps) = Folder::with_maps(count);
    folder.make("data", &[SETTINGS, &maps]);
    (folder, maps)
}

/// The findings of a run that must have some.
#[track_caller]
fn findings(folder: &Folder, more: &str) -> Vec<String> {
    let output = xtask(&format!("verify {} {more}", folder.arg("data")));
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    let told = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<String> = told.lines().map(Into::into).collect();
    assert_told(&errors, &[&format!("{} findings in", lines.len())]);
    lines
}

/// Changes an array and lets the manifests say that it has always been so.
fn forge(folder: &Folder, array: &str, change: impl FnOnce(&mut [u8])) {
    let path = folder.path(&format!("data/{array}"));
    let mut bytes = fs::read(&path).unwrap();
    let before = sha256_of(&bytes);
    change(&mut bytes[128..]);
    fs::write(&path, &bytes).unwrap();
    let of_map = path.with_file_name("map.json");
    for manifest in [of_map, folder.path("data/manifest.json")] {
        let text = fs::read_to_string(&manifest).unwrap();
        // Another array may have the same bytes, and so the same checksum.
        let of_array = format!("\"{}\"", array.split('/').next_back().unwrap());
        let (head, tail) = text.split_at(text.find(&of_array).unwrap());
        assert!(tail.contains(&before));
        let forged = head.to_owned() + &tail.replacen(&before, &sha256_of(&bytes), 1);
        fs::write(&manifest, forged).unwrap();
    }
}

#[test]
fn sound_data_set_has_no_finding() {
    let (folder, maps) = made(3);
    let data = folder.arg("data");
    let told = succeed(&format!("verify {data} --maps {maps} --sample 90"));
    assert!(told.contains("90 links computed anew"), "{told}");
    assert_told(&succeed(&format!("verify {data}")), &["give --maps"]);
}

#[test]
fn synthetic_cities_are_made_anew() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS, "synthetic:2"]);
    let told = succeed(&format!("verify {} --sample 1000", folder.arg("data")));
    assert!(told.contains("as it should be"), "{told}");
}

#[test]
fn forged_label_is_found_by_computing_it_anew() {
    let (folder, maps) = made(1);
    let dataset = Dataset::open(folder.path("data")).unwrap();
    let link = dataset.map(0).unwrap().valid_links().nth(5).unwrap();
    // A level that nothing else depends on: 3 dB more.
    forge(&folder, "map_0000/aps_max_db.npy", |data| {
        let level = &mut data[4 * link..4 * link + 4];
        let db = f32::from_le_bytes((&*level).try_into().unwrap()) + 3.0;
        level.copy_from_slice(&db.to_le_bytes());
    });
    succeed(&format!("verify {}", folder.arg("data")));
    let found = findings(&folder, &format!("--maps {maps} --sample 30"));
    let (tx, rx) = (link / 15, link % 15);
    let expected = format!("map 0, link {link} (tx {tx}, rx {rx}): aps is not what its map gives");
    assert_eq!(found, [expected]);
}

#[test]
fn forged_path_is_found_by_computing_it_anew() {
    let (folder, maps) = made(1);
    forge(&folder, "map_0000/path_delay_s.npy", |data| data[0] ^= 1);
    let found = findings(&folder, &format!("--maps {maps} --sample 30"));
    assert_eq!(
        found,
        ["map 0, link 0 (tx 0, rx 0): paths are not what its map gives"]
    );
}

#[test]
fn forged_shape_is_found_by_the_statistics() {
    let (folder, _) = made(1);
    forge(&folder, "map_0000/aps_db.npy", |data| {
        // Some bin below the maximum, to 0 dB.
        let bin = data.chunks(2).position(|db| db != [0, 0]).unwrap();
        data[2 * bin..2 * bin + 2].copy_from_slice(&[0, 0]);
    });
    let found = findings(&folder, "");
    assert!(
        found[0].contains("statistics.") && found[0].contains("its arrays make"),
        "{found:?}"
    );
}

#[test]
fn link_that_ends_in_a_building_is_found_with_and_without_the_maps() {
    let (folder, maps) = made(1);
    // The middle of the first house of map 0.
    forge(&folder, "map_0000/tx.npy", |data| {
        data[..8].copy_from_slice(&55_f64.to_le_bytes());
        data[8..16].copy_from_slice(&70_f64.to_le_bytes());
    });
    let found = findings(&folder, "");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].contains("tx 0, which has 15 valid links")
            && found[0].contains("in a building, at (55, 70) m"),
        "{found:?}"
    );
    let found = findings(&folder, &format!("--maps {maps} --sample 0"));
    assert!(
        found[0].contains("in a building") && found[1].contains("positions are not"),
        "{found:?}"
    );
}

#[test]
fn other_maps_are_found() {
    let (folder, maps) = made(2);
    fs::write(folder.path("maps/1.json"), map(3)).unwrap();
    let found = findings(&folder, &format!("--maps {maps}"));
    assert!(
        found[0].contains("map 1: buildings are not those of the map given"),
        "{found:?}"
    );
}

/// Points where a terminal may stand are never taken for indoor ones, on synthetic cities, Helsinki and any map of the paper
/// that is there.
#[test]
fn no_outdoor_point_is_deep_inside_a_raster() {
    let synthetic = |seed| {
        let config = CityConfig {
            seed,
            ..CityConfig::default()
        };
        Scene::synthetic(&config).unwrap()
    };
    let real = maps::real_cities(&Vec::from_iter(0..51)).into_iter();
    let (mut outdoor, mut deep) = (0, 0);
    for scene in (0..5).map(synthetic).chain(real.map(|(_, scene)| scene)) {
        let in_numbers = |ring: &Vec<DVec2>| ring.iter().map(|p| p.to_array()).collect();
        let outlines: Vec<Vec<[f64; 2]>> = scene.outlines().iter().map(in_numbers).collect();
        let raster = Raster::of_outlines(&outlines, RasterGrid::default()).unwrap();
        for (x, y) in (0..256).flat_map(|x| (0..256).map(move |y| (f64::from(x), f64::from(y)))) {
            if scene.locate(DVec2::new(x, y)) == Location::Outdoor {
                outdoor += 1;
                deep += usize::from(raster.is_deep_inside([x, y]));
            }
        }
    }
    assert!(outdoor > 100_000);
    assert_eq!(deep, 0, "of {outdoor} outdoor points");
}
