//! Preprocessed samples: normalised labels with their condition images.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use aps_data::released::{LinkName, Sample};
use aps_data::{
    ConditionConfig, ConditionImages, Dataset, MapData, Profile, npy, replace_unsynced,
};
use aps_label::{MeanStd, Normalization};

use super::folder::create_folder;
use crate::error::Result;
use crate::exchange::ExchangeError;
use crate::targets::spectra;

/// The published preprocessing, its default: relative power, minus its own mean, divided by its own deviation.
const NORMALISATION: Normalization = Normalization::Released(MeanStd {
    mean: 0.0,
    std: 1.0,
});

/// The samples of one map.
pub struct Samples<'a> {
    map: &'a MapData,
    aps: &'a Profile,
    images: ConditionImages,
}

impl<'a> Samples<'a> {
    /// Refuses a data set that has no spectra, or images of another scale than samples.
    pub fn check(dataset: &Dataset) -> Result<()> {
        dataset.aps_layout()?;
        match dataset.manifest().layout.raster.metres_per_pixel {
            1.0 => Ok(()),
            pixel_m => Err(ExchangeError::PixelSize(pixel_m).into()),
        }
    }

    /// Prepares a map of a data set that was checked.
    pub fn new(map: &'a MapData) -> Self {
        Self {
            map,
            aps: spectra(map),
            images: ConditionImages::new(&map.buildings, ConditionConfig::default()),
        }
    }

    /// Writes `env_maps/N.npy`, the image of the buildings by itself, and creates the folder of the samples.
    pub fn write_buildings(&self, out: &Path) -> Result<()> {
        create_folder(&out.join("samples"))?;
        let folder = out.join("env_maps");
        create_folder(&folder)?;
        let buildings = &self.map.buildings;
        let pixels = buildings.pixels().iter().copied();
        let pixels: Vec<f32> = pixels.map(f32::from).collect();
        let grid = buildings.grid();
        let mut bytes = Vec::new();
        npy::write_to(&mut bytes, &[grid.height, grid.width], &pixels)?;
        let file = folder.join(format!("{}.npy", self.map.id));
        Ok(replace_unsynced(&file, &bytes)?)
    }

    /// Writes the file of one link if it is not there; returns the bytes written.
    pub fn write(&self, link: usize, name: &LinkName, out: &Path) -> Result<u64> {
        let file = out.join(name.sample_file());
        if is_whole_archive(&file) {
            return Ok(0);
        }
        let mut row = vec![0.0_f32; self.aps.bins()];
        self.aps.read_relative_db(link, &mut row);
        let mut target: Vec<f64> = row.into_iter().map(f64::from).collect();
        NORMALISATION.apply(&mut target)?;
        let (tx, rx) = self.map.ends_m(link);
        let mut cond_img = vec![0.0; self.images.image_len()];
        self.images.write(tx, rx, &mut cond_img);
        let grid = self.map.buildings.grid();
        let sample = Sample {
            aps_norm: target.into_iter().map(|v| v as f32).collect(),
            size: [grid.height, grid.width],
            cond_img,
        };
        let bytes = sample.to_npz()?;
        replace_unsynced(&file, &bytes)?;
        Ok(bytes.len() as u64)
    }
}

/// Returns true when a file ends as a zip archive without a comment does.
fn is_whole_archive(path: &Path) -> bool {
    let end = || -> std::io::Result<[u8; 4]> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::End(-22))?;
        let mut mark = [0; 4];
        file.read_exact(&mut mark)?;
        Ok(mark)
    };
    end().is_ok_and(|mark| mark == *b"PK\x05\x06")
}

/// The table of all samples, which an export writes last.
pub const TABLE_FILE: &str = "metadata.csv";

/// Writes the table: a row a sample, with the columns of the published preprocessing.
pub fn write_table(names: &[LinkName], out: &Path) -> Result<()> {
    let mut table = String::from("sample_name,map_id,tx_x,tx_y,rx_x,rx_y,aps_norm,file_path\n");
    for name in names {
        let ([tx_x, tx_y], [rx_x, rx_y]) = (name.tx_m, name.rx_m);
        let map = name.map;
        table +=
            &format!("aps_{name},{map},{tx_x},{tx_y},{rx_x},{rx_y},std,samples/aps_{name}.npz\n");
    }
    Ok(replace_unsynced(&out.join(TABLE_FILE), table.as_bytes())?)
}
