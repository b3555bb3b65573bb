#[path = "../../../../tests/files.rs"]
mod files;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use aps_data::{
    Axis, DatasetConfig, DatasetWriter, Error, InteractionKind, Layout, LinkRows, LinkStatus,
    Links, MapInput, PathTable, Precision, ProfileLayout, ProfileRows, Raster, RasterGrid, Split,
};
use serde_json::json;
use tempfile::TempDir;

pub use files::files as contents;

pub const ANGLES: usize = 5;
pub const DELAYS: usize = 9;
pub const GRID: RasterGrid = RasterGrid {
    width: 10,
    height: 4,
    metres_per_pixel: 1.0,
};

/// Every kind of array, small axes.
pub fn config() -> DatasetConfig {
    let axis = |stop, count| Axis {
        start: 0.0,
        stop,
        count,
        endpoint: false,
    };
    let layout = Layout {
        raster: GRID,
        aps: Some(ProfileLayout {
            axis: axis(360.0, ANGLES),
            dtype: Precision::F16,
            argmax: true,
        }),
        pdp: Some(ProfileLayout {
            axis: axis(1000.0, DELAYS),
            dtype: Precision::F32,
            argmax: true,
        }),
        paths: true,
    };
    let configuration = json!({
        "tracer": { "max_reflections": 2, "frequency_hz": 3.5e9 },
        "label": { "protocol": "paper", "spacing": 0.1 }
    });
    DatasetConfig {
        seed: u64::MAX,
        layout,
        configuration,
    }
}

/// Values that `write_map` gives the links of a map, in rows of links.
#[derive(Default)]
pub struct Rows {
    pub status: Vec<LinkStatus>,
    pub fallback: Vec<u8>,
    pub aps_db: Vec<f64>,
    pub aps_delay_ns: Vec<f64>,
    pub pdp_db: Vec<f64>,
    pub pdp_angle_deg: Vec<f64>,
    pub paths: PathTable,
}

impl Rows {
    /// Rows that differ for each map and link; every fourth link has no path.
    pub fn of(map: u32, links: std::ops::Range<usize>) -> Self {
        let mut rows = Rows::default();
        for link in links {
            let x = f64::from(map) + link as f64 / 7.0;
            let is_valid = link % 4 != 3;
            rows.status.push(match is_valid {
                true => LinkStatus::Valid,
                false => LinkStatus::NoPath,
            });
            rows.fallback.push((link % 3) as u8);
            rows.aps_db
                .extend((0..ANGLES).map(|i| -70.0 - x - 3.0 * i as f64));
            rows.aps_delay_ns
                .extend((0..ANGLES).map(|i| 100.0 + i as f64));
            rows.pdp_db
                .extend((0..DELAYS).map(|i| -90.0 + x + i as f64));
            rows.pdp_angle_deg
                .extend((0..DELAYS).map(|i| -45.0 * i as f64));
            let paths = if is_valid { 1 + link % 3 } else { 0 };
            let table = &mut rows.paths;
            for path in 0..paths {
                table.delay_s.push((x + path as f64) * 1e-7 / 3.0);
                table.departure_azimuth_rad.push(x.sin());
                table.arrival_azimuth_rad.push(x.cos());
                table.gain.push([1e-4 / (x + 1.0), -1e-5 * path as f64]);
                for step in 0..path {
                    let kinds = [InteractionKind::Reflection, InteractionKind::Diffraction];
                    table.interaction_kind.push(kinds[step % 2]);
                    table.interaction_id.push(step as u32 + map);
                    table.interaction_point_m.push([x / 3.0, step as f64]);
                }
                table.end_path();
            }
            table.end_link();
        }
        rows
    }

    pub fn as_rows(&self) -> LinkRows<'_> {
        LinkRows {
            links: None,
            status: &self.status,
            fallback: Some(&self.fallback),
            aps: Some(ProfileRows {
                db: &self.aps_db,
                argmax: Some(&self.aps_delay_ns),
            }),
            pdp: Some(ProfileRows {
                db: &self.pdp_db,
                argmax: Some(&self.pdp_angle_deg),
            }),
            paths: Some(&self.paths),
        }
    }
}

pub const TX: [[f64; 2]; 2] = [[0.0, 0.5], [3.0, 3.0]];
pub const RX: [[f64; 2]; 3] = [[1.0, 2.0], [2.0, 1.0], [0.1, 0.2]];
pub const LINKS: usize = TX.len() * RX.len();

pub static BUILDINGS: LazyLock<Raster> = LazyLock::new(|| {
    let house = vec![[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];
    Raster::of_outlines(&[house], GRID).unwrap()
});

/// A map with a house, and all links between its terminals.
pub fn input() -> MapInput<'static> {
    MapInput {
        buildings: &BUILDINGS,
        tx_m: &TX,
        rx_m: &RX,
        links: Links::Grid,
    }
}

/// Writes one map, its links in chunks of the given size.
pub fn write_map(writer: &DatasetWriter, id: u32, chunk: usize) -> Result<(), Error> {
    let mut map = writer.begin_map(id, &input())?;
    for first in (0..LINKS).step_by(chunk) {
        map.push(&Rows::of(id, first..LINKS.min(first + chunk)).as_rows())?;
    }
    map.finish().map(|_| ())
}

/// Puts a whole data set of maps 0 to 3 into a folder.
pub fn write(root: &Path) -> Split {
    // Written once, then copied: syncing its many small files to disk for every test takes long.
    static FILES: LazyLock<BTreeMap<String, Vec<u8>>> = LazyLock::new(|| {
        let root = tempfile::tempdir().unwrap();
        let writer = DatasetWriter::open(root.path(), config()).unwrap();
        for id in 0..4 {
            write_map(&writer, id, LINKS).unwrap();
        }
        writer.finish(&Split::of_maps(0..4, 0)).unwrap();
        contents(root.path())
    });
    for (name, bytes) in FILES.iter() {
        let path = root.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    Split::of_maps(0..4, 0)
}

/// A folder with the data set of [`write`].
pub fn written() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    write(root.path());
    root
}

/// Opens the data set of a folder to be written, with the settings of [`config`].
pub fn writer(root: &TempDir) -> DatasetWriter {
    DatasetWriter::open(root.path(), config()).unwrap()
}

/// Changes bytes of a file from place `at` on.
pub fn change(path: &Path, at: usize, value: &[u8]) {
    let mut bytes = fs::read(path).unwrap();
    bytes[at..at + value.len()].copy_from_slice(value);
    fs::write(path, bytes).unwrap();
}

/// Changes a bit of the last byte of a file.
pub fn damage_end(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(path, bytes).unwrap();
}
