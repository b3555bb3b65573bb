//! Links of a data set as pictures need them: with buildings and paths, stored or traced again.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use aps_data::{Dataset, MapData, PathTable, Raster};
use aps_label::LabelConfig;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, Receiver, Scene, TraceConfig, Tracer, Transmitter};
use aps_report::link::LinkView;
use aps_report::picture::Outlines;
use rayon::prelude::*;

use crate::maps::{self, MapSource, SceneSettings};
use crate::settings;
use crate::tiles::TileArgs;

/// A data set, and the maps it was made from where they are at hand.
pub struct Source {
    dataset: Dataset,
    /// The maps, and whether they were asked for by name.
    maps: Option<(MapSource, bool)>,
    label: LabelConfig,
    trace: Option<TraceConfig>,
}

/// One map of it.
pub struct SourceMap {
    pub data: MapData,
    pub outlines: Outlines,
    stored: Option<PathTable>,
    again: Option<(Scene, TraceConfig)>,
}

impl Source {
    /// Opens a data set. Without `maps` its own are used if they were synthetic; a city is cut as it was.
    pub fn open(folder: &Path, maps: Option<MapSource>, tiles: &TileArgs) -> Result<Self> {
        let place = || format!("data set '{}'", folder.display());
        let dataset = Dataset::open(folder).with_context(place)?;
        let configuration = &dataset.manifest().configuration;
        // Imported data sets may lack settings.
        let tracing = settings::tracing_of(configuration).with_context(place)?;
        let label = match configuration.get("label").is_some() {
            true => settings::label_of(configuration).with_context(place)?,
            false => LabelConfig::default(),
        };
        let is_synthetic = configuration
            .get("maps")
            .is_some_and(|maps| maps == "synthetic");
        let maps = maps
            .map(|maps| match maps {
                MapSource::City { .. } => maps.cut_for(folder, configuration, tiles),
                // Maps of other sources are compared by their buildings, map by map.
                _ => Ok(maps),
            })
            .transpose()?;
        let own = is_synthetic.then_some((MapSource::Synthetic { count: None }, false));
        Ok(Self {
            maps: maps.map(|maps| (maps, true)).or(own),
            label,
            trace: tracing.map(|(_, trace)| trace),
            dataset,
        })
    }

    /// The data set.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Settings of its labels.
    pub fn label(&self) -> &LabelConfig {
        &self.label
    }

    /// Loads a map with its buildings and, where there are any, its paths.
    pub fn map(&self, id: u32) -> Result<SourceMap> {
        let data = self.dataset.map(id)?;
        let stores_paths = self.dataset.manifest().layout.paths;
        let stored = stores_paths.then(|| self.dataset.paths(id)).transpose()?;
        let scene = self.original(id, &data.buildings)?;
        let outlines = match &scene {
            Some(scene) => Outlines::of_scene(scene),
            None => outlines(&data.buildings),
        };
        let again = scene.filter(|_| stored.is_none()).zip(self.trace.clone());
        Ok(SourceMap {
            data,
            outlines,
            stored,
            again,
        })
    }

    /// Refuses a link that has no paths to look at, and says why.
    pub fn must_have_paths(&self, map: &SourceMap, row: usize) -> Result<()> {
        ensure!(
            map.has_paths(),
            "the data set stores no paths; give {}, or make it with --store aps,paths",
            maps::wanted(&self.dataset.manifest().configuration)
        );
        let status = map.data.status[row];
        ensure!(
            status.is_valid(),
            "link {row} of map {} has no label: {status}",
            map.data.id
        );
        Ok(())
    }

