//! Spectra as the page draws them.

use aps_label::Protocol;
use aps_report::link::Spectrum;
use serde::Serialize;

/// A spectrum in hundredths of a decibel.
#[derive(Debug, Serialize)]
pub struct Curve {
    protocol: Protocol,
    angles_deg: Vec<f64>,
    aps_db: Vec<f64>,
    /// Power over delay, in steps of `step_ns` from 0.
    pdp_db: Vec<f64>,
    step_ns: f64,
}

/// Rounds to hundredths: as much as a picture shows, in few bytes.
fn hundredths(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let round = |v: f64| (v * 100.0).round() / 100.0;
    values.into_iter().map(round).collect()
}

impl Curve {
    /// The curve of a spectrum, its angles in the sense of `protocol`.
    pub fn of(spectrum: &Spectrum, protocol: Protocol) -> Self {
        let points = spectrum.points(protocol);
        Self {
            protocol: spectrum.protocol,
            angles_deg: hundredths(points.iter().map(|p| p[0])),
            aps_db: hundredths(points.iter().map(|p| p[1])),
            pdp_db: hundredths(spectrum.pdp.iter().map(|p| p[1])),
            step_ns: spectrum.pdp.get(1).map_or(0.0, |p| p[0]),
        }
    }
}
