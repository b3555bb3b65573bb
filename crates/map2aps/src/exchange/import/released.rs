//! Labels as the published converter writes them: two columns a file, half precision.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use aps_data::released::{LinkName, ProfileFile};
use aps_data::{Axis, DatasetConfig, Layout, LinkStatus, Precision, ProfileLayout};
use aps_label::{ANGLE_BINS, LabelConfig};
use serde_json::json;

use super::{ExchangeError, Imported, buildings, make, must_have_maps, named_files, write_named};
use crate::control::Control;
use crate::dataset::Rows;
use crate::error::{At, Place, Result};
use crate::maps::MapSource;

/// Import of labels in `map_N/N_adps/aps/aps_*.npy`, and PDPs beside them.
#[derive(Debug, Clone)]
pub struct ImportReleased {
    /// Folder that holds `map_0`, `map_1`, ...
    pub folder: PathBuf,
    /// Buildings of the maps; without them, their images stay empty.
    pub maps: Option<MapSource>,
    /// Seed of the split.
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
        let pdp = first.is_some_and(|name| self.folder.join(name.pdp_file()).exists());
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
        make(out, config, &maps, control, |writer, id, names| {
            let buildings = buildings(source, id)?;
            let link = |name: &LinkName| self.link(name, &layout);
            write_named(writer, id, names, &buildings, control, link)
        })
    }

    /// The links of each map.
    fn find(&self) -> Result<BTreeMap<u32, Vec<LinkName>>> {
        let mut maps = BTreeMap::new();
        for entry in fs::read_dir(&self.folder).at_file(Place::Reading, &self.folder)? {
            let entry = entry?;
            let name = entry.file_name();
            let id = name
                .to_str()
                .and_then(|n| n.strip_prefix("map_")?.parse::<u32>().ok());
            let Some(id) = id else { continue };
            let folder = entry.path().join(format!("{id}_adps/aps"));
            if !folder.is_dir() {
                continue;
            }
            let names = named_files(&folder, "aps_", ".npy")?;
            // Files are read by the names that they must have.
            let lost = names.iter().find(|link| {
                let file = self.folder.join(link.aps_file());
                link.map != id || name != *format!("map_{id}") || !file.is_file()
            });
            if let Some(link) = lost {
                let file = folder.join(format!("aps_{link}.npy"));
                return Err(ExchangeError::Unnamed(file).into());
            }
            if !names.is_empty() {
                maps.insert(id, names);
            }
        }
        Ok(maps)
    }

    /// One link: zeros are a link without path, numbers that are not finite a label that failed.
    fn link(&self, name: &LinkName, layout: &Layout) -> Result<Rows> {
        let aps = read(&self.folder.join(name.aps_file()), ANGLE_BINS)?;
        let pdp = layout
            .pdp
            .map(|pdp| read(&self.folder.join(name.pdp_file()), pdp.axis.count))
            .transpose()?;
        let is_finite = aps.is_finite() && pdp.as_ref().is_none_or(ProfileFile::is_finite);
        let status = match is_finite {
            _ if aps.is_all_zero() => LinkStatus::NoPath,
            true => LinkStatus::Valid,
            false => LinkStatus::Unlabelled,
        };
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
}

fn read(path: &Path, expected: usize) -> Result<ProfileFile> {
    let profile = || -> Result<ProfileFile> {
        let profile = ProfileFile::from_bytes(&fs::read(path)?)?;
        let found = profile.bins.len();
        match found == expected {
            true => Ok(profile),
            false => Err(ExchangeError::Bins { found, expected }.into()),
        }
    };
    profile().at_file(Place::File, path)
}
