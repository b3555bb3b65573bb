//! A data set as training and prediction need it: which maps, their condition images, the target.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use anyhow::{Context, Result, bail, ensure};
use aps_data::{Axis, Dataset, RasterGrid, Split};
use aps_label::{MeanStd, Normalization, Protocol};
use aps_model::candle_core::Device;
use aps_model::condition::{ConditionConfig, ModelInput, Rasters};
use aps_model::{ANGLE_BINS, ModelKind};
use serde_json::Value;
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

/// Reads the target that labels are made into, as in `cargo xtask metrics`: by the labels' own protocol and the statistics of
/// the training maps of the data set's split, whichever of them are then trained on.
pub fn target(dataset: &Dataset) -> Result<(Protocol, MeanStd, Normalization)> {
    let protocol = map2aps::targets::protocol_of(dataset).unwrap_or(Protocol::Released);
    let train = map2aps::targets::training_statistics(dataset)?;
    Ok((protocol, train, Normalization::of(protocol, train)))
}

/// Rasters of some maps, with the place of each map among them.
pub struct Buildings {
    pixels: Vec<f32>,
    grid: RasterGrid,
    /// Place of each map.
    pub index_of: BTreeMap<u32, u32>,
}

impl Buildings {
    /// Reads them.
    pub fn load(dataset: &Dataset, maps: impl IntoIterator<Item = u32>) -> Result<Self> {
        let (mut pixels, mut index_of) = (Vec::new(), BTreeMap::new());
        for id in maps {
            let map = dataset.map(id)?;
            index_of.insert(id, index_of.len() as u32);
            pixels.extend(map.buildings.pixels().iter().copied().map(f32::from));
        }
        Ok(Self {
            pixels,
            grid: dataset.manifest().layout.raster,
            index_of,
        })
    }

    /// Returns the rasters as `aps_model` takes them.
    pub fn rasters(&self) -> Rasters<'_> {
        Rasters {
            pixels: &self.pixels,
            height: self.grid.height,
            width: self.grid.width,
            metres_per_pixel: self.grid.metres_per_pixel,
        }
    }

    /// Prepares the input of a model for links on these maps, or on their mirror images too.
    pub fn input(
        &self,
        kind: ModelKind,
        mirrored: bool,
        image_size: usize,
        device: &Device,
    ) -> Result<Box<dyn ModelInput>> {
        let config = ConditionConfig {
            image_size,
            ..ConditionConfig::default()
        };
        let rasters = self.rasters();
        let made = match mirrored {
            false => kind.input(rasters, config, device),
            true => {
                let pixels = &rasters.mirrored();
                kind.input(Rasters { pixels, ..rasters }, config, device)
            }
        };
        made.context("condition images")
    }
}

/// For each bin of a data set's spectra the one at the negative of its angle, if the spectra are those of a linear array,
/// whose mirror images are known without tracing. `configuration` is the manifest's.
pub fn negated_bins(configuration: &Value, axis: Axis) -> Result<Vec<usize>> {
    let array = configuration.pointer("/label/array");
    let is_linear = array.is_some_and(|array| array.get("uniform_linear").is_some());
    ensure!(
        is_linear,
        "the spectra of mirrored maps follow without tracing for a uniform linear array only; this data set's array is {}; \
         train without --mirror",
        array.unwrap_or(&Value::Null)
    );
    let angles: Vec<f64> = axis.values().collect();
    let at = |angle: f64| angles.iter().position(|x| (x - angle).abs() < 1e-9);
    // The axis may hold 180 and -180 degrees, or one of them.
    let negated = |&angle: &f64| {
        let turns = [0.0, 360.0, -360.0];
        turns.iter().find_map(|turn| at(turn - angle))
    };
    let bins: Option<Vec<usize>> = angles.iter().map(negated).collect();
    bins.context(
        "the angles of this data set's spectra are not symmetric about zero; train without --mirror",
    )
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
    use aps_label::LabelConfig;
    use serde_json::json;

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
    fn each_bin_has_one_at_its_negative_angle() {
        let linear = json!({ "label": { "array": LabelConfig::released().array } });
        for axis in [Axis::ANGLE_RELEASED_DEG, Axis::ANGLE_PAPER_DEG] {
            let angles: Vec<f64> = axis.values().collect();
            let negated = negated_bins(&linear, axis).unwrap();
            let mut sorted = negated.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..axis.count));
            for (bin, &other) in negated.iter().enumerate() {
                let turns = (angles[bin] + angles[other]) / 360.0;
                assert!((turns - turns.round()).abs() < 1e-12, "{bin} and {other}");
            }
        }
        let half = Axis {
            start: 0.0,
            ..Axis::ANGLE_PAPER_DEG
        };
        let circular = json!({ "label": { "array": { "uniform_circular": { "elements": 8 } } } });
        for (configuration, axis) in [(&linear, half), (&circular, Axis::ANGLE_PAPER_DEG)] {
            let told = negated_bins(configuration, axis).unwrap_err().to_string();
            assert!(told.contains("--mirror"), "{told}");
        }
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
