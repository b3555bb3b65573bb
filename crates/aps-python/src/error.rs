//! Errors as Python's exceptions.

use map2aps::{Error, MapError};
use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyKeyboardInterrupt, PyOSError, PyValueError};

/// The exception that tells an error with its causes: `OSError` for what the system refused, `KeyboardInterrupt` for what was
/// cancelled, else `ValueError`.
pub fn exception(error: impl Into<Error>) -> PyErr {
    let error = error.into();
    let text = error.chain();
    match error.cause() {
        _ if error.is_cancelled() => PyKeyboardInterrupt::new_err(text),
        Error::Map(MapError::NoFile) => PyFileNotFoundError::new_err(text),
        Error::Io(_) | Error::Data(map2aps::aps_data::Error::Io { .. }) => PyOSError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}
