//! The data set of a benchmark.

use std::path::Path;

use aps_data::Split;
use aps_label::LabelConfig;
use map2aps::maps::{NamedMaps, TileSettings};
use map2aps::{Dataset, DatasetPlan, training};
use serde_json::json;

use crate::config::{Config, DataConfig};
use crate::error::{Error, Result};
use crate::part::{Part, State};
use crate::watch::{Event, Watch};

/// Plans the data set, and splits its maps into maps for training, development and test.
pub fn plan(config: &Config) -> Result<(DatasetPlan, Split)> {
    let data = &config.data;
    let maps: NamedMaps = data
        .maps
        .parse()
        .map_err(|e| Error::Setting(format!("data.maps: {e}")))?;
    if let NamedMaps::City(_) = maps {
        let told = "a city in GeoJSON cannot be benchmarked on directly: give a folder of maps, or synthetic; on a city run \
                    dataset, train, predict and metrics";
        return Err(Error::Setting(told.into()));
    }
    let counts = [data.train_maps, data.develop_maps, data.test_maps];
    let mut counts = counts.into_iter();
    let asked = counts.try_fold(0_u32, |sum, n| sum.checked_add(n.try_into().ok()?));
    let too_many =
        "data.train_maps, data.develop_maps and data.test_maps are 2^32 or more together";
    let asked = asked.ok_or_else(|| Error::Setting(too_many.into()))?;
    let maps = maps.open(TileSettings::default(), asked)?;
    let split = split(&maps.ids()?, data)?;
    let plan = DatasetPlan {
        maps,
        tx_per_map: data.tx_per_map,
        rx_per_map: data.rx_per_map,
        label: LabelConfig::of(data.protocol),
        seed: config.seed,
        trace: data.limits.config(),
        ..DatasetPlan::default()
    };
    Ok((plan, split))
}

/// Opens the data set of a part's folder; first makes the maps that it lacks, all of them if `fresh`. Whole maps are kept when it is
/// cancelled.
pub fn open(
    plan: &DatasetPlan,
    split: &Split,
    folder: &Path,
    fresh: bool,
    watch: Watch<'_>,
) -> Result<(Part, Dataset)> {
    let maps = [&split.train[..], &split.develop, &split.test].concat();
    let settings = json!({
        "buildings": plan.buildings_sha256(&maps)?,
        "split": split,
        "seed": plan.seed,
        "settings": plan.config().configuration,
    });
    let part = Part::new(folder.into(), settings);
    if part.is_of_others() {
        watch.tell(Event::DataReplaced(&part.folder));
    }
    let state = part.open(fresh, watch)?;
    // Maps of an unfinished data set are kept in a folder of their own, beside the stamp.
    let folder = part.folder.join("dataset");
    if state != State::Finished {
        plan.make_split(&folder, split, &watch.control())?;
        watch.tell(Event::DataReady);
        part.finish()?;
    }
    Ok((part, training::open(&folder)?))
}

/// Tells if these are the name of synthetic cities.
pub fn is_synthetic(maps: &str) -> bool {
    matches!(maps.parse(), Ok(NamedMaps::Synthetic { .. }))
}

/// Splits maps. If they are the paper's, test maps are taken from its own, 46 to 50, else from the end. Training maps are the first of the
/// others, development maps the next ones.
fn split(available: &[u32], data: &DataConfig) -> Result<Split> {
    let is_papers = available.iter().all(|&id| id <= 50)
        && available.iter().any(|&id| id <= 45)
        && available.iter().any(|&id| id > 45);
    let cut = match is_papers && !is_synthetic(&data.maps) {
        true => available.partition_point(|&id| id <= 45),
        false => available.len().saturating_sub(data.test_maps),
    };
    let (pool, test) = available.split_at(cut);
    let used = data.train_maps + data.develop_maps;
    for (keys, needed, there) in [
        ("train_maps and data.develop_maps", used, pool.len()),
        ("test_maps", data.test_maps, test.len()),
    ] {
        if needed > there {
            let told = format!(
                "data.{keys} ask for {needed} maps, '{}' has {there} for them; ask for fewer or give more",
                data.maps
            );
            return Err(Error::Setting(told));
        }
    }
    Ok(Split {
        train: pool[..data.train_maps].to_vec(),
        develop: pool[data.train_maps..used].to_vec(),
        test: test[..data.test_maps].to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Profile;

    fn data(maps: &str, counts: [usize; 3]) -> DataConfig {
        let config = Config::resolve(Profile::Smoke, None, toml::Table::new()).unwrap();
        DataConfig {
            maps: maps.into(),
            train_maps: counts[0],
            develop_maps: counts[1],
            test_maps: counts[2],
            ..config.data
        }
    }

    #[test]
    fn papers_maps_are_tested_on_the_papers_test_maps() {
        let all: Vec<u32> = (0..=50).collect();
        let split = split(&all, &data("maps", [3, 1, 2])).unwrap();
        assert_eq!(
            (split.train, split.develop, split.test),
            (vec![0, 1, 2], vec![3], vec![46, 47])
        );
    }

    #[test]
    fn other_maps_are_tested_on_the_last_ones() {
        let all: Vec<u32> = (100..110).collect();
        let split = split(&all, &data("maps", [7, 1, 2])).unwrap();
        assert_eq!((split.develop, split.test), (vec![107], vec![108, 109]));
    }

    #[test]
    fn too_few_maps_are_told_with_their_number() {
        let all: Vec<u32> = (0..=50).collect();
        let error = split(&all, &data("maps", [46, 1, 5])).unwrap_err();
        assert!(
            error.to_string().contains("47") && error.to_string().contains("46"),
            "{error}"
        );
        assert!(split(&all, &data("maps", [40, 1, 6])).is_err());
    }
}
