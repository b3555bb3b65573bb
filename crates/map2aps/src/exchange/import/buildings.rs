//! The buildings of an imported map.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use aps_data::{Raster, RasterGrid};
use aps_raytrace::Scene;
use aps_raytrace::glam::{DVec2, dvec2};
use aps_raytrace::scene::Location;
use serde_json::{Value, json};

use crate::error::Result;
use crate::exchange::ExchangeError;
use crate::maps::identity::{SOURCE, with_outlines};
use crate::maps::{self, MapSource, SceneSettings};

/// Places are whole metres in names: an end that seems to be this far inside a building may stand outside \[m\].
const MARGIN_M: f64 = 1.0;

/// A link in this many that ends inside a building may do so by an error of its own place.
const LINKS_PER_ERROR: usize = 100;

/// The buildings of a map: drawn from its footprints, or none where no maps are given.
pub(super) struct Buildings {
    pub image: Raster,
    /// The scene, and the file that it is of.
    scene: Option<(Scene, PathBuf)>,
    inside: Mutex<Inside>,
}

/// Labelled links of which an end lies inside a building.
#[derive(Default)]
struct Inside {
    count: usize,
    first: Option<InsideLink>,
}

/// The ends of a link \[m\], and which of them lies inside.
type InsideLink = ([[f64; 2]; 2], &'static str);

impl Buildings {
    pub fn of(maps: Option<&MapSource>, id: u32, seed: u64) -> Result<Self> {
        let Some(maps) = maps else {
            return Ok(Self::drawn(Raster::empty(RasterGrid::default())?));
        };
        let scene = maps.load(id, seed, SceneSettings::default())?;
        let file = match maps {
            MapSource::Folder(folder) => maps::file_of(folder, id)?,
            #[cfg(feature = "geojson")]
            MapSource::City(city) => city.file().into(),
            MapSource::Synthetic { .. } => maps.to_string().into(),
        };
        let image = maps::raster(&scene, maps.raster())?;
        Ok(Self {
            scene: Some((scene, file)),
            ..Self::drawn(image)
        })
    }

    /// Buildings of which nothing but an image is known.
    pub fn drawn(image: Raster) -> Self {
        Self {
            image,
            scene: None,
            inside: Mutex::default(),
        }
    }

    /// Statistics of a map of these buildings and of files with this checksum.
    pub fn statistics(&self, source: Value) -> Value {
        let statistics = json!({ SOURCE: source });
        match &self.scene {
            Some((scene, _)) => with_outlines(statistics, scene),
            None => statistics,
        }
    }

    /// Notes a labelled link, if an end of it lies inside a building.
    pub fn note_ends(&self, tx_m: [f64; 2], rx_m: [f64; 2]) {
        let Some((scene, _)) = &self.scene else {
            return;
        };
        let is_inside = |place_m: [f64; 2]| {
            let steps = [-MARGIN_M, 0.0, MARGIN_M];
            let mut around = steps.into_iter().flat_map(|y| steps.map(|x| dvec2(x, y)));
            around.all(|by: DVec2| {
                let location = scene.locate(DVec2::from(place_m) + by);
                matches!(location, Location::Inside { .. })
            })
        };
        let mut ends = [("transmitter", tx_m), ("receiver", rx_m)].into_iter();
        if let Some((end, _)) = ends.find(|&(_, place_m)| is_inside(place_m)) {
            let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
            inside.count += 1;
            let link = ([tx_m, rx_m], end);
            // Links come in any order.
            if inside.first.is_none_or(|first| link < first) {
                inside.first = Some(link);
            }
        }
    }

    /// Refuses a map of so many links of which too many noted ones end inside a building: it is not that of the labels.
    pub fn check_ends(&self, links: usize) -> Result<(), ExchangeError> {
        let inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        let count = inside.count;
        let (Some((_, map)), Some(([tx_m, rx_m], end))) = (&self.scene, inside.first) else {
            return Ok(());
        };
        match count > 1.max(links / LINKS_PER_ERROR) {
            true => Err(ExchangeError::InBuilding {
                count,
                links,
                tx_m,
                rx_m,
                end,
                map: map.clone(),
            }),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_ends_inside_a_building_are_errors_of_their_own_and_many_those_of_the_map() {
        let buildings = Buildings::of(Some(&MapSource::Synthetic { count: 1 }), 0, 0).unwrap();
        let count = || buildings.inside.lock().unwrap().count;
        // The first receivers that lie inside, from an end that does not, the later one first.
        let outside = [-50.0, -50.0];
        let mut ends = (0..256 * 256).map(|i| [i / 256, i % 256].map(f64::from));
        let inside: Vec<[f64; 2]> = ends
            .by_ref()
            .filter(|&end| {
                let before = count();
                buildings.note_ends(outside, end);
                count() > before
            })
            .take(2)
            .collect();
        let of = |ends: &[[f64; 2]]| {
            *buildings.inside.lock().unwrap() = Inside::default();
            ends.iter()
                .for_each(|&end| buildings.note_ends(outside, end));
            |links| buildings.check_ends(links)
        };
        of(&[outside, inside[0]])(2).unwrap();
        let check = of(&[inside[1], outside, inside[0]]);
        check(200).unwrap();
        let told = check(199).unwrap_err().to_string();
        let first = format!("to {:?} m", inside[0]);
        assert!(
            told.contains("2 of 199 links") && told.contains(&first),
            "{told}"
        );
        assert!(told.contains("its receiver"), "{told}");
    }
}
