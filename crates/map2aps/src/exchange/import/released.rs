//! Labels as the published converter writes them: two columns a file, half precision.

use std::collections::BTreeMap;
use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use aps_data::released::ProfileFile;
use aps_data::{Axis, DatasetConfig, Layout, LinkStatus, Precision, ProfileLayout};
use aps_label::{ANGLE_BINS, LabelConfig};
use serde_json::json;

use super::buildings::Buildings;
use super::dataset::{Imported, make, must_have_maps};
use super::named::{LinkFile, map_number, write_named};
use crate::control::Control;
use crate::dataset::Rows;
use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;
use crate::maps::MapSource;

/// Powers that antennas can receive, relative to isotropic ones or to a milliwatt \[dB\].
const POWERS_DB: RangeInclusive<f64> = f64::NEG_INFINITY..=0.0;
/// Delays of the released axis \[ns\].
const DELAYS_NS: RangeInclusive<f64> = 0.0..=1000.0;
/// Azimuths within a full turn of 0 \[deg\].
const AZIMUTHS_DEG: RangeInclusive<f64> = -360.0..=360.0;

/// Import of labels in `map_N/N_adps/aps/aps_*.npy`, and PDPs beside them.
#[derive(Debug, Clone)]
pub struct ImportReleased {
    /// Folder that holds `map_0`, `map_1`, ...
    pub folder: PathBuf,
    /// Buildings of the maps; without them, their images stay empty.
    pub maps: Option<MapSource>,
    /// Seed of the split, and of synthetic maps.
    pub seed: u64,
}

impl ImportReleased {
    /// Makes a data set in the folder `out`. Maps that it holds already are kept.
    ///
    /// # Errors
    /// Files that are not there, cannot be read or are not of this form, a folder with another data set, and
    /// cancellation.
    pub fn run(&self, out: &Path, control: &Control<'_>) -> Result<Imported> {
        let source = self.maps.as_ref();
        let maps = self.find()?;
        must_have_maps(
            &maps,
            &self.folder,
            "folders map_N/N_adps/aps with files aps_N_TXX_TXY_RXX_RXY.npy",
        )?;
        let first = maps.values().flatten().next();
        let pdp = first.is_some_and(|file| file.pdp().exists());
        let exact = |axis| ProfileLayout {
            axis,
            // Values that came in half precision must leave as they came: the stored values are relative to the maximum.
            dtype: Precision::F32,
            argmax: true,
        };
        let layout = Layout {
            aps: Some(exact(Axis::ANGLE_RELEASED_DEG)),
            pdp: pdp.then(|| exact(Axis::DELAY_RELEASED_NS)),
            paths: false,
            raster: source.map(MapSource::raster).unwrap_or_default(),
        };
        let config = DatasetConfig {
            seed: self.seed,
            layout,
            configuration: json!({
                "import": "released",
                "maps": source.map(MapSource::describe),
                "label": LabelConfig { pdp, ..LabelConfig::released() },
            }),
        };
        make(out, config, &maps, source, control, |writer, id, files| {
            let buildings = Buildings::of(source, id, self.seed)?;
            let link = |file: &LinkFile| read_link(file, &layout, &buildings);
            write_named(writer, id, files, &buildings, control, link)
        })
    }

    /// The files of each map in the order of their links.
    fn find(&self) -> Result<BTreeMap<u32, Vec<LinkFile>>> {
        let mut maps: BTreeMap<u32, Vec<LinkFile>> = BTreeMap::new();
        for entry in fs::read_dir(&self.folder).at_file(Place::Reading, &self.folder)? {
            let folder = entry?.path();
            if matches!(map_number(&folder), Ok(None)) || !folder.is_dir() {
                continue;
            }
            for entry in fs::read_dir(&folder).at_file(Place::Reading, &folder)? {
                let labels = entry?.path();
                let name = labels.file_name().unwrap_or_default().to_string_lossy();
                let Some(number) = name.strip_suffix("_adps") else {
                    continue;
                };
                // A folder without labels may have any number.
                let id = map_number(&folder)?;
                let aps = labels.join("aps");
                let Some(id) = id.filter(|id| number.parse() == Ok(*id) && aps.is_dir()) else {
                    continue;
                };
                let files = LinkFile::all(&aps, "aps_", ".npy")?;
                if let Some(file) = files.iter().find(|file| file.name.map != id) {
                    return Err(ExchangeError::Unnamed(file.path.clone()).into());
                }
                maps.entry(id).or_default().extend(files);
            }
        }
        maps.retain(|_, files| !files.is_empty());
        maps.values_mut()
            .try_for_each(|files| LinkFile::order(files))?;
        Ok(maps)
    }
}

