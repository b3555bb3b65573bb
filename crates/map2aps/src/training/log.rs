//! Logs of a run as CSV: one row a step, one row a score. Times are in a log of their own, so that the same run writes the same
//! bytes into the others, stopped and continued or not.

use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use aps_data::replace_file;

use super::TrainingError;
use crate::error::{At, Place, Result};

/// A CSV file that a run adds rows to. Its cells are numbers, which need no quotes.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    /// Last cell of the rows it was opened with.
    last: Option<f64>,
}

impl Log {
    /// Opens a log of such columns that has `rows` rows of the run so far; what a stopped run wrote beyond its checkpoint is dropped.
    pub fn open(path: PathBuf, columns: &str, rows: u64) -> Result<Self> {
        let open = || -> Result<(File, Option<f64>)> {
            let kept = match rows {
                0 => format!("{columns}\n"),
                _ => first_lines(&path, columns, rows)?,
            };
            replace_file(&path, kept.as_bytes())?;
            let last = kept.trim_end().rsplit(',').next();
            let last = last.and_then(|cell| cell.parse().ok());
            Ok((OpenOptions::new().append(true).open(&path)?, last))
        };
        let (file, last) = open().at_file(Place::Log, &path)?;
        let file = BufWriter::new(file);
        Ok(Self { path, file, last })
    }

    /// The last cell of the last row that was there when it was opened, if that is a number.
    pub fn last(&self) -> Option<f64> {
        self.last
    }

    /// Appends a row.
    pub fn push(&mut self, cells: &[String]) -> Result<()> {
        writeln!(self.file, "{}", cells.join(",")).at_file(Place::Log, &self.path)
    }

    /// Hands the appended rows to the system.
    pub fn flush(&mut self) -> Result<()> {
        self.file.flush().at_file(Place::Log, &self.path)
    }
}

fn first_lines(path: &Path, columns: &str, rows: u64) -> Result<String> {
    let text = fs::read_to_string(path)?;
    let wanted = usize::try_from(rows).map_or(usize::MAX, |rows| rows.saturating_add(1));
    let lines: Vec<&str> = text.split_inclusive('\n').take(wanted).collect();
    let head = lines.first().map(|line| line.trim_end());
    if head != Some(columns) {
        return Err(TrainingError::LogColumns.into());
    }
    if lines.len() != wanted || lines.iter().any(|line| !line.ends_with('\n')) {
        return Err(TrainingError::LogRows.into());
    }
    Ok(lines.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_continued_log_loses_what_its_checkpoint_has_not_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("steps.csv");
        let open = |rows| Log::open(path.clone(), "step,loss", rows);
        let push = |log: &mut Log, step: usize| {
            log.push(&[step.to_string(), "0.5".into()]).unwrap();
        };
        let mut log = open(0).unwrap();
        (0..5).for_each(|step| push(&mut log, step));
        log.flush().unwrap();
        let whole = fs::read_to_string(&path).unwrap();
        // A kill on the way leaves the old one, whole: it is replaced, not cut.
        let old = folder.path().join("old");
        fs::hard_link(&path, &old).unwrap();
        let mut log = open(3).unwrap();
        assert_eq!(fs::read_to_string(&old).unwrap(), whole);
        assert_eq!(log.last(), Some(0.5));
        (3..5).for_each(|step| push(&mut log, step));
        log.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        assert!(open(6).is_err(), "rows are missing");
        fs::write(&path, "other,columns\n0,1\n").unwrap();
        assert!(open(1).is_err());
    }
}
