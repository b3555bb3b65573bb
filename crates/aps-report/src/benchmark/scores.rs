//! Scores of single links: one npy file an entry and protocol.

use std::path::{Component, Path};

use aps_data::npy::{self, Array};
use aps_metrics::Metric;

use super::results::ProtocolScores;
use crate::ReportError;

/// The scores of an entry under one protocol, a column a metric.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreTable {
    columns: Vec<(Metric, Vec<f64>)>,
}

impl ScoreTable {
    /// Columns of [`Metric::ALL`], of links in the order of the results.
    ///
    /// # Errors
    /// A row of another length, or a value that is not finite.
    pub fn of_rows(rows: &[[f64; Metric::ALL.len()]]) -> Result<Self, ReportError> {
        let column = |i: usize| rows.iter().map(|row| row[i]).collect();
        let columns = Metric::ALL.iter().enumerate();
        let table = Self {
            columns: columns.map(|(i, &metric)| (metric, column(i))).collect(),
        };
        table.check()?;
        Ok(table)
    }

    /// Reads the file that some results name, which lie in `folder`.
    ///
    /// Metrics this version does not know are left out.
    ///
    /// # Errors
    /// A file that cannot be read, has another shape than `links` x metrics, or holds a value that is
    /// not finite; the file is named. A file outside of the folder is not read.
    pub fn read(folder: &Path, scores: &ProtocolScores, links: usize) -> Result<Self, ReportError> {
        let path = folder.join(&scores.file);
        let mut parts = scores.file.components();
        let is_inside = parts.all(|c| matches!(c, Component::Normal(_)));
        let refuse = |why: String| Err(ReportError::Results(why));
        if !is_inside {
            let file = scores.file.display();
            return refuse(format!("'{file}' is not in the folder of the results"));
        }
        let array: Array<f64> =
            npy::read(&path).map_err(ReportError::at("read the scores", &path))?;
        let width = scores.metrics.len();
        let expected = [links, width];
        if array.shape != expected {
            return refuse(format!(
                "'{}' has shape {:?}; {links} links and {width} metrics need {expected:?}",
                path.display(),
                array.shape,
            ));
        }
        let column = |i: usize| array.data.iter().skip(i).step_by(width).copied().collect();
        let known = scores.metrics.iter().enumerate().filter_map(|(i, key)| {
            let metric = Metric::ALL.into_iter().find(|m| m.key() == key)?;
            Some((metric, column(i)))
        });
        let table = Self {
            columns: known.collect(),
        };
        table
            .check()
            .map_err(ReportError::at("read the scores", &path))?;
        Ok(table)
    }

    /// Writes the table as f64; `file` is relative to `folder`, whose own folders are made.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn write(
        &self,
        folder: &Path,
        file: &Path,
        protocol: &str,
    ) -> Result<ProtocolScores, ReportError> {
        let path = folder.join(file);
        if let Some(parent) = path.parent() {
            let place = ReportError::at("write the scores", &path);
            std::fs::create_dir_all(parent).map_err(place)?;
        }
        let links = self.columns.first().map_or(0, |c| c.1.len());
        let row = |link: usize| self.columns.iter().map(move |(_, values)| values[link]);
        let values: Vec<f64> = (0..links).flat_map(row).collect();
        npy::write(&path, &[links, self.columns.len()], &values)
            .map_err(ReportError::at("write the scores", &path))?;
        Ok(ProtocolScores {
            protocol: protocol.into(),
            metrics: self.columns.iter().map(|c| c.0.key().into()).collect(),
            file: file.into(),
        })
    }

    /// One value a link; none for a metric that was not scored.
    pub fn column(&self, metric: Metric) -> Option<&[f64]> {
        let column = self.columns.iter().find(|c| c.0 == metric)?;
        Some(&column.1)
    }

    /// Mean over the links; none for a metric that was not scored, or without links.
    pub fn mean(&self, metric: Metric) -> Option<f64> {
        let column = self.column(metric).filter(|column| !column.is_empty())?;
        Some(column.iter().sum::<f64>() / column.len() as f64)
    }

    fn check(&self) -> Result<(), ReportError> {
        for (metric, values) in &self.columns {
            if let Some(link) = values.iter().position(|v| !v.is_finite()) {
                let name = metric.label();
                let why = format!("{name} of link {link} is not a finite number");
                return Err(ReportError::Results(why));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(links: usize) -> Vec<[f64; 16]> {
        (0..links)
            .map(|i| std::array::from_fn(|j| (i * 16 + j) as f64 / 3.0))
            .collect()
    }

    /// The table of five links, written.
    fn written(folder: &Path, file: &str) -> (ScoreTable, ProtocolScores) {
        let table = ScoreTable::of_rows(&rows(5)).unwrap();
        let scores = table.write(folder, Path::new(file), "paper").unwrap();
        (table, scores)
    }

    #[test]
    fn tables_come_back_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let (table, scores) = written(folder.path(), "scores/a.npy");
        let read = ScoreTable::read(folder.path(), &scores, 5).unwrap();
        assert_eq!(read, table);
        assert_eq!(read.column(Metric::PsnrDb).unwrap()[2], 11.0);
    }

    #[test]
    fn tables_of_other_links_or_places_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (_, scores) = written(folder.path(), "a.npy");
        let error = ScoreTable::read(folder.path(), &scores, 6).unwrap_err();
        assert!(error.to_string().contains("[5, 16]"), "{error}");
        let away = ProtocolScores {
            file: "../a.npy".into(),
            ..scores
        };
        let error = ScoreTable::read(folder.path(), &away, 5).unwrap_err();
        assert!(error.to_string().contains("not in the folder"), "{error}");
    }

    #[test]
    fn a_file_cut_short_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let (_, scores) = written(folder.path(), "a.npy");
        let path = folder.path().join("a.npy");
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 3]).unwrap();
        assert!(ScoreTable::read(folder.path(), &scores, 5).is_err());
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let mut rows = rows(3);
        rows[1][5] = f64::NAN;
        let error = ScoreTable::of_rows(&rows).unwrap_err();
        assert_eq!(error.to_string(), "PLE of link 1 is not a finite number");
    }
}
