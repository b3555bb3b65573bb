//! Writing one map: a folder that appears whole.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::array_files::ArrayFiles;
use crate::arrays::{ArraySpec, Counts, ProfileNames, arrays_of};
use crate::dataset_folder::DatasetFolder;
use crate::durable::{self, PartialFolder};
use crate::error::Error;
use crate::json;
use crate::layout::{Layout, ProfileLayout};
use crate::manifest::{FileEntry, MAP_FILE, MapEntry, MapManifest};
use crate::paths::PathTable;
use crate::profile::{self, ProfileRows};
use crate::raster::{Raster, RasterGrid};
use crate::status::LinkStatus;

/// Data of a map that are known before its links are computed.
#[derive(Debug, Clone, Copy)]
pub struct MapInput<'a> {
    /// The buildings, on the layout's grid.
    pub buildings: &'a Raster,
    /// Positions of the transmitters \[m\].
    pub tx_m: &'a [[f64; 2]],
    /// Positions of the receivers \[m\].
    pub rx_m: &'a [[f64; 2]],
    /// Links between transmitters and receivers.
    pub links: Links<'a>,
}

/// The links of a map, in the order of their rows.
#[derive(Debug, Clone, Copy)]
pub enum Links<'a> {
    /// Every transmitter with every receiver: all links of the first transmitter first.
    Grid,
    /// Any list of (index of transmitter, index of receiver).
    List(&'a [[u32; 2]]),
    /// Not known yet: each link comes with its row, in [`LinkRows::links`].
    WithRows,
}

/// Results for some links, one row a link.
#[derive(Debug, Clone, Copy, Default)]
pub struct LinkRows<'a> {
    /// Index of transmitter and index of receiver of each link; given if and only if the map's links are
    /// [`Links::WithRows`].
    pub links: Option<&'a [[u32; 2]]>,
    /// The state of each link.
    pub status: &'a [LinkStatus],
    /// For each link whose paths lie beyond the tracer's limits, because none was inside, their number of
    /// diffractions; 0 for all others. `None` means 0 throughout.
    pub fallback: Option<&'a [u8]>,
    /// APS of the links, if the layout stores it.
    pub aps: Option<ProfileRows<'a>>,
    /// PDP of the links, if the layout stores it.
    pub pdp: Option<ProfileRows<'a>>,
    /// Paths of the links, if the layout stores them.
    pub paths: Option<&'a PathTable>,
}

/// A map being written. Dropping it unfinished removes all of it.
#[derive(Debug)]
pub struct MapWriter<'w> {
    dataset: &'w DatasetFolder,
    id: u32,
    /// Number of transmitters and of receivers.
    tx: usize,
    rx: usize,
    /// Number of links; not known before the last row where links come with their rows.
    planned: Option<usize>,
    written: usize,
    status_counts: BTreeMap<String, u64>,
    statistics: Value,
    files: ArrayFiles,
    // Last: the files above are closed before the folder is removed.
    folder: PartialFolder,
}

impl<'w> MapWriter<'w> {
    pub(crate) fn begin(
        dataset: &'w DatasetFolder,
        id: u32,
        input: &MapInput<'_>,
    ) -> Result<Self, Error> {
        let layout = &dataset.config.layout;
        let links =
            links_of(input).and_then(|links| check_input(input, layout.raster).map(|()| links));
        let links = links.map_err(|problem| Error::Input { map: id, problem })?;
        let folder = PartialFolder::create(&dataset.root, &MapEntry::folder_of(id))?;
        let mut files = ArrayFiles::create(folder.path(), layout)?;
        files.push("buildings", input.buildings.pixels())?;
        files.push("tx", input.tx_m.as_flattened())?;
        files.push("rx", input.rx_m.as_flattened())?;
        files.push_links(&links)?;
        Ok(MapWriter {
            dataset,
            id,
            planned: (!matches!(input.links, Links::WithRows)).then_some(links.len()),
            written: 0,
            status_counts: BTreeMap::new(),
            statistics: Value::Null,
            tx: input.tx_m.len(),
            rx: input.rx_m.len(),
            files,
            folder,
        })
    }

