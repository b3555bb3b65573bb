//! Maps as settings and arguments name them.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::{MapError, MapSource, TileSettings};
use crate::error::Result;

/// Maps by their name: a folder, the file of a city, or synthetic cities. Nothing is read before they are opened.
///
/// ```
/// use map2aps::maps::NamedMaps;
///
/// let maps: NamedMaps = "synthetic:3".parse()?;
/// assert_eq!(maps, NamedMaps::Synthetic { count: Some(3) });
/// assert_eq!(maps.open(Default::default(), 10)?.ids()?, [0, 1, 2]);
/// # Ok::<(), map2aps::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NamedMaps {
    /// `DIR`: RadioMapSeer files.
    Folder(PathBuf),
    /// A file that is there, or has the name of one (`.geojson`): a city.
    City(PathBuf),
    /// `synthetic` or `synthetic:N`.
    Synthetic {
        /// Number of maps, if one is asked for.
        count: Option<u32>,
    },
}

impl NamedMaps {
    /// Opens the maps, of synthetic cities so many unless a number is asked for; a city is read and cut into tiles.
    ///
    /// # Errors
    /// A city that cannot be read or holds no map, and settings of tiles for other maps.
    pub fn open(&self, tiles: TileSettings, synthetic: u32) -> Result<MapSource> {
        let source = match self {
            Self::City(file) => return MapSource::geojson(file, tiles),
            Self::Folder(folder) => MapSource::Folder(folder.clone()),
            Self::Synthetic { count } => MapSource::Synthetic {
                count: count.unwrap_or(synthetic),
            },
        };
        tiles.must_be_default()?;
        Ok(source)
    }
}

impl FromStr for NamedMaps {
    type Err = MapError;

    fn from_str(text: &str) -> Result<Self, MapError> {
        let is_geojson = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("geojson");
        let path = Path::new(text);
        match text.split_once(':') {
            None if text == "synthetic" => Ok(Self::Synthetic { count: None }),
            Some(("synthetic", count)) => match count.parse() {
                Ok(count) if count > 0 => Ok(Self::Synthetic { count: Some(count) }),
                _ => Err(MapError::Count(count.into())),
            },
            _ if path.is_file() || path.extension().is_some_and(is_geojson) => {
                Ok(Self::City(path.into()))
            }
            _ => Ok(Self::Folder(path.into())),
        }
    }
}

/// Writes the name that [`FromStr`] reads.
impl fmt::Display for NamedMaps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) | Self::City(path) => write!(f, "{}", path.display()),
            Self::Synthetic { count: None } => write!(f, "synthetic"),
            Self::Synthetic { count: Some(n) } => write!(f, "synthetic:{n}"),
        }
    }
}
