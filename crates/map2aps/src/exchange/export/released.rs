//! Labels with the places of their maxima, as the published converter writes them.

use std::fs;
use std::path::{Path, PathBuf};

use aps_data::released::{LinkName, ProfileFile};
use aps_data::{Dataset, MapData, PathTable, Profile, replace_unsynced};
use aps_label::{Label, LabelConfig, Labeler, PathSample, Scratch};

use super::create_folder;
use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;

/// The labels of one map.
pub struct Released<'a> {
    source: Source<'a>,
    /// Length of an APS file, and of a PDP file if there are any [bytes].
    lengths: [Option<u64>; 2],
}

/// Their origin: made anew from the paths, to be rounded once, or as they are stored.
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

/// Buffers of one thread.
#[derive(Default)]
pub struct Buffers {
    samples: Vec<PathSample>,
    scratch: Scratch,
    label: Label,
}

impl<'a> Released<'a> {
    pub fn new(dataset: &Dataset, map: &'a MapData, zero_places: bool) -> Result<Self> {
        let manifest = dataset.manifest();
        let label: Option<LabelConfig> =
            serde_json::from_value(manifest.configuration["label"].clone()).ok();
        let (source, bins) = match (label, &map.aps) {
            (Some(label), _) if manifest.layout.paths => {
                let labeler = Box::new(Labeler::new(&LabelConfig { pdp: true, ..label })?);
                let bins = [
                    Some(labeler.angles_deg().len()),
                    Some(labeler.delays_s().len()),
                ];
                let table = dataset.paths(map.id)?;
                (Source::Paths { table, labeler }, bins)
            }
            (_, Some(aps)) if aps.argmax().is_some() || zero_places => {
                let pdp = manifest
                    .layout
                    .pdp
                    .map(|_| dataset.pdp(map.id))
                    .transpose()?;
                let bins = [Some(aps.bins()), pdp.as_ref().map(Profile::bins)];
                (Source::Stored { aps, pdp }, bins)
            }
            (_, Some(_)) => return Err(ExchangeError::NoPlaces.into()),
            (_, None) => return Err(ExchangeError::NoSpectra.into()),
        };
        let length = |bins: usize| {
            ProfileFile::rounded(&vec![0.0; bins], &vec![0.0; bins])
                .to_bytes()
                .len() as u64
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
                let Buffers {
                    samples,
                    scratch,
                    label,
                } = buffers;
                samples.clear();
                let paths = table.paths_of(link);
                samples.extend(paths.map(|path| table.sample(path)));
                let status = labeler.label_into(samples, scratch, label)?;
                if status != aps_label::Status::Labelled {
                    return Err(ExchangeError::NoLabel.into());
                }
                let delay_ns: Vec<f64> = label
                    .aps_delay_s
                    .iter()
                    .map(|s| (s * 1e9).clamp(0.0, 1000.0))
                    .collect();
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
            length.is_none_or(|n| {
                fs::metadata(file).is_ok_and(|found| found.is_file() && found.len() == n)
            })
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

/// A stored row in absolute dB, with its places or zeros.
fn stored(profile: &Profile, link: usize) -> ProfileFile {
    let bins = profile.bins();
    let mut row = vec![0.0; bins];
    profile.read_relative_db(link, &mut row);
    let max_db = f64::from(profile.max_db()[link]);
    let db: Vec<f64> = row.iter().map(|&v| max_db + f64::from(v)).collect();
    let places = match profile.argmax() {
        Some(places) => places[link * bins..][..bins]
            .iter()
            .map(|v| v.to_f64())
            .collect(),
        None => vec![0.0; bins],
    };
    ProfileFile::rounded(&db, &places)
}
