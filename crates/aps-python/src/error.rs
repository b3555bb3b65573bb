//! Errors as Python's exceptions.

use std::error::Error as _;
use std::io::{self, ErrorKind};
use std::iter;

use map2aps::aps_data::Error as DataError;
use map2aps::{Error, MapError};
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;

use crate::advice::advice;

/// Digits in a row beyond which a number is cut in a message.
const MAX_DIGITS: usize = 24;

/// The exception that tells an error with its causes: of `OSError` and its kinds (`FileNotFoundError`, ...) for what the system
/// refused and files that are not there, `KeyboardInterrupt` for what was cancelled, else `ValueError`.
pub fn exception(error: impl Into<Error>) -> PyErr {
    let error = error.into();
    let text = shortened(&error.chain()) + advice(error.cause());
    match of_system(error.cause()) {
        _ if error.is_cancelled() => PyKeyboardInterrupt::new_err(text),
        Some(kind) => io::Error::new(kind, text).into(),
        None => PyValueError::new_err(text),
    }
}

/// The value of what was tried; `None` if it failed.
///
/// # Errors
/// Exceptions that nobody may take for a failure, `KeyboardInterrupt` above all.
pub fn tried<T>(py: Python<'_>, result: PyResult<T>) -> PyResult<Option<T>> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(error) if error.is_instance_of::<PyException>(py) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The kind of an error of the operating system.
fn of_system(error: &Error) -> Option<ErrorKind> {
    match error {
        Error::Io(error) => Some(error.kind()),
        Error::Map(MapError::NoFile) => Some(ErrorKind::NotFound),
        Error::Data(DataError::NotADataset { path, .. }) if !path.exists() => {
            Some(ErrorKind::NotFound)
        }
        error => {
            let mut causes = iter::successors(error.source(), |&cause| cause.source());
            causes.find_map(|cause| cause.downcast_ref::<io::Error>().map(io::Error::kind))
        }
    }
}

/// The text with what is beyond the first digits of long numbers left out.
fn shortened(text: &str) -> String {
    let mut short = String::new();
    for run in text
        .as_bytes()
        .chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit())
    {
        let run = str::from_utf8(run).expect("a digit is no part of another character");
        match run.starts_with(|c: char| c.is_ascii_digit()) && run.len() > MAX_DIGITS {
            true => short += &format!("{}... ({} digits)", &run[..MAX_DIGITS / 2], run.len()),
            false => short += run,
        }
    }
    short
}
