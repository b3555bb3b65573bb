//! The maps and scenes that studies are made on.

use anyhow::{Result, bail, ensure};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::CityConfig;
use aps_raytrace::{Area, Scene};
use aps_tests::shapes::{block, rectangle, ring};
use map2aps::SceneSettings;
use map2aps::maps::{NamedMaps, TileSettings, choose};
use xtask::IdList;

use crate::profile::Profile;

/// A scene and its name.
#[derive(Debug, Clone)]
pub struct NamedScene {
    /// Name in words.
    pub name: String,
    /// Number that the terminals are drawn by, besides the seed.
    pub id: u32,
    /// The scene.
    pub scene: Scene,
}

impl NamedScene {
    /// Number of corners around which something could bend.
    pub(crate) fn convex_corners(&self) -> usize {
        let count = self.scene.walls().len() as u32;
        (0..count).filter(|&id| self.scene.is_convex(id)).count()
    }
}

/// Synthetic cities by mean side of a block and mean street width \[m\], the open first.
const DENSITIES: [(&str, u32, u32); 5] = [
    ("city, open", 24, 40),
    ("city, loose", 40, 24),
    ("city, usual", 30, 12),
    ("city, close", 40, 8),
    ("city, dense", 24, 6),
];

/// Number of maps of a folder that are taken if none are named, from the one with the fewest walls to the one with
/// the most.
const CHOSEN: usize = 5;

/// The maps of the study of the tracer.
#[derive(Debug, Clone)]
pub struct MapChoice {
    source: NamedMaps,
    ids: Option<IdList>,
}

impl MapChoice {
    /// Synthetic cities, or maps of a folder: those named, or five from the fewest walls to the most.
    ///
    /// # Errors
    /// A city in GeoJSON, and ids of synthetic cities.
    pub fn new(source: NamedMaps, ids: Option<IdList>) -> Result<Self> {
        match source {
            NamedMaps::Folder(_) => {}
            NamedMaps::City(_) => bail!(
                "--maps {source}: the study of the tracer takes a folder of RadioMapSeer files, or synthetic"
            ),
            NamedMaps::Synthetic { .. } => ensure!(
                ids.is_none(),
                "--ids names maps of a folder; give one with --maps"
            ),
        }
        Ok(Self { source, ids })
    }

    /// The scenes, the fewest walls first.
    ///
    /// # Errors
    /// Maps that are not there or cannot be read.
    pub fn scenes(&self, profile: Profile, seed: u64) -> Result<Vec<NamedScene>> {
        let mut scenes = match self.source {
            NamedMaps::Synthetic { .. } => cities(profile, seed)?,
            NamedMaps::Folder(_) | NamedMaps::City(_) => self.maps(profile, seed)?,
        };
        scenes.sort_by_key(|s| (s.scene.walls().len(), s.id));
        Ok(scenes)
    }

    fn maps(&self, profile: Profile, seed: u64) -> Result<Vec<NamedScene>> {
        let source = self.source.open(TileSettings::default(), 0)?;
        let available = source.ids()?;
        let load = |id: u32| -> Result<NamedScene> {
            Ok(NamedScene {
                name: format!("map {id}"),
                id,
                scene: source.load(id, seed, SceneSettings::default())?,
            })
        };
        if let Some(ids) = &self.ids {
            return choose(&available, &ids.0)?.into_iter().map(load).collect();
        }
        let mut all: Vec<NamedScene> = available.into_iter().map(load).collect::<Result<_>>()?;
        all.sort_by_key(|s| (s.scene.walls().len(), s.id));
        let count = profile.choose(2, CHOSEN).min(all.len());
        let last = all.len() - 1;
        let place = |i: usize| match count {
            0 | 1 => last,
            _ => i * last / (count - 1),
        };
        Ok((0..count).map(|i| all[place(i)].clone()).collect())
    }
}

