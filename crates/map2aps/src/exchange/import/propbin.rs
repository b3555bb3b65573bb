//! Paths in RayVerse's `.propbin` files, labelled like traced ones.
//!
//! Each file is one transmitter, `source_K.propbin` the K-th of its map; the map is the N of the folder `map_N` it is
//! in, however deep. Receivers are matched by their places. What the plane of a data set has no room for is left out:
//! heights and elevations. Gains have no phase there, so they are stored as real, positive numbers.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::f64::consts::{PI, TAU};
use std::fs;
use std::iter::repeat_n;
use std::path::{Path, PathBuf};

use aps_data::propbin::{self, Chain, Propbin, Receiver};
use aps_data::{
    DatasetConfig, DatasetWriter, InteractionKind, Layout, LinkStatus, Links, MapInput, MapWriter,
    Stored, UNKNOWN_ID,
};
use aps_label::{LabelConfig, Labeler, Status};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::json;

use super::buildings::Buildings;
use super::dataset::{
    Imported, LINKS_AT_ONCE, LeftOut, make, must_have_maps, source, without_ends,
};
use super::named::map_number;
use crate::batch::Buffers;
use crate::control::Control;
use crate::dataset::Rows;
use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;
use crate::in_order::in_order;
use crate::maps::MapSource;
use crate::path_list::check_azimuth;

/// Losses and delays beyond these are no paths but damage.
const MAX_LOSS_DB: f32 = 3000.0;
const MAX_DELAY_NS: f32 = 1e9;

/// A chain's ends this close to source or receiver are these themselves \[m\].
const SAME_PLACE_M: f32 = 1e-3;

/// Import of paths in `.propbin` or `.propbin.gz` files: a file a transmitter, a folder `map_N` a map.
#[derive(Debug, Clone)]
pub struct ImportPropbin {
    /// A file, or a folder to be searched with all folders in it.
    pub source: PathBuf,
    /// Number of the map for files that are in no folder `map_N`.
    pub map_id: u32,
    /// Buildings of the maps; without them, their images stay empty.
    pub maps: Option<MapSource>,
    /// Number of a map's receivers to draw; otherwise all.
    pub rx_per_map: Option<usize>,
    /// Settings of the labels; [`LabelConfig::pdp`] is taken from `stored`.
    pub label: LabelConfig,
    /// Kinds of data to store.
    pub stored: Stored,
    /// Seed of the receivers drawn, of the split, and of synthetic maps.
    pub seed: u64,
}

/// A place in the plane by the bits of its coordinates \[m\].
type Point = (u32, u32);

impl ImportPropbin {
    /// Makes a data set in the folder `out`. Maps that it holds already are kept.
    ///
    /// # Errors
    /// Files that are not there, cannot be read or hold paths that cannot be labelled, settings out of range, a folder
    /// with another data set, and cancellation.
    pub fn run(&self, out: &Path, control: &Control<'_>) -> Result<Imported> {
        let source = self.maps.as_ref();
        let maps = self.find()?;
        must_have_maps(&maps, &self.source, "files *.propbin or *.propbin.gz")?;
        let label = LabelConfig {
            pdp: self.stored.pdp,
            ..self.label.clone()
        };
        let labeler = Labeler::new(&label)?;
        let raster = source.map(MapSource::raster).unwrap_or_default();
        let config = DatasetConfig {
            seed: self.seed,
            layout: Layout::of_labels(&label, raster, self.stored),
            configuration: json!({
                "import": "propbin",
                "maps": source.map(MapSource::describe),
                "sampling": { "rx_per_map": self.rx_per_map },
                "label": label,
            }),
        };
        let mut left_out = LeftOut::default();
        let made = make(
            out,
            config,
            &maps,
            self.maps.as_ref(),
            control,
            |writer, id, files| self.map(writer, id, files, &labeler, &mut left_out, control),
        )?;
        Ok(Imported { left_out, ..made })
    }

    /// The files of each map in the order of their transmitters.
    fn find(&self) -> Result<BTreeMap<u32, Vec<PathBuf>>> {
        let mut numbered: BTreeMap<(u32, u64, String), PathBuf> = BTreeMap::new();
        let mut to_search = vec![self.source.clone()];
        while let Some(path) = to_search.pop() {
            if fs::metadata(&path).at_file(Place::Reading, &path)?.is_dir() {
                for entry in fs::read_dir(&path).at_file(Place::Reading, &path)? {
                    to_search.push(entry?.path());
                }
                continue;
            }
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let Some(stem) = name
                .strip_suffix(".gz")
                .unwrap_or(&name)
                .strip_suffix(".propbin")
            else {
                continue;
            };
            let number = stem.rsplit('_').next().and_then(|n| n.parse().ok());
            // Files without a number come last, by their names.
            let (number, stem) = match number {
                Some(number) => (number, String::new()),
                None => (u64::MAX, stem.to_owned()),
            };
            let key = (self.map_of(&path)?, number, stem);
            if let Some(other) = numbered.insert(key, path.clone()) {
                let files = [other, path];
                return Err(ExchangeError::SameTransmitter(files).into());
            }
        }
        let mut maps: BTreeMap<u32, Vec<PathBuf>> = BTreeMap::new();
        for ((map, _, _), path) in numbered {
            maps.entry(map).or_default().push(path);
        }
        Ok(maps)
    }

