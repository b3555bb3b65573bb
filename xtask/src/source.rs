//! Links of a data set as pictures need them.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use aps_data::Dataset;
use aps_label::LabelConfig;
use aps_raytrace::glam::DVec2;
use aps_report::link::LinkView;
use aps_report::picture::Outlines;
use map2aps::maps::{NamedMaps, ranges};
use map2aps::{LinkMap, LinkSource, counted, settings};
use serde_json::Value;

use crate::args::TileArgs;

/// A data set, and the maps it was made from where they are at hand.
pub struct Source {
    links: LinkSource,
    label: LabelConfig,
}

/// One map of it.
pub struct SourceMap {
    pub map: LinkMap,
    pub outlines: Outlines,
}

impl Source {
    /// Opens a data set. Without `maps` its own are used if they were synthetic; a city is cut as it was.
    pub fn open(folder: &Path, maps: Option<&NamedMaps>, tiles: &TileArgs) -> Result<Self> {
        let place = || format!("data set '{}'", folder.display());
        let dataset = Dataset::open(folder).with_context(place)?;
        let configuration = &dataset.manifest().configuration;
        // Imported data sets may lack settings.
        let label = match configuration.get("label").is_some() {
            true => settings::label_of(configuration).with_context(place)?,
            false => LabelConfig::default(),
        };
        let maps = tiles.open_for(maps, configuration).with_context(place)?;
        let links = LinkSource::new(dataset, maps).with_context(place)?;
        Ok(Self { links, label })
    }

    /// The data set.
    pub fn dataset(&self) -> &Dataset {
        self.links.dataset()
    }

    /// Settings of its labels.
    pub fn label(&self) -> &LabelConfig {
        &self.label
    }

    /// Loads a map with its buildings and, where there are any, its paths.
    pub fn map(&self, id: u32) -> Result<SourceMap> {
        let map = self.links.map(id)?;
        let outlines = match &map.scene {
            Some(scene) => Outlines::of_scene(scene),
            None => {
                let (raster, grid) = (&map.data.buildings, map.data.buildings.grid());
                let is_set = |x: usize, y: usize| raster.row(y)[x] != 0;
                Outlines::of_pixels([grid.width, grid.height], grid.metres_per_pixel, is_set)
            }
        };
        Ok(SourceMap { map, outlines })
    }

    /// Refuses a link that has no paths to look at, and says why.
    pub fn must_have_paths(&self, source: &SourceMap, row: usize) -> Result<()> {
        ensure!(
            source.map.has_paths(),
            "the data set stores no paths; give {}, or make it with --store aps,paths",
            wanted_maps(&self.dataset().manifest().configuration)
        );
        let data = &source.map.data;
        let status = data.status[row];
        ensure!(
            status.is_valid(),
            "link {row} of map {} has no label: {status}",
            data.id
        );
        Ok(())
    }
}

impl SourceMap {
    /// Some links, by their rows. Without paths, they have none.
    pub fn links(&self, rows: &[usize]) -> Result<Vec<LinkView>> {
        let tables = self.map.paths(rows)?;
        let views = rows.iter().zip(&tables).map(|(&row, table)| {
            let (tx, rx) = self.map.data.ends_m(row);
            LinkView::stored([tx, rx].map(DVec2::from), table, 0)
        });
        Ok(views.collect())
    }

    /// The row of the link from one transmitter to one receiver.
    pub fn row_of(&self, tx: u32, rx: u32) -> Result<usize> {
        self.map.row_of(tx, rx).with_context(|| {
            let data = &self.map.data;
            let of_tx = data.links.iter().filter(|&&[from, _]| from == tx);
            let mut receivers: Vec<u32> = of_tx.map(|&[_, to]| to).collect();
            receivers.sort_unstable();
            let known = match receivers.len() {
                0 => format!("it has {} transmitters, from 0", data.tx_m.len()),
                count => format!(
                    "that transmitter has {}: {}",
                    counted(count, "link, to receiver", "links, to receivers"),
                    shortened(&receivers)
                ),
            };
            format!(
                "map {} has no link from transmitter {tx} to receiver {rx}; {known}",
                data.id
            )
        })
    }
}

/// The first of some ascending numbers as a list like `0-4,7`.
fn shortened(ascending: &[u32]) -> String {
    const SHOWN: usize = 20;
    let more = match ascending.len() > SHOWN {
        true => ", ...",
        false => "",
    };
    ranges(&ascending[..ascending.len().min(SHOWN)]) + more
}

/// Names the option by which the maps of a data set are given, for messages that ask for them.
pub fn wanted_maps(configuration: &Value) -> &'static str {
    match configuration["maps"]["kind"] == "geojson" {
        true => "--maps FILE.geojson, the city it was made from",
        false => "--maps DIR, the maps it was made from",
    }
}

/// A link of a data set, `MAP,TX,RX`: map number, rows of transmitter and receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LinkId {
    pub map: u32,
    pub tx: u32,
    pub rx: u32,
}

impl std::str::FromStr for LinkId {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}' is not MAP,TX,RX, three whole numbers like 0,3,17");
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.map_err(|_| wrong())?[..] {
            [map, tx, rx] => Ok(Self { map, tx, rx }),
            _ => Err(wrong()),
        }
    }
}
