//! Logs of a run as CSV: one row a step, one row a score. Times are in a log of their own, so that the same run writes the same
//! bytes into the others, stopped and continued or not.

use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use aps_data::replace_file;

use super::TrainingError;
use crate::error::{At, Place, Result};

/// A CSV file that a run adds rows to. Its cells are numbers, which need no quotes. One that was moved away begins anew where the run
/// is continued, and the times with it: `times.csv` then counts from there.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    /// Last cell of the rows it was opened with.
    last: Option<f64>,
}

impl Log {
    /// Opens a log of such columns, the first a number of steps, whose row `last` is the last of the run so far, if it has one; what
    /// a stopped run wrote beyond its checkpoint is dropped. A log that was moved away begins anew.
    pub fn open(path: PathBuf, columns: &str, last: Option<u64>) -> Result<Self> {
        let open = || -> Result<(File, Option<f64>)> {
            let kept = match last {
                Some(last) if path.exists() => lines_to(&path, columns, last)?,
                _ => format!("{columns}\n"),
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

/// The names of the columns, and the rows to that which begins with `last`, unless the log was begun anew since.
fn lines_to(path: &Path, columns: &str, last: u64) -> Result<String> {
    let text = fs::read_to_string(path)?;
    let mut lines = text
        .split_inclusive('\n')
        .filter(|line| line.ends_with('\n'));
    let head = lines.next().unwrap_or_default();
    if head.trim_end() != columns {
        return Err(TrainingError::LogColumns.into());
    }
    let number = |line: &str| {
        line.split(',')
            .next()
            .and_then(|cell| cell.parse::<u64>().ok())
    };
    let is_kept = |line: &&str| number(line).is_some_and(|number| number <= last);
    let rows: Vec<&str> = lines.take_while(is_kept).collect();
    match rows.last() {
        Some(row) if number(row) != Some(last) => Err(TrainingError::LogRows.into()),
        _ => Ok(head.to_owned() + &rows.concat()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_continued_log_loses_what_its_checkpoint_has_not_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("steps.csv");
        let open = |last| Log::open(path.clone(), "step,loss", last);
        let push = |log: &mut Log, step: usize| {
            log.push(&[step.to_string(), "0.5".into()]).unwrap();
        };
        let mut log = open(None).unwrap();
        (0..5).for_each(|step| push(&mut log, step));
        log.flush().unwrap();
        let whole = fs::read_to_string(&path).unwrap();
        // A kill on the way leaves the old one, whole: it is replaced, not cut.
        let old = folder.path().join("old");
        fs::hard_link(&path, &old).unwrap();
        let mut log = open(Some(2)).unwrap();
        assert_eq!(fs::read_to_string(&old).unwrap(), whole);
        assert_eq!(log.last(), Some(0.5));
        (3..5).for_each(|step| push(&mut log, step));
        log.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        assert!(open(Some(5)).is_err(), "a row is missing");
        for other in ["other,columns\n0,1\n", ""] {
            fs::write(&path, other).unwrap();
            assert!(open(Some(0)).is_err());
        }
        // Moved away, as the errors advise, it begins anew, and goes on as often as it is stopped.
        fs::remove_file(&path).unwrap();
        open(Some(4)).unwrap();
        let mut log = open(Some(4)).unwrap();
        (5..8).for_each(|step| push(&mut log, step));
        log.flush().unwrap();
        drop(open(Some(6)).unwrap());
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text, "step,loss\n5,0.5\n6,0.5\n");
    }
}
