//! Where maps come from: a folder of RadioMapSeer files, a city in GeoJSON, or the synthetic city.
//!
//! A file that is there is read for what it holds, whatever its name.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use aps_data::{Raster, RasterGrid};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, CityConfig, Footprint, SceneConfig, parse_radiomapseer};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::tiles::{CutCity, MIN_BUILDING_M, TileArgs, TileSettings, bounds};

/// A value of `--maps`.
#[derive(Debug, Clone)]
pub enum MapSource {
    /// `DIR`: files `0.json`, `1.json`, ..., also with zeros before the number.
    Folder(PathBuf),
    /// A file, cut into tiles by [`MapSource::cut`].
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
            _ if is_file(Path::new(text)) => Ok(Self::City {
                file: text.into(),
                cut: None,
            }),
            _ => Ok(Self::Folder(text.into())),
        }
    }
}

/// Returns true when a path is a file, or has the name of one (`.geojson`).
fn is_file(path: &Path) -> bool {
    let is_geojson = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("geojson");
    path.is_file() || path.extension().is_some_and(is_geojson)
}

/// Returns true when a JSON text is a list, like the maps of RadioMapSeer, and no object, like those of GeoJSON.
pub fn is_list(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().first() == Some(&b'[')
}

impl fmt::Display for MapSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) | Self::City { file: path, .. } => write!(f, "{}", path.display()),
            Self::Synthetic { .. } => write!(f, "synthetic city"),
        }
    }
}

/// The image of a scene's buildings.
pub fn raster(scene: &Scene, grid: RasterGrid) -> Result<Raster> {
    let in_numbers = |outline: &Vec<DVec2>| outline.iter().map(DVec2::to_array).collect();
    let outlines: Vec<Vec<[f64; 2]>> = scene.outlines().iter().map(in_numbers).collect();
    Ok(Raster::of_outlines(&outlines, grid)?)
}

/// Settings of the scenes made from maps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct SceneSettings {
    /// Fill slits between walls that are narrower [m]; 0 leaves all open.
    #[arg(
        long = "close-gaps",
        value_name = "METRES",
        default_value_t = SceneConfig::default().close_gaps_m,
        value_parser = parse_width
    )]
    pub close_gaps_m: f64,
}

fn parse_width(text: &str) -> Result<f64, String> {
    let width: Result<f64, _> = text.parse();
    let is_width = |w: &f64| w.is_finite() && *w >= 0.0;
    let wrong = || format!("'{text}' is no width in metres: it must be finite and not negative");
    width.ok().filter(is_width).ok_or_else(wrong)
}

impl Default for SceneSettings {
    fn default() -> Self {
        Self {
            close_gaps_m: SceneConfig::default().close_gaps_m,
        }
    }
}

impl SceneSettings {
    /// The settings in the configuration of a data set; before format version 2 no slit was filled.
    pub fn of_dataset(configuration: &Value) -> Result<Self> {
        match configuration.get("scene") {
            None => Ok(Self { close_gaps_m: 0.0 }),
            Some(scene) => serde_json::from_value(scene.clone())
                .context("its manifest has unknown scene settings"),
        }
    }

    /// Makes a scene in the area of a map.
    pub fn scene(self, footprints: &[Footprint], area: Area) -> Result<Scene> {
        let config = SceneConfig {
            area: Some(area),
            close_gaps_m: self.close_gaps_m,
        };
        Ok(Scene::with_config(footprints, &config)?)
    }
}

impl MapSource {
    /// Reads a city and cuts it into tiles; other sources stay as they are.
    pub fn cut(self, settings: TileSettings) -> Result<Self> {
        match self {
            Self::City { file, .. } => Ok(Self::City {
                cut: Some(Arc::new(CutCity::read(&file, settings)?)),
                file,
            }),
            _ => Ok(self),
        }
    }

    /// The same for the maps of a data set, by the settings in its configuration; refuses others than those it was made of,
    /// as far as that can be told.
    pub fn cut_for(self, folder: &Path, configuration: &Value, args: &TileArgs) -> Result<Self> {
        let stored = &configuration["maps"];
        let maps = self.cut(args.settings_of(stored))?;
        let given = maps.describe();
        let is_same = match (stored, &given) {
            (Value::Null, _) => true,
            // Manifests of earlier versions say less.
            (Value::Object(stored), Value::Object(given)) => stored
                .iter()
                .all(|(name, value)| given.get(name) == Some(value)),
            _ => *stored == given,
        };
        ensure!(
            is_same,
            "'{}' was made of maps {stored}, --maps gives {given}",
            folder.display()
        );
        Ok(maps)
    }

