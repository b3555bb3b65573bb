//! Axes of labels: evenly spaced sample points.

/// Evenly spaced sample points, in the words of `numpy.linspace(start, stop, count, endpoint)`.
///
/// ```
/// use aps_label::Axis;
/// let values: Vec<f64> = Axis::ANGLE_PAPER_DEG.values().collect();
/// assert_eq!((values[0], values[1], values[179]), (-180.0, -178.0, 178.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
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
        let axis = *self;
        let intervals = axis.count.saturating_sub(usize::from(axis.endpoint));
        let step = (axis.stop - axis.start) / intervals.max(1) as f64;
        (0..axis.count).map(move |i| match axis.endpoint && i > 0 && i == intervals {
            true => axis.stop,
            false => axis.start + i as f64 * step,
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