/// One link: zeros are a link without path, numbers that are not finite a label that failed.
fn read_link(file: &LinkFile, layout: &Layout, buildings: &Buildings) -> Result<Rows> {
    let aps = read(&file.path, ANGLE_BINS, "delay [ns]", DELAYS_NS)?;
    let angle = "azimuth [deg]";
    let pdp = layout
        .pdp
        .map(|pdp| read(&file.pdp(), pdp.axis.count, angle, AZIMUTHS_DEG))
        .transpose()?;
    let is_finite = aps.is_finite() && pdp.as_ref().is_none_or(ProfileFile::is_finite);
    let status = match is_finite {
        _ if aps.is_all_zero() => LinkStatus::NoPath,
        true => LinkStatus::Valid,
        false => LinkStatus::Unlabelled,
    };
    if status == LinkStatus::Valid {
        let [tx_m, rx_m] = [file.name.tx_m, file.name.rx_m].map(|place| place.map(f64::from));
        buildings.note_ends(tx_m, rx_m);
    }
    let mut rows = Rows {
        status: vec![status],
        ..Rows::default()
    };
    for (profile, values) in [(Some(aps), &mut rows.aps), (pdp, &mut rows.pdp)] {
        let bins = profile.map(|p| p.bins).unwrap_or_default();
        values.db.extend(bins.iter().map(|bin| bin[0].to_f64()));
        values.places.extend(bins.iter().map(|bin| bin[1].to_f64()));
    }
    Ok(rows)
}

/// Reads a file of so many bins, whose second column holds such places.
fn read(
    path: &Path,
    expected: usize,
    places: &'static str,
    range: RangeInclusive<f64>,
) -> Result<ProfileFile> {
    let profile = || -> Result<ProfileFile> {
        let profile = ProfileFile::from_bytes(&fs::read(path)?)?;
        let found = profile.bins.len();
        if found != expected {
            return Err(ExchangeError::Bins { found, expected }.into());
        }
        if profile.is_finite() {
            check_values(&profile, places, &range)?;
        }
        Ok(profile)
    };
    profile().at_file(Place::File, path)
}

/// Refuses values that are no powers and places: of another unit, or in the other column.
fn check_values(
    profile: &ProfileFile,
    places: &'static str,
    range: &RangeInclusive<f64>,
) -> Result<(), ExchangeError> {
    for (bin, values) in profile.bins.iter().enumerate() {
        let columns = [("power [dB]", &POWERS_DB), (places, range)];
        for (value, (column, range)) in values.iter().zip(columns) {
            let value = value.to_f64();
            if !range.contains(&value) {
                return Err(ExchangeError::Impossible {
                    bin,
                    value,
                    column,
                    expected: range.clone(),
                });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const DELAY: (&str, &RangeInclusive<f64>) = ("delay [ns]", &DELAYS_NS);
    const ANGLE: (&str, &RangeInclusive<f64>) = ("azimuth [deg]", &AZIMUTHS_DEG);

    #[test]
    fn values_of_another_column_or_unit_are_refused() {
        let check = |power: f64, (places, range): (&'static str, _), place: f64| {
            let profile = ProfileFile::rounded(&[-80.0, power], &[0.0, place]);
            check_values(&profile, places, range)
        };
        for (power, axis, place) in [
            (-91.3, DELAY, 212.6),
            (0.0, DELAY, 1000.0),
            (-350.0, ANGLE, -180.0),
        ] {
            check(power, axis, place).unwrap();
        }
        for (power, axis, place, told) in [
            (212.6, DELAY, -91.3, "power [dB] is 212.625"),
            (0.5, DELAY, 212.6, "power [dB] is 0.5"),
            (-80.0, DELAY, -5.0, "delay [ns] is -5"),
            (-80.0, DELAY, 1001.0, "delay [ns] is 1001"),
            (-80.0, ANGLE, 400.0, "azimuth [deg] is 400"),
        ] {
            let error = check(power, axis, place).unwrap_err().to_string();
            assert!(error.contains(told) && error.contains("bin 1"), "{error}");
        }
    }
}
