//! Paths in RayVerse's `.propbin` files, labelled like traced ones.
//!
//! Each file is one transmitter, `source_K.propbin` the K-th of its map; the map is the N of the folder `map_N` it is
//! in, however deep. Receivers are matched by their places. What the plane of a data set has no room for is left out:
//! heights and elevations. Gains have no phase there, so they are stored as real, positive numbers.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use aps_data::propbin::{self, Chain, Propbin, Receiver};
use aps_data::{
    DatasetConfig, DatasetWriter, InteractionKind, Layout, LinkStatus, Links, MapInput, MapWriter,
    UNKNOWN_ID,
};
use aps_label::{Label, LabelConfig, Labeler, PathSample, Scratch, Status};
use indicatif::ProgressBar;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::json;

use super::rows::Rows;
use super::{LINKS_AT_ONCE, Target, buildings, must_have_maps};
use crate::args::{self, LabelArgs, Store};
use crate::maps::MapSource;
use crate::samples::check_azimuth;
use crate::say;
use crate::tiles::TileArgs;

/// Losses and delays beyond these are no paths but damage.
const MAX_LOSS_DB: f32 = 3000.0;
const MAX_DELAY_NS: f32 = 1e9;

/// A chain's ends this close to source or receiver are these themselves [m].
const SAME_PLACE_M: f32 = 1e-3;

/// Import paths in .propbin or .propbin.gz files: a file a transmitter, a folder map_N a map.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A file, or a folder to be searched with all folders in it.
    source: PathBuf,
    /// Number of the map for files that are in no folder map_N.
    #[arg(long, default_value_t = 0)]
    map_id: u32,
    /// Buildings of the maps: a folder of 0.json, 1.json, ... [default: none, their images stay empty].
    #[arg(long)]
    maps: Option<MapSource>,
    /// Draw so many of a map's receivers [default: all].
    #[arg(long)]
    rx_per_map: Option<usize>,
    #[command(flatten)]
    label: LabelArgs,
    /// Data to store: any of aps,pdp,paths.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "aps,paths")]
    store: Vec<Store>,
    #[command(flatten)]
    target: Target,
    #[command(flatten)]
    tiles: TileArgs,
}

/// A place in the plane by the bits of its coordinates [m].
type Place = (u32, u32);

/// Counts of entries that are left out, by the reason.
#[derive(Debug, Default)]
struct LeftOut {
    not_finite: usize,
    impossible: usize,
    repeated_receivers: usize,
}

impl Args {
    pub fn run(self) -> Result<()> {
        let source = self
            .maps
            .clone()
            .map(|maps| maps.cut(self.tiles.settings()))
            .transpose()?;
        let maps = self.find()?;
        must_have_maps(&maps, &self.source, "files *.propbin or *.propbin.gz")?;
        let label = self.label.config(self.store.contains(&Store::Pdp));
        let labeler = Labeler::new(&label)?;
        let config = self.config(&label, source.as_ref());
        let mut left_out = LeftOut::default();
        self.target
            .make(config, &maps, |writer, id, files, progress| {
                self.map(
                    writer,
                    id,
                    files,
                    &labeler,
                    source.as_ref(),
                    &mut left_out,
                    progress,
                )
            })?;
        for (count, what) in [
            (
                left_out.not_finite,
                "paths with a number that is not finite",
            ),
            (
                left_out.impossible,
                "paths with an impossible loss or delay",
            ),
            (
                left_out.repeated_receivers,
                "receivers at the place of an earlier one",
            ),
        ] {
            if count > 0 {
                say!("left out: {count} {what}")?;
            }
        }
        Ok(())
    }

    fn config(&self, label: &LabelConfig, source: Option<&MapSource>) -> DatasetConfig {
        let stored = args::stored(&self.store);
        let raster = source.map(MapSource::raster).unwrap_or_default();
        DatasetConfig {
            seed: self.target.seed,
            layout: Layout::of_labels(label, raster, stored),
            configuration: json!({
                "import": "propbin",
                "maps": source.map(MapSource::describe),
                "sampling": { "rx_per_map": self.rx_per_map },
                "label": label,
            }),
        }
    }

