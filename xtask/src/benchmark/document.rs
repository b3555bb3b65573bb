//! A report in the making: one list of parts, written as a page, as Markdown and as files.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use maud::{Markup, Render, html};

use crate::drawing::Drawing;
use crate::page::{self, Page, Section};

/// A report.
#[derive(Debug, Default)]
pub struct Document {
    /// Its heading.
    pub title: String,
    /// Paragraphs below it.
    pub lead: Vec<String>,
    /// The rest.
    pub parts: Vec<Part>,
}

/// A part with a heading.
#[derive(Debug)]
pub struct Part {
    /// The heading.
    pub title: String,
    /// What it holds.
    pub blocks: Vec<Block>,
}

/// A piece of a part.
#[derive(Debug)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// Points of a list.
    Points(Vec<String>),
    /// A table.
    Table(Grid),
    /// Figures side by side.
    Figures(Vec<Figure>),
    /// A smaller heading.
    Heading(String),
    /// Preformatted text behind a line that opens it.
    Folded(String, String),
}

/// A figure.
#[derive(Debug)]
pub struct Figure {
    /// Name of its file without `.svg`.
    pub stem: String,
    /// Words below it.
    pub caption: String,
    /// The picture.
    pub drawing: Drawing,
}

/// A table to read, and the same with all digits as CSV.
#[derive(Debug, Default)]
pub struct Grid {
    /// Name of its file without `.csv`.
    pub stem: String,
    /// Words above it.
    pub caption: String,
    /// Headings.
    pub head: Vec<String>,
    /// Rows, the first cell being a name.
    pub rows: Vec<Vec<Cell>>,
    /// Headings and rows of the CSV.
    pub data: Vec<Vec<String>>,
    /// Whether the page shows it only when asked, and Markdown only links to its file.
    pub is_folded: bool,
}

/// A cell of a table.
#[derive(Debug, Clone, Default)]
pub struct Cell {
    /// What it says.
    pub text: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
    /// Whether it stands out.
    pub is_best: bool,
}

impl Cell {
    /// A cell of a few words.
    pub fn text(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    /// A cell that says there is nothing.
    pub fn nothing() -> Self {
        Self::text("\u{2013}")
    }

    /// The same with a smaller line.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }
}

impl Part {
    /// A part with nothing but a heading.
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

    /// Adds figures, if there are any.
    pub fn figures(&mut self, figures: Vec<Figure>) {
        if !figures.is_empty() {
            self.blocks.push(Block::Figures(figures));
        }
    }
}

impl Document {
    /// Writes `report.html`, `report.md`, `tables/*.csv` and `figures/*.svg`; returns all files.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        for name in ["tables", "figures"] {
            let folder = folder.join(name);
            fs::create_dir_all(&folder)
                .with_context(|| format!("cannot make the folder '{}'", folder.display()))?;
        }
        for block in self.parts.iter().flat_map(|p| &p.blocks) {
            match block {
                Block::Table(grid) => {
                    let file = folder.join("tables").join(format!("{}.csv", grid.stem));
                    write_csv(grid, &file)?;
                    files.push(file);
                }
                Block::Figures(figures) => {
                    for figure in figures {
                        let file = folder.join("figures").join(format!("{}.svg", figure.stem));
                        figure.drawing.save(&file)?;
                        files.push(file);
                    }
                }
                _ => {}
            }
        }
        let html = folder.join("report.html");
        self.page().save(&html)?;
        let markdown = folder.join("report.md");
        fs::write(&markdown, self.to_markdown())
            .with_context(|| format!("cannot write the report '{}'", markdown.display()))?;
        files.extend([html, markdown]);
        Ok(files)
    }

    fn page(&self) -> Page {
        let page = self.lead.iter().fold(Page::new(&self.title), Page::lead);
        self.parts.iter().fold(page, |page, part| {
            let mut section = Section::new(&part.title);
            for block in &part.blocks {
                section.markup(block.to_html());
            }
            page.section(section)
        })
    }

    /// The report in GitHub's Markdown.
    pub fn to_markdown(&self) -> String {
        let mut out = format!("# {}\n", escape(&self.title));
        for text in &self.lead {
            out += &format!("\n{}\n", escape(text));
        }
        for part in &self.parts {
            out += &format!("\n## {}\n", escape(&part.title));
            for block in &part.blocks {
                out += "\n";
                out += &block.to_markdown();
            }
        }
        out
    }
}

impl Block {
    fn to_html(&self) -> Markup {
        match self {
            Self::Text(text) => html! { p { (text) } },
            Self::Heading(text) => html! { h3 { (text) } },
            Self::Points(points) => html! { ul { @for point in points { li { (point) } } } },
            Self::Folded(title, text) => html! {
                details { summary { (title) } pre style="overflow-x:auto;font-size:.85rem" { (text) } }
            },
            Self::Table(grid) if grid.is_folded => html! {
                details { summary { (grid.caption) } (grid.body("")) }
            },
            Self::Table(grid) => grid.body(&grid.caption),
            Self::Figures(figures) => {
                let drawn = figures.iter().map(|f| page::figure(&f.drawing, &f.caption));
                page::side_by_side(drawn)
            }
        }
    }

