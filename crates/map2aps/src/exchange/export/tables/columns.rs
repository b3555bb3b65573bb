//! The columns of the tables: the names, values and words of each, in one place.

use std::ops::Range;

use aps_data::{MapData, Part, PathTable, Profile, Raster};

/// A column of a table.
pub struct Column {
    pub name: &'static str,
    /// Unit, or empty.
    pub unit: &'static str,
    pub meaning: &'static str,
    pub values: Values,
}

fn column(name: &'static str, unit: &'static str, meaning: &'static str, values: Values) -> Column {
    Column {
        name,
        unit,
        meaning,
        values,
    }
}

/// Values of a column, one a row.
pub enum Values {
    Integers(Vec<i32>),
    Floats(Vec<f32>),
    Doubles(Vec<f64>),
    Texts(Vec<String>),
    Bytes(Vec<Vec<u8>>),
    /// Lists, of which the values stand one after the other, and their lengths.
    FloatLists(Vec<f32>, Vec<usize>),
    DoubleLists(Vec<f64>, Vec<usize>),
}

impl Values {
    /// Type of one value, as a schema of Parquet, the card and the description name it.
    pub fn types(&self) -> [&'static str; 3] {
        match self {
            Self::Integers(_) => ["int32", "int32", "sc:Integer"],
            Self::Floats(_) | Self::FloatLists(..) => ["float", "float32", "sc:Float"],
            Self::Doubles(_) | Self::DoubleLists(..) => ["double", "float64", "sc:Float"],
            Self::Texts(_) => ["binary", "string", "sc:Text"],
            Self::Bytes(_) => ["binary", "binary", "sc:Text"],
        }
    }

    /// True for many values a row.
    pub fn are_lists(&self) -> bool {
        matches!(self, Self::FloatLists(..) | Self::DoubleLists(..))
    }
}

/// Folder of a part of the split.
pub fn folder_of(part: Option<Part>) -> &'static str {
    part.map_or("other", Part::name)
}

/// The columns of some links of a map.
pub fn of_links(
    map: &MapData,
    pdp: Option<&Profile>,
    paths: Option<&PathTable>,
    rows: Range<usize>,
) -> Vec<Column> {
    let integers =
        |value: &dyn Fn(usize) -> i32| Values::Integers(rows.clone().map(value).collect());
    let end = |end: usize, axis: usize| {
        let place = |row: usize| {
            let (tx_m, rx_m) = map.ends_m(row);
            [tx_m, rx_m][end][axis]
        };
        Values::Doubles(rows.clone().map(place).collect())
    };
    let status = rows.clone().map(|row| map.status[row].to_string());
    let mut columns = vec![
        column("map", "", "number of the map", integers(&|_| map.id as i32)),
        column(
            "link",
            "",
            "row of the link in the map",
            integers(&|row| row as i32),
        ),
        column(
            "tx",
            "",
            "number of the transmitter in the map",
            integers(&|row| map.links[row][0] as i32),
        ),
        column(
            "rx",
            "",
            "number of the receiver in the map",
            integers(&|row| map.links[row][1] as i32),
        ),
        column("tx_x_m", "m", "position of the transmitter", end(0, 0)),
        column("tx_y_m", "m", "position of the transmitter", end(0, 1)),
        column("rx_x_m", "m", "position of the receiver", end(1, 0)),
        column("rx_y_m", "m", "position of the receiver", end(1, 1)),
        column(
            "status",
            "",
            "`valid` for a link with a label, else the reason for none",
            Values::Texts(status.collect()),
        ),
        column(
            "fallback",
            "",
            "diffractions of the link's paths where none was inside the tracer's limits, else 0",
            integers(&|row| map.fallback[row].into()),
        ),
    ];
    let profiles = [
        (map.aps.as_ref(), ["aps_db", "aps_max_db", "aps_delay_ns"]),
        (pdp, ["pdp_db", "pdp_max_db", "pdp_angle_deg"]),
    ];
    for (profile, names) in profiles {
        let Some(profile) = profile else { continue };
        let meanings = match names[0] {
            "aps_db" => [
                "power over arrival azimuth, relative to the link's largest value",
                "that largest value: the label is it plus each of `aps_db`",
                "delay at which the maximum over delay was found, for each azimuth",
            ],
            _ => [
                "power over delay, relative to the link's largest value",
                "that largest value: the profile is it plus each of `pdp_db`",
                "azimuth at which the maximum over azimuth was found, for each delay",
            ],
        };
        let lists = |values: Vec<f32>| Values::FloatLists(values, vec![profile.bins(); rows.len()]);
        let (bins, mut db) = (profile.bins(), vec![0.0; rows.len() * profile.bins()]);
        for (row, values) in rows.clone().zip(db.chunks_exact_mut(bins)) {
            profile.read_relative_db(row, values);
        }
        let largest = profile.max_db()[rows.clone()].to_vec();
        columns.push(column(names[0], "dB", meanings[0], lists(db)));
        columns.push(column(names[1], "dB", meanings[1], Values::Floats(largest)));
        if let Some(places) = profile.argmax() {
            let places = &places[rows.start * bins..rows.end * bins];
            let unit = if names[0] == "aps_db" { "ns" } else { "deg" };
            let places = places.iter().map(|place| place.to_f32()).collect();
            columns.push(column(names[2], unit, meanings[2], lists(places)));
        }
    }
    if let Some(paths) = paths {
        columns.extend(of_paths(paths, rows));
    }
    columns
}