    /// The number of the innermost folder `map_N` around a file; one that is too large is a map's only directly around it.
    fn map_of(&self, path: &Path) -> Result<u32> {
        let whole = std::path::absolute(path)?;
        let mut folders = whole.ancestors().skip(1);
        let own = folders.next().map(map_number).transpose()?.flatten();
        let found = own.or_else(|| folders.find_map(|folder| map_number(folder).ok().flatten()));
        Ok(found.unwrap_or(self.map_id))
    }

    fn map(
        &self,
        writer: &DatasetWriter,
        id: u32,
        files: &[PathBuf],
        labeler: &Labeler,
        left_out: &mut LeftOut,
        control: &Control<'_>,
    ) -> Result<()> {
        let places: Vec<(Point, Vec<Point>)> = files
            .par_iter()
            .map(|path| {
                let file = read(path)?;
                let receivers = file.receivers().iter().map(|r| place(r.position_m));
                Ok((place(file.source_m()), receivers.collect()))
            })
            .collect::<Result<_>>()?;
        let all = places.iter().flat_map(|(_, rx)| rx.iter().copied());
        let rx = self.choose(id, all.collect())?;
        let row: HashMap<Point, u32> = rx.iter().copied().zip(0..).collect();
        let mut links = Vec::new();
        for (tx, (_, receivers)) in places.iter().enumerate() {
            let mut seen = HashSet::new();
            let receivers = receivers.iter().filter(|&&place| seen.insert(place));
            let receivers = receivers.filter_map(|place| row.get(place));
            links.extend(receivers.map(|&rx| [tx as u32, rx]));
        }
        let metres = |(x, y): Point| [x, y].map(|bits| f64::from(f32::from_bits(bits)));
        let buildings = Buildings::of(self.maps.as_ref(), id, self.seed)?;
        let mut map = writer.begin_map(
            id,
            &MapInput {
                buildings: &buildings.image,
                tx_m: &places.iter().map(|(tx, _)| metres(*tx)).collect::<Vec<_>>(),
                rx_m: &rx.iter().copied().map(metres).collect::<Vec<_>>(),
                links: Links::List(&links),
            },
        )?;
        for path in files {
            control.check()?;
            let file = read(path)?;
            let links = (&file, &row, &buildings);
            let written = write_links(&mut map, writer, links, labeler, left_out);
            written.at_file(Place::File, path)?;
            control.progress.advance(1);
        }
        buildings.check_ends(links.len())?;
        map.set_statistics(buildings.statistics(source(files)?));
        map.finish()?;
        Ok(())
    }

    /// Returns all places of receivers, from the south up, or some of them in a drawn order.
    fn choose(&self, id: u32, places: BTreeSet<Point>) -> Result<Vec<Point>, ExchangeError> {
        let mut places: Vec<Point> = places.into_iter().collect();
        let key = |&(x, y): &Point| [y, x].map(f32::from_bits);
        places.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("places are finite"));
        if let Some(count) = self.rx_per_map {
            let (found, asked) = (places.len(), count);
            if asked > found {
                return Err(ExchangeError::Receivers { found, asked });
            }
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(u64::from(id));
            places.shuffle(&mut rng);
            places.truncate(count);
        }
        Ok(places)
    }
}

/// Labels and writes all links of one transmitter.
fn write_links(
    map: &mut MapWriter<'_>,
    writer: &DatasetWriter,
    (file, row, buildings): (&Propbin, &HashMap<Point, u32>, &Buildings),
    labeler: &Labeler,
    left_out: &mut LeftOut,
) -> Result<()> {
    left_out.not_finite += file.unusable_paths();
    let mut seen = HashSet::new();
    let mut receivers = Vec::new();
    for receiver in file.receivers() {
        let place = place(receiver.position_m);
        let is_new = seen.insert(place);
        left_out.repeated_receivers += usize::from(!is_new);
        if is_new && row.contains_key(&place) {
            receivers.push(receiver);
        }
    }
    let parts: Vec<&[&Receiver]> = receivers.chunks(LINKS_AT_ONCE).collect();
    let label = |receivers: &&[&Receiver]| label_links(file, receivers, buildings, labeler);
    in_order(&parts, label, |(rows, impossible)| {
        left_out.impossible += impossible;
        Ok(map.push(&without_ends(rows.link_rows(&writer.config().layout)))?)
    })
}

