//! Reading a data set: the manifest first, then maps as they are asked for.

mod verify;

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::arrays::ProfileNames;
use crate::error::{Error, in_array};
use crate::layout::{Precision, ProfileLayout};
use crate::manifest::{MANIFEST_FILE, Manifest, MapEntry};
use crate::map_data::MapData;
use crate::npy::{self, Element};
use crate::paths::{InteractionKind, PathTable};
use crate::profile::{Profile, Samples};
use crate::raster::Raster;
use crate::split::Part;
use crate::status::LinkStatus;

/// A finished data set on disk.
///
/// Opening reads the manifest only. A map's arrays are loaded whole, after name, type, shape and
/// length of each file have been checked against the manifest; what is returned is free of NaN and
/// indices out of range. Checksums are left to [`Dataset::verify`].
#[derive(Debug, Clone)]
pub struct Dataset {
    root: PathBuf,
    manifest: Manifest,
}

impl Dataset {
    /// Opens the data set in a folder.
    ///
    /// # Errors
    /// [`Error::NotADataset`] without a manifest, [`Error::NewerFormat`], [`Error::Json`], and
    /// [`Error::Damaged`] when the manifest contradicts itself.
    pub fn open(root: impl AsRef<Path>) -> Result<Self, Error> {
        let root = root.as_ref().to_path_buf();
        let path = root.join(MANIFEST_FILE);
        if !Self::is_at(&root) {
            let problem =
                "it has no manifest.json; if a run was interrupted, start it again to finish it";
            let (path, problem) = (root, problem.into());
            return Err(Error::NotADataset { path, problem });
        }
        Ok(Dataset {
            manifest: Manifest::read(&path)?,
            root,
        })
    }

    /// Tells if a folder has the manifest of a data set, which may be damaged.
    pub fn is_at(root: &Path) -> bool {
        root.join(MANIFEST_FILE).is_file()
    }

    /// Returns the folder that the data set was opened in.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Returns the manifest of the data set.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Checks that the states of the links of these maps, and the APS if stored, are there in full length, without reading them:
    /// whoever takes memory for as many links as the manifest tells asks this first.
    ///
    /// # Errors
    /// [`Error::UnknownMap`]; [`Error::Io`] for a file that is not there, [`Error::Damaged`] for one of another length.
    pub fn check_sizes(&self, maps: &[u32]) -> Result<(), Error> {
        let aps = self.manifest.layout.aps.map(|_| ProfileNames::APS.db);
        for &id in maps {
            let map = self.entry(id)?;
            for name in ["status"].into_iter().chain(aps) {
                let file = map.file(name).expect("the manifest was checked");
                if let Some(found) = file.other_length(&self.folder(id))? {
                    let problem = format!("{found} bytes, the manifest says {}", file.bytes);
                    let path = self.folder(id).join(&file.name);
                    return Err(Error::Damaged { path, problem });
                }
            }
        }
        Ok(())
    }

    /// Loads link table, buildings and APS of a map: some 18 MB for 50,000 links in half precision.
    ///
    /// # Errors
    /// [`Error::UnknownMap`]; [`Error::Io`], [`Error::Npy`] and [`Error::Damaged`] for files that
    /// are not as written.
    pub fn map(&self, id: u32) -> Result<MapData, Error> {
        let mut data = self.links(id)?;
        let map = self.entry(id)?;
        let aps = self.manifest.layout.aps;
        let profile = aps.map(|aps| self.profile(map, &data.status, ProfileNames::APS, &aps));
        data.aps = profile.transpose()?;
        Ok(data)
    }

    /// Loads link table and buildings of a map, and no labels: some 600 kB for 50,000 links.
    ///
    /// # Errors
    /// As [`Dataset::map`].
    pub fn links(&self, id: u32) -> Result<MapData, Error> {
        let map = self.entry(id)?;
        let (link_tx, link_rx): (Vec<u32>, Vec<u32>) =
            (self.array(map, "link_tx")?, self.array(map, "link_rx")?);
        let is_outside = |(&t, &r): (&u32, &u32)| t as usize >= map.tx || r as usize >= map.rx;
        if let Some(link) = link_tx.iter().zip(&link_rx).position(is_outside) {
            let problem = format!("link {link} joins positions that are not there");
            return Err(self.damaged(id, problem));
        }
        let grid = self.manifest.layout.raster;
        let Some(buildings) = Raster::from_pixels(grid, self.array(map, "buildings")?) else {
            return Err(self.damaged(id, "a pixel of buildings.npy is neither 0 nor 1".into()));
        };
        let status = self.status(map)?;
        let data = MapData {
            id,
            buildings,
            tx_m: pairs(self.array(map, "tx")?),
            rx_m: pairs(self.array(map, "rx")?),
            links: link_tx
                .into_iter()
                .zip(link_rx)
                .map(|(t, r)| [t, r])
                .collect(),
            status,
            fallback: self.array(map, "fallback")?,
            aps: None,
        };
        let mut positions = data.tx_m.iter().chain(&data.rx_m).flatten();
        match positions.all(|value| value.is_finite()) {
            true => Ok(data),
            false => Err(self.damaged(id, "a position is not finite".into())),
        }
    }

    /// Layout of the stored angle power spectra.
    ///
    /// # Errors
    /// [`Error::NotStored`].
    pub fn aps_layout(&self) -> Result<ProfileLayout, Error> {
        let layout = self.manifest.layout.aps;
        layout.ok_or_else(|| self.not_stored("angle power spectra"))
    }

