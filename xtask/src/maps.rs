//! Where maps come from: a folder of RadioMapSeer files, a city in GeoJSON, or the synthetic city.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use aps_data::{Raster, RasterGrid};
use aps_raytrace::Scene;
use aps_raytrace::scene::{Area, CityConfig, Footprint, parse_radiomapseer};
use serde_json::{Value, json};

use crate::tiles::{CutCity, TileArgs};

/// A value of `--maps`.
#[derive(Debug, Clone)]
pub enum MapSource {
    /// `DIR`: files `0.json`, `1.json`, ...
    Folder(PathBuf),
    /// `FILE.geojson`, cut into tiles by [`MapSource::cut`].
    City {
        /// The GeoJSON file.
        file: PathBuf,
        /// Its maps, once it is read and cut.
        cut: Option<Arc<CutCity>>,
    },
    /// `synthetic` or `synthetic:N`.
    Synthetic {
        /// Number of maps, if one is asked for.
        count: Option<u32>,
    },
}

impl FromStr for MapSource {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "synthetic" => Ok(Self::Synthetic { count: None }),
            Some(("synthetic", count)) => match count.parse() {
                Ok(count) if count > 0 => Ok(Self::Synthetic { count: Some(count) }),
                _ => Err(format!(
                    "'{count}' is not a number of maps; try synthetic:10"
                )),
            },
            _ if is_geojson(Path::new(text)) => Ok(Self::City {
                file: text.into(),
                cut: None,
            }),
            _ => Ok(Self::Folder(text.into())),
        }
    }
}

/// Whether a file is a city in GeoJSON, by its name.
pub fn is_geojson(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("geojson"))
}

impl fmt::Display for MapSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) | Self::City { file: path, .. } => write!(f, "{}", path.display()),
            Self::Synthetic { .. } => write!(f, "synthetic city"),
        }
    }
}

/// One map: the buildings as given, and the scene made of them.
pub struct Map {
    pub footprints: Vec<Footprint>,
    pub scene: Scene,
}

impl Map {
    /// The image of its buildings.
    pub fn raster(&self, grid: RasterGrid) -> Result<Raster> {
        let outlines = self.scene.outlines().into_iter();
        let outlines: Vec<Vec<[f64; 2]>> = outlines
            .map(|outline| outline.iter().map(|p| p.to_array()).collect())
            .collect();
        Ok(Raster::of_outlines(&outlines, grid)?)
    }
}

impl MapSource {
    /// Reads a city and cuts it into tiles; other sources stay as they are.
    pub fn cut(self, args: &TileArgs) -> Result<Self> {
        match self {
            Self::City { file, .. } => Ok(Self::City {
                cut: Some(Arc::new(CutCity::read(&file, args)?)),
                file,
            }),
            _ => Ok(self),
        }
    }

    /// What decides the maps, as a manifest keeps it.
    pub fn describe(&self) -> Value {
        match self {
            Self::Folder(_) => json!("radiomapseer"),
            Self::City { cut, .. } => cut.as_ref().map_or(Value::Null, |city| city.describe()),
            Self::Synthetic { .. } => json!("synthetic"),
        }
    }

    /// The image of a map: 256 x 256 pixels, whatever its size.
    pub fn raster(&self) -> RasterGrid {
        match self {
            Self::City {
                cut: Some(city), ..
            } => RasterGrid::square(256, city.side_m()),
            _ => RasterGrid::default(),
        }
    }

    /// The maps there are, by id: all that the folder holds, the city's tiles, or as many cities as asked for.
    pub fn ids(&self, default_count: u32) -> Result<Vec<u32>> {
        let folder = match self {
            Self::Synthetic { count } => return Ok((0..count.unwrap_or(default_count)).collect()),
            Self::City { file, cut } => return uncut(file, cut)?.ids(),
            Self::Folder(folder) => folder,
        };
        let entries = std::fs::read_dir(folder).with_context(|| {
            format!(
                "cannot read the maps in '{}' (give a folder of files 0.json, 1.json, ..., or synthetic:N)",
                folder.display()
            )
        })?;
        let mut ids = Vec::new();
        for entry in entries {
            let name = entry?.file_name();
            let stem = name.to_str().and_then(|n| n.strip_suffix(".json"));
            ids.extend(stem.and_then(|s| s.parse::<u32>().ok()));
        }
        ids.sort_unstable();
        ensure!(
            !ids.is_empty(),
            "no map in '{}': expected files named 0.json, 1.json, ...",
            folder.display()
        );
        Ok(ids)
    }

    /// Reads and checks one map. City `id` has the seed `seed + id`.
    pub fn load(&self, id: u32, seed: u64) -> Result<Map> {
        match self {
            Self::Folder(folder) => load_file(&folder.join(format!("{id}.json"))),
            Self::City { file, cut } => uncut(file, cut)?.load(id),
            Self::Synthetic { .. } => {
                let config = CityConfig {
                    seed: seed.wrapping_add(u64::from(id)),
                    ..CityConfig::default()
                };
                Ok(Map {
                    footprints: config.footprints()?,
                    scene: Scene::synthetic(&config)?,
                })
            }
        }
    }
}

fn uncut<'a>(file: &Path, cut: &'a Option<Arc<CutCity>>) -> Result<&'a CutCity> {
    let place = || format!("city '{}' was not cut into tiles", file.display());
    cut.as_deref().with_context(place)
}

/// Reads and checks one RadioMapSeer file.
pub fn load_file(path: &Path) -> Result<Map> {
    let place = || format!("map '{}'", path.display());
    let text = std::fs::read_to_string(path).with_context(place)?;
    let footprints = parse_radiomapseer(&text).with_context(place)?;
    let scene = Scene::new(&footprints, Some(Area::RADIOMAPSEER)).with_context(place)?;
    Ok(Map { footprints, scene })
}

/// Ids in a list like `0-4,7,46-50`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IdList(pub Vec<u32>);

impl FromStr for IdList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |part: &str| format!("'{part}' is not a map id or a range like 0-4");
        let mut ids = Vec::new();
        for part in text.split(',') {
            let (from, to) = part.split_once('-').unwrap_or((part, part));
            let from: u32 = from.trim().parse().map_err(|_| wrong(part))?;
            let to: u32 = to.trim().parse().map_err(|_| wrong(part))?;
            if from > to || to - from >= 1_000_000 {
                return Err(wrong(part));
            }
            ids.extend(from..=to);
        }
        ids.sort_unstable();
        ids.dedup();
        Ok(Self(ids))
    }
}

/// Ascending ids as a list that [`IdList`] reads, like `0-4,7`.
pub fn ranges(ids: &[u32]) -> String {
    let runs = ids.chunk_by(|a, b| a + 1 == *b);
    let run = |run: &[u32]| match run {
        [first, .., last] => format!("{first}-{last}"),
        ids => ids.iter().map(u32::to_string).collect(),
    };
    runs.map(run).collect::<Vec<_>>().join(",")
}

/// The chosen maps, all of which must be there.
pub fn choose(available: &[u32], chosen: &IdList) -> Result<Vec<u32>> {
    let missing: Vec<u32> = chosen
        .0
        .iter()
        .copied()
        .filter(|id| available.binary_search(id).is_err())
        .collect();
    if !missing.is_empty() {
        bail!("maps {missing:?} are not there; available are {available:?}");
    }
    Ok(chosen.0.clone())
}
