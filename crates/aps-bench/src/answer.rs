//! Predictions of the test links, and the files that keep them.

use std::path::{Path, PathBuf};

use aps_data::npy;
use aps_metrics::{Protocol, Shape};
use aps_model::{ANGLE_BINS, ModelKind};
use aps_report::benchmark::{Entry, EntryKind, Latency, Training};
use map2aps::ArrayFile;

use crate::error::{Error, Result};
use crate::files::{read_json, write_json};
use crate::test_set::TestSet;

/// Predictions of all test links.
#[derive(Debug, Default)]
pub struct Answer {
    /// Normalised spectra, shape (links, bins).
    pub predictions: Vec<f32>,
    /// Links without an answer of its own, for which the mean spectrum stands.
    pub substituted: Vec<usize>,
    /// The model that made them.
    pub model: Option<ModelKind>,
    /// Number of parameters.
    pub parameters: Option<u64>,
    /// Training of the model, for trained ones.
    pub training: Option<Training>,
    /// Measured run times.
    pub latency: Vec<Latency>,
}

/// Files of an answer in its folder.
const PREDICTIONS: &str = "prediction.npy";
const SUBSTITUTED: &str = "substituted.json";
const ENTRY: &str = "entry.json";

/// Scores an answer and writes everything about it into `root`/`folder`.
pub fn keep(
    answer: Answer,
    (name, kind): (&str, EntryKind),
    test: &TestSet,
    root: &Path,
    folder: &Path,
) -> Result<Entry> {
    let place = root.join(folder);
    let shape = [test.len(), ANGLE_BINS];
    npy::write(place.join(PREDICTIONS), &shape, &answer.predictions)
        .map_err(Error::file("cannot write into", &place))?;
    write_json(&place.join(SUBSTITUTED), &answer.substituted)?;
    let score = |protocol: Protocol| {
        let file: PathBuf = folder.join(format!("{}.npy", protocol.name()));
        let table = test.score(&answer.predictions, protocol)?;
        Ok(table.write(root, &file, protocol.name())?)
    };
    let entry = Entry {
        name: name.into(),
        kind,
        model: answer.model.map(|model| model.title().into()),
        parameters: answer.parameters,
        training: answer.training,
        latency: answer.latency,
        scores: Protocol::ALL
            .into_iter()
            .map(score)
            .collect::<Result<_>>()?,
        substituted_links: answer.substituted.len() as u64,
    };
    write_json(&place.join(ENTRY), &entry)?;
    Ok(entry)
}

/// Reads the entry that [`keep`] made of an answer.
pub fn entry(folder: &Path) -> Result<Entry> {
    read_json(&folder.join(ENTRY))
}

/// Numbers of the links, of so many, that have no answer of their own.
pub fn substituted(folder: &Path, links: usize) -> Result<Vec<usize>> {
    let file = folder.join(SUBSTITUTED);
    let substituted: Vec<usize> = read_json(&file)?;
    match substituted.iter().find(|&&link| link >= links) {
        Some(link) => {
            let told =
                format!("there is no link {link} among {links}; remove the folder to make it anew");
            Err(Error::file("damaged", &file)(told))
        }
        None => Ok(substituted),
    }
}

/// The predictions of `links` links, shape (links, bins).
pub fn predictions(folder: &Path, links: usize) -> Result<Vec<f32>> {
    let file = folder.join(PREDICTIONS);
    let predictions = spectra(&file)?;
    match predictions.len() / ANGLE_BINS {
        found if found == links => Ok(predictions),
        found => {
            let told =
                format!("it has {found} links, not {links}; remove the folder to make it anew");
            Err(Error::file("damaged", &file)(told))
        }
    }
}

/// Spectra of a file: `.npy`, shape (links, 180), float16, float32 or float64.
pub fn spectra(path: &Path) -> Result<Vec<f32>> {
    let mut file = ArrayFile::open_spectra(path)?;
    let (Shape { samples, bins }, mut values) = (file.shape(), Vec::new());
    if bins != ANGLE_BINS {
        let told = format!("there are {bins} bins, expected {ANGLE_BINS}");
        return Err(Error::file("predictions", path)(told));
    }
    file.read_rows(samples, &mut values)?;
    Ok(values.iter().map(|&x| x as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_other_numbers_of_links_are_told() {
        let folder = tempfile::tempdir().unwrap();
        write_json(&folder.path().join(SUBSTITUTED), &vec![0, 5]).unwrap();
        assert_eq!(substituted(folder.path(), 6).unwrap(), [0, 5]);
        let told = substituted(folder.path(), 5).unwrap_err();
        let told = std::error::Error::source(&told).unwrap().to_string();
        assert!(told.contains("no link 5 among 5"), "{told}");
        let values = [0.0_f32; 2 * ANGLE_BINS];
        npy::write(folder.path().join(PREDICTIONS), &[2, ANGLE_BINS], &values).unwrap();
        assert_eq!(predictions(folder.path(), 2).unwrap(), values);
        assert!(predictions(folder.path(), 3).is_err());
    }
}