    /// Appends the results of the next links, in the order of the link list; any number of links a
    /// call.
    ///
    /// Memory is needed for the rows of one call only.
    ///
    /// # Errors
    /// [`Error::Input`] when the rows do not fit the layout or each other, or hold a value that is
    /// not finite in a link with a label: nothing is then written. [`Error::Io`]: the map cannot be
    /// finished any more.
    pub fn push(&mut self, rows: &LinkRows<'_>) -> Result<(), Error> {
        let layout = &self.dataset.config.layout;
        let map = self.id;
        let refuse = |problem: String| Error::Input { map, problem };
        let first = self.written;
        if let Some(planned) = self.planned
            && rows.status.len() > planned - first
        {
            return Err(refuse(format!("more rows than its {planned} links")));
        }
        let links = match (rows.links, self.planned) {
            (None, Some(_)) => &[],
            (Some(links), None) if links.len() == rows.status.len() => {
                check_links(links, self.tx, self.rx).map_err(refuse)?;
                links
            }
            (Some(links), None) => {
                let (found, wanted) = (links.len(), rows.status.len());
                return Err(refuse(format!("links has {found} rows, expected {wanted}")));
            }
            (given, _) => {
                let word = if given.is_some() { "twice" } else { "nowhere" };
                return Err(refuse(format!("its links are given {word}")));
            }
        };
        let encode =
            |name: &str, rows_of: &Option<ProfileRows<'_>>, layout: &Option<ProfileLayout>| {
                let encoded = match (rows_of, layout) {
                    (Some(rows_of), Some(layout)) => {
                        profile::encode(rows_of, layout, rows.status, first).map(Some)
                    }
                    (None, None) => Ok(None),
                    (None, Some(_)) => Err("missing, though the layout stores it".into()),
                    (Some(_), None) => Err("given, though the layout does not store it".into()),
                };
                encoded.map_err(|problem| refuse(format!("{name}: {problem}")))
            };
        let aps = encode("aps", &rows.aps, &layout.aps)?;
        let pdp = encode("pdp", &rows.pdp, &layout.pdp)?;
        let (found, wanted) = (rows.fallback.map(<[u8]>::len), rows.status.len());
        if let Some(found) = found.filter(|&found| found != wanted) {
            let problem = format!("fallback has {found} values, expected {wanted}");
            return Err(refuse(problem));
        }
        let problem = match (rows.paths, layout.paths) {
            (Some(paths), true) => paths.problem(rows.status, first),
            (paths, stores) => {
                (paths.is_some() != stores).then(|| "must be given if and only if stored".into())
            }
        };
        if let Some(problem) = problem {
            return Err(refuse(format!("paths: {problem}")));
        }