fn of_paths(paths: &PathTable, rows: Range<usize>) -> Vec<Column> {
    let lengths: Vec<usize> = rows.clone().map(|row| paths.paths_of(row).len()).collect();
    let range = match rows.is_empty() {
        true => 0..0,
        false => paths.paths_of(rows.start).start..paths.paths_of(rows.end - 1).end,
    };
    let lists = |value: &dyn Fn(usize) -> f64| {
        Values::DoubleLists(range.clone().map(value).collect(), lengths.clone())
    };
    let columns: [(_, _, _, &dyn Fn(usize) -> f64); 5] = [
        ("path_delay_s", "s", "delay of each path", &|path| {
            paths.delay_s[path]
        }),
        (
            "path_departure_azimuth_rad",
            "rad",
            "direction from the transmitter to the first interaction of each path, or to the receiver",
            &|path| paths.departure_azimuth_rad[path],
        ),
        (
            "path_arrival_azimuth_rad",
            "rad",
            "direction from the receiver to the last interaction of each path, or to the transmitter",
            &|path| paths.arrival_azimuth_rad[path],
        ),
        (
            "path_gain_re",
            "",
            "complex amplitude of each path between isotropic antennas, real part",
            &|path| paths.gain[path][0],
        ),
        ("path_gain_im", "", "its imaginary part", &|path| {
            paths.gain[path][1]
        }),
    ];
    let columns = columns.into_iter();
    columns
        .map(|(name, unit, meaning, value)| column(name, unit, meaning, lists(value)))
        .collect()
}

/// Number of a map, its part and the image of its buildings.
pub type MapImage = (u32, Option<Part>, Raster);

/// The columns of the images of buildings.
pub fn of_images(maps: &[MapImage]) -> Vec<Column> {
    let integers =
        |value: &dyn Fn(&MapImage) -> i32| Values::Integers(maps.iter().map(value).collect());
    let parts = maps.iter().map(|(_, part, _)| folder_of(*part).into());
    let spacings_m = maps.iter().map(|(.., image)| image.grid().metres_per_pixel);
    let pixels = maps.iter().map(|(.., image)| image.pixels().to_vec());
    vec![
        column(
            "map",
            "",
            "number of the map",
            integers(&|(id, ..)| *id as i32),
        ),
        column(
            "split",
            "",
            "part of the split",
            Values::Texts(parts.collect()),
        ),
        column(
            "height",
            "pixels",
            "rows of the image",
            integers(&|(.., image)| image.grid().height as i32),
        ),
        column(
            "width",
            "pixels",
            "columns of the image",
            integers(&|(.., image)| image.grid().width as i32),
        ),
        column(
            "metres_per_pixel",
            "m",
            "distance of neighbouring pixels; pixel (x, y) stands for the point (x, y) times it",
            Values::Doubles(spacings_m.collect()),
        ),
        column(
            "pixels",
            "",
            "a byte a pixel, row by row from y = 0: 1 where it touches a building, else 0",
            Values::Bytes(pixels.collect()),
        ),
    ]
}
