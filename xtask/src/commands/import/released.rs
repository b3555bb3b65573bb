//! Labels as the published converter writes them: two columns a file, half precision.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use aps_data::released::{LinkName, ProfileFile};
use aps_data::{
    Axis, DatasetConfig, DatasetWriter, Layout, LinkStatus, Links, MapInput, Precision,
    ProfileLayout,
};
use aps_label::{ANGLE_BINS, LabelConfig};
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde_json::json;

use super::rows::Rows;
use super::{Ends, LINKS_AT_ONCE, Target, buildings, must_have_maps, named_files};
use crate::maps::MapSource;
use crate::tiles::TileArgs;

/// Import labels in map_N/N_adps/aps/aps_*.npy, and PDPs beside them.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder that holds map_0, map_1, ...
    folder: PathBuf,
    /// Buildings of the maps: a folder of 0.json, 1.json, ... [default: none, their images stay empty].
    #[arg(long)]
    maps: Option<MapSource>,
    #[command(flatten)]
    target: Target,
    #[command(flatten)]
    tiles: TileArgs,
}

impl Args {
    pub fn run(self) -> Result<()> {
        let source = self
            .maps
            .clone()
            .map(|maps| maps.cut(self.tiles.settings()))
            .transpose()?;
        let maps = self.find()?;
        must_have_maps(
            &maps,
            &self.folder,
            "folders map_N/N_adps/aps with files aps_N_TXX_TXY_RXX_RXY.npy",
        )?;
        let pdp = maps
            .values()
            .flatten()
            .next()
            .is_some_and(|name| self.folder.join(name.pdp_file()).exists());
        let exact = |axis| ProfileLayout {
            axis,
            // Values that came in half precision must leave as they came: the stored values are relative to the maximum.
            dtype: Precision::F32,
            argmax: true,
        };
        let config = DatasetConfig {
            seed: self.target.seed,
            layout: Layout {
                aps: Some(exact(Axis::ANGLE_RELEASED_DEG)),
                pdp: pdp.then(|| exact(Axis::DELAY_RELEASED_NS)),
                paths: false,
                raster: source.as_ref().map(MapSource::raster).unwrap_or_default(),
            },
            configuration: json!({
                "import": "released",
                "maps": source.as_ref().map(MapSource::describe),
                "label": LabelConfig { pdp, ..LabelConfig::released() },
            }),
        };
        self.target
            .make(config, &maps, |writer, id, names, progress| {
                self.map(writer, id, names, source.as_ref(), progress)
            })
    }

    /// The links of each map.
    fn find(&self) -> Result<BTreeMap<u32, Vec<LinkName>>> {
        let mut maps = BTreeMap::new();
        let place = || format!("cannot read '{}'", self.folder.display());
        for entry in fs::read_dir(&self.folder).with_context(place)? {
            let name = entry?.file_name();
            let id = name
                .to_str()
                .and_then(|n| n.strip_prefix("map_")?.parse::<u32>().ok());
            let Some(id) = id else { continue };
            let folder = self.folder.join(format!("map_{id}/{id}_adps/aps"));
            if !folder.is_dir() {
                continue;
            }
            let mut names = named_files(&folder, "aps_", ".npy")?;
            names.retain(|name| name.map == id);
            if !names.is_empty() {
                maps.insert(id, names);
            }
        }
        Ok(maps)
    }

    fn map(
        &self,
        writer: &DatasetWriter,
        id: u32,
        names: &[LinkName],
        source: Option<&MapSource>,
        progress: &ProgressBar,
    ) -> Result<()> {
        let ends = Ends::of(names);
        let layout = writer.config().layout;
        let mut map = writer.begin_map(
            id,
            &MapInput {
                buildings: &buildings(source, id)?,
                tx_m: &ends.tx_m,
                rx_m: &ends.rx_m,
                links: Links::List(&ends.links),
            },
        )?;
        for names in names.chunks(LINKS_AT_ONCE) {
            let links: Vec<Result<Rows>> = names
                .par_iter()
                .map(|name| self.link(name, &layout))
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

fn read(path: &Path, bins: usize) -> Result<ProfileFile> {
    let place = || format!("'{}'", path.display());
    let bytes = fs::read(path).with_context(place)?;
    let profile = ProfileFile::from_bytes(&bytes).with_context(place)?;
    let found = profile.bins.len();
    ensure!(found == bins, "{}: {found} bins, expected {bins}", place());
    Ok(profile)
}
