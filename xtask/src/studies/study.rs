//! What a study has to say, and how it lies in a folder.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use super::Conditions;
use crate::drawing::Drawing;
use crate::whole_files;

/// Version of `NAME.json`. Fields that a reader does not know are passed over; a change that it must
/// know of counts this up.
pub const FORMAT: u32 = 1;

/// A study: its words, tables and figures, and the files that belong to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// [`FORMAT`] of the writer.
    pub format: u32,
    /// Lower-case letters, digits and hyphens; all its files begin with it.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// Place in the document; of equal ones the name decides.
    pub place: u32,
    /// How it came about.
    pub conditions: Option<Conditions>,
    /// What it says, in order.
    pub blocks: Vec<Block>,
    /// Names of its CSV and SVG files, in the folder of its JSON.
    pub files: BTreeSet<String>,
    /// Their contents, on the way to the folder.
    #[serde(skip)]
    contents: Vec<(String, Vec<u8>)>,
}

/// A piece of a study. All text is plain: nothing in it is taken for markup.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Block {
    /// A smaller heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// Points of a list.
    Points(Vec<String>),
    /// A figure.
    Figure {
        /// Its file.
        file: String,
        /// Words below it.
        caption: String,
    },
    /// A table to read.
    Table {
        /// Words above it.
        caption: String,
        /// Headings, with units.
        head: Vec<String>,
        /// Rows of as many cells.
        rows: Vec<Vec<String>>,
    },
    /// A file of data.
    Data {
        /// Its file.
        file: String,
        /// What is in it.
        caption: String,
    },
}

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
            title: title.into(),
            place: 0,
            conditions: None,
            blocks: Vec::new(),
            files: BTreeSet::new(),
            contents: Vec::new(),
        }
    }

    /// Sets its place in the document.
    #[must_use]
    pub fn at(self, place: u32) -> Self {
        Self { place, ..self }
    }

    /// Adds a smaller heading.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading(text.into()));
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }

    /// Adds a list, if it has any points.
    pub fn points(&mut self, points: Vec<String>) {
        if !points.is_empty() {
            self.blocks.push(Block::Points(points));
        }
    }

    /// Adds a figure; its file is `NAME-STEM.svg`.
    pub fn figure(&mut self, stem: &str, caption: impl Into<String>, drawing: &Drawing) {
        let file = self.keep(stem, "svg", drawing.to_file_text().into_bytes());
        let caption = caption.into();
        self.blocks.push(Block::Figure { file, caption });
    }

    /// Adds a table.
    ///
    /// # Panics
    /// For a row with another number of cells than the head.
    pub fn table(&mut self, caption: impl Into<String>, head: &[&str], rows: Vec<Vec<String>>) {
        let all_fit = rows.iter().all(|row| row.len() == head.len());
        assert!(all_fit, "{head:?} does not head all rows");
        self.blocks.push(Block::Table {
            caption: caption.into(),
            head: head.iter().copied().map(Into::into).collect(),
            rows,
        });
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
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in rows {
            writer.serialize(row).context("a row of measured data")?;
        }
        let file = self.keep(stem, "csv", writer.into_inner()?);
        let caption = caption.into();
        self.blocks.push(Block::Data { file, caption });
        Ok(())
    }

    fn keep(&mut self, stem: &str, extension: &str, content: Vec<u8>) -> String {
        let file = format!("{}-{stem}.{extension}", self.name);
        assert!(is_plain(stem), "'{stem}' is no part of a file name");
        assert!(self.files.insert(file.clone()), "'{file}' is there twice");
        self.contents.push((file.clone(), content));
        file
    }

    /// Writes its files, then its JSON, and removes what an earlier run of it left behind.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn write(mut self, folder: &Path, conditions: Conditions) -> Result<()> {
        self.conditions = Some(conditions);
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder '{}'", folder.display()))?;
        let path = folder.join(format!("{}.json", self.name));
        let before = match path.exists() {
            // What cannot be read anew is written anew, and leaves its files.
            true => Self::read(&path).map_or_else(|_| BTreeSet::new(), |study| study.files),
            false => BTreeSet::new(),
        };
        for (file, content) in &self.contents {
            whole_files::write(&folder.join(file), content)?;
        }
        let mut text = serde_json::to_string_pretty(&self).context("a study as JSON")?;
        text.push('\n');
        whole_files::write(&path, text.as_bytes())?;
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
        for file in study
            .files
            .iter()
            .chain(study.blocks.iter().filter_map(Block::file))
        {
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

impl Block {
    /// The file it shows or names.
    fn file(&self) -> Option<&String> {
        match self {
            Self::Figure { file, .. } | Self::Data { file, .. } => Some(file),
            _ => None,
        }
    }
}

/// Whether a name is safe in file names and links on every system.
fn is_plain(name: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    !name.is_empty() && name.chars().all(is_plain)
}
