//! A study, and its files in a folder.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use aps_data::replace_unsynced;
use aps_report::document::{Block, Data, Figure, Section, Table};
use aps_report::drawing::Drawing;
use serde::{Deserialize, Serialize};

use crate::conditions::Conditions;

/// Version of `NAME.json`. Fields that a reader does not know are passed over; a change that it must
/// know of counts this up. 2 brought verdicts.
pub const FORMAT: u32 = 2;

/// A study: a section of the document, and the files that belong to it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Study {
    /// [`FORMAT`] of the writer.
    pub format: u32,
    /// Lower-case letters, digits and hyphens; all its files begin with it.
    pub name: String,
    /// Place in the document; of equal ones the name decides.
    pub place: u32,
    /// Machine, version and settings.
    pub conditions: Option<Conditions>,
    /// Its title, tables, figures and verdicts.
    #[serde(flatten)]
    pub section: Section,
    /// Names of its CSV and SVG files, in the folder of its JSON.
    pub files: BTreeSet<String>,
}

/// A column of a table: its head, and its cell of an item.
pub type Column<'c, T> = (&'c str, &'c dyn Fn(&T) -> String);

impl Study {
    /// An empty study.
    ///
    /// # Panics
    /// For a name with other characters than lower-case letters, digits and hyphens.
    pub fn new(name: &str, title: impl Into<String>) -> Self {
        assert!(is_plain(name), "'{name}' is no name of a study");
        Self {
            format: FORMAT,
            name: name.into(),
            place: 0,
            conditions: None,
            section: Section::new(title),
            files: BTreeSet::new(),
        }
    }

    /// Adds a figure; its file is `NAME-STEM.svg`.
    pub fn figure(&mut self, stem: &str, caption: impl Into<String>, drawing: Drawing) {
        let figure = Figure::new(self.file(stem, "svg"), caption, drawing);
        self.section.blocks.push(Block::Figure(figure));
    }

    /// Adds a table.
    ///
    /// # Panics
    /// For a row with another number of cells than the head.
    pub fn table(
        &mut self,
        caption: impl Into<String>,
        head: &[&str],
        rows: impl IntoIterator<Item = Vec<String>>,
    ) {
        let table = Table::new(caption, head.iter().copied());
        self.section.table(table.rows(rows));
    }

    /// Adds a table with a row for each item.
    pub fn columns<'i, T: 'i>(
        &mut self,
        caption: impl Into<String>,
        items: impl IntoIterator<Item = &'i T>,
        columns: &[Column<'_, T>],
    ) {
        let head: Vec<&str> = columns.iter().map(|(head, _)| *head).collect();
        let row = |item: &T| columns.iter().map(|(_, cell)| cell(item)).collect();
        self.table(caption, &head, items.into_iter().map(row));
    }

    /// Adds all that was measured as `NAME-STEM.csv`, headed by the rows' field names.
    ///
    /// # Errors
    /// Rows that no table can hold.
    pub fn data<R: Serialize>(
        &mut self,
        stem: &str,
        caption: impl Into<String>,
        rows: &[R],
    ) -> Result<()> {
        let data = Data::of_rows(self.file(stem, "csv"), caption, rows)?;
        self.section.blocks.push(Block::Data(data));
        Ok(())
    }

    /// The name of a file of its own.
    fn file(&mut self, stem: &str, extension: &str) -> String {
        let file = format!("{}-{stem}.{extension}", self.name);
        assert!(is_plain(stem), "'{stem}' is no part of a file name");
        assert!(self.files.insert(file.clone()), "'{file}' is there twice");
        file
    }

    /// Writes the study's files, then its JSON, and removes files that an earlier run left behind.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn write(mut self, folder: &Path, conditions: Conditions) -> Result<()> {
        self.conditions = Some(conditions);
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder '{}'", folder.display()))?;
        let path = folder.join(format!("{}.json", self.name));
        let before = match path.exists() {
            // A study that cannot be read is written anew; its old files stay.
            true => Self::read(&path).map_or_else(|_| BTreeSet::new(), |study| study.files),
            false => BTreeSet::new(),
        };
        for (file, content) in self.section.files() {
            replace_unsynced(&folder.join(file), &content)?;
        }
        let mut text = serde_json::to_string_pretty(&self).context("a study as JSON")?;
        text.push('\n');
        replace_unsynced(&path, text.as_bytes())?;
        for file in before.difference(&self.files) {
            // Gone already is as good.
            let _ = fs::remove_file(folder.join(file));
        }
        Ok(())
    }

    /// Reads a study without the contents of its files, which must be there.
    ///
    /// # Errors
    /// A file that is no study, one of a later format, or names of files that lead elsewhere or nowhere.
    pub fn read(path: &Path) -> Result<Self> {
        let place = || format!("study '{}'", path.display());
        let text = fs::read_to_string(path).with_context(place)?;
        let study: Self = serde_json::from_str(&text).with_context(place)?;
        ensure!(
            study.format <= FORMAT,
            "{} has format {}; this program reads up to {FORMAT}: update it",
            place(),
            study.format
        );
        let folder = path.parent().unwrap_or(Path::new("."));
        let shown = study.section.blocks.iter().flat_map(Block::names);
        for file in study.files.iter().map(String::as_str).chain(shown) {
            let stem = file.rsplit_once('.').map_or("", |(stem, _)| stem);
            ensure!(
                is_plain(stem) && study.files.contains(file),
                "{} names the file '{file}', which is not one of its own",
                place()
            );
            ensure!(
                folder.join(file).is_file(),
                "{} lacks its file '{file}'; measure it anew",
                place()
            );
        }
        Ok(study)
    }
}

/// Tells if a name is safe in file names and links on every system.
fn is_plain(name: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    !name.is_empty() && name.chars().all(is_plain)
}