/// The rows of some receivers, and how many paths were impossible.
fn label_links(
    file: &Propbin,
    receivers: &[&Receiver],
    buildings: &Buildings,
    labeler: &Labeler,
) -> Result<(Rows, usize)> {
    let mut buffers = Buffers::default();
    let mut rows = Rows::default();
    let mut impossible = 0;
    for (link, receiver) in receivers.iter().enumerate() {
        for (path, chain) in file.paths_of(receiver) {
            let is_possible =
                path.loss_db.abs() <= MAX_LOSS_DB && (0.0..=MAX_DELAY_NS).contains(&path.delay_ns);
            for (end, direction) in [("departure", path.departure), ("arrival", path.arrival)] {
                check_azimuth(end, direction.azimuth_rad.into())
                    .at(Place::Receiver(receiver.id.into()))?;
            }
            if is_possible {
                add_path(&mut rows, path);
                let ends = [file.source_m(), receiver.position_m];
                add_chain(&mut rows, &chain, ends);
            }
            impossible += usize::from(!is_possible);
        }
        rows.paths.end_link();
        let labelled = buffers.label_stored(labeler, &rows.paths, link);
        let status = match labelled.at(Place::Receiver(receiver.id.into()))? {
            Status::Labelled => LinkStatus::Valid,
            Status::NoPath if !rows.paths.paths_of(link).is_empty() => LinkStatus::Unlabelled,
            Status::NoPath if place(file.source_m()) == place(receiver.position_m) => {
                LinkStatus::SamePoint
            }
            Status::NoPath => LinkStatus::NoPath,
        };
        if status == LinkStatus::Valid {
            let [tx_m, rx_m] =
                [file.source_m(), receiver.position_m].map(|[x, y, _]| [x, y].map(f64::from));
            buildings.note_ends(tx_m, rx_m);
        }
        rows.push_label(labeler, status, &buffers.label);
    }
    Ok((rows, impossible))
}

/// Adds the columns of a path but its interactions.
fn add_path(rows: &mut Rows, path: &propbin::Path) {
    let amplitude = libm::exp10(-f64::from(path.loss_db) / 20.0);
    // Theirs points along the way the wave travels, ours back to where it comes from.
    let arrival_azimuth_rad = turned(f64::from(path.arrival.azimuth_rad));
    // Rounded to single precision, a turn is more than a turn.
    let departure_azimuth_rad = f64::from(path.departure.azimuth_rad) % TAU;
    let table = &mut rows.paths;
    table.delay_s.push(f64::from(path.delay_ns) * 1e-9);
    table.departure_azimuth_rad.push(departure_azimuth_rad);
    table.arrival_azimuth_rad.push(arrival_azimuth_rad);
    table.gain.push([amplitude, 0.0]);
}

/// Adds a path's points between its ends. Vertices are numbers of a table that is not part of the file: without a
/// place they are no interactions.
fn add_chain(rows: &mut Rows, chain: &Chain<'_>, [source, receiver]: [[f32; 3]; 2]) {
    let is_at = |p: &[f32], end: [f32; 3]| (p[0] - end[0]).hypot(p[1] - end[1]) < SAME_PLACE_M;
    let mut points: Vec<[f64; 2]> = Vec::new();
    match chain {
        Chain::Points(all) => {
            let inner = all
                .iter()
                .filter(|p| !is_at(&p[..], source) && !is_at(&p[..], receiver));
            points.extend(inner.map(|p| [f64::from(p[0]), f64::from(p[1])]));
        }
        Chain::Rooftop(all) => points.extend(all.iter().map(|p| p.map(f64::from))),
        Chain::Vertices(_) => {}
    }
    let kind = match chain {
        Chain::Rooftop(_) => InteractionKind::Diffraction,
        Chain::Points(_) | Chain::Vertices(_) => InteractionKind::Other(255),
    };
    let (table, count) = (&mut rows.paths, points.len());
    table.interaction_kind.extend(repeat_n(kind, count));
    table.interaction_id.extend(repeat_n(UNKNOWN_ID, count));
    table.interaction_point_m.append(&mut points);
    table.end_path();
}

/// An angle half a turn further, in (-pi, pi] if it was.
fn turned(azimuth_rad: f64) -> f64 {
    if azimuth_rad > 0.0 {
        azimuth_rad - PI
    } else {
        azimuth_rad + PI
    }
}

fn place([x, y, _]: [f32; 3]) -> Point {
    // -0 is 0.
    ((x + 0.0).to_bits(), (y + 0.0).to_bits())
}

fn read(path: &Path) -> Result<Propbin> {
    Propbin::read(path).at_file(Place::File, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_azimuth_is_beyond_a_turn() {
        for azimuth_rad in [-TAU as f32, -3.0, -0.0, 3.0, 6.25, TAU as f32] {
            let direction = propbin::Direction {
                azimuth_rad,
                elevation_rad: 0.0,
            };
            let path = propbin::Path {
                loss_db: 80.0,
                length_m: 30.0,
                delay_ns: 100.0,
                departure: direction,
                arrival: direction,
            };
            let mut rows = Rows::default();
            add_path(&mut rows, &path);
            let stored = [
                rows.paths.departure_azimuth_rad[0],
                rows.paths.arrival_azimuth_rad[0],
            ];
            assert!(stored.iter().all(|rad| rad.abs() <= TAU), "{stored:?}");
            let given = f64::from(azimuth_rad);
            assert!(given.abs() > TAU || stored[0] == given, "{stored:?}");
        }
    }
}
