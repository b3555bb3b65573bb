//! Paths of links, held as the tracer found them; their columns become arrays when they are asked for.

use std::iter;
use std::sync::Arc;

use map2aps::aps_data::{InteractionKind, PathTable};
use map2aps::aps_raytrace::SPEED_OF_LIGHT_M_PER_S;
use map2aps::aps_raytrace::glam::DVec2;
use numpy::Complex64;
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Argument, Kind, shaped};
use crate::scene::Scene;

/// Lengths of paths are rounded by less \[m\].
const LENGTH_ROUNDING_M: f64 = 1e-6;

/// Paths of links, and where their ends are.
#[derive(Debug)]
#[pyclass(module = "map2aps._native", frozen)]
pub struct Paths {
    pub(crate) table: PathTable,
    /// Transmitter and receiver of each link \[m\]; NaN where they are not known.
    pub(crate) ends_m: Vec<[[f64; 2]; 2]>,
    /// [`Scene::digest`] of the buildings that they were traced in; `None` for paths of another program.
    digest: Option<Arc<str>>,
}

impl Paths {
    /// Paths of links from a transmitter to a receiver each, traced in a scene of that digest.
    pub fn traced(
        table: PathTable,
        pairs: impl Iterator<Item = [DVec2; 2]>,
        digest: &Arc<str>,
    ) -> Self {
        Self {
            table,
            ends_m: pairs.map(|ends| ends.map(|end| end.to_array())).collect(),
            digest: Some(Arc::clone(digest)),
        }
    }
}

#[pymethods]
impl Paths {
    /// Reads the columns of a `map2aps.Paths`, by their names, and the digest of the scene of such paths.
    ///
    /// # Errors
    /// `ValueError` for columns of other types or lengths, and for offsets that do not ascend from 0 to the length of their
    /// columns; `TypeError` for a column that is missing.
    #[new]
    #[pyo3(signature = (columns, digest = None))]
    fn new(columns: &Bound<'_, PyDict>, digest: Option<String>) -> PyResult<Self> {
        let column = |name: &'static str, kind, shape: &[Option<usize>]| {
            let column = columns.get_item(name)?;
            let missing = || PyTypeError::new_err(format!("no column {name}"));
            Argument::new(&column.ok_or_else(missing)?, name, kind, shape)
        };
        let delay_s = column("delay_s", Kind::Real, &[None])?.values::<f64>()?;
        let count = Some(delay_s.len());
        let departure = column("departure_azimuth_rad", Kind::Real, &[count])?.values::<f64>()?;
        let arrival = column("arrival_azimuth_rad", Kind::Real, &[count])?.values::<f64>()?;
        let gain = column("gain", Kind::Complex, &[count])?.values::<Complex64>()?;
        let kinds = column("interaction_kind", Kind::Integer, &[None])?.integers::<u8>()?;
        let events = Some(kinds.len());
        let ids = column("interaction_id", Kind::Integer, &[events])?.integers::<u32>()?;
        let points = column("interaction_point_m", Kind::Real, &[events, Some(2)])?;
        let points = points.values::<f64>()?;
        let of_links = column("path_offset", Kind::Integer, &[None])?;
        let of_links = ends(&of_links, delay_s.len())?;
        let of_paths = column("interaction_offset", Kind::Integer, &[count.map(|n| n + 1)])?;
        let of_paths = ends(&of_paths, kinds.len())?;
        let places = |name| {
            let shape = [Some(of_links.len()), Some(2)];
            column(name, Kind::Real, &shape)?.values::<f64>()
        };
        let (tx, rx) = (places("tx_m")?, places("rx_m")?);
        let places = tx.as_chunks().0.iter().zip(rx.as_chunks().0);
        let ends_m = places.map(|(&tx, &rx)| [tx, rx]).collect();

