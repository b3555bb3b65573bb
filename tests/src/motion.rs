//! The same links in a scene and in its moved copy.

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Footprint, Interaction, PathRecord, TraceConfig, Tracer};

use crate::links::strongest;
use crate::shapes::{moved, scene};

/// Paths this far below the strongest \[dB\] are sums that cancel: rounding decides on their gain.
const CANCELLED_DB: f64 = 150.0;

/// Largest differences between two traces of the same links.
#[derive(Debug, Default)]
pub struct Difference {
    /// Paths of both.
    pub paths: usize,
    /// Paths above the cancelled ones that only one of the two has, and links of which only one went beyond the limits.
    pub unmatched: usize,
    /// Difference of the lengths, relative.
    pub length: f64,
    /// Difference of the gains, relative.
    pub gain: f64,
    /// Distance of the points of interaction, moved with the scene \[m\].
    pub point_m: f64,
}

/// Tells if two paths have the same kinds of interaction at the same points, `q` in a scene that `motion` moved: ids of walls
/// may change with it.
fn is_same(p: &PathRecord, q: &PathRecord, within_m: f64, motion: impl Fn(DVec2) -> DVec2) -> bool {
    let is_same = |(a, b): (&Interaction, &Interaction)| {
        a.kind == b.kind && motion(a.point).distance(b.point) < within_m
    };
    p.interactions.len() == q.interactions.len()
        && p.interactions.iter().zip(&q.interactions).all(is_same)
}

/// Traces the links between `points` in a scene and in its moved copy, lengths `scale` times as long.
///
/// # Panics
/// When the two have another number of walls, or cannot be traced.
pub fn difference(
    footprints: &[Footprint],
    points: &[DVec2],
    config: [&TraceConfig; 2],
    scale: f64,
    motion: impl Fn(DVec2) -> DVec2,
) -> Difference {
    let scenes = [scene(footprints), scene(&moved(footprints, &motion))];
    assert_eq!(scenes[0].walls().len(), scenes[1].walls().len());
    let tracer = |i: usize| Tracer::new(&scenes[i], config[i].clone()).expect("sound settings");
    let (here, there) = (tracer(0), tracer(1));
    let mut d = Difference::default();
    for (i, &tx) in points.iter().enumerate() {
        for &rx in &points[..i] {
            let before = here.trace(tx, rx).expect("a link");
            let after = there.trace(motion(tx), motion(rx)).expect("a link");
            d.unmatched += usize::from(before.fallback_diffractions != after.fallback_diffractions);
            let floor = strongest(&before.paths) * 10_f64.powf(-CANCELLED_DB / 10.0);
            let mut left: Vec<&PathRecord> = after.paths.iter().collect();
            for p in before.paths.iter().filter(|p| p.power() > floor) {
                let twin = left
                    .iter()
                    .position(|q| is_same(p, q, 1e-6 * scale, &motion));
                let Some(q) = twin.map(|at| left.swap_remove(at)) else {
                    d.unmatched += 1;
                    continue;
                };
                d.paths += 1;
                d.length = d
                    .length
                    .max((q.length_m / (p.length_m * scale) - 1.0).abs());
                d.gain = d.gain.max((p.gain - q.gain).norm() / p.gain.norm());
                for (a, b) in p.interactions.iter().zip(&q.interactions) {
                    d.point_m = d.point_m.max(motion(a.point).distance(b.point));
                }
            }
            d.unmatched += left.iter().filter(|q| q.power() > floor).count();
        }
    }
    d
}
