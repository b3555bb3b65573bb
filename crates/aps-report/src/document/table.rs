//! Tables: names to the left, numbers to the right.

use serde::{Deserialize, Serialize};

/// A table to read, and the same with all digits as CSV. A column of numbers, with or without units, is set flush right.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Table {
    /// Words above it; empty for none.
    pub caption: String,
    /// Headings, with units.
    pub head: Vec<String>,
    /// Rows of as many cells. Lines of a cell after its first are set smaller.
    pub rows: Vec<Vec<String>>,
    /// Places of the cells that stand out, row and column.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub best: Vec<(usize, usize)>,
    /// Links of the rows to pictures; empty for none at all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<RowMark>,
    /// Its CSV file, relative to the document.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// A page shows it only when asked, and Markdown only links to its file.
    #[serde(skip_serializing_if = "is_false")]
    pub is_folded: bool,
    /// Headings and rows of the CSV; empty for a table that was read back.
    #[serde(skip)]
    pub data: Vec<Vec<String>>,
}

/// A link of a row to elements of pictures.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RowMark {
    /// The value of their `data-path`: they light up together.
    pub link: Option<String>,
    /// The name of the colour that the first cell has.
    pub colour: Option<String>,
}

fn is_false(value: &bool) -> bool {
    !value
}

impl Table {
    /// A table without rows.
    pub fn new<S: Into<String>>(
        caption: impl Into<String>,
        head: impl IntoIterator<Item = S>,
    ) -> Self {
        Self {
            caption: caption.into(),
            head: head.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }

    /// Adds a row.
    #[must_use]
    pub fn row<S: Into<String>>(mut self, cells: impl IntoIterator<Item = S>) -> Self {
        self.push(cells);
        self
    }

    /// Adds rows.
    #[must_use]
    pub fn rows(mut self, rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        rows.into_iter().for_each(|row| self.push(row));
        self
    }

    /// Adds a row.
    ///
    /// # Panics
    /// For another number of cells than the head has.
    pub fn push<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        let cells: Vec<String> = cells.into_iter().map(Into::into).collect();
        assert_eq!(cells.len(), self.head.len(), "{:?}: {cells:?}", self.head);
        self.rows.push(cells);
    }

    /// Adds a row that is linked to pictures.
    pub fn push_marked(&mut self, cells: Vec<String>, mark: RowMark) {
        self.marks.resize(self.rows.len(), RowMark::default());
        self.push(cells);
        self.marks.push(mark);
    }

    /// Sets its CSV file, whose first row is the headings.
    #[must_use]
    pub fn with_data(self, file: impl Into<String>, data: Vec<Vec<String>>) -> Self {
        Self {
            file: Some(file.into()),
            data,
            ..self
        }
    }

    /// Folds the table: it is shown only when asked.
    #[must_use]
    pub fn folded(self) -> Self {
        Self {
            is_folded: true,
            ..self
        }
    }

    /// The bytes of its CSV file, if it has rows for one.
    pub(super) fn csv(&self) -> Option<Vec<u8>> {
        if self.data.is_empty() {
            return None;
        }
        let mut writer = csv::WriterBuilder::new()
            .flexible(true)
            .from_writer(Vec::new());
        for row in &self.data {
            writer.write_record(row).expect("memory takes any record");
        }
        Some(writer.into_inner().expect("memory takes any record"))
    }

    /// The link of a row.
    pub(super) fn mark(&self, row: usize) -> RowMark {
        self.marks.get(row).cloned().unwrap_or_default()
    }

    pub(super) fn is_numeric(&self, column: usize) -> bool {
        // A number, alone or with its unit.
        let is_number = |cell: &String| {
            let unsigned = cell.trim_start_matches(['\u{2212}', '-', '+', '>', '<', ' ']);
            let first = unsigned.lines().next().unwrap_or_default();
            let mut words = first.split_whitespace();
            let number = words.next().is_some_and(|word| word.parse::<f64>().is_ok());
            let is_blank = cell.is_empty() || cell == "\u{2013}";
            is_blank || (number && words.count() <= 1)
        };
        let cells: Vec<_> = self.rows.iter().filter_map(|row| row.get(column)).collect();
        !cells.is_empty() && cells.into_iter().all(is_number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_columns_of_numbers_are_set_flush_right() {
        let table = Table::new("", ["name", "error", "mixed"])
            .row(["a", "\u{2212}0.5\n0.1\u{2026}0.9", "1"])
            .row(["1b", "12 %", "one"])
            .row(["c", "\u{2013}", ""]);
        let numeric: Vec<bool> = (0..3).map(|i| table.is_numeric(i)).collect();
        assert_eq!(numeric, [false, true, false]);
    }
}
