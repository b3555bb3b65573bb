//! Preprocessed samples: normalised labels with their condition images.
//!
//! A sample has lost its level and its scale: aps_norm = (p - mean) / deviation of the relative power p, or 2 (p - least) /
//! (largest - least) - 1, the other that the published preprocessing knows. The level is
//! set to 0 dB, and the scale such that the weakest bin has no power, which a spectrum with a deep null comes close to.
//! Normalised again, the label is the same up to rounding; decibels are good near the maximum and mean nothing 60 dB
//! below.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use aps_data::released::Sample;
use aps_data::{
    Axis, DatasetConfig, Layout, LinkStatus, Precision, ProfileLayout, Raster, RasterGrid,
};
use aps_label::{ANGLE_BINS, LabelConfig};
use serde_json::json;

use super::buildings::Buildings;
use super::dataset::{Imported, make, must_have_maps};
use super::named::{LinkFile, write_named};
use crate::control::Control;
use crate::dataset::Rows;
use crate::error::{At, Place, Result};
use crate::exchange::{ExchangeError, export};

/// Power of a bin without power, relative to the maximum \[dB\]: the floor of the label.
const NO_POWER_DB: f64 = -350.0;

/// Most that mean and deviation of a normalised spectrum are off; half precision changes values by a few hundredths.
const ROUNDING: f64 = 0.1;

/// Most that the ends of a spectrum normalised to -1 up to 1 are off, which are rounded alone.
const END_ROUNDING: f64 = 0.01;

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
        let mut files = LinkFile::all(&self.folder.join("samples"), "aps_", ".npz")?;
        LinkFile::order(&mut files)?;
        let mut maps: BTreeMap<u32, Vec<LinkFile>> = BTreeMap::new();
        for file in files {
            maps.entry(file.name.map).or_default().push(file);
        }
        let expected = "files samples/aps_N_TXX_TXY_RXX_RXY.npz";
        must_have_maps(&maps, &self.folder, expected)?;
        // Of others there need be no table.
        let has = |file: &str| self.folder.join(file).exists();
        if has(export::RECORD_FILE) && !has(export::samples::TABLE_FILE) {
            return Err(ExchangeError::Unfinished(self.folder.clone()).into());
        }
        let first = maps.values().flatten().next().expect("there is a map");
        let first = read(&first.path)?;
        let layout = Layout {
            raster: RasterGrid {
                width: first.size[1],
                height: first.size[0],
                metres_per_pixel: 1.0,
            },
            aps: Some(ProfileLayout {
                dtype: Precision::F32,
                ..ProfileLayout::over(Axis::ANGLE_RELEASED_DEG)
            }),
            pdp: None,
            paths: false,
        };
        let config = DatasetConfig {
            seed: self.seed,
            layout,
            configuration: json!({ "import": "samples", "label": LabelConfig::released() }),
        };
        make(out, config, &maps, None, control, |writer, id, files| {
            let buildings = buildings_of(&read(&files[0].path)?, layout.raster);
            let buildings = buildings.at(Place::LinkName(files[0].name))?;
            let buildings = Buildings::drawn(buildings);
            let link = |file: &LinkFile| {
                let rows = read_link(file, &buildings.image);
                rows.at(Place::LinkName(file.name))
            };
            write_named(writer, id, files, &buildings, control, link)
        })
    }
}

fn read(path: &Path) -> Result<Sample> {
    let bytes = fs::read(path).at_file(Place::File, path)?;
    Sample::from_npz(&bytes).at_file(Place::File, path)
}

fn read_link(file: &LinkFile, buildings: &Raster) -> Result<Rows> {
    let sample = read(&file.path)?;
    if buildings_of(&sample, buildings.grid())? != *buildings {
        return Err(ExchangeError::OtherBuildings.into());
    }
    check_spectrum(&sample.aps_norm)?;
    check_spot(&sample, 1, "transmitter", file.name.tx_m)?;
    check_spot(&sample, 2, "receiver", file.name.rx_m)?;
    let mut rows = Rows {
        status: vec![LinkStatus::Valid],
        ..Rows::default()
    };
    rows.aps.db = relative_db(&sample.aps_norm);
    Ok(rows)
}

/// Refuses a spectrum of another length, and one that is not normalised by itself, to mean 0 and deviation 1 or to -1 up to 1; a constant
/// one cannot be.
fn check_spectrum(normalised: &[f32]) -> Result<(), ExchangeError> {
    let (found, expected) = (normalised.len(), ANGLE_BINS);
    if found != expected {
        return Err(ExchangeError::Bins { found, expected });
    }
    let values = || normalised.iter().map(|&v| f64::from(v));
    let mean = values().sum::<f64>() / found as f64;
    let variance = values().map(|v| (v - mean).powi(2)).sum::<f64>() / found as f64;
    let deviation = variance.sqrt();
    let (least, largest) = range(normalised);
    let is_standard = mean.abs() <= ROUNDING && (deviation - 1.0).abs() <= ROUNDING;
    let is_of_range = (least + 1.0).abs() <= END_ROUNDING && (largest - 1.0).abs() <= END_ROUNDING;
    match least == largest || is_standard || is_of_range {
        true => Ok(()),
        false => Err(ExchangeError::NotNormalised { mean, deviation }),
    }
}

