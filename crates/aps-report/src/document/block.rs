//! The pieces of a section.

use serde::{Deserialize, Serialize};

use super::{Table, Verdict};
use crate::ReportError;
use crate::drawing::Drawing;

/// A piece of a section.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Block {
    /// A smaller heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// Lines that tell which bounds hold.
    Verdicts(Vec<Verdict>),
    /// A table.
    Table(Table),
    /// A picture with a caption.
    Figure(Figure),
    /// A file of data.
    Data(Data),
    /// Preformatted text behind a line that opens it.
    Folded {
        /// The line.
        title: String,
        /// The text.
        text: String,
    },
    /// Pieces that belong together.
    Group(Layout, Vec<Block>),
}

/// An arrangement of pieces on a page; in Markdown they follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// Side by side, as many as fit.
    Beside,
    /// Below each other, in one place of those beside each other.
    Stack,
    /// Elements with the same `data-path` light up together when one is pointed at.
    Linked,
}

/// A picture with words below it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Figure {
    /// Its SVG file, relative to the document; empty for a picture that is only shown on a page.
    pub file: String,
    /// Words below it.
    pub caption: String,
    /// The picture; none for a figure that was read back, which is in its file.
    #[serde(skip)]
    pub drawing: Option<Drawing>,
}

/// A file of data.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Data {
    /// The file, relative to the document.
    pub file: String,
    /// Description.
    pub caption: String,
    /// Its bytes; none for data that were read back, which are in their file.
    #[serde(skip)]
    pub content: Option<Vec<u8>>,
}

impl Figure {
    /// A figure with a file.
    pub fn new(file: impl Into<String>, caption: impl Into<String>, drawing: Drawing) -> Self {
        Self {
            file: file.into(),
            caption: caption.into(),
            drawing: Some(drawing),
        }
    }

    /// A figure that is only shown on a page.
    pub fn shown(caption: impl Into<String>, drawing: Drawing) -> Self {
        Self::new("", caption, drawing)
    }
}

impl Data {
    /// Rows as CSV, headed by the names of their fields.
    ///
    /// # Errors
    /// Rows that no table can hold.
    pub fn of_rows<R: Serialize>(
        file: impl Into<String>,
        caption: impl Into<String>,
        rows: &[R],
    ) -> Result<Self, ReportError> {
        let file = file.into();
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in rows {
            let written = writer.serialize(row);
            written.map_err(ReportError::at("make the data", file.as_ref()))?;
        }
        let content = writer.into_inner().expect("memory takes any row");
        Ok(Self {
            content: Some(content),
            caption: caption.into(),
            file,
        })
    }
}

impl Block {
    /// The files that it refers to.
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Figure(figure) if !figure.file.is_empty() => vec![&figure.file],
            Self::Data(data) => vec![&data.file],
            Self::Table(table) => table.file.as_deref().into_iter().collect(),
            Self::Group(_, blocks) => blocks.iter().flat_map(Block::names).collect(),
            Self::Figure(_)
            | Self::Heading(_)
            | Self::Text(_)
            | Self::Verdicts(_)
            | Self::Folded { .. } => Vec::new(),
        }
    }

    pub(super) fn add_files<'a>(&'a self, files: &mut Vec<(&'a str, Vec<u8>)>) {
        match self {
            Self::Figure(figure) if !figure.file.is_empty() => {
                let text = figure.drawing.as_ref().map(Drawing::to_file_text);
                files.extend(text.map(|text| (&*figure.file, text.into_bytes())));
            }
            Self::Data(data) => {
                files.extend(data.content.clone().map(|bytes| (&*data.file, bytes)));
            }
            Self::Table(table) => files.extend(table.file.as_deref().zip(table.csv())),
            Self::Group(_, blocks) => blocks.iter().for_each(|block| block.add_files(files)),
            Self::Figure(_)
            | Self::Heading(_)
            | Self::Text(_)
            | Self::Verdicts(_)
            | Self::Folded { .. } => {}
        }
    }
}
