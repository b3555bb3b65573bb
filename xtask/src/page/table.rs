//! Tables: names to the left, numbers to the right.

use maud::{Markup, Render, html};

/// A table. A column whose cells all begin like numbers is set flush right.
#[derive(Debug, Clone, Default)]
pub struct Table {
    caption: String,
    head: Vec<String>,
    rows: Vec<Row>,
}

#[derive(Debug, Clone)]
struct Row {
    cells: Vec<String>,
    link: Option<String>,
    colour: Option<String>,
}

impl Table {
    /// A table without rows.
    pub fn new<S: Into<String>>(head: impl IntoIterator<Item = S>) -> Self {
        Self {
            head: head.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }

    /// Sets the line above the table.
    #[must_use]
    pub fn captioned(self, caption: impl Into<String>) -> Self {
        Self {
            caption: caption.into(),
            ..self
        }
    }

    /// Adds a row.
    #[must_use]
    pub fn row<S: Into<String>>(mut self, cells: impl IntoIterator<Item = S>) -> Self {
        self.push(cells, None, None);
        self
    }

    /// Adds a row that lights up with the elements of pictures that have the same `link`, the value
    /// of their `data-path`, and whose first cell has the colour of that name.
    pub fn push<S: Into<String>>(
        &mut self,
        cells: impl IntoIterator<Item = S>,
        link: Option<String>,
        colour: Option<String>,
    ) {
        self.rows.push(Row {
            cells: cells.into_iter().map(Into::into).collect(),
            link,
            colour,
        });
    }

    fn is_numeric(&self, column: usize) -> bool {
        let is_number = |cell: &String| {
            let start = cell.trim_start_matches(['\u{2212}', '-', '+', '>', '<', ' ']);
            cell.is_empty() || cell == "\u{2013}" || start.starts_with(|c: char| c.is_ascii_digit())
        };
        let mut cells = self
            .rows
            .iter()
            .filter_map(|row| row.cells.get(column))
            .peekable();
        cells.peek().is_some() && cells.all(is_number)
    }
}

impl Render for Table {
    fn render(&self) -> Markup {
        let numeric: Vec<bool> = (0..self.head.len()).map(|i| self.is_numeric(i)).collect();
        let class = |i: usize| numeric.get(i).copied().unwrap_or(false).then_some("number");
        html! {
            div.scroll {
                table {
                    @if !self.caption.is_empty() { caption { (self.caption) } }
                    thead { tr { @for (i, title) in self.head.iter().enumerate() {
                        th class=[class(i)] { (title) }
                    } } }
                    tbody { @for row in &self.rows {
                        tr data-path=[row.link.as_deref()] tabindex=[row.link.as_ref().map(|_| 0)] {
                            @for (i, cell) in row.cells.iter().enumerate() {
                                td class=[class(i)] {
                                    @match &row.colour {
                                        Some(colour) if i == 0 => span.chip style={ "background:var(--" (colour) ")" } { (cell) },
                                        _ => (cell),
                                    }
                                }
                            }
                        }
                    } }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_columns_of_numbers_are_set_flush_right() {
        let table = Table::new(["name", "error", "mixed"])
            .row(["a", "\u{2212}0.5", "1"])
            .row(["1b", "12 %", "one"])
            .row(["c", "\u{2013}", ""]);
        let numeric: Vec<bool> = (0..3).map(|i| table.is_numeric(i)).collect();
        assert_eq!(numeric, [false, true, false]);
    }
}
