//! Names of the links that spectra were predicted of, and of their labels, in a file beside them.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use aps_data::{Dataset, Part};

use super::{Domain, ScoreError};
use crate::error::{At, Place, Result};
use crate::examples::{Example, Examples};
use crate::settings;

/// First line of the file.
pub const LINK_COLUMNS: &str = "row,map,link,tx,rx,tx_x_m,tx_y_m,rx_x_m,rx_y_m,protocol,array";

/// The columns that tell the labels: the last ones of the line, which files of earlier versions lack.
const LABEL_COLUMNS: [&str; 2] = ["protocol", "array"];

/// The file beside a prediction that names its links, in CSV: `pred.links.csv` beside `pred.npy`.
pub fn links_file(prediction: &Path) -> PathBuf {
    prediction.with_extension("links.csv")
}

/// The line of the link that a row of a prediction is of, without its end: see [`LINK_COLUMNS`]. The labels are those of
/// [`link_labels`].
pub fn link_line(labels: &[String; 2], row: usize, link: &Example) -> String {
    let [protocol, array] = labels;
    format!("{},{protocol},{array}", place_line(row, link))
}

/// The last cells of all lines of a data set: protocol and array, that is form, elements and spacing in wavelengths, of its labels. They are
/// empty where its manifest does not tell them.
pub fn link_labels(dataset: &Dataset) -> [String; 2] {
    let label = settings::label_of(&dataset.manifest().configuration);
    label.map_or_else(
        |_| Default::default(),
        |label| {
            let (form, elements, spacing) = label.array.parts();
            [
                label.protocol.to_string(),
                format!("{} {elements} {spacing}", form.name()),
            ]
        },
    )
}

/// The line without its labels.
fn place_line(row: usize, link: &Example) -> String {
    let [tx_x, tx_y] = link.tx_m;
    let [rx_x, rx_y] = link.rx_m;
    let (map, tx, rx) = (link.map, link.tx, link.rx);
    format!(
        "{row},{map},{},{tx},{rx},{tx_x},{tx_y},{rx_x},{rx_y}",
        link.link
    )
}

/// Refuses a prediction beside which other links, or labels of another protocol or array, are named than those of a part of a data set.
/// One without such a file passes.
///
/// # Errors
/// [`ScoreError::OtherLinks`], [`ScoreError::OtherLabels`], and files that cannot be read.
pub fn check_links(dataset: &Dataset, part: Part, prediction: &Path) -> Result<()> {
    let path = links_file(prediction);
    if !path.is_file() {
        return Ok(());
    }
    let lines = File::open(&path).at_file(Place::Reading, &path)?;
    let mut lines = BufReader::new(lines).lines();
    let head = lines.next().transpose().at_file(Place::Reading, &path)?;
    // Spreadsheets begin the file with a mark.
    let head = head
        .as_deref()
        .map(|head| head.trim_start_matches('\u{feff}'));
    let tells_labels = head == Some(LINK_COLUMNS);
    let labels = link_labels(dataset);
    let examples = Examples::open(dataset, part, Domain::Linear)?;
    let links = examples.list();
    for row in 0..=links.len() {
        let found = lines.next().transpose().at_file(Place::Reading, &path)?;
        let mut cells = found.as_deref().map(|line| line.rsplitn(3, ','));
        if let (true, Some(cells)) = (tells_labels, &mut cells) {
            // From the last.
            for (i, what) in LABEL_COLUMNS.into_iter().enumerate().rev() {
                let (found, expected) = (cells.next().unwrap_or_default(), &labels[i]);
                if found != expected && !found.is_empty() && !expected.is_empty() {
                    let [found, expected] = [found, expected].map(str::to_owned);
                    return Err(ScoreError::OtherLabels {
                        path,
                        what,
                        found,
                        expected,
                    }
                    .into());
                }
            }
        }
        let place = match tells_labels {
            true => cells.and_then(|mut cells| cells.next()),
            false => found.as_deref(),
        };
        let expected = links.get(row).map(|link| place_line(row, link));
        if place != expected.as_deref() {
            return Err(ScoreError::OtherLinks { path, row }.into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use aps_data::npy;

    use super::*;
    use crate::{ArrayFile, Prediction, Scoring, Truth, synthetic};

    #[test]
    fn a_prediction_of_other_links_is_not_scored() {
        let root = tempfile::tempdir().unwrap();
        let [data, prediction] = ["data", "pred.npy"].map(|name| root.path().join(name));
        let dataset = synthetic::made(&synthetic::plan(3, 2, 5), &data, &[0, 1, 2]);
        let examples = Examples::open(&dataset, Part::Train, Domain::Linear).unwrap();
        let count = examples.list().len();
        let mut file = npy::Writer::new(File::create(&prediction).unwrap(), "<f4", &[180]).unwrap();
        file.push(&vec![0.5_f32; count * 180]).unwrap();
        file.finish().unwrap();
        let score = || {
            let mut truth = Truth::dataset(&data, Part::Train, Domain::Linear).unwrap();
            let file = ArrayFile::open_spectra(&prediction).unwrap();
            Scoring::default().score(&mut truth, Prediction::File(file))
        };
        assert!(score().is_ok(), "nothing tells its links");

        let labels = link_labels(&dataset);
        let lines = examples.list().iter().enumerate();
        let lines: Vec<String> = lines
            .map(|(row, link)| link_line(&labels, row, link))
            .collect();
        let write = |lines: &[String]| {
            let text = [&[LINK_COLUMNS.to_owned()], lines].concat().join("\n");
            std::fs::write(links_file(&prediction), text).unwrap();
        };
        write(&lines);
        assert!(score().is_ok());
        // Neither fewer nor more.
        for count in [count - 1, count + 1] {
            write(
                &lines
                    .iter()
                    .cycle()
                    .take(count)
                    .cloned()
                    .collect::<Vec<_>>(),
            );
            assert!(score().is_err(), "{count}");
        }
        let mut others = lines.clone();
        others.swap(3, 4);
        write(&others);
        let told = score().unwrap_err().chain();
        assert!(told.contains("for other links, from row 3 on"), "{told}");

        // Labels of the same links, but of another protocol or array; those that are not told pass.
        for (own, other, is_refused) in [
            ("released,ula 16 0.5", "paper,ula 16 0.5", true),
            ("released,ula 16 0.5", "released,uca 8 0.5", true),
            ("released,ula 16 0.5", ",", false),
        ] {
            let change = |line: &String| {
                assert!(line.ends_with(own), "{line}");
                line.replace(own, other)
            };
            write(&lines.iter().map(change).collect::<Vec<_>>());
            match score() {
                Ok(_) => assert!(!is_refused, "{other}"),
                Err(error) => {
                    let told = error.chain();
                    let words = other
                        .split(',')
                        .chain(own.split(','))
                        .filter(|w| !own.contains(w) || !other.contains(w));
                    assert!(is_refused && words.clone().count() == 2, "{told}");
                    assert!(words.into_iter().all(|word| told.contains(word)), "{told}");
                }
            }
        }
        // A file of an earlier version tells no labels.
        let places = |line: &String| line.replace(",released,ula 16 0.5", "");
        let text = std::iter::once("row,map,link,...".to_owned()).chain(lines.iter().map(places));
        std::fs::write(links_file(&prediction), text.collect::<Vec<_>>().join("\n")).unwrap();
        assert!(score().is_ok());
    }
}
