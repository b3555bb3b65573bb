//! Layout of a data set: the arrays stored for each link, and their axes.

use aps_label::{Axis, LabelConfig};
use serde::{Deserialize, Serialize};

use crate::raster::RasterGrid;

/// Largest number of bins of an [`Axis`]: far above any use, far below any harm.
const MAX_BINS: usize = 1 << 16;

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

/// Kinds of data that are stored of each link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stored {
    /// Angle power spectra.
    pub aps: bool,
    /// Power delay profiles.
    pub pdp: bool,
    /// Propagation paths.
    pub paths: bool,
}

impl Default for Stored {
    /// Angle power spectra alone.
    fn default() -> Self {
        Stored {
            aps: true,
            pdp: false,
            paths: false,
        }
    }
}

impl Layout {
    /// Returns the kinds of data that are stored.
    pub fn stored(&self) -> Stored {
        Stored {
            aps: self.aps.is_some(),
            pdp: self.pdp.is_some(),
            paths: self.paths,
        }
    }

    /// Returns the layout of labels made with these settings, in half precision.
    pub fn of_labels(label: &LabelConfig, raster: RasterGrid, stored: Stored) -> Self {
        Layout {
            raster,
            aps: (stored.aps).then(|| ProfileLayout::over(label.protocol.angle_axis_deg())),
            pdp: (stored.pdp).then(|| ProfileLayout::over(label.delay_axis.axis_ns())),
            paths: stored.paths,
        }
    }

    /// Describes a fault of the layout; `None` if it is sound.
    pub(crate) fn problem(&self) -> Option<&'static str> {
        let profiles = [self.aps, self.pdp];
        self.raster.problem().or_else(|| {
            profiles
                .iter()
                .flatten()
                .find_map(|profile| axis_problem(&profile.axis))
        })
    }
}

fn axis_problem(axis: &Axis) -> Option<&'static str> {
    if !(axis.start.is_finite() && axis.stop.is_finite()) {
        Some("an axis needs finite ends")
    } else if axis.count == 0 || axis.count > MAX_BINS {
        Some("an axis needs 1 to 65536 values")
    } else {
        None
    }
}
