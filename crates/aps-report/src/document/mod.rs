//! Documents: sections of paragraphs, verdicts, tables and figures, written as HTML or as Markdown.
//!
//! There is one model for all that the programs write to be read. As HTML ([`Document::to_html`]) a document needs nothing
//! but itself: its style and pictures are inside, it opens offline, can be read on a phone, follows the reader's light or
//! dark theme, and holds no script. As Markdown ([`Document::to_markdown`]) it refers to the files of its figures and data,
//! which [`Section::files`] gives. Text is plain wherever it goes: nothing in it is taken for markup.
//!
//! ```
//! use aps_report::document::{Document, Section, Table, Verdict};
//!
//! let mut section = Section::new("Scores");
//! section.verdict(Verdict::bound("error of the model", 0.31, 0.5, ""));
//! section.table(Table::new("Scores", ["model", "error"]).row(["mean <spectrum>", "0.31"]));
//! let document = Document::new("Results").section(section);
//! assert!(document.to_html().contains("mean &lt;spectrum&gt;"));
//! assert!(document.to_markdown("").contains("**PASS** error of the model: 0.310, bound 0.500"));
//! ```

mod block;
mod html;
mod markdown;
mod style;
mod table;
mod verdict;

use std::fs;
use std::path::{Path, PathBuf};

pub use block::{Block, Data, Figure, Layout};
pub use table::{RowMark, Table};
pub use verdict::{Outcome, Verdict};

use serde::{Deserialize, Serialize};

use crate::ReportError;

/// A title, paragraphs below it, and sections.
#[derive(Debug, Clone)]
pub struct Document {
    /// Its heading.
    pub title: String,
    /// Paragraphs between the title and the first section.
    pub lead: Vec<String>,
    /// Its sections.
    pub sections: Vec<Section>,
}

/// A part of a document with a heading.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// Its content, in order.
    pub blocks: Vec<Block>,
}

impl Document {
    /// A document with nothing but a title.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            lead: Vec::new(),
            sections: Vec::new(),
        }
    }

    /// Adds a paragraph between the title and the first section.
    #[must_use]
    pub fn lead(mut self, text: impl Into<String>) -> Self {
        self.lead.push(text.into());
        self
    }

    /// Adds a section.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// Writes the HTML file.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn save_html(&self, file: &Path) -> Result<(), ReportError> {
        fs::write(file, self.to_html()).map_err(ReportError::at("write the page", file))
    }

    /// Writes `NAME.html`, `NAME.md` and the files of its figures and data into a folder; returns all of them.
    ///
    /// # Errors
    /// The file or folder that cannot be written, and why.
    pub fn write(&self, folder: &Path, name: &str) -> Result<Vec<PathBuf>, ReportError> {
        let mut files = Vec::new();
        for (file, content) in self.sections.iter().flat_map(Section::files) {
            let path = folder.join(file);
            let parent = path.parent().unwrap_or(folder);
            fs::create_dir_all(parent).map_err(ReportError::at("make the folder", parent))?;
            fs::write(&path, content).map_err(ReportError::at("write", &path))?;
            files.push(path);
        }
        let html = folder.join(format!("{name}.html"));
        self.save_html(&html)?;
        let markdown = folder.join(format!("{name}.md"));
        fs::write(&markdown, self.to_markdown(""))
            .map_err(ReportError::at("write the report", &markdown))?;
        files.extend([html, markdown]);
        Ok(files)
    }
}

impl Section {
    /// A section with nothing but a heading.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            blocks: Vec::new(),
        }
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }

    /// Adds a heading within the section.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading(text.into()));
    }

    /// Adds a verdict; those that follow each other make a list.
    pub fn verdict(&mut self, verdict: Verdict) {
        if let Some(Block::Verdicts(verdicts)) = self.blocks.last_mut() {
            verdicts.push(verdict);
        } else {
            self.blocks.push(Block::Verdicts(vec![verdict]));
        }
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    /// Adds figures side by side, as many as fit, if there are any.
    pub fn figures(&mut self, figures: Vec<Figure>) {
        if !figures.is_empty() {
            let blocks = figures.into_iter().map(Block::Figure).collect();
            self.blocks.push(Block::Group(Layout::Beside, blocks));
        }
    }

    /// The files that its figures and data refer to, with their contents; none for those that were read back without.
    pub fn files(&self) -> Vec<(&str, Vec<u8>)> {
        let mut files = Vec::new();
        for block in &self.blocks {
            block.add_files(&mut files);
        }
        files
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Axis, Chart};

    fn nasty(text: &str) -> Document {
        let mut section = Section::new(text);
        section.text(text);
        section.heading(text);
        section.verdict(Verdict::decided(true, text, text));
        section.table(Table::new(text, [text]).row([text]));
        let chart = Chart::new(Axis::linear(text), Axis::linear(text)).titled(text);
        let figure = Figure::new("figures/a.svg", text, chart.draw());
        section.figures(vec![figure]);
        Document::new(text).lead(text).section(section)
    }

    #[test]
    fn text_stays_text_wherever_it_goes() {
        let text = "</title><script>alert('&')</script>\" a|b **x** ~~u~~ [y](z)\n# w";
        let document = nasty(text);
        let html = document.to_html();
        assert!(!html.contains("<script"), "{html}");
        assert!(html.contains("&lt;script&gt;alert('&amp;')"), "{html}");
        let markdown = document.to_markdown("");
        for raw in ["<script", " **x**", " ~~u", "a|b", "\n# w", "[y](z)"] {
            assert!(!markdown.contains(raw), "{raw}: {markdown}");
        }
    }

    #[test]
    fn a_page_asks_nothing_of_the_network() {
        let html = nasty("x").to_html();
        let outside = html.replace("http://www.w3.org/2000/svg", "");
        assert!(
            !outside.contains("http") && !outside.contains("@import"),
            "{html}"
        );
    }

    #[test]
    fn all_files_that_markdown_links_to_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let mut document = nasty("x");
        let data = Data::of_rows("d.csv", "Data", &[(1, 2.5)]).unwrap();
        document.sections[0].blocks.push(Block::Data(data));
        let table = Table::new("T", ["a"]).row(["1"]);
        document.sections[0].table(table.with_data("tables/t.csv", vec![vec!["a".into()]]));
        let files = document.write(folder.path(), "report").unwrap();
        assert_eq!(files.len(), 5);
        let text = fs::read_to_string(folder.path().join("report.md")).unwrap();
        let links: Vec<&str> = text.split("](").skip(1).collect();
        assert_eq!(links.len(), 3);
        for link in links {
            let file = link.split(')').next().unwrap();
            assert!(folder.path().join(file).is_file(), "{file}");
        }
    }
}