fn cities(profile: Profile, seed: u64) -> Result<Vec<NamedScene>> {
    let city = |(id, (name, block_m, street_m)): (u32, (&str, u32, u32))| -> Result<NamedScene> {
        let config = CityConfig {
            size_m: profile.choose(128, 256),
            block_m,
            street_m,
            seed: seed.wrapping_add(u64::from(id)),
        };
        Ok(NamedScene {
            name: name.into(),
            id,
            scene: Scene::synthetic(&config)?,
        })
    };
    let every = profile.choose(4, 1);
    (0..).zip(DENSITIES).step_by(every).map(city).collect()
}

/// Scenes that lack something, and two that do not: what each needs differs most.
///
/// # Errors
/// None that the fixed layouts could cause.
pub fn typical(profile: Profile, seed: u64) -> Result<Vec<NamedScene>> {
    let area = |x: [f64; 2], y: [f64; 2]| Area {
        min: DVec2::new(x[0], y[0]),
        max: DVec2::new(x[1], y[1]),
    };
    let size = profile.choose(128.0, 256.0);
    let square = Scene::new(&[], Some(area([0.0, size], [0.0, size])))?;
    let (outer, yard) = (
        ring([0.0, 120.0], [0.0, 100.0]),
        ring([20.0, 100.0], [20.0, 80.0]),
    );
    let courtyard = Scene::new(
        &[block(outer, yard)],
        Some(area([21.0, 99.0], [21.0, 79.0])),
    )?;
    let rows = [60.0, 120.0].map(|y| rectangle(-200.0, y, 456.0, y + 40.0));
    let canyon = Scene::new(&rows, Some(area([0.0, 256.0], [101.0, 119.0])))?;
    let [open, .., dense] = &cities(profile, seed)?[..] else {
        bail!("no synthetic cities");
    };
    let scenes = [
        ("empty square", square),
        ("courtyard", courtyard),
        ("canyon", canyon),
        ("open suburb", open.scene.clone()),
        ("dense old town", dense.scene.clone()),
    ];
    let named = |(id, (name, scene)): (u32, (&str, Scene))| NamedScene {
        name: name.into(),
        id,
        scene,
    };
    Ok((100..).zip(scenes).map(named).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typical_scenes_lack_what_they_are_there_for() {
        let scenes = typical(Profile::Smoke, 1).unwrap();
        let walls = |name: &str| {
            let scene = &scenes.iter().find(|s| s.name == name).unwrap().scene;
            (scene.walls().len(), scene)
        };
        assert_eq!(walls("empty square").0, 0);
        let (_, courtyard) = walls("courtyard");
        assert!(courtyard.courtyard_of(DVec2::new(50.0, 50.0)).is_some());
        assert!(walls("dense old town").0 > walls("open suburb").0);
    }

    #[test]
    fn unnamed_maps_reach_from_the_fewest_walls_to_the_most() {
        let folder = tempfile::tempdir().unwrap();
        for (id, houses) in [(0, 3), (1, 1), (2, 9), (3, 4), (4, 2), (5, 8), (6, 5)] {
            let house = |i: usize| {
                let (left, right) = (10 + 20 * i, 19 + 20 * i);
                format!("[[{left},10],[{right},10],[{right},19],[{left},10]]")
            };
            let houses: Vec<String> = (0..houses).map(house).collect();
            let text = format!("[{}]", houses.join(","));
            std::fs::write(folder.path().join(format!("{id}.json")), text).unwrap();
        }
        let source = NamedMaps::Folder(folder.path().into());
        let ids = |ids: Option<IdList>| -> Vec<u32> {
            let maps = MapChoice::new(source.clone(), ids).unwrap();
            let scenes = maps.scenes(Profile::Full, 1).unwrap();
            scenes.iter().map(|s| s.id).collect()
        };
        assert_eq!(ids(None), [1, 4, 3, 6, 2]);
        assert_eq!(ids(Some(IdList(vec![2, 4]))), [4, 2]);
    }
}
