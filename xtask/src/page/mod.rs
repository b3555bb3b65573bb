//! Pages that need nothing but themselves: HTML with its style and pictures inside.
//!
//! A page is a title, a few words, and [`Section`]s of paragraphs, figures and tables. It opens
//! offline, can be read on a phone, follows the reader's light or dark theme, and holds no script.
//! Text is escaped wherever it goes; what is meant as markup is made with [`maud::html!`].
//!
//! ```
//! use xtask::page::{Page, Section, Table};
//!
//! let mut section = Section::new("Scores");
//! section.paragraph("Smaller is better: a < b.");
//! section.table(&Table::new(["model", "error"]).row(["mean <spectrum>", "0.31"]));
//! let html = Page::new("Results").section(section).to_html();
//! assert!(html.contains("mean &lt;spectrum&gt;") && html.contains("id=\"scores\""));
//! ```

mod style;
mod table;

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
use maud::{DOCTYPE, Markup, PreEscaped, Render, html};

pub use table::Table;

use crate::drawing::Drawing;

/// A page in the making.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    lead: Vec<Markup>,
    sections: Vec<Section>,
}

/// A part of a page with a heading and an anchor.
#[derive(Debug, Clone)]
pub struct Section {
    title: String,
    body: Vec<Markup>,
}

impl Page {
    /// A page with nothing but a title.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            lead: Vec::new(),
            sections: Vec::new(),
        }
    }

    /// Adds a paragraph between the title and the table of contents.
    #[must_use]
    pub fn lead(mut self, text: impl Render) -> Self {
        self.lead.push(html! { p.lead { (text) } });
        self
    }

    /// Adds a section.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// The whole text of the file. Sections get anchors made of their titles, numbered where two
    /// would be equal; three or more get a table of contents.
    pub fn to_html(&self) -> String {
        let ids = self.anchors();
        let sections = || self.sections.iter().zip(&ids);
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(style::css())) }
                }
                body {
                    main {
                        h1 { (self.title) }
                        @for part in &self.lead { (part) }
                        @if self.sections.len() > 2 {
                            nav { ul { @for (section, id) in sections() {
                                li { a href={ "#" (id) } { (section.title) } }
                            } } }
                        }
                        @for (section, id) in sections() {
                            section id=(id) {
                                h2 { (section.title) }
                                @for part in &section.body { (part) }
                            }
                        }
                    }
                }
            }
        };
        page.into_string()
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn save(&self, file: &Path) -> Result<()> {
        std::fs::write(file, self.to_html())
            .with_context(|| format!("cannot write the page '{}'", file.display()))
    }

    fn anchors(&self) -> Vec<String> {
        let mut seen = BTreeMap::new();
        let mut anchor = |title: &str| {
            let id = slug(title);
            let count = seen.entry(id.clone()).or_insert(0);
            *count += 1;
            if *count == 1 {
                id
            } else {
                format!("{id}-{count}")
            }
        };
        self.sections.iter().map(|s| anchor(&s.title)).collect()
    }
}

impl Section {
    /// A section with nothing but a heading.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            body: Vec::new(),
        }
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: impl Render) {
        self.body.push(html! { p { (text) } });
    }

    /// Adds a picture with a caption, over the whole width.
    pub fn figure(&mut self, drawing: &Drawing, caption: impl Render) {
        self.body.push(figure(drawing, caption));
    }

    /// Adds figures side by side, as many as fit.
    pub fn figures(&mut self, figures: impl IntoIterator<Item = Markup>) {
        self.body.push(side_by_side(figures));
    }

    /// Adds a table.
    pub fn table(&mut self, table: &Table) {
        self.body.push(table.render());
    }

    /// Adds any markup.
    pub fn markup(&mut self, markup: Markup) {
        self.body.push(markup);
    }
}

/// A picture with a caption, as large as it was drawn where there is room.
pub fn figure(drawing: &Drawing, caption: impl Render) -> Markup {
    html! {
        figure style={ "max-width:" (drawing.size().0) "px" } {
            (drawing)
            figcaption { (caption) }
        }
    }
}

/// Parts side by side, as many as fit.
pub fn side_by_side(parts: impl IntoIterator<Item = Markup>) -> Markup {
    html! { div.beside { @for part in parts { (part) } } }
}

/// Parts in which elements with the same `data-path` light up together when one is pointed at.
pub fn linked(content: impl Render) -> Markup {
    html! { div.linked { (content) } }
}

/// Letters and digits of a title, the rest as single hyphens.
fn slug(title: &str) -> String {
    let mut id = String::new();
    for c in title.chars().flat_map(char::to_lowercase) {
        if c.is_alphanumeric() {
            id.push(c);
        } else if !id.is_empty() && !id.ends_with('-') {
            id.push('-');
        }
    }
    let id = id.trim_end_matches('-');
    if id.is_empty() {
        "section".into()
    } else {
        id.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::{Axis, Chart};

    #[test]
    fn text_stays_text_wherever_it_goes() {
        let nasty = "</title><script>alert('&')</script>\"";
        let mut section = Section::new(nasty);
        section.paragraph(nasty);
        section.table(&Table::new([nasty]).row([nasty]).captioned(nasty));
        let chart = Chart::new(Axis::linear(nasty), Axis::linear(nasty)).titled(nasty);
        section.figure(&chart.draw(), nasty);
        let html = Page::new(nasty).lead(nasty).section(section).to_html();
        assert!(!html.contains("<script"), "{html}");
        assert!(html.contains("&lt;script&gt;alert('&amp;')"), "{html}");
    }

    #[test]
    fn sections_of_equal_names_have_different_anchors() {
        let page = ["A b", "a  B!", "?"]
            .into_iter()
            .fold(Page::new(""), |page, title| {
                page.section(Section::new(title))
            });
        assert_eq!(page.anchors(), ["a-b", "a-b-2", "section"]);
        let html = page.to_html();
        assert!(html.contains("href=\"#a-b-2\"") && html.contains("id=\"a-b-2\""));
    }

    #[test]
    fn a_page_asks_nothing_of_the_network() {
        let html = Page::new("x").section(Section::new("y")).to_html();
        let outside = html.replace("http://www.w3.org/2000/svg", "");
        assert!(
            !outside.contains("http") && !outside.contains("@import"),
            "{html}"
        );
    }
}
