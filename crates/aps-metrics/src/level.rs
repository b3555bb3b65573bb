//! Spectra in decibels, compared level by level.

/// Spectra are compared down to this far below the maximum of the true one \[dB\].
pub const LEVEL_FLOOR_DB: f64 = 40.0;

/// Distance of a spectrum in decibels from the true one.
///
/// ```
/// use aps_metrics::LevelDistance;
///
/// let truth = [0.0, -10.0, -60.0, -90.0];
/// let distance = LevelDistance::of(&truth, Some(&[-1.0, -10.0, -80.0, -20.0]));
/// // What lies below the floor in both does not count: three bins do, off by 1, 0 and 20 dB.
/// assert_eq!((distance.mean_db, distance.worst_db), (7.0, 20.0));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LevelDistance {
    /// Mean over the bins in which either spectrum is above the floor \[dB\].
    pub mean_db: f64,
    /// The largest of them \[dB\].
    pub worst_db: f64,
}

impl LevelDistance {
    /// Compares finite levels \[dB\] bin by bin. A level below the floor counts as the floor. A spectrum that is missing is off by
    /// [`LEVEL_FLOOR_DB`] in every bin.
    ///
    /// # Panics
    /// When the two have not as many bins.
    #[must_use]
    pub fn of(truth_db: &[f64], found_db: Option<&[f64]>) -> Self {
        let Some(found_db) = found_db else {
            return Self {
                mean_db: LEVEL_FLOOR_DB,
                worst_db: LEVEL_FLOOR_DB,
            };
        };
        assert_eq!(truth_db.len(), found_db.len(), "bins of both");
        let floor = truth_db.iter().copied().fold(f64::NEG_INFINITY, f64::max) - LEVEL_FLOOR_DB;
        let (mut sum, mut count, mut worst) = (0.0, 0_u32, 0.0_f64);
        for (&truth, &found) in truth_db.iter().zip(found_db) {
            if truth.max(found) >= floor {
                let error = (truth.max(floor) - found.max(floor)).abs();
                (sum, count, worst) = (sum + error, count + 1, worst.max(error));
            }
        }
        Self {
            mean_db: sum / f64::from(count.max(1)),
            worst_db: worst,
        }
    }
}
