//! Text for whoever runs a command: results on standard output, remarks on standard error.
//!
//! A reader may go away before the end, as `head` does. That ends no command: the data set is finished, findings are
//! counted, the picture is drawn, and only text is lost. Hence [`say!`](crate::say) and [`note!`](crate::note) in place
//! of `println!` and `eprintln!`, which panic then.

use std::fmt;
use std::io::{self, ErrorKind, Write};

use anyhow::{Context, Result};

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

/// An error with its causes, in one line.
///
/// A cause that ends what was told so far is left out: some libraries repeat it in their own message.
pub fn told(error: &(dyn std::error::Error + 'static)) -> String {
    let mut told = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let text = error.to_string();
        if !told.ends_with(&text) {
            told = format!("{told}: {text}");
        }
        cause = error.source();
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_told_once() {
        // zip's and csv's errors repeat their cause.
        let cause = io::Error::other("the disk is full");
        let repeated = zip_like(cause);
        assert_eq!(
            told(anyhow::Error::new(repeated).context("map 3").as_ref()),
            "map 3: i/o error: the disk is full"
        );
        let plain = anyhow::anyhow!("no such link").context("data set 'x'");
        assert_eq!(told(plain.as_ref()), "data set 'x': no such link");
    }

    fn zip_like(cause: io::Error) -> impl std::error::Error + Send + Sync + 'static {
        #[derive(Debug)]
        struct Repeats(io::Error);
        impl fmt::Display for Repeats {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "i/o error: {}", self.0)
            }
        }
        impl std::error::Error for Repeats {
            fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
                Some(&self.0)
            }
        }
        Repeats(cause)
    }
}
