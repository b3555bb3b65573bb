//! Times of the stages of a link.

use std::time::Duration;

use serde::Serialize;

/// Times of the stages of a link \[us\].
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Times {
    /// Preparation of the map.
    pub map: f64,
    /// Preparation of the transmitter.
    pub tx: f64,
    /// Preparation of the receiver.
    pub rx: f64,
    /// Join of the two.
    pub join: f64,
    /// Label of the paths.
    pub label: f64,
}

/// Microseconds, to a tenth.
pub fn us(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e7).round() / 10.0
}