    /// The map it was made from: one given by name must be it, another is used if it is.
    fn original(&self, id: u32, buildings: &Raster) -> Result<Option<Scene>> {
        let Some((maps, is_asked_for)) = &self.maps else {
            return Ok(None);
        };
        let manifest = self.dataset.manifest();
        let settings = SceneSettings::of_dataset(&manifest.configuration)?;
        let scene = match maps.load(id, manifest.seed, settings) {
            Ok(scene) => scene,
            Err(_) if !is_asked_for => return Ok(None),
            Err(error) => return Err(error),
        };
        let raster = maps::raster(&scene, buildings.grid())?;
        match (raster == *buildings, is_asked_for) {
            (true, _) => Ok(Some(scene)),
            (false, false) => Ok(None),
            (false, true) => bail!(
                "map {id} of '{maps}' is not the one the data set was made from: their buildings differ"
            ),
        }
    }
}

impl SourceMap {
    /// Returns true when links come with their paths.
    pub fn has_paths(&self) -> bool {
        self.stored.is_some() || self.again.is_some()
    }

    /// Some links, by their rows. Without paths, they have none.
    pub fn links(&self, rows: &[usize]) -> Result<Vec<LinkView>> {
        if let Some((scene, config)) = &self.again {
            return trace_again(&self.data, scene, config, rows);
        }
        let view = |&row: &usize| {
            let (tx, rx) = self.data.ends_m(row);
            let [tx, rx] = [tx, rx].map(DVec2::from);
            match &self.stored {
                Some(table) => LinkView::stored([tx, rx], table, row),
                None => LinkView::traced(tx, rx, &[]),
            }
        };
        Ok(rows.iter().map(view).collect())
    }

    /// The row of the link from one transmitter to one receiver.
    pub fn row_of(&self, tx: u32, rx: u32) -> Result<usize> {
        let found = self.data.links.iter().position(|&l| l == [tx, rx]);
        found.with_context(|| {
            format!(
                "map {} has no link from transmitter {tx} to receiver {rx}; it has {} transmitters, {} receivers and {} links",
                self.data.id,
                self.data.tx_m.len(),
                self.data.rx_m.len(),
                self.data.links.len()
            )
        })
    }
}

/// Buildings that are known by their raster alone.
fn outlines(raster: &Raster) -> Outlines {
    let grid = raster.grid();
    let is_set = |x: usize, y: usize| raster.row(y)[x] != 0;
    Outlines::of_pixels([grid.width, grid.height], grid.metres_per_pixel, is_set)
}

fn trace_again(
    data: &MapData,
    scene: &Scene,
    config: &TraceConfig,
    rows: &[usize],
) -> Result<Vec<LinkView>> {
    let tracer = Tracer::new(scene, config.clone())?;
    let mut of_tx: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut rx: BTreeMap<u32, Option<Receiver>> = BTreeMap::new();
    for (place, &row) in rows.iter().enumerate() {
        let [t, r] = data.links[row];
        of_tx.entry(t).or_default().push(place);
        rx.insert(r, None);
    }
    rx.par_iter_mut().try_for_each(|(&r, receiver)| {
        *receiver = Some(tracer.receiver(data.rx_m[r as usize].into())?);
        anyhow::Ok(())
    })?;
    let one = |tx: &Transmitter, row: usize| -> Result<LinkView> {
        let mut link = Link::default();
        let end = rx[&data.links[row][1]].as_ref();
        tracer.link(tx, end.expect("every receiver was prepared"), &mut link)?;
        let (tx, rx) = data.ends_m(row);
        Ok(LinkView::traced(
            DVec2::from(tx),
            DVec2::from(rx),
            &link.paths,
        ))
    };
    let groups: Vec<Vec<(usize, LinkView)>> = of_tx
        .into_par_iter()
        .map(|(t, places)| {
            let tx = tracer.transmitter(data.tx_m[t as usize].into())?;
            let traced = places
                .into_iter()
                .map(|place| Ok((place, one(&tx, rows[place])?)));
            traced.collect::<Result<Vec<_>>>()
        })
        .collect::<Result<_>>()?;
    let mut links: Vec<(usize, LinkView)> = groups.into_iter().flatten().collect();
    links.sort_by_key(|(place, _)| *place);
    Ok(links.into_iter().map(|(_, link)| link).collect())
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