        let gain = gain.into_iter().map(|gain| [gain.re, gain.im]);
        let (points, _) = points.as_chunks();
        let mut table = PathTable::default();
        table.departure_azimuth_rad = departure;
        table.arrival_azimuth_rad = arrival;
        table.gain = gain.collect();
        let (mut path, mut event) = (0, 0);
        for end in of_links {
            // The ends of paths and links are taken from how far their columns have grown.
            for &last in &of_paths[path..end] {
                let events = event..last;
                let kinds = kinds[events.clone()].iter().copied();
                table
                    .interaction_kind
                    .extend(kinds.map(InteractionKind::from_code));
                table.interaction_id.extend_from_slice(&ids[events.clone()]);
                table.interaction_point_m.extend_from_slice(&points[events]);
                event = last;
                table.end_path();
            }
            table.delay_s.extend_from_slice(&delay_s[path..end]);
            path = end;
            table.end_link();
        }
        Ok(Self {
            table,
            ends_m,
            digest: digest.map(Arc::from),
        })
    }

    /// Number of links.
    fn __len__(&self) -> usize {
        self.table.links()
    }

    /// Number of paths.
    #[getter]
    fn count(&self) -> usize {
        self.table.delay_s.len()
    }

    /// Copies a column into an array, by its name in `map2aps.Paths`.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let Self { table, ends_m, .. } = self;
        let (links, paths) = (table.links(), table.delay_s.len());
        let events = table.interaction_kind.len();
        let numbers = |values: &[f64]| Ok(shaped(py, values.to_vec(), [paths])?.into_any());
        let end = |end: usize| {
            let places: Vec<f64> = ends_m.iter().flat_map(|ends| ends[end]).collect();
            Ok(shaped(py, places, [links, 2])?.into_any())
        };
        match name {
            "path_offset" => {
                let offsets = offsets(links, |link| table.paths_of(link).end);
                Ok(shaped(py, offsets, [links + 1])?.into_any())
            }
            "delay_s" => numbers(&table.delay_s),
            "departure_azimuth_rad" => numbers(&table.departure_azimuth_rad),
            "arrival_azimuth_rad" => numbers(&table.arrival_azimuth_rad),
            "gain" => {
                let gain = table.gain.iter().map(|&[re, im]| Complex64::new(re, im));
                Ok(shaped::<Complex64>(py, gain.collect(), [paths])?.into_any())
            }
            "interaction_offset" => {
                let offsets = offsets(paths, |path| table.interactions_of(path).end);
                Ok(shaped(py, offsets, [paths + 1])?.into_any())
            }
            "interaction_kind" => {
                let kinds = table.interaction_kind.iter().map(|kind| kind.code());
                Ok(shaped::<u8>(py, kinds.collect(), [events])?.into_any())
            }
            "interaction_id" => Ok(shaped(py, table.interaction_id.clone(), [events])?.into_any()),
            "interaction_point_m" => {
                let points = table.interaction_point_m.as_flattened().to_vec();
                Ok(shaped(py, points, [events, 2])?.into_any())
            }
            "tx_m" => end(0),
            "rx_m" => end(1),
            _ => Err(PyKeyError::new_err(name.to_owned())),
        }
    }

    /// Tells of each path if it is as long as its link, as a line of sight is; of none where the ends are not known.
    fn is_straight(&self) -> Vec<bool> {
        let links = self.ends_m.iter().enumerate();
        let of_link = |(link, &[tx, rx]): (usize, &[[f64; 2]; 2])| {
            let apart_m = DVec2::from(tx).distance(rx.into());
            let is_straight = move |delay_s: &f64| {
                (delay_s * SPEED_OF_LIGHT_M_PER_S - apart_m).abs() <= LENGTH_ROUNDING_M
            };
            let delays_s = &self.table.delay_s[self.table.paths_of(link)];
            delays_s.iter().map(is_straight)
        };
        links.flat_map(of_link).collect()
    }

    /// The paths of some links, in their order.
    fn take(&self, links: Vec<usize>) -> Self {
        let ends_m = links.iter().map(|&link| self.ends_m[link]).collect();
        Self {
            ends_m,
            table: self.table.of_links(links),
            digest: self.digest.clone(),
        }
    }

    /// Digest of the buildings that the paths were traced in; None for paths of another program.
    #[getter]
    fn digest(&self) -> Option<&str> {
        self.digest.as_deref()
    }

    /// Tells if the paths may have been traced in a scene: in one of the same walls, or nobody knows in which.
    fn may_be_of(&self, scene: &Bound<'_, Scene>) -> bool {
        let is_same = |digest: &Arc<str>| **digest == *scene.get().digest();
        self.digest.as_ref().is_none_or(is_same)
    }
}

fn offsets(count: usize, end: impl Fn(usize) -> usize) -> Vec<i64> {
    let ends = (0..count).map(|i| end(i) as i64);
    iter::once(0).chain(ends).collect()
}

/// The ends of parts from their offsets, which ascend from 0 to the length of a column.
fn ends(offsets: &Argument<'_>, length: usize) -> PyResult<Vec<usize>> {
    let values = offsets.integers::<i64>()?;
    let is_good =
        values.is_sorted() && values.first() == Some(&0) && values.last() == Some(&(length as i64));
    match is_good {
        true => Ok(values[1..].iter().map(|&end| end as usize).collect()),
        false => Err(offsets.refuse(format_args!(
            ": offsets must ascend from 0 to the length {length} of their column"
        ))),
    }
}
