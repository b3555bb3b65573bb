//! Layout of a data set: the arrays stored for each link, and their axes.

use serde::{Deserialize, Serialize};

use crate::raster::RasterGrid;

/// Largest number of bins of an [`Axis`]: far above any use, far below any harm.
const MAX_BINS: usize = 1 << 16;

/// Evenly spaced sample points, in the words of `numpy.linspace(start, stop, count, endpoint)`.
///
/// ```
/// use aps_data::Axis;
/// let values: Vec<f64> = Axis::ANGLE_PAPER_DEG.values().collect();
/// assert_eq!((values[0], values[1], values[179]), (-180.0, -178.0, 178.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// First value, in the unit of the axis.
    pub start: f64,
    /// End of the interval, in the same unit; the last value if `endpoint`.
    pub stop: f64,
    /// Number of values.
    pub count: usize,
    /// True if `stop` is the last value (step `(stop - start) / (count - 1)`), false if it is excluded
    /// (step `(stop - start) / count`).
    pub endpoint: bool,
}

impl Axis {
    /// The paper's angle grid: [-180, 180), step 2 deg, 180 bins \[deg\].
    pub const ANGLE_PAPER_DEG: Axis = Axis {
        start: -180.0,
        stop: 180.0,
        count: 180,
        endpoint: false,
    };
    /// The released data's angle grid: both ends of [-180, 180], step 360/179 deg, 180 bins
    /// \[deg\].
    pub const ANGLE_RELEASED_DEG: Axis = Axis {
        start: -180.0,
        stop: 180.0,
        count: 180,
        endpoint: true,
    };
    /// The released data's delay grid: 128 points from 0 to 1000 ns, both included \[ns\].
    pub const DELAY_RELEASED_NS: Axis = Axis {
        start: 0.0,
        stop: 1000.0,
        count: 128,
        endpoint: true,
    };

    /// Returns the values of the axis, with the rounding of `numpy.linspace`.
    pub fn values(&self) -> impl ExactSizeIterator<Item = f64> + use<> {
        let Axis {
            start,
            stop,
            count,
            endpoint,
        } = *self;
        let intervals = if endpoint {
            count.saturating_sub(1)
        } else {
            count
        };
        let step = (stop - start) / intervals.max(1) as f64;
        (0..count).map(move |i| {
            let is_stop = endpoint && count > 1 && i == count - 1;
            if is_stop {
                stop
            } else {
                start + i as f64 * step
            }
        })
    }

    fn problem(&self) -> Option<&'static str> {
        if !(self.start.is_finite() && self.stop.is_finite()) {
            Some("an axis needs finite ends")
        } else if self.count == 0 || self.count > MAX_BINS {
            Some("an axis needs 1 to 65536 values")
        } else {
            None
        }
    }
}

/// Type in which a profile's values are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Precision {
    /// IEEE half precision: half the space. A value of magnitude in [2^k, 2^(k+1)) dB is off by at
    /// most 2^(k-11) dB: 0.004 dB down to -16 dB, 0.016 dB down to -64 dB, 0.125 dB down to -512
    /// dB.
    #[default]
    #[serde(rename = "<f2")]
    F16,
    /// Single precision, off by at most 2^(k-24) dB: for imported data that must leave as it came.
    #[serde(rename = "<f4")]
    F32,
}

/// Layout of one profile of each link, its APS or its PDP.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileLayout {
    /// The bins: arrival azimuth \[deg\] for an APS, delay \[ns\] for a PDP.
    pub axis: Axis,
    /// Type of the stored values.
    pub dtype: Precision,
    /// True if the place of each bin's maximum on the other axis is stored as well: delay \[ns\] for
    /// an APS, arrival azimuth \[deg\] for a PDP.
    pub argmax: bool,
}

impl ProfileLayout {
    /// Returns the layout of profiles over `axis` in half precision, without the place of each maximum.
    pub fn over(axis: Axis) -> Self {
        ProfileLayout {
            axis,
            dtype: Precision::F16,
            argmax: false,
        }
    }
}

/// Layout of a data set; the same for all its maps.
///
/// The default is the paper's APS on 256 x 256 maps, without PDP and paths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layout {
    /// The raster of buildings.
    pub raster: RasterGrid,
    /// Angle power spectra, if stored.
    pub aps: Option<ProfileLayout>,
    /// Power delay profiles, if stored.
    pub pdp: Option<ProfileLayout>,
    /// True if the propagation paths are stored, from which labels can be made anew.
    pub paths: bool,
}

impl Default for Layout {
    fn default() -> Self {
        Layout {
            raster: RasterGrid::default(),
            aps: Some(ProfileLayout::over(Axis::ANGLE_PAPER_DEG)),
            pdp: None,
            paths: false,
        }
    }
}

impl Layout {
    /// Describes a fault of the layout; `None` if it is sound.
    pub(crate) fn problem(&self) -> Option<&'static str> {
        let profiles = [self.aps, self.pdp];
        self.raster.problem().or_else(|| {
            profiles
                .iter()
                .flatten()
                .find_map(|profile| profile.axis.problem())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn released_angles_are_those_of_linspace() {
        let values: Vec<f64> = Axis::ANGLE_RELEASED_DEG.values().collect();
        // numpy.linspace(-180, 180, 180)[[1, 100, 178, 179]]
        let expected = [
            (1, -177.98882681564245),
            (100, 21.117318435754214),
            (178, 177.98882681564248),
            (179, 180.0),
        ];
        for (i, value) in expected {
            assert_eq!(values[i], value);
        }
    }

    #[test]
    fn axis_of_one_value_is_its_start() {
        let axis = Axis {
            start: 3.0,
            stop: 5.0,
            count: 1,
            endpoint: true,
        };
        assert_eq!(axis.values().collect::<Vec<_>>(), [3.0]);
    }
}
