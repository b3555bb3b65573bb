//! Links of a data set with their paths, stored or traced again.

use aps_data::{Dataset, MapData, PathTable};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Scene, TraceConfig, Tracer};

use crate::batch::trace_pairs;
use crate::control::Control;
use crate::dataset::stored_paths;
use crate::error::Result;
use crate::maps::MapSource;
use crate::maps::identity::Kept;
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
        let buildings = Kept::new(&self.dataset, id, data.buildings.clone());
        Ok(LinkMap {
            stored: stored_paths(&self.dataset, id)?,
            scene: self.scenes.scene(id, &buildings)?,
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

    fn traced(&self, scene: &Scene, trace: &TraceConfig, rows: &[usize]) -> Result<Vec<PathTable>> {
        let tracer = Tracer::new(scene, trace.clone())?;
        let pair = |&row: &usize| {
            let [tx, rx] = self.data.links[row].map(|end| end as usize);
            [self.data.tx_m[tx], self.data.rx_m[rx]].map(DVec2::from)
        };
        let pairs: Vec<[DVec2; 2]> = rows.iter().map(pair).collect();
        let table = trace_pairs(&tracer, &pairs, |paths| paths, &Control::default())?;
        Ok((0..rows.len()).map(|link| table.of_links([link])).collect())
    }
}