    /// Loads the stored APS of one link, by its row in the map: values relative to the link's largest \[dB\].
    ///
    /// # Errors
    /// [`Error::NotStored`], and those of [`Dataset::map`].
    pub fn spectrum(&self, id: u32, link: usize) -> Result<Samples, Error> {
        let map = self.entry(id)?;
        let layout = self.aps_layout()?;
        let row = self.samples(map, ProfileNames::APS.db, &layout, Some(link..link + 1))?;
        match row.is_finite() {
            true => Ok(row),
            false => Err(self.damaged(id, format!("the spectrum of link {link} is not finite"))),
        }
    }

    /// Loads the power delay profiles of a map.
    ///
    /// # Errors
    /// [`Error::NotStored`], and those of [`Dataset::map`].
    pub fn pdp(&self, id: u32) -> Result<Profile, Error> {
        let map = self.entry(id)?;
        let pdp = self.manifest.layout.pdp;
        let layout = pdp.ok_or_else(|| self.not_stored("power delay profiles"))?;
        self.profile(map, &self.status(map)?, ProfileNames::PDP, &layout)
    }

    /// Loads the propagation paths of a map.
    ///
    /// # Errors
    /// [`Error::NotStored`], and those of [`Dataset::map`].
    pub fn paths(&self, id: u32) -> Result<PathTable, Error> {
        let map = self.entry(id)?;
        if !self.manifest.layout.paths {
            return Err(self.not_stored("propagation paths"));
        }
        let kinds: Vec<u8> = self.array(map, "interaction_kind")?;
        let table = PathTable {
            path_offset: self.array(map, "path_offset")?,
            delay_s: self.array(map, "path_delay_s")?,
            departure_azimuth_rad: self.array(map, "path_departure_azimuth_rad")?,
            arrival_azimuth_rad: self.array(map, "path_arrival_azimuth_rad")?,
            gain: self.array(map, "path_gain")?,
            interaction_offset: self.array(map, "interaction_offset")?,
            interaction_kind: kinds.into_iter().map(InteractionKind::from_code).collect(),
            interaction_id: self.array(map, "interaction_id")?,
            interaction_point_m: pairs(self.array(map, "interaction_point")?),
        };
        match table.problem(&self.status(map)?, 0) {
            Some(problem) => Err(self.damaged(id, problem)),
            None => Ok(table),
        }
    }

    /// Loads the maps of one part of the split one after the other, in ascending order.
    pub fn maps_of(&self, part: Part) -> impl Iterator<Item = Result<MapData, Error>> {
        self.manifest
            .split
            .maps(part)
            .iter()
            .map(|&id| self.map(id))
    }

    fn entry(&self, id: u32) -> Result<&MapEntry, Error> {
        self.manifest.map(id).ok_or_else(|| Error::UnknownMap {
            path: self.root.clone(),
            map: id,
        })
    }

    fn folder(&self, id: u32) -> PathBuf {
        self.root.join(MapEntry::folder_of(id))
    }

    fn not_stored(&self, what: &'static str) -> Error {
        Error::NotStored {
            path: self.root.clone(),
            what,
        }
    }

    fn damaged(&self, id: u32, problem: String) -> Error {
        Error::Damaged {
            path: self.folder(id),
            problem,
        }
    }

    /// Loads an array whose type and shape the manifest was checked for.
    fn array<T: Element>(&self, map: &MapEntry, name: &'static str) -> Result<Vec<T>, Error> {
        self.rows(map, name, None)
    }

    /// Loads rows of such an array; `None` for all.
    fn rows<T: Element>(
        &self,
        map: &MapEntry,
        name: &'static str,
        rows: Option<Range<usize>>,
    ) -> Result<Vec<T>, Error> {
        let file = map
            .file(name)
            .expect("the manifest was checked to list the arrays of its layout");
        let path = self.folder(map.id).join(&file.name);
        let read = rows.map_or_else(|| npy::read(&path), |rows| npy::read_rows(&path, rows));
        let array = read.map_err(in_array(&path, "read"))?;
        if array.shape != file.shape {
            let problem = format!(
                "its shape is {:?}, the manifest says {:?}",
                array.shape, file.shape
            );
            return Err(Error::Damaged { path, problem });
        }
        Ok(array.data)
    }

    /// Loads rows of the values of a profile; `None` for all.
    fn samples(
        &self,
        map: &MapEntry,
        name: &'static str,
        layout: &ProfileLayout,
        rows: Option<Range<usize>>,
    ) -> Result<Samples, Error> {
        Ok(match layout.dtype {
            Precision::F16 => Samples::F16(self.rows(map, name, rows)?),
            Precision::F32 => Samples::F32(self.rows(map, name, rows)?),
        })
    }

    fn status(&self, map: &MapEntry) -> Result<Vec<LinkStatus>, Error> {
        let codes: Vec<u8> = self.array(map, "status")?;
        Ok(codes.into_iter().map(LinkStatus::from_code).collect())
    }

    fn profile(
        &self,
        map: &MapEntry,
        status: &[LinkStatus],
        names: ProfileNames,
        layout: &ProfileLayout,
    ) -> Result<Profile, Error> {
        let profile = Profile {
            bins: layout.axis.count,
            db: self.samples(map, names.db, layout, None)?,
            max_db: self.array(map, names.max_db)?,
            argmax: layout
                .argmax
                .then(|| self.array(map, names.argmax))
                .transpose()?,
        };
        match profile.problem(status) {
            Some(problem) => Err(self.damaged(map.id, format!("{}: {problem}", names.db))),
            None => Ok(profile),
        }
    }
}

fn pairs(values: Vec<f64>) -> Vec<[f64; 2]> {
    let (pairs, _) = values.as_chunks();
    pairs.to_vec()
}
