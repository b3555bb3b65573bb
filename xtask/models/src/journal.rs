//! Logs of a run as CSV: one row a step, one row a score. They hold no times, so that the same run writes the same
//! bytes, stopped and continued or not.

use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

/// A CSV file that a run adds rows to.
pub struct Journal {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl Journal {
    /// Opens a log that has `rows` rows of the run so far; what a stopped run wrote beyond its checkpoint is dropped.
    pub fn open(path: PathBuf, columns: &[String], rows: u64) -> Result<Self> {
        let place = || format!("log '{}'", path.display());
        let kept = match rows {
            0 => columns.join(",") + "\n",
            _ => first_lines(&path, columns, rows).with_context(place)?,
        };
        fs::write(&path, kept).with_context(place)?;
        let file = OpenOptions::new()
            .append(true)
            .open(&path)
            .with_context(place)?;
        let writer = csv::WriterBuilder::new()
            .has_headers(false)
            .from_writer(file);
        Ok(Self { path, writer })
    }

    /// Appends a row.
    pub fn push(&mut self, cells: &[String]) -> Result<()> {
        let written = self.writer.write_record(cells);
        written.with_context(|| format!("log '{}'", self.path.display()))
    }

    /// Hands the appended rows to the system.
    pub fn flush(&mut self) -> Result<()> {
        let flushed = self.writer.flush();
        flushed.with_context(|| format!("log '{}'", self.path.display()))
    }
}

fn first_lines(path: &Path, columns: &[String], rows: u64) -> Result<String> {
    let text = fs::read_to_string(path)?;
    let wanted = usize::try_from(rows).map_or(usize::MAX, |rows| rows.saturating_add(1));
    let lines: Vec<&str> = text.split_inclusive('\n').take(wanted).collect();
    ensure!(
        lines
            .first()
            .is_some_and(|line| line.trim_end() == columns.join(",")),
        "its columns are not those of this run; move it away to continue without it"
    );
    ensure!(
        lines.len() == wanted && lines.iter().all(|line| line.ends_with('\n')),
        "it has fewer rows than its checkpoint has seen; restore it, or start anew in another folder"
    );
    Ok(lines.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_continued_log_loses_what_its_checkpoint_has_not_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("steps.csv");
        let columns = ["step".to_owned(), "loss".to_owned()];
        let open = |rows| Journal::open(path.clone(), &columns, rows);
        let push = |journal: &mut Journal, step: usize| {
            journal.push(&[step.to_string(), "0.5".into()]).unwrap();
        };
        let mut journal = open(0).unwrap();
        (0..5).for_each(|step| push(&mut journal, step));
        journal.flush().unwrap();
        let whole = fs::read_to_string(&path).unwrap();
        let mut journal = open(3).unwrap();
        (3..5).for_each(|step| push(&mut journal, step));
        journal.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        assert!(open(6).is_err(), "rows are missing");
        fs::write(&path, "other,columns\n0,1\n").unwrap();
        assert!(open(1).is_err());
    }
}
