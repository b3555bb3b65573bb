//! Terminals to try and links to compare.

use std::collections::BTreeMap;

use aps_label::PathSample;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use aps_raytrace::{Complex64, InteractionKind, Link, Material, PathRecord, Scene, TraceConfig};

/// Interactions of a path, in order from the transmitter: kinds, and ids of walls or corners.
pub type Sequence = Vec<(InteractionKind, u32)>;

/// Outdoor points of the integer grid 0..=256 in a fixed scattered order.
#[must_use]
pub fn outdoor_points(scene: &Scene, count: usize, offset: u32) -> Vec<DVec2> {
    (0..)
        .map(|i: u32| {
            let j = (i + offset).wrapping_mul(2_654_435_761) >> 8;
            DVec2::new(f64::from(j % 257), f64::from(j / 257 % 257))
        })
        .filter(|&p| scene.locate(p) == Location::Outdoor)
        .take(count)
        .collect()
}

/// The interactions of a path without their points.
#[must_use]
pub fn sequence(path: &PathRecord) -> Sequence {
    path.interactions.iter().map(|i| (i.kind, i.id)).collect()
}

/// Paths by sequence, backwards if asked.
///
/// # Panics
/// When two paths have the same sequence: a link lists each once.
#[must_use]
pub fn by_sequence(paths: &[PathRecord], backwards: bool) -> BTreeMap<Sequence, &PathRecord> {
    let mut map = BTreeMap::new();
    for path in paths {
        let mut key = sequence(path);
        if backwards {
            key.reverse();
        }
        let twin = map.insert(key, path);
        assert!(twin.is_none(), "{:?} is listed twice", sequence(path));
    }
    map
}

/// A path as labels take it.
#[must_use]
pub fn sample(path: &PathRecord) -> PathSample {
    PathSample {
        delay_s: path.delay_s,
        arrival_azimuth_rad: path.arrival_azimuth_rad,
        gain_db: path.gain_db(),
    }
}

/// Refuses NaN and infinity in any number of a link.
///
/// # Panics
/// With the path that has one.
pub fn assert_finite(link: &Link, what: &str) {
    for p in &link.paths {
        let numbers = [
            p.length_m,
            p.delay_s,
            p.departure_azimuth_rad,
            p.arrival_azimuth_rad,
            p.gain.re,
            p.gain.im,
            p.power(),
        ];
        let mut points = p.interactions.iter().map(|i| i.point);
        let is_finite = numbers.iter().all(|v| v.is_finite()) && points.all(DVec2::is_finite);
        assert!(is_finite, "{what}: {p:?}");
    }
    assert!(link.omitted.power.is_finite(), "{what}: {:?}", link.omitted);
}

/// Number of the corners on a path.
#[must_use]
pub fn corners(path: &PathRecord) -> usize {
    let kinds = path.interactions.iter().map(|i| i.kind);
    kinds.filter(|&k| k == InteractionKind::Diffraction).count()
}

/// Power of the strongest path; 0 without any.
#[must_use]
pub fn strongest(paths: &[PathRecord]) -> f64 {
    paths.iter().map(PathRecord::power).fold(0.0, f64::max)
}

/// The sum of all paths: what a narrow-band receiver measures.
#[must_use]
pub fn total_field(paths: &[PathRecord]) -> Complex64 {
    paths.iter().map(|p| p.gain).sum()
}

/// 20 log10 of a ratio of magnitudes \[dB\].
#[must_use]
pub fn decibels(p: Complex64, q: Complex64) -> f64 {
    20.0 * (p.norm() / q.norm()).log10()
}

/// The default limits, and chains of up to four diffractions for links without a path inside them.
#[must_use]
pub fn with_chains() -> TraceConfig {
    TraceConfig {
        max_fallback_diffractions: 4,
        ..TraceConfig::default()
    }
}

/// Every path of at most one reflection and one diffraction, at walls of this material.
#[must_use]
pub fn one_of_each(material: Material) -> TraceConfig {
    TraceConfig {
        material,
        dynamic_range_db: None,
        ..TraceConfig::within(1, 1)
    }
}
