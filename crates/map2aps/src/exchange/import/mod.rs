//! The files of the published data as a data set.

mod buildings;
mod named;
mod propbin;
mod released;
mod samples;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use aps_data::released::LinkName;
use aps_data::{DatasetConfig, DatasetWriter, LinkRows, Links, MapInput, Totals, sha256_of};
use rayon::prelude::*;
use serde_json::Value;

use super::ExchangeError;
use crate::control::{Control, Work};
use crate::dataset::{Rows, or_kept};
use crate::error::{At, Place, Result};
use crate::maps::identity::{self, SOURCE};
use crate::maps::{MapError, MapSource, SceneSettings, split_of_imported};

use buildings::Buildings;
use named::{LinkFile, map_number};
pub use propbin::{ImportPropbin, LeftOut};
pub use released::ImportReleased;
pub use samples::ImportSamples;

/// Links read between two writes.
const LINKS_AT_ONCE: usize = 2048;

/// Result of an import.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Imported {
    /// Sums over the data set.
    pub totals: Totals,
    /// Entries that are no links or paths.
    pub left_out: LeftOut,
}

/// Makes those of the maps that are not there, and finishes the data set.
fn make<T>(
    out: &Path,
    config: DatasetConfig,
    maps: &BTreeMap<u32, Vec<T>>,
    given: Option<&MapSource>,
    control: &Control<'_>,
    mut map: impl FnMut(&DatasetWriter, u32, &[T]) -> Result<()>,
) -> Result<Imported>
where
    T: AsRef<Path>,
{
    let seed = config.seed;
    let writer = DatasetWriter::open(out, config).at_file(Place::Dataset, out)?;
    for (&id, files) in maps {
        control.check()?;
        let Some(there) = writer.entry(id) else {
            continue;
        };
        let other = |what: &str| MapError::OtherSource {
            id,
            what: what.into(),
            folder: out.into(),
        };
        let noted = &there.statistics[SOURCE];
        if !noted.is_null() && *noted != source(files)? {
            return Err(other("list of files").into());
        }
        if let Some(given) = given {
            let scene = given.load(id, seed, SceneSettings::default());
            let scene = scene.at(Place::Map(id))?;
            if let Some(what) = identity::contradicted(&there, &scene, given.raster())? {
                return Err(other(what).into());
            }
        }
    }
    let todo = || maps.iter().filter(|(id, _)| !writer.has_map(**id));
    if todo().next().is_some() {
        writer.set_plan(&control.plan(maps.keys().copied().collect(), None))?;
    }
    control.progress.begin(Work {
        units: todo().map(|(_, files)| files.len() as u64).sum(),
        name: "files",
        finished_maps: maps.len() - todo().count(),
        maps: maps.len(),
    });
    for (&id, files) in todo() {
        control.progress.map(id);
        or_kept(
            map(&writer, id, files).at(Place::Map(id)),
            &writer,
            out,
            control,
        )?;
    }
    let ids = writer.map_ids();
    Ok(Imported {
        totals: writer.finish(&split_of_imported(&ids, seed))?.totals,
        left_out: LeftOut::default(),
    })
}

/// Checksum of the names and sizes of the files that a map is made of, which the map keeps. It tells another source unless names and
/// sizes are the same.
fn source<T: AsRef<Path>>(files: &[T]) -> Result<Value> {
    let mut list = String::new();
    for path in files.iter().map(AsRef::as_ref) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let bytes = fs::metadata(path).at_file(Place::Reading, path)?.len();
        list.push_str(&format!("{bytes} {name}\n"));
    }
    Ok(sha256_of(list.as_bytes()).into())
}

/// Writes a map of links that are named after their ends, a file each, which `link` reads.
fn write_named(
    writer: &DatasetWriter,
    id: u32,
    files: &[LinkFile],
    buildings: &Buildings,
    control: &Control<'_>,
    link: impl Fn(&LinkFile) -> Result<Rows> + Send + Sync,
) -> Result<()> {
    let names: Vec<LinkName> = files.iter().map(|file| file.name).collect();
    let ends = Ends::of(&names);
    let layout = writer.config().layout;
    let input = MapInput {
        buildings: &buildings.image,
        tx_m: &ends.tx_m,
        rx_m: &ends.rx_m,
        links: Links::List(&ends.links),
    };
    let mut map = writer.begin_map(id, &input)?;
    for files in files.chunks(LINKS_AT_ONCE) {
        control.check()?;
        let links: Vec<Result<Rows>> = files.par_iter().map(&link).collect();
        let mut rows = Rows::default();
        for link in links {
            rows.append(link?);
        }
        map.push(&without_ends(rows.link_rows(&layout)))?;
        control.progress.advance(files.len() as u64);
    }
    buildings.check_ends(files.len())?;
    map.set_statistics(buildings.statistics(source(files)?));
    map.finish()?;
    Ok(())
}

