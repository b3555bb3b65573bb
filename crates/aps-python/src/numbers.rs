//! Numbers as arguments.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A number that was given, or why it is none of its type: what is wrong is told by the name of the argument, which only its reader
/// knows.
pub struct Number<T>(Result<T, String>);

impl<T> Number<T> {
    /// The number.
    ///
    /// # Errors
    /// `ValueError` that names the argument, what it takes, and what was given.
    pub fn named(self, name: &str) -> PyResult<T> {
        self.0
            .map_err(|why| PyValueError::new_err(format!("{name}: {why}")))
    }
}

impl<T> From<T> for Number<T> {
    fn from(number: T) -> Self {
        Self(Ok(number))
    }
}

impl<'a, 'py, T: Wanted + FromPyObject<'a, 'py>> FromPyObject<'a, 'py> for Number<T> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let kind = given.get_type().name()?;
        let shown = given.repr()?;
        let refuse = |_| format!("expected {}, got {kind} {shown}", T::wanted());
        Ok(Self(given.extract().map_err(refuse)))
    }
}

/// The number that was given for an argument; `None` for none.
///
/// # Errors
/// As [`Number::named`].
pub fn optional<T>(number: Option<Number<T>>, name: &str) -> PyResult<Option<T>> {
    number.map(|number| number.named(name)).transpose()
}

/// Types of numbers, in words.
pub trait Wanted {
    /// The words.
    fn wanted() -> String;
}

impl Wanted for u32 {
    fn wanted() -> String {
        format!("an integer from 0 to {}", Self::MAX)
    }
}

impl Wanted for u64 {
    fn wanted() -> String {
        format!("an integer from 0 to {}", Self::MAX)
    }
}

impl Wanted for usize {
    fn wanted() -> String {
        format!("an integer from 0 to {}", Self::MAX)
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
