//! Paths through corners, exactly: integer coordinates put them there all the time.

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Footprint, Interaction, InteractionKind, Material, TraceConfig, Tracer};
use aps_tests::shapes::{points, rectangle, scene};

/// From (55, 0) to (60, 10), the start of a wall, past the corner (50, 30) to (45, 40), past
/// the corner (40, 30) to (35, 20). Seen from the far end the first wall shows a single point,
/// beside a corner that hides all of its neighbourhood.
#[test]
fn path_that_touches_three_corners_is_found_both_ways() {
    let block = |i: i32| {
        let (x, y) = (20.0 * f64::from(i % 4), 20.0 * f64::from(i / 4));
        rectangle(x, y, x + 10.0, y + 10.0)
    };
    let scene = scene(&(0..16).map(block).collect::<Vec<_>>());
    let tracer = Tracer::new(&scene, TraceConfig::reflections_only(2)).unwrap();
    let (a, b) = (DVec2::new(55.0, 0.0), DVec2::new(35.0, 20.0));
    let points = [DVec2::new(60.0, 10.0), DVec2::new(45.0, 40.0)];
    for (tx, rx, points) in [(a, b, points), (b, a, [points[1], points[0]])] {
        let paths = tracer.trace(tx, rx).unwrap().paths;
        let found = paths.iter().any(|p| {
            let is_there = |(i, q): (&Interaction, &DVec2)| {
                i.kind == InteractionKind::Reflection && i.point.distance(*q) < 1e-12
            };
            p.interactions.len() == 2 && p.interactions.iter().zip(&points).all(is_there)
        });
        assert!(found, "{tx} -> {rx}");
    }
}

/// The field on a perfectly conducting wall is zero: a ray along it feeds no diffraction, at
/// either end of the wall, in either direction.
#[test]
fn ray_along_a_perfectly_conducting_wall_is_not_diffracted() {
    let config = TraceConfig {
        material: Material::PerfectConductor,
        max_reflections: 0,
        dynamic_range_db: None,
        ..TraceConfig::default()
    };
    let house = points("0,0 12,5 7,17 -5,12");
    let scene = scene(&[Footprint::new(house.clone())]);
    let tracer = Tracer::new(&scene, config).unwrap();
    for i in 0..4 {
        let (a, b) = (house[i], house[(i + 1) % 4]);
        let (before, after) = (a - (b - a), b + (b - a));
        // In the shadow of the wall's far end, and of its near end.
        let (behind_b, behind_a) = (
            b + (house[(i + 2) % 4] - b) * 2.0,
            a + (house[(i + 3) % 4] - a) * 2.0,
        );
        for (tx, rx, corner) in [(before, behind_b, b), (after, behind_a, a)] {
            for (tx, rx) in [(tx, rx), (rx, tx)] {
                let paths = tracer.trace(tx, rx).unwrap().paths;
                let feeds = paths
                    .iter()
                    .flat_map(|p| &p.interactions)
                    .any(|i| i.point == corner);
                assert!(!feeds, "{tx} -> {rx} by {corner}: {paths:?}");
            }
        }
    }
}
