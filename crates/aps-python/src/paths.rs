//! Paths of links as columns.

use map2aps::aps_data::{InteractionKind, PathTable};
use numpy::Complex64;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Argument, Kind, shaped};

/// The columns of a table as arrays, by the names of `map2aps.Paths`.
pub fn arrays(py: Python<'_>, table: PathTable) -> PyResult<Bound<'_, PyDict>> {
    let (links, paths) = (table.links(), table.delay_s.len());
    let interactions = table.interaction_kind.len();
    let path_offset = offsets(links, |link| table.paths_of(link).end);
    let interaction_offset = offsets(paths, |path| table.interactions_of(path).end);
    let gain = table.gain.iter().map(|&[re, im]| Complex64::new(re, im));
    let kinds = table.interaction_kind.iter().map(|kind| kind.code());
    let (gain, kinds) = (gain.collect(), kinds.collect());
    let columns = PyDict::new(py);
    columns.set_item("path_offset", shaped(py, path_offset, [links + 1])?)?;
    columns.set_item("delay_s", shaped(py, table.delay_s, [paths])?)?;
    columns.set_item(
        "departure_azimuth_rad",
        shaped(py, table.departure_azimuth_rad, [paths])?,
    )?;
    columns.set_item(
        "arrival_azimuth_rad",
        shaped(py, table.arrival_azimuth_rad, [paths])?,
    )?;
    columns.set_item("gain", shaped::<Complex64>(py, gain, [paths])?)?;
    columns.set_item(
        "interaction_offset",
        shaped(py, interaction_offset, [paths + 1])?,
    )?;
    columns.set_item("interaction_kind", shaped::<u8>(py, kinds, [interactions])?)?;
    columns.set_item(
        "interaction_id",
        shaped(py, table.interaction_id, [interactions])?,
    )?;
    let points = table.interaction_point_m.into_flattened();
    columns.set_item(
        "interaction_point_m",
        shaped(py, points, [interactions, 2])?,
    )?;
    Ok(columns)
}

fn offsets(count: usize, end: impl Fn(usize) -> usize) -> Vec<i64> {
    let ends = (0..count).map(|i| end(i) as i64);
    std::iter::once(0).chain(ends).collect()
}

/// Reads the columns of a `map2aps.Paths`.
///
/// # Errors
/// `ValueError` for columns of other types or lengths, and for offsets that do not ascend from 0 to the length of their columns.
pub fn table(paths: &Bound<'_, PyAny>) -> PyResult<PathTable> {
    let column = |name: &'static str, kind, shape: &[Option<usize>]| {
        Argument::new(&paths.getattr(name)?, name, kind, shape)
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
    Ok(table)
}

/// The ends of parts from their offsets, which ascend from 0 to the length of a column.
fn ends(offsets: &Argument<'_>, length: usize) -> PyResult<Vec<usize>> {
    let values = offsets.values::<i64>()?;
    let is_good =
        values.is_sorted() && values.first() == Some(&0) && values.last() == Some(&(length as i64));
    match is_good {
        true => Ok(values[1..].iter().map(|&end| end as usize).collect()),
        false => Err(offsets.refuse(format_args!(
            ": offsets must ascend from 0 to the length {length} of their column"
        ))),
    }
}
