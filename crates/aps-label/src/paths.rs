//! From the caller's paths to the canonical list the kernels work on.

use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

use crate::protocol::Protocol;
use crate::{MAX_DELAY_S, NEGLIGIBLE_DB, PathError};

/// One propagation path as a label sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathSample {
    /// Propagation delay \[s\], 0 to [`MAX_DELAY_S`].
    pub delay_s: f64,
    /// Azimuth from the receiver towards the last interaction, or towards the transmitter on a line
    /// of sight \[rad\]; counter-clockwise from +x, any number of turns.
    pub arrival_azimuth_rad: f64,
    /// 20 log10|a| \[dB\], the negative of the path loss.
    pub gain_db: f64,
}

/// Headings of an array that settings may ask for \[deg\]: a turn to either side says everything.
pub const HEADINGS_DEG: RangeInclusive<f64> = -360.0..=360.0;

impl PathSample {
    /// The path as an array turned by `heading_rad`, counter-clockwise, sees it: its azimuth counted from that direction, from
    /// -pi to pi; the same bits at a heading of 0.
    #[must_use]
    pub fn from_heading(self, heading_rad: f64) -> Self {
        if heading_rad == 0.0 {
            return self;
        }
        let turned_rad = self.arrival_azimuth_rad - heading_rad;
        Self {
            arrival_azimuth_rad: PI - (PI - turned_rad).rem_euclid(TAU),
            ..self
        }
    }
}

/// Path losses the released code accepts \[dB\]: above the first, up to the second.
const RELEASED_LOSS_DB: (f64, f64) = (0.0, 310.0);

/// The usable paths, strongest first, as one array a quantity.
#[derive(Debug, Clone, Default)]
pub(crate) struct Paths {
    sorted: Vec<PathSample>,
    /// tau_k \[s\].
    pub delay_s: Vec<f64>,
    /// Sine and cosine of the arrival angle in the protocol's sense.
    pub direction: Vec<(f64, f64)>,
    /// Power relative to the strongest path's, in (0, 1].
    pub power: Vec<f64>,
    /// The strongest path's power in the protocol's unit \[dBm, or dB\].
    pub strongest_db: f64,
}

impl Paths {
    pub fn len(&self) -> usize {
        self.power.len()
    }

    /// Checks, selects, sorts and scales.
    ///
    /// The order is canonical (power, then delay, then azimuth), so that neither sums nor ties
    /// depend on the caller's order; the first path has power 1, so that nothing that counts
    /// underflows.
    pub fn prepare(
        &mut self,
        protocol: Protocol,
        samples: &[PathSample],
        max: usize,
    ) -> Result<(), PathError> {
        self.sorted.clear();
        self.delay_s.clear();
        self.direction.clear();
        self.power.clear();
        self.strongest_db = f64::NEG_INFINITY;

        if samples.len() > max {
            return Err(PathError::TooMany {
                count: samples.len(),
                max,
            });
        }
        for (index, sample) in samples.iter().enumerate() {
            check(index, sample)?;
            if used(protocol, sample.gain_db) {
                self.sorted.push(*sample);
            }
        }
        self.sorted.sort_unstable_by(canonical);

        let Some(strongest) = self.sorted.first().map(|path| path.gain_db) else {
            return Ok(());
        };
        // Towards the last interaction, or the opposite: the direction of travel.
        let sense = match protocol {
            Protocol::Paper => 1.0,
            Protocol::Released => -1.0,
        };
        self.strongest_db = power_db(protocol, strongest);
        for path in &self.sorted {
            let below_db = strongest - path.gain_db;
            if below_db > NEGLIGIBLE_DB {
                break;
            }
            self.delay_s.push(path.delay_s);
            let (sin, cos) = libm::sincos(path.arrival_azimuth_rad);
            self.direction.push((sense * sin, sense * cos));
            self.power.push(libm::exp10(-0.1 * below_db));
        }
        Ok(())
    }
}

pub(crate) fn check(index: usize, sample: &PathSample) -> Result<(), PathError> {
    let fields = [
        ("delay_s", sample.delay_s),
        ("arrival_azimuth_rad", sample.arrival_azimuth_rad),
        ("gain_db", sample.gain_db),
    ];
    if let Some((field, value)) = fields.into_iter().find(|(_, value)| !value.is_finite()) {
        return Err(PathError::NotFinite {
            index,
            field,
            value,
        });
    }
    if !(0.0..=MAX_DELAY_S).contains(&sample.delay_s) {
        return Err(PathError::Delay {
            index,
            value: sample.delay_s,
        });
    }
    Ok(())
}

/// Returns true when the protocol counts a path of this gain.
pub(crate) fn used(protocol: Protocol, gain_db: f64) -> bool {
    let loss_db = -gain_db;
    match protocol {
        Protocol::Paper => true,
        Protocol::Released => loss_db > RELEASED_LOSS_DB.0 && loss_db <= RELEASED_LOSS_DB.1,
    }
}

/// The path's power in the protocol's unit \[dBm, or dB\].
pub(crate) fn power_db(protocol: Protocol, gain_db: f64) -> f64 {
    protocol.sent_power_db() + gain_db
}

fn canonical(a: &PathSample, b: &PathSample) -> Ordering {
    b.gain_db
        .total_cmp(&a.gain_db)
        .then(a.delay_s.total_cmp(&b.delay_s))
        .then(a.arrival_azimuth_rad.total_cmp(&b.arrival_azimuth_rad))
}
