//! The commands of the documentation, taken out of its pages and run.
//!
//! A fenced block of shell commands says after `sh` who runs it:
//!
//! - `sh test`: the test of package `xtask`;
//! - `sh models`: that of package `xtask-models`, which needs candle;
//! - `sh manual`: nobody, for it needs hours, a cluster, a GPU or files that are not in the repository.
//!
//! The blocks of a page run in their order, in a folder that looks like the repository: everything in it is a link, so that
//! `data`, `runs` and what else a command writes is in that folder alone. `path/to/maps` holds three small maps there,
//! `truth.npy` and `prediction.npy` some spectra.

#[path = "../houses.rs"]
mod houses;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use houses::map;

/// A fenced block of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Line of its fence, from 1.
    pub line: usize,
    /// Words after the opening fence, like `sh test`.
    pub kind: String,
    /// Its lines.
    pub text: String,
}

/// The fenced blocks of a Markdown page.
pub fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (line, text) in (1..).zip(page.lines()) {
        match (text.strip_prefix("```"), &mut open) {
            (Some(kind), None) => {
                open = Some(Block {
                    line,
                    kind: kind.trim().into(),
                    text: String::new(),
                });
            }
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (None, Some(block)) => block.text += &format!("{text}\n"),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    blocks
}

/// The repository.
pub fn repository() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let found = package
        .ancestors()
        .find(|folder| folder.join("docs/SUMMARY.md").is_file());
    found.expect("the package is inside the repository").into()
}

/// The pages whose commands are looked at: the book, the README, and what they refer to.
pub fn pages() -> Vec<PathBuf> {
    let root = repository();
    let mut pages = vec![
        root.join("README.md"),
        root.join("CONTRIBUTING.md"),
        root.join("data-spec/README.md"),
    ];
    let mut folders = vec![root.join("docs")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(extension) if extension == "md" => pages.push(path),
                _ => {}
            }
        }
    }
    pages.sort();
    pages
}

/// Programs that stand for `cargo xtask`.
#[derive(Debug, Clone, Copy)]
pub struct Runner<'a> {
    /// The runner.
    pub own: &'a Path,
    /// Program that it starts for the commands that need models.
    pub models: Option<&'a Path>,
}

/// Runs the blocks of a kind of all pages, a page a thread.
///
/// # Panics
/// Telling page, line and output of each block that fails.
pub fn run_all(kind: &str, runner: Runner<'_>) {
    let failures: Vec<String> = std::thread::scope(|scope| {
        let runs: Vec<_> = pages()
            .into_iter()
            .map(|page| scope.spawn(move || run_page(&page, kind, runner)))
            .collect();
        runs.into_iter()
            .filter_map(|run| run.join().unwrap().err())
            .collect()
    });
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Runs the blocks of a kind of one page, up to the first that fails.
fn run_page(page: &Path, kind: &str, runner: Runner<'_>) -> Result<(), String> {
    let mut blocks = blocks(&fs::read_to_string(page).unwrap());
    blocks.retain(|block| block.kind == kind);
    if blocks.is_empty() {
        return Ok(());
    }
    let folder = tempfile::tempdir().unwrap();
    furnish(folder.path());
    for block in blocks {
        let output = Command::new("bash")
            .args(["-euo", "pipefail", "-c", &(cargo(runner) + &block.text)])
            .current_dir(folder.path().join("repository"))
            .output()
            .unwrap();
        if !output.status.success() {
            let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
            let (said, errors) = (text(&output.stdout), text(&output.stderr));
            return Err(format!(
                "{}:{}: {}{said}{errors}",
                page.display(),
                block.line,
                block.text
            ));
        }
    }
    Ok(())
}

/// Makes a folder look like the repository.
fn furnish(folder: &Path) {
    let inside = folder.join("repository");
    fs::create_dir_all(inside.join("path/to/maps")).unwrap();
    for entry in fs::read_dir(repository()).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name();
        if !["target", "data", "runs", ".git"]
            .iter()
            .any(|own| name == *own)
        {
            symlink(entry.path(), inside.join(name)).unwrap();
        }
    }
    for id in 0..3 {
        fs::write(inside.join(format!("path/to/maps/{id}.json")), map(id)).unwrap();
    }
    for (name, shift) in [("truth", 0.0), ("prediction", 0.1)] {
        let file = inside.join(format!("{name}.npy"));
        aps_data::npy::write(file, &[4, 180], &spectra(shift)).unwrap();
    }
}

/// A function of the shell that stands for `cargo`: as a file it would be busy while another test's process starts.
fn cargo(runner: Runner<'_>) -> String {
    let models = match runner.models {
        Some(models) => format!("'{}' \"$@\"", models.display()),
        None => "echo 'mark this block: sh models' >&2; exit 1".into(),
    };
    format!(
        r#"cargo() {{
    [ "$1" = xtask ] || {{ echo "'cargo $1' has no place in a tested block" >&2; exit 1; }}
    shift
    case "$1" in
        train | predict | export-onnx | bench-models) {models} ;;
        *) '{}' "$@" ;;
    esac
}}
"#,
        runner.own.display()
    )
}

/// Four spectra of 180 bins.
fn spectra(shift: f32) -> Vec<f32> {
    let value = |i: u16| {
        let (row, bin) = (f32::from(i / 180), f32::from(i % 180));
        (bin * 0.1 + row + shift).sin()
    };
    (0..4 * 180).map(value).collect()
}
