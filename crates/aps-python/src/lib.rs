//! The native module of the Python package `map2aps`: conversions between Python's objects and the crate `map2aps`.
//!
//! The package in `python/map2aps` is what people import; it documents what is here, in `_native.pyi`. Arrays come in as
//! anything NumPy makes an array of, and are copied; they go out without a copy. Whatever takes long runs on a pool of
//! threads of its own, without Python's lock, and ends at Ctrl-C or is left behind by it, as `run` tells.

mod advice;
mod arrays;
mod differences;
mod error;
mod examples;
mod explain;
mod given;
mod labels;
mod learnt;
mod making;
mod maps;
mod metrics;
mod paths;
mod polar;
mod run;
mod scene;
mod shipped;
mod tracer;

use pyo3::pymodule;

/// The native part of `map2aps`.
#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::differences::label_differences;
    #[pymodule_export]
    use super::examples::Examples;
    #[pymodule_export]
    use super::explain::explain;
    #[pymodule_export]
    use super::labels::label;
    #[pymodule_export]
    use super::learnt::{array_response, training_facts};
    #[pymodule_export]
    use super::making::{make_dataset, manifest, relabel};
    #[pymodule_export]
    use super::metrics::metrics;
    #[pymodule_export]
    use super::paths::Paths;
    #[pymodule_export]
    use super::polar::PolarView;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::shipped::shipped;
    #[pymodule_export]
    use super::tracer::Tracer;

    /// Loads NumPy's interface with the module: loaded by the first array instead, Ctrl-C at that moment would be a panic.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        numpy::PyArray1::<f64>::zeros(module.py(), 0, false);
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
