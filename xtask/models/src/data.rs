//! A data set as training and prediction need it: which maps, their condition images, the target.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use anyhow::{Context, Result, bail, ensure};
use aps_data::{Dataset, Split};
use aps_label::{MeanStd, Normalization, Protocol};
use aps_model::ANGLE_BINS;
use aps_model::candle_core::Device;
use aps_model::condition::{ConditionConfig, Conditions, Rasters};
use xtask::IdList;

/// Opens a data set whose labels a model can learn.
pub fn open(root: &Path) -> Result<Dataset> {
    let dataset = Dataset::open(root)?;
    let place = root.display();
    let Some(aps) = dataset.manifest().layout.aps else {
        bail!("data set '{place}' stores no angle power spectra; make it with --store aps");
    };
    let bins = aps.axis.count;
    ensure!(
        bins == ANGLE_BINS,
        "data set '{place}' has spectra of {bins} bins, the models predict {ANGLE_BINS}"
    );
    Ok(dataset)
}

/// What labels are made into, as `cargo xtask metrics` makes them: by the labels' own protocol and the statistics of the
/// training maps of the data set's split, whichever of them are then trained on.
pub fn target(dataset: &Dataset) -> Result<(Protocol, MeanStd, Normalization)> {
    let protocol = xtask::targets::protocol_of(dataset).unwrap_or(Protocol::Released);
    let train = xtask::targets::training_statistics(dataset)?;
    Ok((
        protocol,
        train,
        xtask::targets::normalization(protocol, train),
    ))
}

/// Condition images of some maps, with the place of each map among them.
pub fn conditions(
    dataset: &Dataset,
    maps: impl IntoIterator<Item = u32>,
    image_size: usize,
    device: &Device,
) -> Result<(Conditions, BTreeMap<u32, u32>)> {
    let grid = dataset.manifest().layout.raster;
    let (mut pixels, mut index_of) = (Vec::new(), BTreeMap::new());
    for id in maps {
        let map = dataset.map(id)?;
        index_of.insert(id, index_of.len() as u32);
        pixels.extend(map.buildings.pixels().iter().copied().map(f32::from));
    }
    let rasters = Rasters {
        pixels: &pixels,
        height: grid.height,
        width: grid.width,
        metres_per_pixel: grid.metres_per_pixel,
    };
    let config = ConditionConfig {
        image_size,
        ..ConditionConfig::default()
    };
    let conditions = Conditions::new(rasters, config, device).context("condition images")?;
    Ok((conditions, index_of))
}

/// A value of `--dev-maps`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DevMaps {
    /// `0-4,7`: these.
    Ids(IdList),
    /// `count:N`: so many.
    Count(usize),
}

impl FromStr for DevMaps {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.strip_prefix("count:") {
            None => Ok(Self::Ids(text.parse()?)),
            Some(count) => match count.parse() {
                Ok(count) if count > 0 => Ok(Self::Count(count)),
                _ => Err(format!("'{count}' is not a number of maps; try count:4")),
            },
        }
    }
}

/// The maps to train on and those to choose the model by; test maps are neither.
pub fn divide(split: &Split, chosen: Option<&DevMaps>) -> Result<(Vec<u32>, Vec<u32>)> {
    let mut pool = [split.train.as_slice(), &split.develop].concat();
    pool.sort_unstable();
    let develop = match chosen {
        None => split.develop.clone(),
        Some(DevMaps::Ids(IdList(ids))) => {
            if let Some(id) = ids.iter().find(|id| !pool.contains(id)) {
                bail!(
                    "--dev-maps names map {id}; development maps must be among the training maps {pool:?}"
                );
            }
            ids.clone()
        }
        // The split's own come first, then training maps from the end.
        Some(&DevMaps::Count(count)) => {
            let order = split.develop.iter().chain(split.train.iter().rev());
            let mut ids: Vec<u32> = order.copied().take(count).collect();
            ids.sort_unstable();
            ids
        }
    };
    ensure!(
        !develop.is_empty(),
        "the data set has no development maps to choose the best weights by; name some of {pool:?} with --dev-maps"
    );
    let train: Vec<u32> = pool
        .into_iter()
        .filter(|id| !develop.contains(id))
        .collect();
    ensure!(
        !train.is_empty(),
        "no map is left to train on beside the development maps {develop:?}"
    );
    Ok((train, develop))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(chosen: Option<&str>) -> Result<(Vec<u32>, Vec<u32>)> {
        let split = Split {
            train: vec![0, 1, 4, 5],
            develop: vec![2, 3],
            test: vec![6],
        };
        divide(&split, chosen.map(|text| text.parse().unwrap()).as_ref())
    }

    #[test]
    fn development_maps_are_held_out_of_the_training_maps() {
        assert_eq!(parts(None).unwrap(), (vec![0, 1, 4, 5], vec![2, 3]));
        assert_eq!(parts(Some("0,5")).unwrap(), (vec![1, 2, 3, 4], vec![0, 5]));
        assert_eq!(
            parts(Some("count:1")).unwrap(),
            (vec![0, 1, 3, 4, 5], vec![2])
        );
        assert_eq!(
            parts(Some("count:3")).unwrap(),
            (vec![0, 1, 4], vec![2, 3, 5])
        );
    }

    #[test]
    fn test_maps_are_never_developed_on() {
        assert!(
            parts(Some("2,6"))
                .unwrap_err()
                .to_string()
                .contains("map 6")
        );
        assert!(parts(Some("count:6")).is_err());
        assert!("count:x".parse::<DevMaps>().is_err());
    }
}
