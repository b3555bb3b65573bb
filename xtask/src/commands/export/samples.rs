//! Preprocessed samples: normalised labels with their condition images.

use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use aps_data::released::{LinkName, Sample};
use aps_data::{ConditionConfig, ConditionImages, MapData, Profile, npy, replace_unsynced};
use aps_label::{MeanStd, Normalization};

use super::Exporter;

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
    pub fn new(map: &'a MapData) -> Result<Self> {
        let images = ConditionImages::new(&map.buildings, ConditionConfig::default());
        let aps = map
            .aps
            .as_ref()
            .context("the data set has no angle power spectra; make it with --store aps")?;
        Ok(Self { map, aps, images })
    }
}

impl Exporter for Samples<'_> {
    type Scratch = ();

    fn folders(&self, _: u32) -> Vec<PathBuf> {
        vec!["samples".into()]
    }

    fn link(&self, link: usize, name: &LinkName, out: &Path, (): &mut ()) -> Result<u64> {
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

/// `env_maps/N.npy`: the image of the buildings by itself.
pub fn write_buildings(map: &MapData, out: &Path) -> Result<()> {
    let folder = out.join("env_maps");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create '{}'", folder.display()))?;
    let grid = map.buildings.grid();
    let pixels: Vec<f32> = map
        .buildings
        .pixels()
        .iter()
        .copied()
        .map(f32::from)
        .collect();
    let mut bytes = Vec::new();
    npy::write_to(&mut bytes, &[grid.height, grid.width], &pixels)?;
    Ok(replace_unsynced(
        &folder.join(format!("{}.npy", map.id)),
        &bytes,
    )?)
}

/// `metadata.csv`: a row a sample, with the columns of the published preprocessing.
pub fn write_table(names: &[LinkName], out: &Path) -> Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record([
        "sample_name",
        "map_id",
        "tx_x",
        "tx_y",
        "rx_x",
        "rx_y",
        "aps_norm",
        "file_path",
    ])?;
    for name in names {
        let [tx_x, tx_y] = name.tx_m;
        let [rx_x, rx_y] = name.rx_m;
        let file = format!("samples/aps_{name}.npz");
        table.serialize((
            format!("aps_{name}"),
            name.map,
            tx_x,
            tx_y,
            rx_x,
            rx_y,
            "std",
            file,
        ))?;
    }
    Ok(replace_unsynced(
        &out.join("metadata.csv"),
        &table.into_inner()?,
    )?)
}