/// Rows of links whose ends the map's list tells, and whose tracer is unknown.
fn without_ends(rows: LinkRows<'_>) -> LinkRows<'_> {
    LinkRows {
        links: None,
        fallback: None,
        ..rows
    }
}

/// Positions of the ends of some links, each once and in order, and the links as rows of these.
struct Ends {
    tx_m: Vec<[f64; 2]>,
    rx_m: Vec<[f64; 2]>,
    links: Vec<[u32; 2]>,
}

impl Ends {
    /// Collects the ends of the links with these sorted names.
    fn of(names: &[LinkName]) -> Self {
        let unique = |place: fn(&LinkName) -> [i32; 2]| {
            let mut places: Vec<[i32; 2]> = names.iter().map(place).collect();
            places.sort_unstable();
            places.dedup();
            places
        };
        let (tx, rx) = (unique(|n| n.tx_m), unique(|n| n.rx_m));
        let row = |places: &[[i32; 2]], place| {
            places.binary_search(&place).expect("it was collected") as u32
        };
        let metres = |places: &[[i32; 2]]| places.iter().map(|p| p.map(f64::from)).collect();
        let link = |n: &LinkName| [row(&tx, n.tx_m), row(&rx, n.rx_m)];
        Self {
            links: names.iter().map(link).collect(),
            tx_m: metres(&tx),
            rx_m: metres(&rx),
        }
    }
}

fn must_have_maps<T>(
    maps: &BTreeMap<u32, Vec<T>>,
    folder: &Path,
    expected: &'static str,
) -> Result<(), ExchangeError> {
    match maps.is_empty() {
        true => Err(ExchangeError::Nothing {
            folder: folder.into(),
            expected,
        }),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use aps_data::Dataset;
    use aps_data::propbin::{Propbin, Version};

    use super::*;
    use crate::maps::MapSource;
    use crate::{DatasetPlan, Export, ExportLayout, Verify, synthetic};

    /// Seed of the synthetic maps and of the imports.
    const SEED: u64 = 7;
    const SYNTHETIC: MapSource = MapSource::Synthetic { count: 2 };

    /// The labels of a data set of synthetic cities as published files, in the folder that is returned.
    fn released() -> (tempfile::TempDir, PathBuf, usize) {
        let root = tempfile::tempdir().unwrap();
        let [data, files] = ["data", "files"].map(|name| root.path().join(name));
        let plan = DatasetPlan {
            seed: SEED,
            stored: aps_data::Stored {
                paths: true,
                ..Default::default()
            },
            ..synthetic::plan(2, 2, 30)
        };
        let dataset = synthetic::made(&plan, &data, &[0, 1]);
        let export = Export::new(ExportLayout::Released);
        let exported = export.run(&dataset, &files, &Control::default()).unwrap();
        (root, files, exported.links)
    }

    fn import(folder: &Path, maps: Option<MapSource>) -> Result<Imported> {
        let out = tempfile::tempdir().unwrap();
        let import = ImportReleased {
            folder: folder.into(),
            maps,
            seed: SEED,
        };
        import.run(out.path(), &Control::default())
    }

    #[test]
    fn files_of_another_source_are_not_put_beside_those_of_the_first() {
        let (root, files, _) = released();
        let out = root.path().join("out");
        let run = |folder: &Path| {
            let import = ImportReleased {
                folder: folder.into(),
                maps: None,
                seed: SEED,
            };
            import.run(&out, &Control::default())
        };
        run(&files).unwrap();
        run(&files).unwrap();
        // One link less: another list of files of map 1.
        let folder = files.join("map_1/1_adps/aps");
        let mut entries = fs::read_dir(folder).unwrap();
        fs::remove_file(entries.next().unwrap().unwrap().path()).unwrap();
        for finished in [true, false] {
            if !finished {
                fs::remove_file(out.join("manifest.json")).unwrap();
                fs::remove_dir_all(out.join("map_0000")).unwrap();
            }
            let error = told(run(&files));
            assert!(
                error.contains("map 1 in") && error.contains("another source"),
                "{error}"
            );
        }
    }

    fn told(result: Result<Imported>) -> String {
        result.unwrap_err().chain()
    }

    #[test]
    fn zeros_before_numbers_do_not_hide_a_file_nor_make_two_links_of_one() {
        let (root, files, links) = released();
        let old = files.join("map_1/1_adps");
        let mut entries = fs::read_dir(old.join("aps")).unwrap();
        let aps = entries.next().unwrap().unwrap().path();
        let name = aps.file_name().unwrap().to_str().unwrap();
        let padded = name.replace("aps_1_", "aps_001_0");
        let renamed = aps.with_file_name(&padded);
        fs::copy(&aps, &renamed).unwrap();
        let error = told(import(&files, None));
        assert!(error.contains("are the same link"), "{error}");
        assert!(error.contains(name) && error.contains(&padded), "{error}");

        fs::remove_file(&aps).unwrap();
        let [pdp, other] =
            [name, &padded].map(|name| old.join("pdp").join(name.replace("aps_", "pdp_")));
        fs::rename(pdp, other).unwrap();
        fs::rename(&old, files.join("map_1/01_adps")).unwrap();
        fs::rename(files.join("map_1"), files.join("map_001")).unwrap();
        let imported = import(&files, None).unwrap();
        assert_eq!(
            (imported.totals.maps, imported.totals.links),
            (2, links as u64)
        );

        // A folder of something else, as of a date, may have any number.
        let date = files.join("map_20240101120000");
        fs::create_dir(&date).unwrap();
        import(&files, None).unwrap();

        let large = files.join("map_99999999999999");
        fs::rename(files.join("map_001"), &large).unwrap();
        let error = told(import(&files, None));
        assert!(
            error.contains("map_99999999999999") && error.contains("4294967295"),
            "{error}"
        );
        let propbin = ImportPropbin {
            source: large.join("source_0.propbin"),
            map_id: 0,
            maps: None,
            rx_per_map: None,
            label: Default::default(),
            stored: aps_data::Stored::default(),
            seed: SEED,
        };
        fs::write(&propbin.source, "").unwrap();
        let error = told(propbin.run(&root.path().join("out"), &Control::default()));
        assert!(error.contains("map_99999999999999"), "{error}");
        // Further above it is none of a map, and the number that is given holds.
        let inner = date.join("runs");
        fs::create_dir(&inner).unwrap();
        let mut file = Propbin::new(Version::Full, [0.0; 3]);
        file.add_receiver(7, [30.0, 20.0, 1.5], None, None);
        fs::write(inner.join("source_0.propbin"), file.to_bytes().unwrap()).unwrap();
        let propbin = ImportPropbin {
            source: inner,
            map_id: 5,
            ..propbin
        };
        let out = root.path().join("out");
        propbin.run(&out, &Control::default()).unwrap();
        assert_eq!(Dataset::open(&out).unwrap().manifest().maps[0].id, 5);
    }

    #[test]
    fn an_import_with_maps_is_verified_by_them() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("maps");
        fs::create_dir(&folder).unwrap();
        // A slit of a centimetre, which is filled.
        let houses = "[[[40, 40], [60, 40], [60, 60], [40, 60]], [[60.01, 40], [80, 40], [80, 60], [60.01, 60]]]";
        fs::write(folder.join("0.json"), houses).unwrap();
        let folder = MapSource::Folder(folder);
        for (maps, ids, name) in [(SYNTHETIC, &[0, 1][..], "cities"), (folder, &[0], "slit")] {
            let [data, files, out] =
                ["data", "files", "out"].map(|kind| root.path().join(format!("{name}-{kind}")));
            let plan = DatasetPlan {
                maps: maps.clone(),
                seed: SEED,
                stored: aps_data::Stored {
                    paths: true,
                    ..Default::default()
                },
                ..synthetic::plan(2, 2, 30)
            };
            let dataset = synthetic::made(&plan, &data, ids);
            let export = Export::new(ExportLayout::Released);
            export.run(&dataset, &files, &Control::default()).unwrap();
            let import = ImportReleased {
                folder: files,
                maps: Some(maps.clone()),
                seed: SEED,
            };
            import.run(&out, &Control::default()).unwrap();
            let verify = Verify {
                maps: Some(maps),
                ..Verify::default()
            };
            let mut found = Vec::new();
            let dataset = Dataset::open(&out).unwrap();
            let verified = verify.run(&dataset, &Control::default(), &mut |line| found.push(line));
            verified.unwrap();
            assert!(found.is_empty(), "{name}: {found:?}");
        }
    }

    #[test]
    fn labels_with_the_buildings_of_another_map_are_refused() {
        let (_root, files, links) = released();
        let imported = import(&files, Some(SYNTHETIC)).unwrap();
        assert_eq!(imported.totals.links, links as u64);
        // The cities of each other.
        for (from, to) in [("map_0", "aside"), ("map_1", "map_0"), ("aside", "map_1")] {
            fs::rename(files.join(from), files.join(to)).unwrap();
        }
        for (new, old) in [(0, 1), (1, 0)] {
            let map = files.join(format!("map_{new}"));
            fs::rename(
                map.join(format!("{old}_adps")),
                map.join(format!("{new}_adps")),
            )
            .unwrap();
            for kind in ["aps", "pdp"] {
                for entry in fs::read_dir(map.join(format!("{new}_adps/{kind}"))).unwrap() {
                    let path = entry.unwrap().path();
                    let name = path.file_name().unwrap().to_str().unwrap();
                    let [old, new] = [old, new].map(|id| format!("{kind}_{id}_"));
                    fs::rename(&path, path.with_file_name(name.replacen(&old, &new, 1))).unwrap();
                }
            }
        }
        let error = told(import(&files, Some(SYNTHETIC)));
        assert!(
            error.contains("inside a building of the map") && error.contains("of 60 links"),
            "{error}"
        );
    }
}