    /// Describes the settings that decide the maps, as a manifest keeps them.
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
                "cannot read the maps in '{}' (give a folder of files 0.json, 1.json, ..., a GeoJSON file, or synthetic:N)",
                folder.display()
            )
        })?;
        let mut ids = Vec::new();
        for entry in entries {
            let name = entry?.file_name();
            let stem = name.to_str().and_then(|n| n.strip_suffix(".json"));
            ids.extend(stem.and_then(id_of));
        }
        ids.sort_unstable();
        ensure!(
            !ids.is_empty(),
            "no map in '{}': expected files named 0.json, 1.json, ...",
            folder.display()
        );
        if let Some(twice) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
            file_of(folder, twice[0])?;
        }
        Ok(ids)
    }

    /// Reads and checks one map. Synthetic city `id` has the seed `seed + id`.
    pub fn load(&self, id: u32, seed: u64, settings: SceneSettings) -> Result<Scene> {
        match self {
            Self::Folder(folder) => load_file(&file_of(folder, id)?, settings),
            Self::City { file, cut } => uncut(file, cut)?.load(id, settings),
            Self::Synthetic { .. } => {
                let config = CityConfig {
                    seed: seed.wrapping_add(u64::from(id)),
                    ..CityConfig::default()
                };
                let area = Area {
                    min: DVec2::ZERO,
                    max: DVec2::splat(config.size_m.into()),
                };
                settings.scene(&config.footprints()?, area)
            }
        }
    }
}

/// Names the option by which the maps of a data set are given, for messages that ask for them.
pub fn wanted(configuration: &Value) -> &'static str {
    match configuration["maps"]["kind"] == "geojson" {
        true => "--maps FILE.geojson, the city it was made from",
        false => "--maps DIR, the maps it was made from",
    }
}

fn uncut<'a>(file: &Path, cut: &'a Option<Arc<CutCity>>) -> Result<&'a CutCity> {
    let place = || format!("city '{}' was not cut into tiles", file.display());
    cut.as_deref().with_context(place)
}

/// Most digits of a map's name.
const MAX_DIGITS: usize = 10;

/// The map that a file is by its name without the ending: digits alone.
fn id_of(stem: &str) -> Option<u32> {
    let is_number = stem.len() <= MAX_DIGITS && stem.bytes().all(|b| b.is_ascii_digit());
    is_number.then(|| stem.parse().ok())?
}

/// The file of a map in a folder, its number with or without zeros before it.
fn file_of(folder: &Path, id: u32) -> Result<PathBuf> {
    let mut names: Vec<String> = (1..=MAX_DIGITS).map(|n| format!("{id:0n$}.json")).collect();
    names.dedup();
    let named: Vec<&String> = names.iter().filter(|n| folder.join(n).exists()).collect();
    match named[..] {
        [] => Ok(folder.join(&names[0])),
        [name] => Ok(folder.join(name)),
        [a, b, ..] => bail!(
            "'{}' has two files of map {id}, {a} and {b}; remove one",
            folder.display()
        ),
    }
}

/// Reads the one map that a command asks for: a RadioMapSeer file, a tile of a city in GeoJSON (the first that is a map,
/// if none is named), or `synthetic`.
pub fn load_one(
    path: &Path,
    tile: Option<u32>,
    seed: u64,
    args: &TileArgs,
    settings: SceneSettings,
) -> Result<Scene> {
    if path == Path::new("synthetic") {
        return MapSource::Synthetic { count: None }.load(0, seed, settings);
    }
    let place = || format!("map '{}'", path.display());
    ensure!(path.is_file(), "{}: no such file", place());
    let bytes = std::fs::read(path).with_context(place)?;
    match is_list(&bytes) {
        true => of_radiomapseer(&bytes, settings).with_context(place),
        false => {
            let city = CutCity::of_bytes(&bytes, path, args.settings())?;
            city.load(tile.unwrap_or(city.ids()?[0]), settings)
        }
    }
}

/// Reads and checks one RadioMapSeer file.
fn load_file(path: &Path, settings: SceneSettings) -> Result<Scene> {
    let place = || format!("map '{}'", path.display());
    let bytes = std::fs::read(path).with_context(place)?;
    of_radiomapseer(&bytes, settings).with_context(place)
}

fn of_radiomapseer(bytes: &[u8], settings: SceneSettings) -> Result<Scene> {
    let footprints = parse_radiomapseer(bytes)?;
    ensure!(!footprints.is_empty(), "no building in it");
    let boxes: Vec<(DVec2, DVec2)> = footprints.iter().map(|f| bounds(&f.outer)).collect();
    let sizes = boxes.iter().map(|(min, max)| (max - min).max_element());
    let size_m = sizes.fold(0.0, f64::max);
    ensure!(
        size_m >= MIN_BUILDING_M,
        "the largest of {} buildings is {size_m:.3} m long: the numbers must be in another unit",
        footprints.len()
    );
    let area = Area::RADIOMAPSEER;
    let meets =
        |(min, max): &(DVec2, DVec2)| min.cmplt(area.max).all() && max.cmpgt(area.min).all();
    ensure!(
        boxes.iter().any(meets),
        "no building in the square from {} to {} m; the first is at {} m",
        area.min,
        area.max,
        boxes[0].0
    );
    settings.scene(&footprints, area)
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
