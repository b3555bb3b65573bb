//! Labels with the places of their maxima, as the published converter writes them.

use std::fs;
use std::path::{Path, PathBuf};

use aps_data::released::{LinkName, ProfileFile};
use aps_data::{Dataset, MapData, PathTable, Profile, replace_unsynced};
use aps_label::{LabelConfig, Labeler, Status};
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::folder::create_folder;
use crate::batch::Buffers;
use crate::dataset::stored_pdp;
use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;
use crate::targets::spectra;

/// The labels of one map.
pub struct Released<'a> {
    source: Source<'a>,
    /// Length of an APS file, and of a PDP file if there are any [bytes].
    lengths: [Option<u64>; 2],
}

/// Origin of labels: made anew from the paths, to be rounded once, or as they are stored.
enum Source<'a> {
    Paths {
        table: PathTable,
        labeler: Box<Labeler>,
    },
    Stored {
        aps: &'a Profile,
        pdp: Option<Profile>,
    },
}

impl<'a> Released<'a> {
    pub fn new(dataset: &Dataset, map: &'a MapData, zero_places: bool) -> Result<Self> {
        let manifest = dataset.manifest();
        let label: Option<LabelConfig> =
            serde_json::from_value(manifest.configuration["label"].clone()).ok();
        let (source, bins) = match label {
            Some(label) if manifest.layout.paths => {
                let labeler = Box::new(Labeler::new(&LabelConfig { pdp: true, ..label })?);
                let bins = [labeler.angles_deg(), labeler.delays_s()].map(|axis| Some(axis.len()));
                let table = dataset.paths(map.id)?;
                (Source::Paths { table, labeler }, bins)
            }
            _ => {
                let layout = dataset.aps_layout()?;
                if !layout.argmax && !zero_places {
                    return Err(ExchangeError::NoPlaces.into());
                }
                let (aps, pdp) = (spectra(map), stored_pdp(dataset, map.id)?);
                let bins = [Some(aps.bins()), pdp.as_ref().map(Profile::bins)];
                (Source::Stored { aps, pdp }, bins)
            }
        };
        let length = |bins: usize| {
            let zeros = vec![0.0; bins];
            ProfileFile::rounded(&zeros, &zeros).to_bytes().len() as u64
        };
        Ok(Self {
            source,
            lengths: bins.map(|bins| bins.map(length)),
        })
    }

    /// APS and, if there is one, PDP of a link.
    fn profiles(&self, link: usize, buffers: &mut Buffers) -> Result<[Option<ProfileFile>; 2]> {
        match &self.source {
            Source::Paths { table, labeler } => {
                let status = buffers.label_stored(labeler, table, link)?;
                if status != Status::Labelled {
                    return Err(ExchangeError::NoLabel.into());
                }
                let label = &buffers.label;
                let delays_s = label.aps_delay_s.iter();
                let delay_ns: Vec<f64> = delays_s.copied().map(place_ns).collect();
                Ok([
                    Some(ProfileFile::rounded(&label.aps_db, &delay_ns)),
                    Some(ProfileFile::rounded(&label.pdp_db, &label.pdp_angle_deg)),
                ])
            }
            Source::Stored { aps, pdp } => Ok([
                Some(stored(aps, link)),
                pdp.as_ref().map(|pdp| stored(pdp, link)),
            ]),
        }
    }

    /// Creates the folders of a map's files.
    pub fn create_folders(&self, map: u32, out: &Path) -> Result<()> {
        for (kind, length) in ["aps", "pdp"].into_iter().zip(self.lengths) {
            if length.is_some() {
                create_folder(&out.join(format!("map_{map}/{map}_adps/{kind}")))?;
            }
        }
        Ok(())
    }

    /// Writes the files of one link that are not there; returns the bytes written.
    pub fn write(
        &self,
        link: usize,
        name: &LinkName,
        out: &Path,
        buffers: &mut Buffers,
    ) -> Result<u64> {
        let paths = [name.aps_file(), name.pdp_file()].map(|file| out.join(file));
        let is_there = |(file, length): (&PathBuf, &Option<u64>)| {
            let has = |n| fs::metadata(file).is_ok_and(|found| found.is_file() && found.len() == n);
            length.is_none_or(has)
        };
        if paths.iter().zip(&self.lengths).all(is_there) {
            return Ok(0);
        }
        let mut written = 0;
        for (profile, file) in self.profiles(link, buffers)?.into_iter().zip(paths) {
            let Some(profile) = profile else { continue };
            let bytes = profile.to_bytes();
            replace_unsynced(&file, &bytes).at(Place::LinkName(*name))?;
            written += bytes.len() as u64;
        }
        Ok(written)
    }
}

/// A delay as it is written: not negative, and within what half precision holds.
fn place_ns(delay_s: f64) -> f64 {
    (delay_s * 1e9).clamp(0.0, f16::MAX.to_f64())
}

/// A stored row in absolute dB, with its places or zeros.
fn stored(profile: &Profile, link: usize) -> ProfileFile {
    let bins = profile.bins();
    let mut row = vec![0.0; bins];
    profile.read_relative_db(link, &mut row);
    let max_db = f64::from(profile.max_db()[link]);
    let db: Vec<f64> = row.iter().map(|&v| max_db + f64::from(v)).collect();
    let mut places = vec![0.0; bins];
    if let Some(stored) = profile.argmax() {
        stored[link * bins..][..bins].convert_to_f64_slice(&mut places);
    }
    ProfileFile::rounded(&db, &places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_beyond_the_published_grid_are_told() {
        assert_eq!([-1e-12, 1e-6, 1.5e-6].map(place_ns), [0.0, 1000.0, 1500.0]);
        let far = ProfileFile::rounded(&[0.0], &[place_ns(1.0)]).to_bytes();
        assert_eq!(far, ProfileFile::rounded(&[0.0], &[65_504.0]).to_bytes());
    }
}