    /// The files of each map in the order of their transmitters.
    fn find(&self) -> Result<BTreeMap<u32, Vec<PathBuf>>> {
        let mut numbered: BTreeMap<(u32, u64, String), PathBuf> = BTreeMap::new();
        let mut to_search = vec![self.source.clone()];
        while let Some(path) = to_search.pop() {
            let place = || format!("cannot read '{}'", path.display());
            if fs::metadata(&path).with_context(place)?.is_dir() {
                for entry in fs::read_dir(&path).with_context(place)? {
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
            let number = stem
                .rsplit('_')
                .next()
                .and_then(|n| n.parse().ok())
                .unwrap_or(u64::MAX);
            let key = (self.map_of(&path)?, number, stem.to_owned());
            if let Some(other) = numbered.insert(key, path.clone()) {
                bail!(
                    "'{}' and '{}' are the same transmitter of the same map; import one of them",
                    other.display(),
                    path.display()
                );
            }
        }
        let mut maps: BTreeMap<u32, Vec<PathBuf>> = BTreeMap::new();
        for ((map, _, _), path) in numbered {
            maps.entry(map).or_default().push(path);
        }
        Ok(maps)
    }

    /// The number of the innermost folder `map_N` around a file.
    fn map_of(&self, path: &Path) -> Result<u32> {
        let whole = std::path::absolute(path)?;
        let numbers = whole
            .parent()
            .into_iter()
            .flat_map(Path::ancestors)
            .filter_map(|folder| {
                let name = folder.file_name()?.to_str()?;
                name.strip_prefix("map_")?.parse().ok()
            });
        Ok(numbers.into_iter().next().unwrap_or(self.map_id))
    }

    #[allow(clippy::too_many_arguments)]
    fn map(
        &self,
        writer: &DatasetWriter,
        id: u32,
        files: &[PathBuf],
        labeler: &Labeler,
        source: Option<&MapSource>,
        left_out: &mut LeftOut,
        progress: &ProgressBar,
    ) -> Result<()> {
        let places: Vec<(Place, Vec<Place>)> = files
            .par_iter()
            .map(|path| {
                let file = read(path)?;
                let receivers = file.receivers().iter().map(|r| place(r.position_m));
                Ok((place(file.source_m()), receivers.collect()))
            })
            .collect::<Result<_>>()?;
        let rx = self.choose(
            id,
            places
                .iter()
                .flat_map(|(_, rx)| rx.iter().copied())
                .collect(),
        )?;
        let row: HashMap<Place, u32> = rx.iter().copied().zip(0..).collect();
        let mut links = Vec::new();
        for (tx, (_, receivers)) in places.iter().enumerate() {
            let mut seen = HashSet::new();
            let receivers = receivers.iter().filter(|&&place| seen.insert(place));
            links.extend(
                receivers
                    .filter_map(|place| row.get(place))
                    .map(|&rx| [tx as u32, rx]),
            );
        }
        let metres = |(x, y): Place| [x, y].map(|bits| f64::from(f32::from_bits(bits)));
        let mut map = writer.begin_map(
            id,
            &MapInput {
                buildings: &buildings(source, id)?,
                tx_m: &places.iter().map(|(tx, _)| metres(*tx)).collect::<Vec<_>>(),
                rx_m: &rx.iter().copied().map(metres).collect::<Vec<_>>(),
                links: Links::List(&links),
            },
        )?;
        for path in files {
            let file = read(path)?;
            write_links(
                &mut map,
                &file,
                &row,
                labeler,
                &writer.config().layout,
                left_out,
            )
            .with_context(|| format!("'{}'", path.display()))?;
            progress.inc(1);
        }
        map.finish()?;
        Ok(())
    }

    /// Returns all places of receivers, from the south up, or some of them in a drawn order.
    fn choose(&self, id: u32, places: BTreeSet<Place>) -> Result<Vec<Place>> {
        let mut places: Vec<Place> = places.into_iter().collect();
        let key = |&(x, y): &Place| [y, x].map(f32::from_bits);
        places.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("places are finite"));
        if let Some(count) = self.rx_per_map {
            ensure!(
                count <= places.len(),
                "it has only {} receivers, {count} were asked for",
                places.len()
            );
            let mut rng = ChaCha8Rng::seed_from_u64(self.target.seed);
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
    file: &Propbin,
    row: &HashMap<Place, u32>,
    labeler: &Labeler,
    layout: &Layout,
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
    for receivers in receivers.chunks(LINKS_AT_ONCE) {
        let parts: Vec<Result<(Rows, usize)>> = receivers
            .par_chunks(64)
            .map(|receivers| label_links(file, receivers, labeler, layout))
            .collect();
        let mut rows = Rows::default();
        for part in parts {
            let (part, impossible) = part?;
            left_out.impossible += impossible;
            rows.append(part);
        }
        map.push(&rows.link_rows(layout))?;
    }
    Ok(())
}

/// The rows of some receivers, and how many paths were impossible.
fn label_links(
    file: &Propbin,
    receivers: &[&Receiver],
    labeler: &Labeler,
    layout: &Layout,
) -> Result<(Rows, usize)> {
    let (mut scratch, mut label, mut samples) = (Scratch::default(), Label::default(), Vec::new());
    let mut rows = Rows::default();
    let mut impossible = 0;
    for receiver in receivers {
        samples.clear();
        for (path, chain) in file.paths_of(receiver) {
            let is_possible =
                path.loss_db.abs() <= MAX_LOSS_DB && (0.0..=MAX_DELAY_NS).contains(&path.delay_ns);
            for (end, direction) in [("departure", path.departure), ("arrival", path.arrival)] {
                check_azimuth(end, direction.azimuth_rad.into())
                    .with_context(|| format!("receiver {}", receiver.id))?;
            }
            if is_possible {
                samples.push(add_path(&mut rows, path));
                let ends = [file.source_m(), receiver.position_m];
                add_chain(&mut rows, &chain, ends);
            }
            impossible += usize::from(!is_possible);
        }
        let labelled = labeler
            .label_into(&samples, &mut scratch, &mut label)
            .with_context(|| format!("receiver {}", receiver.id))?;
        rows.status.push(match labelled {
            Status::Labelled => LinkStatus::Valid,
            Status::NoPath if !samples.is_empty() => LinkStatus::Unlabelled,
            Status::NoPath if place(file.source_m()) == place(receiver.position_m) => {
                LinkStatus::SamePoint
            }
            Status::NoPath => LinkStatus::NoPath,
        });
        rows.paths.end_link();
        let links = rows.status.len();
        rows.aps.db.extend_from_slice(&label.aps_db);
        rows.pdp.db.extend_from_slice(&label.pdp_db);
        rows.aps
            .fill(links, layout.aps.map_or(0, |aps| aps.axis.count));
        rows.pdp
            .fill(links, layout.pdp.map_or(0, |pdp| pdp.axis.count));
    }
    Ok((rows, impossible))
}

/// Adds the columns of a path but its interactions; returns what a label sees of it.
fn add_path(rows: &mut Rows, path: &propbin::Path) -> PathSample {
    let delay_s = f64::from(path.delay_ns) * 1e-9;
    let amplitude = libm::exp10(-f64::from(path.loss_db) / 20.0);
    // Theirs points along the way the wave travels, ours back to where it comes from.
    let arrival_azimuth_rad = turned(f64::from(path.arrival.azimuth_rad));
    rows.paths.delay_s.push(delay_s);
    rows.paths
        .departure_azimuth_rad
        .push(f64::from(path.departure.azimuth_rad));
    rows.paths.arrival_azimuth_rad.push(arrival_azimuth_rad);
    rows.paths.gain.push([amplitude, 0.0]);
    PathSample {
        delay_s,
        arrival_azimuth_rad,
        // As it will be read back from the stored amplitude.
        gain_db: 10.0 * (amplitude * amplitude).log10(),
    }
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
    rows.paths
        .interaction_kind
        .extend(points.iter().map(|_| kind));
    rows.paths
        .interaction_id
        .extend(points.iter().map(|_| UNKNOWN_ID));
    rows.paths.interaction_point_m.append(&mut points);
    rows.paths.end_path();
}

/// An angle half a turn further, in (-pi, pi] if it was.
fn turned(azimuth_rad: f64) -> f64 {
    use std::f64::consts::PI;
    if azimuth_rad > 0.0 {
        azimuth_rad - PI
    } else {
        azimuth_rad + PI
    }
}

fn place([x, y, _]: [f32; 3]) -> Place {
    // -0 is 0.
    ((x + 0.0).to_bits(), (y + 0.0).to_bits())
}

fn read(path: &Path) -> Result<Propbin> {
    Propbin::read(path).with_context(|| format!("'{}'", path.display()))
}
