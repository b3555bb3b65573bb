//! Files and folders that are named after maps and links, by the names that they have.

use std::fs;
use std::path::{Path, PathBuf};

use aps_data::released::LinkName;

use super::ExchangeError;
use crate::error::{At, Place, Result};

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
