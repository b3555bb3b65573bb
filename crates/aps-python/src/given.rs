//! Numbers, words and truth values as arguments.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::error::tried;

/// Most characters of a value that a message shows.
const SHOWN: usize = 60;

/// A value that was given, or why there is none of its type. Reading it never fails, for those who read several at once would make a
/// `TypeError` of a `KeyboardInterrupt`; and what is wrong is told by the name of the argument, which only its reader knows.
pub struct Given<T>(Result<T, Refusal>);

enum Refusal {
    /// Another value, in words.
    Unfit(String),
    /// An exception of Python.
    Raised(PyErr),
}

impl<T> Given<T> {
    /// The value.
    ///
    /// # Errors
    /// `ValueError` that names the argument, what it takes, and what was given.
    pub fn named(self, name: &str) -> PyResult<T> {
        self.0.map_err(|refusal| match refusal {
            Refusal::Unfit(why) => PyValueError::new_err(format!("{name}: {why}")),
            Refusal::Raised(error) => error,
        })
    }

    /// The value; `None` for a value of another type.
    ///
    /// # Errors
    /// An exception of Python that was raised meanwhile.
    pub fn ok(self) -> PyResult<Option<T>> {
        match self.0 {
            Ok(value) => Ok(Some(value)),
            Err(Refusal::Unfit(_)) => Ok(None),
            Err(Refusal::Raised(error)) => Err(error),
        }
    }
}

impl<T> From<T> for Given<T> {
    fn from(value: T) -> Self {
        Self(Ok(value))
    }
}

impl<'a, 'py, T: Wanted + FromPyObject<'a, 'py>> FromPyObject<'a, 'py> for Given<T> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let read = || -> PyResult<Result<T, String>> {
            // To Python, True is the number 1.
            let is_other = given.is_instance_of::<PyBool>() && !T::IS_BOOL;
            let value = given.extract().map_err(Into::into);
            if let Some(value) = tried(given.py(), value)?.filter(|_| !is_other) {
                return Ok(Ok(value));
            }
            let (kind, mut shown) = (given.get_type().name()?, given.repr()?.to_string());
            if let Some((end, _)) = shown.char_indices().nth(SHOWN) {
                shown.truncate(end);
                shown.push_str("...");
            }
            let wanted = T::wanted();
            Ok(Err(format!("expected {wanted}, got {kind} {shown}")))
        };
        Ok(Self(match read() {
            Ok(value) => value.map_err(Refusal::Unfit),
            Err(error) => Err(Refusal::Raised(error)),
        }))
    }
}

/// The value that was given for an argument; `None` for none.
///
/// # Errors
/// As [`Given::named`].
pub fn optional<T>(given: Option<Given<T>>, name: &str) -> PyResult<Option<T>> {
    given.map(|given| given.named(name)).transpose()
}

/// Types of values, in words.
pub trait Wanted {
    /// True for truth values alone.
    const IS_BOOL: bool = false;

    /// The words.
    fn wanted() -> String;
}

impl Wanted for bool {
    const IS_BOOL: bool = true;

    fn wanted() -> String {
        "True or False".into()
    }
}

impl Wanted for String {
    fn wanted() -> String {
        "a string".into()
    }
}

macro_rules! integers {
    ($($type:ty),*) => {$(
        impl Wanted for $type {
            fn wanted() -> String {
                format!("an integer from 0 to {}", Self::MAX)
            }
        }
    )*};
}

integers!(u32, u64, usize);

impl Wanted for PathBuf {
    fn wanted() -> String {
        "a path".into()
    }
}

impl Wanted for f64 {
    fn wanted() -> String {
        "a real number".into()
    }
}

impl<const N: usize> Wanted for [f64; N] {
    fn wanted() -> String {
        format!("{N} real numbers")
    }
}
