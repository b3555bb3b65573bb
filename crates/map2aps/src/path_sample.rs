//! Paths in each of their forms as the samples that labels are made from.

use aps_data::PathTable;
use aps_label::PathSample;
use aps_raytrace::PathRecord;

use crate::path_list::{PathEntry, PathListError};

/// Sample of a traced path.
pub fn of_traced(path: &PathRecord) -> PathSample {
    PathSample {
        delay_s: path.delay_s,
        arrival_azimuth_rad: path.arrival_azimuth_rad,
        gain_db: path.gain_db(),
    }
}

/// Sample of a stored path: the same bits as from the traced path that was stored.
pub fn of_stored(table: &PathTable, path: usize) -> PathSample {
    PathSample {
        delay_s: table.delay_s[path],
        arrival_azimuth_rad: table.arrival_azimuth_rad[path],
        gain_db: gain_db(table.gain[path]),
    }
}

/// Power gain of a complex amplitude `[re, im]` \[dB\].
pub fn gain_db([re, im]: [f64; 2]) -> f64 {
    10.0 * (re * re + im * im).log10()
}

/// Sample of a path in JSON.
///
/// # Errors
/// [`PathListError::Azimuth`].
pub fn of_entry(path: &PathEntry) -> Result<PathSample, PathListError> {
    check_azimuth("arrival_azimuth_rad", path.arrival_azimuth_rad)?;
    Ok(PathSample {
        delay_s: path.delay_s,
        arrival_azimuth_rad: path.arrival_azimuth_rad,
        gain_db: path.gain_db,
    })
}

/// Largest azimuth that others' programs give \[rad\]: a turn, and what half precision may add to it. For labels alone
/// any number of turns would do, but 135 of them are degrees.
const MAX_AZIMUTH_RAD: f64 = std::f64::consts::TAU + 0.01;

/// Refuses an azimuth that must be meant in degrees. One that is no number passes, for labels refuse it.
pub(crate) fn check_azimuth(field: &'static str, azimuth_rad: f64) -> Result<(), PathListError> {
    match azimuth_rad.abs() > MAX_AZIMUTH_RAD {
        true => Err(PathListError::Azimuth { field, azimuth_rad }),
        false => Ok(()),
    }
}