    fn to_markdown(&self) -> String {
        match self {
            Self::Text(text) => format!("{}\n", escape(text)),
            Self::Heading(text) => format!("### {}\n", escape(text)),
            Self::Points(points) => points
                .iter()
                .map(|p| format!("- {}\n", escape(p)))
                .collect(),
            Self::Folded(title, text) => {
                format!("{}:\n\n```\n{}\n```\n", escape(title), text.trim())
            }
            Self::Table(grid) => grid.to_markdown(),
            Self::Figures(figures) => figures
                .iter()
                .map(|f| {
                    let caption = escape(&f.caption);
                    format!("![{caption}](figures/{}.svg)\n\n{caption}\n\n", f.stem)
                })
                .collect(),
        }
    }
}

impl Grid {
    fn body(&self, caption: &str) -> Markup {
        // The names stay in sight when a wide table is moved under a narrow screen.
        let name = "position:sticky;left:0;background:var(--paper);z-index:1";
        let columns = 1..self.head.len();
        let numeric: Vec<bool> = columns.map(|i| self.is_numeric(i)).collect();
        // Short names keep to one line.
        let style = |i: usize, cell: &Cell| match cell.text.chars().count() {
            n if i == 0 && n <= 16 => Some(format!("{name};white-space:nowrap")),
            _ => (i == 0).then(|| name.to_owned()),
        };
        let heading = |i: usize| if i == 0 { name } else { "white-space:normal" };
        let class = |i: usize| (i > 0 && numeric[i - 1]).then_some("number");
        html! {
            div.scroll { table {
                @if !caption.is_empty() { caption { (caption) } }
                thead { tr { @for (i, title) in self.head.iter().enumerate() {
                    th style=(heading(i)) class=[class(i)] { (title) }
                } } }
                tbody { @for row in &self.rows { tr {
                    @for (i, cell) in row.iter().enumerate() {
                        td style=[style(i, cell)] class=[class(i)] { (cell) }
                    }
                } } }
            } }
        }
    }

    fn is_numeric(&self, column: usize) -> bool {
        let is_number = |cell: &Cell| {
            let start = cell.text.trim_start_matches(['\u{2212}', '+', '\u{2013}']);
            start.is_empty() || start.starts_with(|c: char| c.is_ascii_digit())
        };
        self.rows
            .iter()
            .filter_map(|row| row.get(column))
            .all(is_number)
    }

    fn to_markdown(&self) -> String {
        let link = format!("[{0}.csv](tables/{0}.csv)", self.stem);
        if self.is_folded {
            return format!("{}: {link}\n", escape(&self.caption));
        }
        let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut out = format!("{} ({link})\n\n", escape(&self.caption));
        out += &row(self.head.iter().map(|c| escape(c)).collect());
        out += &row(self.head.iter().map(|_| "---".into()).collect());
        for cells in &self.rows {
            out += &row(cells.iter().map(Cell::to_markdown).collect());
        }
        out
    }
}

impl Cell {
    fn to_markdown(&self) -> String {
        let text = match self.is_best {
            true => format!("**{}**", escape(&self.text)),
            false => escape(&self.text),
        };
        self.notes.iter().fold(text, |text, note| {
            format!("{text}<br><sub>{}</sub>", escape(note))
        })
    }
}

impl Render for Cell {
    fn render(&self) -> Markup {
        html! {
            @if self.is_best { strong { (self.text) } } @else { (self.text) }
            @for note in &self.notes {
                br; span style="font-size:.78rem;color:var(--soft)" { (note) }
            }
        }
    }
}

fn write_csv(grid: &Grid, file: &Path) -> Result<()> {
    let place = || format!("cannot write the table '{}'", file.display());
    let mut writer = csv::Writer::from_path(file).with_context(place)?;
    for row in &grid.data {
        writer.write_record(row).with_context(place)?;
    }
    writer.flush().with_context(place)
}

/// Text that Markdown takes for nothing else, on one line.
pub fn escape(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' => out.extend(['\\', c]),
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '&' => out += "&amp;",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_outside_stay_text() {
        let nasty = "a|b <script> **x** [y](z)\n# w";
        let mut part = Part::new(nasty);
        part.text(nasty);
        part.blocks.push(Block::Table(Grid {
            head: vec![nasty.into()],
            rows: vec![vec![Cell::text(nasty).note(nasty)]],
            ..Grid::default()
        }));
        let document = Document {
            title: nasty.into(),
            lead: vec![nasty.into()],
            parts: vec![part],
        };
        assert!(!document.page().to_html().contains("<script"));
        let markdown = document.to_markdown();
        assert!(
            !markdown.contains("<script") && !markdown.contains(" **x**"),
            "{markdown}"
        );
        assert!(
            !markdown.contains("a|b") && !markdown.contains("\n# w"),
            "{markdown}"
        );
    }
}