        self.files.push_links(links)?;
        let codes: Vec<u8> = rows.status.iter().map(|status| status.code()).collect();
        self.files.push("status", &codes)?;
        let within = vec![0; codes.len()];
        self.files
            .push("fallback", rows.fallback.unwrap_or(&within))?;
        for (names, profile) in [(ProfileNames::APS, aps), (ProfileNames::PDP, pdp)] {
            if let Some(profile) = profile {
                self.files.push_profile(names, &profile)?;
            }
        }
        if let Some(paths) = rows.paths {
            self.files.push_paths(paths)?;
        }
        for status in rows.status {
            *self.status_counts.entry(status.to_string()).or_insert(0) += 1;
        }
        self.written += rows.status.len();
        Ok(())
    }

    /// Records the writer's own findings about the map, a JSON object, in its entry of the manifest. They must
    /// follow from the settings alone, as all bytes of a data set do.
    pub fn set_statistics(&mut self, statistics: Value) {
        self.statistics = statistics;
        self.statistics.sort_all_objects();
    }

    /// Completes the map: all files on disk, then the folder under its name.
    ///
    /// # Errors
    /// [`Error::Input`] when links are missing; [`Error::Io`]. The map is then not part of the data
    /// set.
    pub fn finish(self) -> Result<MapEntry, Error> {
        let (map, written) = (self.id, self.written);
        if let Some(planned) = self.planned
            && written != planned
        {
            let problem = format!("only {written} of its {planned} links were written");
            return Err(Error::Input { map, problem });
        }
        let config = &self.dataset.config;
        let counts = self.files.finish()?;
        let folder = self.folder.path();
        let entry = MapEntry {
            id: map,
            tx: counts.tx,
            rx: counts.rx,
            links: counts.links,
            paths: counts.paths,
            interactions: counts.interactions,
            status: self.status_counts,
            statistics: self.statistics,
            files: file_entries(folder, &config.layout, &counts)?,
        };
        let manifest = MapManifest::new(config.clone(), entry.clone());
        durable::write_synced(&folder.join(MAP_FILE), &json::to_bytes(&manifest))?;
        self.folder.complete()?;
        self.dataset.register(entry.clone());
        Ok(entry)
    }
}

fn check_input(input: &MapInput<'_>, grid: RasterGrid) -> Result<(), String> {
    if input.buildings.grid() != grid {
        return Err(format!(
            "raster of {:?}, the layout has {grid:?}",
            input.buildings.grid()
        ));
    }
    for (name, points) in [("tx", input.tx_m), ("rx", input.rx_m)] {
        if let Some(i) = points.iter().position(|&point| !grid.holds(point)) {
            let ([x, y], [width, height]) = (points[i], grid.size_m());
            return Err(format!(
                "{name} {i} is at ({x}, {y}) m, outside of the map's image of {width} m x {height} m"
            ));
        }
    }
    Ok(())
}

/// Returns the link table as far as it is known before the rows.
fn links_of<'a>(input: &MapInput<'a>) -> Result<Cow<'a, [[u32; 2]]>, String> {
    let (tx, rx) = (input.tx_m.len(), input.rx_m.len());
    match input.links {
        Links::List(list) => check_links(list, tx, rx).map(|()| list.into()),
        Links::Grid => {
            let of = |n: usize| {
                u32::try_from(n).map_err(|_| format!("{n} positions, at most {} fit", u32::MAX))
            };
            let (tx, rx) = (of(tx)?, of(rx)?);
            let links = (0..tx).flat_map(|t| (0..rx).map(move |r| [t, r]));
            Ok(links.collect())
        }
        Links::WithRows => Ok(Cow::Borrowed(&[])),
    }
}

fn check_links(links: &[[u32; 2]], tx: usize, rx: usize) -> Result<(), String> {
    let is_outside = |&[t, r]: &[u32; 2]| t as usize >= tx || r as usize >= rx;
    match links.iter().position(is_outside) {
        Some(i) => Err(format!(
            "link {i} is {:?}, but there are {tx} tx and {rx} rx",
            links[i]
        )),
        None => Ok(()),
    }
}

/// Describes the finished files of a map.
fn file_entries(folder: &Path, layout: &Layout, counts: &Counts) -> Result<Vec<FileEntry>, Error> {
    let arrays = arrays_of(layout, counts).expect("counts of arrays on disk do not overflow");
    let describe = |array: ArraySpec| {
        let name = format!("{}.npy", array.name);
        let path = folder.join(&name);
        let (bytes, sha256) = durable::size_and_sha256(&path)?;
        if array.file_bytes() != Some(bytes) {
            let problem = format!(
                "{bytes} bytes written, its shape {:?} has others",
                array.shape
            );
            return Err(Error::Damaged { path, problem });
        }
        Ok(FileEntry {
            name,
            dtype: array.dtype.into(),
            shape: array.shape,
            bytes,
            sha256,
        })
    };
    arrays.into_iter().map(describe).collect()
}
