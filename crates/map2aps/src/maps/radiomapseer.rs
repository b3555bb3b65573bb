//! Maps in RadioMapSeer's files.

use std::path::{Path, PathBuf};

use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, Footprint, parse_radiomapseer};

use super::MapError;
use super::scene_settings::{MIN_BUILDING_M, SceneSettings, bounds};
use crate::error::{At, Error, Place, Result};

/// Most digits of a map's name.
const MAX_DIGITS: usize = 10;

/// The maps of a folder, ascending.
pub fn ids(folder: &Path) -> Result<Vec<u32>> {
    let mut ids = Vec::new();
    for entry in std::fs::read_dir(folder).at_file(Place::MapFolder, folder)? {
        let name = entry?.file_name();
        let stem = name.to_str().and_then(|n| n.strip_suffix(".json"));
        ids.extend(stem.and_then(id_of));
    }
    ids.sort_unstable();
    if let Some(twice) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
        file_of(folder, twice[0])?;
    }
    match ids.is_empty() {
        true => Err(Error::Map(MapError::NoMap(folder.into()))),
        false => Ok(ids),
    }
}

/// The map that a file is by its name without the ending: digits alone.
fn id_of(stem: &str) -> Option<u32> {
    let is_number = stem.len() <= MAX_DIGITS && stem.bytes().all(|b| b.is_ascii_digit());
    is_number.then(|| stem.parse().ok())?
}

/// The file of a map in a folder, its number with or without zeros before it.
pub fn file_of(folder: &Path, id: u32) -> Result<PathBuf, MapError> {
    let mut names: Vec<String> = (1..=MAX_DIGITS).map(|n| format!("{id:0n$}.json")).collect();
    names.dedup();
    let named: Vec<&String> = names.iter().filter(|n| folder.join(n).exists()).collect();
    match named[..] {
        [] => Ok(folder.join(&names[0])),
        [name] => Ok(folder.join(name)),
        [a, b, ..] => Err(MapError::TwoFiles {
            folder: folder.into(),
            id,
            files: [a.clone(), b.clone()],
        }),
    }
}

/// The scene of a file's bytes.
pub fn scene(bytes: &[u8], settings: SceneSettings) -> Result<Scene> {
    settings.scene(&footprints(bytes)?, Area::RADIOMAPSEER)
}

/// The footprints in a file's bytes.
pub fn footprints(bytes: &[u8]) -> Result<Vec<Footprint>> {
    let footprints = parse_radiomapseer(bytes)?;
    let boxes: Vec<(DVec2, DVec2)> = footprints.iter().map(|f| bounds(&f.outer)).collect();
    let Some(&(first, _)) = boxes.first() else {
        return Err(MapError::NoBuilding.into());
    };
    let sizes = boxes.iter().map(|(min, max)| (max - min).max_element());
    let size_m = sizes.fold(0.0, f64::max);
    if size_m < MIN_BUILDING_M {
        let buildings = footprints.len();
        return Err(MapError::Unit { buildings, size_m }.into());
    }
    let Area { min, max } = Area::RADIOMAPSEER;
    if !boxes
        .iter()
        .any(|(low, high)| low.cmplt(max).all() && high.cmpgt(min).all())
    {
        return Err(MapError::Elsewhere { min, max, first }.into());
    }
    Ok(footprints)
}
