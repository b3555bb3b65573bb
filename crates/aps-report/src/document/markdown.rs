//! Documents in GitHub's Markdown.

use super::{Block, Document, Table};

impl Document {
    /// The text of a Markdown file, whose links to files begin with `prefix`: `numerics/`, or nothing.
    pub fn to_markdown(&self, prefix: &str) -> String {
        let mut out = format!("# {}\n", escape(&self.title));
        for text in &self.lead {
            out += &format!("\n{}\n", escape(text));
        }
        for section in &self.sections {
            out += &format!("\n## {}\n", escape(&section.title));
            for block in &section.blocks {
                out += "\n";
                out += &block.to_markdown(prefix);
            }
        }
        out
    }
}

impl Block {
    fn to_markdown(&self, prefix: &str) -> String {
        match self {
            Self::Text(text) => format!("{}\n", escape(text)),
            Self::Heading(text) => format!("### {}\n", escape(text)),
            Self::Verdicts(verdicts) => verdicts
                .iter()
                .map(|v| format!("- **{}** {}\n", v.outcome.word(), escape(&v.line())))
                .collect(),
            Self::Table(table) => table.to_markdown(prefix),
            Self::Figure(figure) => {
                let caption = escape(&figure.caption);
                match &*figure.file {
                    "" => format!("*{caption}*\n"),
                    file => format!("![{caption}]({prefix}{file})\n\n*{caption}*\n"),
                }
            }
            Self::Data(data) => {
                format!("{}: {}\n", escape(&data.caption), link(prefix, &data.file))
            }
            Self::Folded { title, text } => {
                let (title, text) = (escape(title), text.trim());
                format!("<details><summary>{title}</summary>\n\n```\n{text}\n```\n\n</details>\n")
            }
            Self::Group(_, blocks) => {
                let blocks: Vec<String> = blocks.iter().map(|b| b.to_markdown(prefix)).collect();
                blocks.join("\n")
            }
        }
    }
}

impl Table {
    fn to_markdown(&self, prefix: &str) -> String {
        let caption = escape(&self.caption);
        let mut out = match &self.file {
            Some(file) if self.is_folded => return format!("{caption}: {}\n", link(prefix, file)),
            Some(file) => format!("{caption} ({})\n\n", link(prefix, file)),
            None => format!("{caption}\n\n"),
        };
        let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        out += &row(self.head.iter().map(|c| escape(c)).collect());
        out += &row(self.head.iter().map(|_| "---".into()).collect());
        for (i, cells) in self.rows.iter().enumerate() {
            let cell = |(j, text): (usize, &String)| lines(text, self.best.contains(&(i, j)));
            out += &row(cells.iter().enumerate().map(cell).collect());
        }
        out
    }
}

fn lines(cell: &str, is_best: bool) -> String {
    let mut lines = cell.lines().map(escape);
    let first = lines.next().unwrap_or_default();
    let first = match is_best {
        true => format!("**{first}**"),
        false => first,
    };
    lines.fold(first, |text, line| format!("{text}<br><sub>{line}</sub>"))
}

fn link(prefix: &str, file: &str) -> String {
    let name = file.rsplit('/').next().unwrap_or(file);
    format!("[{name}]({prefix}{file})")
}

/// Text that Markdown takes for nothing else, on one line.
fn escape(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' | '~' => out.extend(['\\', c]),
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '&' => out += "&amp;",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