/// Refuses a plane of the condition image that is not brightest at an end's place, or a pixel beside it, as places are rounded.
fn check_spot(
    sample: &Sample,
    plane: usize,
    end: &'static str,
    place_m: [i32; 2],
) -> Result<(), ExchangeError> {
    let [height, width] = sample.size;
    let pixels = &sample.cond_img[plane * height * width..][..height * width];
    let is_near = |row: usize, column: usize| {
        let is_beside = |at: usize, place: i32, size: usize| {
            let place = i64::from(place).clamp(0, size as i64 - 1);
            (at as i64 - place).abs() <= 1
        };
        is_beside(column, place_m[0], width) && is_beside(row, place_m[1], height)
    };
    let (mut brightest, mut beside, mut elsewhere) = ([0; 2], f32::MIN, f32::MIN);
    for (i, &value) in pixels.iter().enumerate() {
        let (row, column) = (i / width, i % width);
        match is_near(row, column) {
            true => beside = beside.max(value),
            false if value > elsewhere => (elsewhere, brightest) = (value, [column, row]),
            false => {}
        }
    }
    match beside > elsewhere {
        true => Ok(()),
        false => Err(ExchangeError::Spot {
            end,
            place_m,
            brightest,
        }),
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
    let values = normalised.iter().map(|&v| f64::from(v));
    let (least, largest) = range(normalised);
    let power = |v: f64| {
        if largest > least {
            (v - least) / (largest - least)
        } else {
            1.0
        }
    };
    values
        .map(|v| (10.0 * libm::log10(power(v))).max(NO_POWER_DB))
        .collect()
}

fn range(values: &[f32]) -> (f64, f64) {
    let values = values.iter().map(|&v| f64::from(v));
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
        (a.min(v), b.max(v))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A normalised spectrum: a peak over a floor.
    fn normalised() -> Vec<f32> {
        let peaks = |bin: usize| if bin < 9 { 1.0 } else { 0.0 };
        let (mean, deviation) = (0.05_f32, (0.05_f32 * 0.95).sqrt());
        (0..ANGLE_BINS)
            .map(|bin| (peaks(bin) - mean) / deviation)
            .collect()
    }

    #[test]
    fn a_spectrum_that_is_not_normalised_is_refused() {
        let good = normalised();
        let of = |change: fn(f32) -> f32| -> Vec<f32> { good.iter().map(|&v| change(v)).collect() };
        check_spectrum(&good).unwrap();
        check_spectrum(&of(|v| half::f16::from_f32(v * 1.01 + 0.01).to_f32())).unwrap();
        check_spectrum(&[0.0; ANGLE_BINS]).unwrap();
        // To -1 up to 1, as the published preprocessing knows too: the same label.
        let least = good[ANGLE_BINS - 1];
        let scale = (good[0] - least) / 2.0;
        let of_range: Vec<f32> = good.iter().map(|&v| (v - least) / scale - 1.0).collect();
        check_spectrum(&of_range).unwrap();
        assert_eq!(relative_db(&of_range), relative_db(&good));
        check_spectrum(&of_range.iter().map(|v| 0.9 * v).collect::<Vec<_>>()).unwrap_err();
        for bad in [
            of(|v| -110.0 + v),
            of(|v| 0.2 * v + 0.05),
            of(|v| 2.0 * v),
            good[..90].to_vec(),
            [good.clone(), vec![0.0]].concat(),
        ] {
            assert!(check_spectrum(&bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn spots_elsewhere_than_the_name_says_are_refused() {
        let [tx_m, rx_m] = [[3, 9], [12, 4]];
        let size @ [height, width] = [16, 20];
        let spot = |[x, y]: [i32; 2]| {
            let squared = move |i: usize| {
                let (row, column) = ((i / width) as f32, (i % width) as f32);
                (column - x as f32).powi(2) + (row - y as f32).powi(2)
            };
            (0..height * width).map(move |i| (-squared(i) / 800.0).exp())
        };
        let sample = |tx_m, rx_m| {
            let none = vec![0.0; height * width];
            let cond_img = none.into_iter().chain(spot(tx_m)).chain(spot(rx_m));
            Sample {
                aps_norm: normalised(),
                size,
                cond_img: cond_img.collect(),
            }
        };
        let check = |sample: &Sample| {
            check_spot(sample, 1, "transmitter", tx_m)?;
            check_spot(sample, 2, "receiver", rx_m)
        };
        check(&sample(tx_m, rx_m)).unwrap();
        check(&sample([4, 8], rx_m)).unwrap();
        for other in [
            sample(rx_m, tx_m),
            sample([9, 3], [4, 12]),
            sample(tx_m, [14, 4]),
        ] {
            assert!(matches!(check(&other), Err(ExchangeError::Spot { .. })));
        }
        let mut even = sample(tx_m, rx_m);
        even.cond_img.fill(1.0);
        assert!(check(&even).is_err());
    }
}
