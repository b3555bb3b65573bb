//! The input of Polar-Reg.

use std::ops::Range;

use map2aps::aps_raytrace::polar::{Mirror, PER_WAY};
use map2aps::error::Place;
use map2aps::{Error, PolarViews, SeenLink, padded};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{fits, points, shaped, too_many};
use crate::run::{run, run_owned};
use crate::scene::Scene;

/// Links between two looks for Ctrl-C.
const AT_A_TIME: usize = 256;

/// An error in a link among those after the first so many.
fn behind(links: usize, error: Error) -> Error {
    match error {
        Error::At {
            place: Place::Link(row),
            source,
        } => Error::At {
            place: Place::Link(links + row),
            source,
        },
        error => error,
    }
}

/// Finds the ways of so many links, some at a time, as an array of shape (links, ways, numbers).
///
/// # Errors
/// `MemoryError` that names the argument `name`, as soon as a link's ways show that all will be too many.
pub fn all_ways<'py>(
    py: Python<'py>,
    name: &str,
    links: usize,
    find: impl Fn(Range<usize>) -> Result<Vec<Vec<f32>>, Error> + Sync,
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    let found = run(py, None, |control| {
        let (mut all, mut most) = (Vec::new(), PER_WAY);
        // The lists are there beside the array.
        while all.len() < links && fits(links, 2 * most) {
            if control.is_cancelled() {
                return Err(Error::Cancelled);
            }
            let first = all.len();
            let some = find(first..links.min(first + AT_A_TIME));
            all.extend(some.map_err(|error| behind(first, error))?);
            most = all[first..].iter().map(Vec::len).fold(most, usize::max);
        }
        Ok(match fits(links, 2 * most) {
            true => Ok(padded(&all)),
            false => Err(most),
        })
    })?;
    let (values, shape) = found.map_err(|most| too_many(name, links, most))?;
    shaped(py, values, shape)
}

/// A scene prepared for its receivers to look at.
#[derive(Debug)]
#[pyclass(module = "map2aps._native", frozen)]
pub struct PolarView {
    views: PolarViews,
}

#[pymethods]
impl PolarView {
    #[new]
    fn new(py: Python<'_>, scene: &Bound<'_, Scene>) -> PyResult<Self> {
        let scene = scene.get().scene.clone();
        let views = run_owned(py, move || PolarViews::new([Ok((0, scene))].into_iter()))?;
        Ok(Self { views })
    }

    fn ways<'py>(
        &self,
        py: Python<'py>,
        tx: &Bound<'py, PyAny>,
        rx: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let (tx, rx) = (points(tx, "tx")?, points(rx, "rx")?);
        let seen = |link: usize| SeenLink {
            map: 0,
            tx_m: tx[link / rx.len()].to_array(),
            rx_m: rx[link % rx.len()].to_array(),
            mirror: Mirror::default(),
        };
        all_ways(py, "rx: links", tx.len().saturating_mul(rx.len()), |some| {
            self.views.ways(&some.map(seen).collect::<Vec<_>>())
        })
    }
}
