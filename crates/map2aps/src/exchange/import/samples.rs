//! Preprocessed samples: normalised labels with their condition images.
//!
//! A sample has lost its level and its scale: aps_norm = (p - mean) / deviation of the relative power p. The level is
//! set to 0 dB, and the scale such that the weakest bin has no power, which a spectrum with a deep null comes close to.
//! Normalised again, the label is the same up to rounding; decibels are good near the maximum and mean nothing 60 dB
//! below.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use aps_data::released::{LinkName, Sample};
use aps_data::{
    Axis, DatasetConfig, Layout, LinkStatus, Precision, ProfileLayout, Raster, RasterGrid,
};
use aps_label::LabelConfig;
use serde_json::json;

use super::{ExchangeError, Imported, make, must_have_maps, named_files, write_named};
use crate::control::Control;
use crate::dataset::Rows;
use crate::error::{At, Place, Result};

/// Power of a bin without power, relative to the maximum \[dB\]: the floor of the label.
const NO_POWER_DB: f64 = -350.0;

/// Import of normalised labels with condition images in `samples/aps_*.npz`.
#[derive(Debug, Clone)]
pub struct ImportSamples {
    /// Folder that holds `samples`.
    pub folder: PathBuf,
    /// Seed of the split.
    pub seed: u64,
}

impl ImportSamples {
    /// Makes a data set in the folder `out`. Maps that it holds already are kept.
    ///
    /// # Errors
    /// Files that are not there, cannot be read or are not of this form, a folder with another data set, and
    /// cancellation.
    pub fn run(&self, out: &Path, control: &Control<'_>) -> Result<Imported> {
        let mut maps: BTreeMap<u32, Vec<LinkName>> = BTreeMap::new();
        for name in named_files(&self.folder.join("samples"), "aps_", ".npz")? {
            maps.entry(name.map).or_default().push(name);
        }
        let expected = "files samples/aps_N_TXX_TXY_RXX_RXY.npz";
        must_have_maps(&maps, &self.folder, expected)?;
        let first = maps.values().flatten().next().expect("there is a map");
        let first = self.read(first)?;
        let layout = Layout {
            raster: RasterGrid {
                width: first.size[1],
                height: first.size[0],
                metres_per_pixel: 1.0,
            },
            aps: Some(ProfileLayout {
                dtype: Precision::F32,
                ..ProfileLayout::over(Axis {
                    count: first.aps_norm.len(),
                    ..Axis::ANGLE_RELEASED_DEG
                })
            }),
            pdp: None,
            paths: false,
        };
        let config = DatasetConfig {
            seed: self.seed,
            layout,
            configuration: json!({ "import": "samples", "label": LabelConfig::released() }),
        };
        make(out, config, &maps, control, |writer, id, names| {
            let buildings = buildings_of(&self.read(&names[0])?, layout.raster);
            let buildings = buildings.at(Place::LinkName(names[0]))?;
            let link = |name: &LinkName| {
                let rows = self.link(name, &layout, &buildings);
                rows.at(Place::LinkName(*name))
            };
            write_named(writer, id, names, &buildings, control, link)
        })
    }

    fn link(&self, name: &LinkName, layout: &Layout, buildings: &Raster) -> Result<Rows> {
        let sample = self.read(name)?;
        let expected = layout.aps.map_or(0, |aps| aps.axis.count);
        let found = sample.aps_norm.len();
        if found != expected {
            return Err(ExchangeError::Bins { found, expected }.into());
        }
        if buildings_of(&sample, layout.raster)? != *buildings {
            return Err(ExchangeError::OtherBuildings.into());
        }
        let mut rows = Rows {
            status: vec![LinkStatus::Valid],
            ..Rows::default()
        };
        rows.aps.db = relative_db(&sample.aps_norm);
        Ok(rows)
    }

    fn read(&self, name: &LinkName) -> Result<Sample> {
        let path = self.folder.join(name.sample_file());
        let bytes = fs::read(&path).at_file(Place::File, &path)?;
        Sample::from_npz(&bytes).at_file(Place::File, &path)
    }
}

fn buildings_of(sample: &Sample, grid: RasterGrid) -> Result<Raster, ExchangeError> {
    let (found, expected) = (sample.size, [grid.height, grid.width]);
    if found != expected {
        return Err(ExchangeError::ImageSize { found, expected });
    }
    let plane = &sample.cond_img[..grid.height * grid.width];
    let pixels = plane.iter().map(|&v| match v {
        0.0 => 0,
        1.0 => 1,
        _ => 2,
    });
    Raster::from_pixels(grid, pixels.collect()).ok_or(ExchangeError::Pixel)
}

/// Powers relative to the largest, the least of them 0 [dB]; 0 dB throughout for a constant.
fn relative_db(normalised: &[f32]) -> Vec<f64> {
    let values = || normalised.iter().map(|&v| f64::from(v));
    let (least, largest) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
        (a.min(v), b.max(v))
    });
    let power = |v: f64| {
        if largest > least {
            (v - least) / (largest - least)
        } else {
            1.0
        }
    };
    values()
        .map(|v| (10.0 * libm::log10(power(v))).max(NO_POWER_DB))
        .collect()
}
