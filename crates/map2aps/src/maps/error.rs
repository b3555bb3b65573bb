//! Errors of maps and of the choice of maps.

use std::path::PathBuf;

use aps_data::Part;
use aps_raytrace::glam::DVec2;
use serde_json::Value;

use super::ranges::ranges;

/// Fault of a map, or of the choice of maps.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// Text that is no list of ids.
    #[error("'{0}' is not a map id or a range like 0-4")]
    IdList(String),
    /// A number of synthetic cities that is none.
    #[error("'{0}' is not a number of maps; try synthetic:10")]
    Count(String),
    /// Maps that are not there.
    #[error("maps {missing:?} are not there; available are {}", ranges(available))]
    Missing {
        /// Chosen maps that are not there.
        missing: Vec<u32>,
        /// Maps that are there.
        available: Vec<u32>,
    },
    /// Settings of tiles beside maps that are not cut into tiles.
    #[error(
        "settings of tiles (side, corner, coordinates, which buildings, number) are for a city in GeoJSON; leave them away, for \
         these maps are not cut into tiles"
    )]
    NoTiles,
    /// More synthetic cities than there are ids for.
    #[error(
        "{0} synthetic cities are too many: their ids end at 999999, where those of copies begin"
    )]
    TooMany(u32),
    /// A map in two parts of a split.
    #[error("the split names map {0} twice")]
    Twice(u32),
    /// A number of orientations that a square does not have.
    #[error("a map has 1 to 8 orientations, not {0}")]
    Orientations(u32),
    /// The id of a copy that is not made.
    #[error(
        "map {id} would be a copy in an orientation beyond the {orientations} of this data set"
    )]
    NoCopy {
        /// The id.
        id: u32,
        /// Orientations that the data set has.
        orientations: u32,
    },
    /// A map whose id leaves no room for the ids of its copies.
    #[error(
        "map {0} cannot have copies in other orientations: ids from 1000000 on are those of copies"
    )]
    NoRoomForCopies(u32),
    /// Copies of maps that are no training maps, as when more maps change the split.
    #[error(
        "maps {} are copies of maps that are no training maps among these; make them in another folder, or remove the folders of the \
         copies",
        ranges(.0)
    )]
    CopiesOfOthers(Vec<u32>),
    /// Maps of which one differs from the map that a data set was begun with.
    #[error(
        "map {id} in '{}' was made from another source: it differs in {what} from the one now given; give the former, or another folder, or remove this map's",
        folder.display()
    )]
    OtherSource {
        /// The map.
        id: u32,
        /// The file, or another part of it, that differs.
        what: String,
        /// The folder of the data set.
        folder: PathBuf,
    },
    /// A folder without maps.
    #[error("no map in '{}': expected files named 0.json, 1.json, ...", .0.display())]
    NoMap(PathBuf),
    /// Two files of one map.
    #[error("'{}' has two files of map {id}, {a} and {b}; remove one", folder.display(), a = files[0], b = files[1])]
    TwoFiles {
        /// The folder.
        folder: PathBuf,
        /// The map.
        id: u32,
        /// Names of the files.
        files: [String; 2],
    },
    /// A file that is not there.
    #[error("no such file")]
    NoFile,
    /// A map without buildings.
    #[error("no building in it")]
    NoBuilding,
    /// A map whose numbers cannot be metres.
    #[error(
        "the largest of {buildings} buildings is {size_m:.3} m long: the numbers must be in another unit"
    )]
    Unit {
        /// Number of buildings.
        buildings: usize,
        /// Longest side of a building's bounding box, read as metres.
        size_m: f64,
    },
    /// A map whose buildings are elsewhere.
    #[error("no building in the square from {min} to {max} m; the first is at {first} m")]
    Elsewhere {
        /// Lower left corner of the map \[m\].
        min: DVec2,
        /// Upper right corner of the map \[m\].
        max: DVec2,
        /// Lower left corner of the first building \[m\].
        first: DVec2,
    },
    /// A RadioMapSeer map where a city was expected.
    #[error(
        "'{}' holds a list, as RadioMapSeer's maps do, and no GeoJSON; give the folder that it is in, and its number",
        .0.display()
    )]
    NotGeoJson(PathBuf),
    /// A city without maps.
    #[error("no tile has {0} buildings and less than 95 % of its area built over")]
    NoTile(usize),
    /// A tile without buildings.
    #[error("tile {tile} has no buildings; those with some are {}", ranges(maps))]
    EmptyTile {
        /// The tile.
        tile: u32,
        /// Tiles that are maps.
        maps: Vec<u32>,
    },
    /// Maps that are not those of a data set.
    #[error("the data set was made of maps {stored}, those given are {given}")]
    OtherMaps {
        /// Description of the data set's maps.
        stored: Value,
        /// Description of the maps given.
        given: Value,
    },
    /// A map with other buildings than the data set's.
    #[error(
        "map {id} of '{maps}' is not the one the data set was made from: their buildings differ"
    )]
    OtherBuildings {
        /// The map.
        id: u32,
        /// Name of the maps.
        maps: String,
    },
    /// Links whose geometry is asked for, without the maps.
    #[error(
        "the model is given the outlines of buildings, which a data set does not keep, and the maps that map {0} was made \
         from are not at hand: give them, or use a model of images"
    )]
    NoScene(u32),
    /// A data set without maps.
    #[error(
        "the data set came without maps: its image of map {0} shows no building. Import it again, with the maps that it was \
         made from"
    )]
    NoImage(u32),
    /// A part of a data set without maps.
    #[error("it has no {} maps, only {}", part.name(), of_parts(others))]
    NoPart {
        /// The part.
        part: Part,
        /// Parts that have some.
        others: Vec<Part>,
    },
    /// Text that names no choice of receivers.
    #[error("'{0}' is none of reached, outdoor")]
    Receivers(String),
    /// A scene without an area.
    #[error("the map has no area to draw terminals from")]
    NoArea,
    /// A data set without links.
    #[error("a map needs at least 1 transmitter and 1 receiver, not {tx} and {rx}")]
    NoLinks {
        /// Transmitters wanted.
        tx: usize,
        /// Receivers wanted of each.
        rx: usize,
    },
    /// A map with more grid points than terminals are drawn from.
    #[error(
        "map {id} of {size_m} m has too many grid points to draw terminals from; cut smaller maps"
    )]
    TooLarge {
        /// The map.
        id: u32,
        /// Its size \[m\].
        size_m: DVec2,
    },
    /// A map without room for its terminals.
    #[error(
        "map {id} has only {points} outdoor grid points for {tx} transmitters and {rx} receivers"
    )]
    NoRoom {
        /// The map.
        id: u32,
        /// Outdoor grid points.
        points: usize,
        /// Transmitters wanted.
        tx: usize,
        /// Receivers wanted at least.
        rx: usize,
    },
}

fn of_parts(parts: &[Part]) -> String {
    let names: Vec<&str> = parts.iter().map(|part| part.name()).collect();
    format!("{} maps", names.join(" and "))
}
