//! Text for whoever runs a command: results on standard output, remarks on standard error.
//!
//! A reader may go away before the end, as `head` does. That ends no command: the data set is finished, findings are
//! counted, the picture is drawn, and only text is lost. Hence [`say!`](crate::say) and [`note!`](crate::note) in place
//! of `println!` and `eprintln!`, which panic then.

use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::{fmt, fs};

use anyhow::{Context, Result, ensure};

pub use map2aps::error::chain as told;

/// Makes the folder of a file that a command will write, before the work for it begins, and refuses one of a data set's own files.
pub fn make_folder_of(file: &Path) -> Result<()> {
    let name = file.display();
    ensure!(!file.is_dir(), "'{name}' is a folder; name a file in it");
    let folder = file.parent().unwrap_or(file);
    let is_of_dataset = file.ends_with("manifest.json") || folder.join("map.json").is_file();
    ensure!(
        !(file.exists() && is_of_dataset),
        "'{name}' is a file of a data set; name another"
    );
    fs::create_dir_all(folder).with_context(|| format!("cannot create the folder of '{name}'"))
}

/// Standard output that takes everything once its reader has gone away.
#[derive(Debug)]
pub struct Stdout(io::Stdout);

/// Standard output, for many lines.
pub fn stdout() -> Stdout {
    Stdout(io::stdout())
}

impl Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.0.write(bytes) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(bytes.len()),
            result => result,
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.0.flush() {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            result => result,
        }
    }
}

/// Prints a line to standard output, as [`say!`](crate::say) does.
pub fn say(text: fmt::Arguments<'_>) -> Result<()> {
    writeln!(stdout(), "{text}").context("cannot write to standard output")
}

/// Prints a line to standard error, as [`note!`](crate::note) does.
pub fn note(text: fmt::Arguments<'_>) {
    // A closed standard error leaves no way to report its own failure.
    let _ = writeln!(io::stderr(), "{text}");
}

/// Prints a line to standard output; the error is any but a reader that has gone away.
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => { $crate::output::say(format_args!($($text)*)) };
}

/// Prints a line to standard error, if anybody listens.
#[macro_export]
macro_rules! note {
    ($($text:tt)*) => { $crate::output::note(format_args!($($text)*)) };
}
