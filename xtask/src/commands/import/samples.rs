//! Preprocessed samples: normalised labels with their condition images.
//!
//! A sample has lost its level and its scale: aps_norm = (p - mean) / deviation of the relative power p. The level is
//! set to 0 dB, and the scale such that the weakest bin has no power, which a spectrum with a deep null comes close to.
//! Normalised again, the label is the same up to rounding; decibels are good near the maximum and mean nothing 60 dB
//! below.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use aps_data::released::{LinkName, Sample};
use aps_data::{
    Axis, DatasetConfig, DatasetWriter, Layout, LinkStatus, Links, MapInput, Precision,
    ProfileLayout, Raster, RasterGrid,
};
use aps_label::LabelConfig;
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde_json::json;

use super::rows::Rows;
use super::{Ends, LINKS_AT_ONCE, Target, must_have_maps, named_files};

/// Power of a bin without power, relative to the maximum [dB]: the floor of the label.
const NO_POWER_DB: f64 = -350.0;

/// Import normalised labels with condition images in samples/aps_*.npz.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder that holds samples/.
    folder: PathBuf,
    #[command(flatten)]
    target: Target,
}

impl Args {
    pub fn run(self) -> Result<()> {
        let mut maps: BTreeMap<u32, Vec<LinkName>> = BTreeMap::new();
        for name in named_files(&self.folder.join("samples"), "aps_", ".npz")? {
            maps.entry(name.map).or_default().push(name);
        }
        must_have_maps(
            &maps,
            &self.folder,
            "files samples/aps_N_TXX_TXY_RXX_RXY.npz",
        )?;
        let first = maps.values().flatten().next().expect("there is a map");
        let first = self.read(first)?;
        let config = DatasetConfig {
            seed: self.target.seed,
            layout: Layout {
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
            },
            configuration: json!({ "import": "samples", "label": LabelConfig::released() }),
        };
        self.target
            .make(config, &maps, |writer, id, names, progress| {
                self.map(writer, id, names, progress)
            })
    }

    fn map(
        &self,
        writer: &DatasetWriter,
        id: u32,
        names: &[LinkName],
        progress: &ProgressBar,
    ) -> Result<()> {
        let ends = Ends::of(names);
        let layout = writer.config().layout;
        let buildings = self.read(&names[0])?;
        let buildings = buildings_of(&buildings, layout.raster)
            .with_context(|| format!("sample {}", names[0]))?;
        let mut map = writer.begin_map(
            id,
            &MapInput {
                buildings: &buildings,
                tx_m: &ends.tx_m,
                rx_m: &ends.rx_m,
                links: Links::List(&ends.links),
            },
        )?;
        for names in names.chunks(LINKS_AT_ONCE) {
            let links: Vec<Result<Rows>> = names
                .par_iter()
                .map(|name| self.link(name, &layout, &buildings))
                .collect();
            let mut rows = Rows::default();
            for link in links {
                rows.append(link?);
            }
            map.push(&rows.link_rows(&layout))?;
            progress.inc(names.len() as u64);
        }
        map.finish()?;
        Ok(())
    }

    fn link(&self, name: &LinkName, layout: &Layout, buildings: &Raster) -> Result<Rows> {
        let sample = self.read(name)?;
        let bins = layout.aps.map_or(0, |aps| aps.axis.count);
        ensure!(
            sample.aps_norm.len() == bins,
            "sample {name}: {} bins, the first one has {bins}",
            sample.aps_norm.len()
        );
        ensure!(
            buildings_of(&sample, layout.raster)? == *buildings,
            "sample {name}: its buildings are not those of the map's first sample"
        );
        let mut rows = Rows {
            status: vec![LinkStatus::Valid],
            ..Rows::default()
        };
        rows.aps.db = relative_db(&sample.aps_norm);
        Ok(rows)
    }

    fn read(&self, name: &LinkName) -> Result<Sample> {
        let path = self.folder.join(name.sample_file());
        let place = || format!("'{}'", path.display());
        Sample::from_npz(&fs::read(&path).with_context(place)?).with_context(place)
    }
}

fn buildings_of(sample: &Sample, grid: RasterGrid) -> Result<Raster> {
    ensure!(
        sample.size == [grid.height, grid.width],
        "its image is {} x {}, the first one's {} x {}",
        sample.size[0],
        sample.size[1],
        grid.height,
        grid.width
    );
    let plane = &sample.cond_img[..grid.height * grid.width];
    let pixels = plane.iter().map(|&v| {
        if v == 0.0 {
            0
        } else if v == 1.0 {
            1
        } else {
            2
        }
    });
    Raster::from_pixels(grid, pixels.collect())
        .context("a pixel of its buildings is neither 0 nor 1")
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
