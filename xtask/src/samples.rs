//! Samples of labels from paths in JSON, and the azimuths that others' programs may give.

use anyhow::{Result, ensure};
use aps_label::PathSample;

use crate::wire::PathEntry;

/// Sample of a path in JSON.
///
/// # Errors
/// An azimuth that must be meant in degrees.
pub fn of_entry(path: &PathEntry) -> Result<PathSample> {
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
pub fn check_azimuth(field: &str, azimuth_rad: f64) -> Result<()> {
    ensure!(
        azimuth_rad.is_nan() || azimuth_rad.abs() <= MAX_AZIMUTH_RAD,
        "{field} = {azimuth_rad} is more than a turn, 2 pi; are the units radians?"
    );
    Ok(())
}
