//! Links of a data set with their paths, stored or traced again.

use std::collections::BTreeMap;

use aps_data::{Dataset, MapData, PathTable};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, Receiver, Scene, TraceConfig, Tracer};
use rayon::prelude::*;

use crate::dataset::stored_paths;
use crate::error::Result;
use crate::maps::MapSource;
use crate::scenes::Scenes;
use crate::settings;

/// A data set, and the maps it was made of where they are at hand.
#[derive(Debug, Clone)]
pub struct LinkSource {
    dataset: Dataset,
    scenes: Scenes,
    trace: Option<TraceConfig>,
}

/// One map of a [`LinkSource`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LinkMap {
    /// Terminals, links and spectra.
    pub data: MapData,
    /// The scene that the map was made of, if it is at hand.
    pub scene: Option<Scene>,
    stored: Option<PathTable>,
    trace: Option<TraceConfig>,
}

impl LinkSource {
    /// The links of a data set. Without `maps` its own are used if they were synthetic; paths that are not stored are
    /// traced again where there are maps.
    ///
    /// # Errors
    /// Unknown settings in the manifest.
    pub fn new(dataset: Dataset, maps: Option<MapSource>) -> Result<Self> {
        let configuration = &dataset.manifest().configuration;
        Ok(Self {
            scenes: Scenes::new(configuration, dataset.manifest().seed, maps)?,
            trace: settings::tracing_of(configuration)?.map(|(_, trace)| trace),
            dataset,
        })
    }

    /// The data set.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Loads a map and, where there are any, its paths.
    ///
    /// # Errors
    /// A map that is not there or cannot be read, and [`MapError::OtherBuildings`](crate::MapError::OtherBuildings) for a given one.
    pub fn map(&self, id: u32) -> Result<LinkMap> {
        let data = self.dataset.map(id)?;
        Ok(LinkMap {
            stored: stored_paths(&self.dataset, id)?,
            scene: self.scenes.scene(id, &data.buildings)?,
            trace: self.trace.clone(),
            data,
        })
    }
}

impl LinkMap {
    /// Returns true when the paths of links are known.
    pub fn has_paths(&self) -> bool {
        self.stored.is_some() || (self.scene.is_some() && self.trace.is_some())
    }

    /// The row of the link from one transmitter to one receiver.
    pub fn row_of(&self, tx: u32, rx: u32) -> Option<usize> {
        self.data.links.iter().position(|&link| link == [tx, rx])
    }

    /// The paths of some links, given by their rows, in that order: a table of one link each. Without stored paths they
    /// are traced; links whose paths are not known have none.
    ///
    /// # Errors
    /// Links that cannot be traced.
    ///
    /// # Panics
    /// When there is no such row.
    pub fn paths(&self, rows: &[usize]) -> Result<Vec<PathTable>> {
        if let Some(stored) = &self.stored {
            let rows = rows.iter();
            return Ok(rows.map(|&row| stored.of_links([row])).collect());
        }
        match (&self.scene, &self.trace) {
            (Some(scene), Some(trace)) => self.traced(scene, trace, rows),
            _ => {
                let mut none = PathTable::default();
                none.end_link();
                Ok(vec![none; rows.len()])
            }
        }
    }

    /// Traces links on all threads; each terminal is prepared once.
    fn traced(&self, scene: &Scene, trace: &TraceConfig, rows: &[usize]) -> Result<Vec<PathTable>> {
        let tracer = Tracer::new(scene, trace.clone())?;
        let mut of_tx: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        let mut receivers: BTreeMap<u32, Option<Receiver>> = BTreeMap::new();
        for (place, &row) in rows.iter().enumerate() {
            let [tx, rx] = self.data.links[row];
            of_tx.entry(tx).or_default().push(place);
            receivers.insert(rx, None);
        }
        receivers.par_iter_mut().try_for_each(|(&rx, receiver)| {
            let prepared = tracer.receiver(DVec2::from(self.data.rx_m[rx as usize]))?;
            *receiver = Some(prepared);
            Result::<()>::Ok(())
        })?;
        let groups: Vec<Vec<(usize, PathTable)>> = of_tx
            .into_par_iter()
            .map(|(tx, places)| {
                let tx = tracer.transmitter(DVec2::from(self.data.tx_m[tx as usize]))?;
                let one = |place: usize| {
                    let [_, rx] = self.data.links[rows[place]];
                    let receiver = receivers[&rx].as_ref();
                    let receiver = receiver.expect("every receiver was prepared");
                    let mut link = Link::default();
                    tracer.link(&tx, receiver, &mut link)?;
                    let mut table = PathTable::default();
                    table.push_records(&link.paths);
                    Ok((place, table))
                };
                places.into_iter().map(one).collect::<Result<_>>()
            })
            .collect::<Result<_>>()?;
        let mut links: Vec<(usize, PathTable)> = groups.into_iter().flatten().collect();
        links.sort_by_key(|(place, _)| *place);
        Ok(links.into_iter().map(|(_, table)| table).collect())
    }
}
