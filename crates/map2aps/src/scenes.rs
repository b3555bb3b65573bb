//! The scenes that the maps of a data set were made of.

use aps_raytrace::Scene;
use serde_json::Value;

use crate::error::Result;
use crate::maps::identity::Kept;
use crate::maps::{MapError, MapSource, SceneSettings};
use crate::settings;

/// Source of the scenes of a data set: maps that were given, or its own where no file is needed for them.
#[derive(Debug, Clone)]
pub(crate) struct Scenes {
    /// The maps, and whether they were given.
    maps: Option<(MapSource, bool)>,
    seed: u64,
    settings: SceneSettings,
}

impl Scenes {
    /// The scenes of a data set whose manifest holds `configuration` and `seed`. Without `given` maps its own are used if they
    /// were synthetic.
    ///
    /// # Errors
    /// Unknown settings.
    pub fn new(configuration: &Value, seed: u64, given: Option<MapSource>) -> Result<Self> {
        let own = || MapSource::of_dataset(configuration).map(|maps| (maps, false));
        Ok(Self {
            maps: given.map(|maps| (maps, true)).or_else(own),
            seed,
            settings: settings::scene_of(configuration)?,
        })
    }

    /// The scene that a map was made of, if it is at hand: one that was given must be it, another is used if it is.
    ///
    /// # Errors
    /// A given map that is not there or cannot be read, [`MapError::OtherBuildings`] and [`MapError::NoImage`].
    pub fn scene(&self, id: u32, buildings: &Kept) -> Result<Option<Scene>> {
        let Some((maps, is_given)) = &self.maps else {
            return Ok(None);
        };
        let scene = match maps.load(id, self.seed, self.settings) {
            Ok(scene) => scene,
            Err(_) if !is_given => return Ok(None),
            Err(error) => return Err(error),
        };
        match (buildings.is_of(&scene)?, is_given) {
            (true, _) => Ok(Some(scene)),
            (false, false) => Ok(None),
            (false, true) if buildings.is_blank() => Err(MapError::NoImage(id).into()),
            (false, true) => Err(MapError::OtherBuildings {
                id,
                maps: maps.to_string(),
            }
            .into()),
        }
    }
}
