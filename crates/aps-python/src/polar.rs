//! The input of Polar-Reg.

use map2aps::aps_raytrace::polar::Mirror;
use map2aps::error::Place;
use map2aps::{Error, PolarViews, SeenLink};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{points, shaped, zeros};
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

/// A scene prepared for its receivers to look at.
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

    fn input<'py>(
        &self,
        py: Python<'py>,
        tx: &Bound<'py, PyAny>,
        rx: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let (tx, rx) = (points(tx, "tx")?, points(rx, "rx")?);
        let shape = PolarViews::shape();
        let links = tx.len().saturating_mul(rx.len());
        let mut values = zeros("rx: links", links, shape.values())?;
        let values = run(py, None, |control| {
            let pairs = tx.iter().flat_map(|tx| rx.iter().map(move |rx| (tx, rx)));
            let seen = pairs.map(|(tx, rx)| SeenLink {
                map: 0,
                tx_m: tx.to_array(),
                rx_m: rx.to_array(),
                mirror: Mirror::default(),
            });
            let seen: Vec<SeenLink> = seen.collect();
            for (part, links) in seen.chunks(AT_A_TIME).enumerate() {
                if control.is_cancelled() {
                    return Err(Error::Cancelled);
                }
                let first = part * AT_A_TIME;
                let rows = first * shape.values()..(first + links.len()) * shape.values();
                let written = self.views.write(links, &mut values[rows]);
                written.map_err(|error| behind(first, error))?;
            }
            Ok(values)
        })?;
        shaped(py, values, [links, shape.directions, shape.per_direction()])
    }
}
