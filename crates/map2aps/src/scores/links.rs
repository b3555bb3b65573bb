//! Names of the links that spectra were predicted of, in a file beside them.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use aps_data::{Dataset, Part};

use super::{Domain, ScoreError};
use crate::error::{At, Place, Result};
use crate::examples::{Example, Examples};

/// First line of the file.
pub const LINK_COLUMNS: &str = "row,map,link,tx,rx,tx_x_m,tx_y_m,rx_x_m,rx_y_m";

/// The file beside a prediction that names its links, in CSV: `pred.links.csv` beside `pred.npy`.
pub fn links_file(prediction: &Path) -> PathBuf {
    prediction.with_extension("links.csv")
}

/// The line of the link that a row of a prediction is of, without its end: see [`LINK_COLUMNS`].
pub fn link_line(row: usize, link: &Example) -> String {
    let [tx_x, tx_y] = link.tx_m;
    let [rx_x, rx_y] = link.rx_m;
    let (map, tx, rx) = (link.map, link.tx, link.rx);
    format!(
        "{row},{map},{},{tx},{rx},{tx_x},{tx_y},{rx_x},{rx_y}",
        link.link
    )
}

/// Refuses a prediction beside which other links are named than those of a part of a data set.
pub(super) fn check(dataset: &Dataset, part: Part, prediction: &Path) -> Result<()> {
    let path = links_file(prediction);
    if !path.is_file() {
        return Ok(());
    }
    let lines = File::open(&path).at_file(Place::Reading, &path)?;
    let mut lines = BufReader::new(lines).lines().skip(1);
    let examples = Examples::open(dataset, part, Domain::Linear)?;
    let links = examples.list();
    for row in 0..=links.len() {
        let found = lines.next().transpose();
        let expected = links.get(row).map(|link| link_line(row, link));
        if found.at_file(Place::Reading, &path)? != expected {
            return Err(ScoreError::OtherLinks { path, row }.into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use aps_data::npy;

    use super::*;
    use crate::{ArrayFile, Control, DatasetPlan, MapSource, Prediction, Scoring, Truth};

    #[test]
    fn a_prediction_of_other_links_is_not_scored() {
        let root = tempfile::tempdir().unwrap();
        let [data, prediction] = ["data", "pred.npy"].map(|name| root.path().join(name));
        let plan = DatasetPlan {
            maps: MapSource::Synthetic { count: 3 },
            tx_per_map: 2,
            rx_per_map: 5,
            ..DatasetPlan::default()
        };
        plan.make(&data, &[0, 1, 2], &Control::default()).unwrap();
        let dataset = Dataset::open(&data).unwrap();
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

        let lines = examples.list().iter().enumerate();
        let lines: Vec<String> = lines.map(|(row, link)| link_line(row, link)).collect();
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
        let mut others = lines;
        others.swap(3, 4);
        write(&others);
        let told = score().unwrap_err().chain();
        assert!(told.contains("for other links, from row 3 on"), "{told}");
    }
}
