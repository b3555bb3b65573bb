//! What a label needs of a path, from each form in which the runner meets one.

use aps_data::PathTable;
use aps_label::PathSample;
use aps_raytrace::PathRecord;

use crate::wire::PathEntry;

/// Of a traced path.
pub fn of_record(path: &PathRecord) -> PathSample {
    PathSample {
        delay_s: path.delay_s,
        arrival_azimuth_rad: path.arrival_azimuth_rad,
        gain_db: path.gain_db(),
    }
}

/// Of a stored path: the same bits as of the traced one it was.
pub fn of_stored(table: &PathTable, path: usize) -> PathSample {
    let [re, im] = table.gain[path];
    PathSample {
        delay_s: table.delay_s[path],
        arrival_azimuth_rad: table.arrival_azimuth_rad[path],
        gain_db: 10.0 * (re * re + im * im).log10(),
    }
}

/// Of a path in JSON.
pub fn of_entry(path: &PathEntry) -> PathSample {
    PathSample {
        delay_s: path.delay_s,
        arrival_azimuth_rad: path.arrival_azimuth_rad,
        gain_db: path.gain_db,
    }
}
