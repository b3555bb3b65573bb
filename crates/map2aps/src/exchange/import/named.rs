//! Files and folders that are named after maps and links: found by their names, and written as maps.

use std::fs;
use std::path::{Path, PathBuf};

use aps_data::released::LinkName;
use aps_data::{DatasetWriter, Links, MapInput};

use super::buildings::Buildings;
use super::dataset::{LINKS_AT_ONCE, source, without_ends};
use crate::control::Control;
use crate::dataset::Rows;
use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;
use crate::in_order::in_order;
use crate::maps::ascending;

/// A file of a link, with the link that its name tells. Numbers in names may begin with zeros.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct LinkFile {
    pub name: LinkName,
    pub path: PathBuf,
}

impl AsRef<Path> for LinkFile {
    fn as_ref(&self) -> &Path {
        &self.path
    }
}

impl LinkFile {
    /// The files of a folder with such a beginning and end, which are named after links.
    ///
    /// # Errors
    /// [`ExchangeError::Unnamed`] for one whose name is no link's: it would be left out without a word.
    pub fn all(folder: &Path, beginning: &str, end: &str) -> Result<Vec<Self>> {
        let mut files = Vec::new();
        for entry in fs::read_dir(folder).at_file(Place::Reading, folder)? {
            let path = entry?.path();
            let name = path.file_name().and_then(|name| name.to_str());
            let Some(name) = name.filter(|n| n.starts_with(beginning) && n.ends_with(end)) else {
                continue;
            };
            match LinkName::of_file(name, beginning, end) {
                Some(name) => files.push(Self { name, path }),
                None => return Err(ExchangeError::Unnamed(path).into()),
            }
        }
        Ok(files)
    }

    /// Puts files into the order of their links.
    ///
    /// # Errors
    /// [`ExchangeError::SameLink`].
    pub fn order(files: &mut [Self]) -> Result<(), ExchangeError> {
        files.sort_unstable();
        let mut pairs = files.windows(2);
        match pairs.find(|pair| pair[0].name == pair[1].name) {
            Some([one, other]) => Err(ExchangeError::SameLink(
                [one, other].map(|file| file.path.clone()),
            )),
            _ => Ok(()),
        }
    }

    /// The file of the same link in the folder `pdp` beside its folder.
    pub fn pdp(&self) -> PathBuf {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        folder
            .with_file_name("pdp")
            .join(name.replacen("aps_", "pdp_", 1))
    }
}

/// The number of a map by the name of its folder, `map_N`; `None` for other names.
///
/// # Errors
/// [`ExchangeError::MapNumber`] for one that is too large.
pub(super) fn map_number(folder: &Path) -> Result<Option<u32>, ExchangeError> {
    let name = folder.file_name().and_then(|name| name.to_str());
    let digits = name.and_then(|name| name.strip_prefix("map_"));
    let is_number = |text: &&str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    digits
        .filter(is_number)
        .map(|digits| digits.parse())
        .transpose()
        .map_err(|_| ExchangeError::MapNumber(folder.into()))
}

/// Writes a map of links that are named after their ends, a file each, which `link` reads.
pub(super) fn write_named(
    writer: &DatasetWriter,
    id: u32,
    files: &[LinkFile],
    buildings: &Buildings,
    control: &Control<'_>,
    link: impl Fn(&LinkFile) -> Result<Rows> + Send + Sync,
) -> Result<()> {
    let names: Vec<LinkName> = files.iter().map(|file| file.name).collect();
    let ends = Ends::of(&names);
    let layout = writer.config().layout;
    let input = MapInput {
        buildings: &buildings.image,
        tx_m: &ends.tx_m,
        rx_m: &ends.rx_m,
        links: Links::List(&ends.links),
    };
    let mut map = writer.begin_map(id, &input)?;
    let parts: Vec<&[LinkFile]> = files.chunks(LINKS_AT_ONCE).collect();
    let read = |files: &&[LinkFile]| -> Result<Rows> {
        control.check()?;
        let mut rows = Rows::default();
        for file in *files {
            rows.append(link(file)?);
        }
        Ok(rows)
    };
    in_order(&parts, read, |rows| {
        map.push(&without_ends(rows.link_rows(&layout)))?;
        control.progress.advance(rows.status.len() as u64);
        Ok(())
    })?;
    buildings.check_ends(files.len())?;
    map.set_statistics(buildings.statistics(source(files)?));
    map.finish()?;
    Ok(())
}

/// Positions of the ends of some links, each once and in order, and the links as rows of these.
struct Ends {
    tx_m: Vec<[f64; 2]>,
    rx_m: Vec<[f64; 2]>,
    links: Vec<[u32; 2]>,
}

impl Ends {
    /// Collects the ends of the links with these sorted names.
    fn of(names: &[LinkName]) -> Self {
        let unique = |place: fn(&LinkName) -> [i32; 2]| ascending(names.iter().map(place));
        let (tx, rx) = (unique(|n| n.tx_m), unique(|n| n.rx_m));
        let row = |places: &[[i32; 2]], place| {
            places.binary_search(&place).expect("it was collected") as u32
        };
        let metres = |places: &[[i32; 2]]| places.iter().map(|p| p.map(f64::from)).collect();
        let link = |n: &LinkName| [row(&tx, n.tx_m), row(&rx, n.rx_m)];
        Self {
            links: names.iter().map(link).collect(),
            tx_m: metres(&tx),
            rx_m: metres(&rx),
        }
    }
}
