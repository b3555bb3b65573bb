//! Documents as HTML.

use std::collections::BTreeMap;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Block, Document, Figure, Layout, Table, style};
use crate::numbers::stem;

impl Document {
    /// The whole text of an HTML file. Sections get anchors made of their titles, numbered where two would be equal;
    /// four or more get a table of contents.
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
                        @for text in &self.lead { p.lead { (text) } }
                        @if self.sections.len() > 3 {
                            nav { ul { @for (section, id) in sections() {
                                li { a href={ "#" (id) } { (section.title) } }
                            } } }
                        }
                        @for (section, id) in sections() {
                            section id=(id) {
                                h2 { (section.title) }
                                @for block in &section.blocks { (block.to_html()) }
                            }
                        }
                    }
                }
            }
        };
        page.into_string()
    }

    fn anchors(&self) -> Vec<String> {
        let mut seen = BTreeMap::new();
        let mut anchor = |title: &str| {
            let id = match stem(title) {
                none if none.is_empty() => "section".into(),
                id => id,
            };
            let count = seen.entry(id.clone()).or_insert(0);
            *count += 1;
            match count {
                1 => id,
                n => format!("{id}-{n}"),
            }
        };
        self.sections.iter().map(|s| anchor(&s.title)).collect()
    }
}

impl Block {
    fn to_html(&self) -> Markup {
        match self {
            Self::Text(text) => html! { p { (text) } },
            Self::Heading(text) => html! { h3 { (text) } },
            Self::Verdicts(verdicts) => html! { ul { @for v in verdicts {
                li { strong { (v.outcome.word()) } " " (v.line()) }
            } } },
            Self::Table(table) if table.is_folded => html! {
                details { summary { (table.caption) } (body(table, "")) }
            },
            Self::Table(table) => body(table, &table.caption),
            Self::Figure(figure) => figure.to_html(),
            Self::Data(data) => html! { p { a href=(data.file) { (data.caption) } } },
            Self::Folded { title, text } => html! {
                details { summary { (title) } pre { code { (text) } } }
            },
            Self::Group(layout, blocks) => {
                let class = match layout {
                    Layout::Beside => Some("beside"),
                    Layout::Linked => Some("linked"),
                    Layout::Stack => None,
                };
                html! { div class=[class] { @for block in blocks { (block.to_html()) } } }
            }
        }
    }
}

impl Figure {
    /// The figure, as large as it was drawn where there is room.
    fn to_html(&self) -> Markup {
        let width = self.drawing.as_ref().map(|drawing| drawing.size().0);
        let width = width.map(|width| format!("max-width:{width}px"));
        html! {
            figure style=[width] {
                @match &self.drawing {
                    Some(drawing) => (drawing),
                    None => img src=(self.file) alt=(self.caption);,
                }
                figcaption { (self.caption) }
            }
        }
    }
}

fn body(table: &Table, caption: &str) -> Markup {
    let numeric: Vec<bool> = (0..table.head.len()).map(|i| table.is_numeric(i)).collect();
    let class = |i: usize| numeric.get(i).copied().unwrap_or(false).then_some("number");
    // The names stay in sight when a wide table is moved under a narrow screen.
    let scroll = match table.file {
        Some(_) => "scroll pinned",
        None => "scroll",
    };
    html! {
        div class=(scroll) {
            table {
                @if !caption.is_empty() { caption { (caption) } }
                thead { tr { @for (i, title) in table.head.iter().enumerate() {
                    th class=[class(i)] { (title) }
                } } }
                tbody { @for (row, cells) in table.rows.iter().enumerate() {
                    @let mark = table.mark(row);
                    tr data-path=[mark.link.as_deref()] tabindex=[mark.link.as_ref().map(|_| 0)] {
                        @for (i, cell) in cells.iter().enumerate() {
                            td class=[class(i)] {
                                @match &mark.colour {
                                    Some(colour) if i == 0 => span.chip style={ "background:var(--" (colour) ")" } { (cell) },
                                    _ => (lines(cell, table.best.contains(&(row, i)))),
                                }
                            }
                        }
                    }
                } }
            }
        }
    }
}

/// The first line of a cell, and the others below it in small.
fn lines(cell: &str, is_best: bool) -> Markup {
    let mut lines = cell.lines();
    let first = lines.next().unwrap_or_default();
    html! {
        @if is_best { strong { (first) } } @else { (first) }
        @for line in lines { br; small { (line) } }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Section;
    use super::*;

    #[test]
    fn sections_of_equal_names_have_different_anchors() {
        let titles = ["A b", "a  B!", "?", "c"];
        let mut page = Document::new("");
        page.sections = titles.map(Section::new).into();
        assert_eq!(page.anchors(), ["a-b", "a-b-2", "section", "c"]);
        let html = page.to_html();
        assert!(html.contains("href=\"#a-b-2\"") && html.contains("id=\"a-b-2\""));
    }
}
