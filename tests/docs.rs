//! The documentation keeps its word: its commands run, its links lead somewhere.
#![cfg(unix)]

mod documentation;

use std::fs;
use std::path::Path;

use documentation::{Runner, blocks, pages, repository, run_all};

#[test]
fn commands_of_the_pages_run() {
    let own = Path::new(env!("CARGO_BIN_EXE_xtask"));
    run_all("sh test", Runner { own, models: None });
}

#[test]
fn every_block_of_commands_says_who_runs_it() {
    let mut tested = 0;
    for page in pages() {
        for block in blocks(&fs::read_to_string(&page).unwrap()) {
            let is_known = ["sh test", "sh models", "sh manual"].contains(&block.kind.as_str());
            let is_shell = ["sh", "bash", "shell", "console"]
                .iter()
                .any(|shell| block.kind.starts_with(shell));
            assert!(
                is_known || !is_shell,
                "{}:{}: '{}'",
                page.display(),
                block.line,
                block.kind
            );
            tested += usize::from(block.kind == "sh test");
        }
    }
    assert!(tested >= 10, "{tested} blocks");
}

/// Targets of the links of a page that are files.
fn targets(page: &str) -> Vec<String> {
    // Every second part is code: between single marks, and, with empty parts beside it, between triple ones.
    let words: String = page.split('`').step_by(2).collect();
    let mut targets = Vec::new();
    for part in words.split("](").skip(1) {
        let target = part.split([')', ' ', '\n']).next().unwrap_or_default();
        let file = target.split('#').next().unwrap_or_default();
        if !file.is_empty() && !file.contains("://") {
            targets.push(file.into());
        }
    }
    targets
}

#[test]
fn links_lead_to_files() {
    for page in pages() {
        for target in targets(&fs::read_to_string(&page).unwrap()) {
            let path = page.parent().unwrap().join(&target);
            assert!(path.exists(), "{} has a link to {target}", page.display());
        }
    }
}

#[test]
fn every_page_is_in_the_book() {
    let root = repository().join("docs");
    let summary = fs::read_to_string(root.join("SUMMARY.md")).unwrap();
    let listed = targets(&summary);
    for page in pages()
        .iter()
        .filter_map(|page| page.strip_prefix(&root).ok())
    {
        let name = page.to_str().unwrap();
        // Examples have pages of their own folders.
        let is_of_book = name != "SUMMARY.md" && !name.starts_with("examples/");
        assert!(
            !is_of_book || listed.iter().any(|one| one == name),
            "{name}"
        );
    }
}

/// A comment with the path of a file stands above a block that shows it, all of it or from a line on.
#[test]
fn blocks_that_show_a_file_are_its_text() {
    let mut shown = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        for block in blocks(&text) {
            let above = block.line.checked_sub(2).map_or("", |line| lines[line]);
            let path = above
                .strip_prefix("<!-- ")
                .and_then(|path| path.strip_suffix(" -->"));
            let Some(path) = path else { continue };
            let file = fs::read_to_string(repository().join(path)).unwrap();
            let is_shown = file.ends_with(&block.text) && block.text.lines().count() > 5;
            assert!(is_shown, "{}:{} is not {path}", page.display(), block.line);
            shown += 1;
        }
    }
    assert!(shown >= 7, "{shown} blocks");
}

#[test]
fn blocks_are_taken_as_they_stand() {
    let found = blocks("a\n```sh test\none\n  two\n```\n\n```text\nthree\n```\n");
    let kinds: Vec<&str> = found.iter().map(|block| block.kind.as_str()).collect();
    assert_eq!(kinds, ["sh test", "text"]);
    assert_eq!((found[0].line, found[0].text.as_str()), (2, "one\n  two\n"));
}
