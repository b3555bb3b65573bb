//! Helpers that several test files share: labelers, the tolerance, and links to try.

use aps_label::{Label, LabelConfig, Labeler, PathSample, Protocol};
use proptest::prelude::*;

/// Error of a square root of the array response or of the pulse, for the benchmark's array: N psi
/// and f_s tau are up to 25 and 700 and carry a few relative 1e-16 each, NumPy's as well as ours.
const ROOT_ERROR: f64 = 2e-14;
/// Relative error elsewhere; 1e-9 dB is 2.3e-10.
const RELATIVE_ERROR: f64 = 1e-10;
/// Additional error allowed in a continuous maximum: 1e-6 dB.
pub const MAXIMUM_ERROR: f64 = 2.3e-7;

pub fn linear(db: f64) -> f64 {
    10_f64.powf(0.1 * db)
}

/// The labeler of a preset, with the PDP.
pub fn labeler(protocol: Protocol) -> Labeler {
    let preset = LabelConfig::of(protocol);
    Labeler::new(&LabelConfig {
        pdp: true,
        ..preset
    })
    .expect("valid preset")
}

pub fn label(labeler: &Labeler, paths: &[PathSample]) -> Label {
    labeler.label(paths).expect("good paths").expect("a label")
}

/// Sum of the powers the protocol counts.
pub fn total_power(protocol: Protocol, paths: &[PathSample]) -> f64 {
    let used =
        |path: &&PathSample| protocol == Protocol::Paper || (-310.0..0.0).contains(&path.gain_db);
    let send_db = match protocol {
        Protocol::Released => 1.0,
        Protocol::Paper => 0.0,
    };
    let used = paths.iter().filter(used);
    used.map(|path| linear(send_db + path.gain_db)).sum()
}

/// Error allowed for a power of about `power` in a link of power `total`.
///
/// Relative, except near a zero of every path's response: there Q = sum p_k r_k^2 follows an error d
/// of the roots r_k by up to 2 d sqrt(Q total) + d^2 total (Cauchy-Schwarz), in any f64 evaluation
/// from the same inputs.
pub fn tolerance(power: f64, total: f64) -> f64 {
    RELATIVE_ERROR * power
        + 2.0 * ROOT_ERROR * (power * total).sqrt()
        + ROOT_ERROR * ROOT_ERROR * total
}

#[track_caller]
pub fn assert_power(got: f64, want: f64, total: f64, what: &str) {
    let error = (got - want).abs();
    assert!(
        error <= tolerance(want, total),
        "{what}: {got:e} instead of {want:e}"
    );
}

#[track_caller]
pub fn assert_power_db(got: f64, want: f64, total: f64, what: &str) {
    assert_power(linear(got), linear(want), total, what);
}

/// A path of a city link.
pub fn path() -> impl Strategy<Value = PathSample> {
    (1e-8..1.4e-6, -7.0..7.0, -160.0..-60.0).prop_map(|(delay_s, arrival_azimuth_rad, gain_db)| {
        PathSample {
            delay_s,
            arrival_azimuth_rad,
            gain_db,
        }
    })
}

/// 1 to 40 paths: spread out, or crowded within a few pulses.
pub fn link() -> impl Strategy<Value = Vec<PathSample>> {
    (prop::collection::vec(path(), 1..40), prop::bool::ANY).prop_map(|(mut paths, crowded)| {
        if crowded {
            paths
                .iter_mut()
                .for_each(|path| path.delay_s = 3e-7 + 0.02 * path.delay_s);
        }
        paths
    })
}
