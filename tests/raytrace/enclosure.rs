//! A courtyard closed on all sides keeps waves in and out, and the link says so.

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Footprint, Scene, Tracer};
use aps_tests::links::with_chains;

fn square(lo: f64, hi: f64) -> Vec<DVec2> {
    [(lo, lo), (hi, lo), (hi, hi), (lo, hi)]
        .map(DVec2::from)
        .to_vec()
}

/// A block around a courtyard from 20 to 80 m; if `gate`, with a way out to the south.
fn block(gate: bool) -> Scene {
    let footprint = if gate {
        let outline = [
            (0, 0),
            (45, 0),
            (45, 20),
            (20, 20),
            (20, 80),
            (80, 80),
            (80, 20),
            (55, 20),
            (55, 0),
            (100, 0),
            (100, 100),
            (0, 100),
        ];
        Footprint::new(outline.map(|(x, y)| DVec2::new(f64::from(x), f64::from(y))))
    } else {
        Footprint {
            outer: square(0.0, 100.0),
            holes: vec![square(20.0, 80.0)],
            material: None,
        }
    };
    Scene::new(&[footprint], None).unwrap()
}

#[test]
fn closed_courtyard_has_no_path_and_says_why() {
    let scene = block(false);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let (inside, other, outside) = (
        DVec2::new(30.0, 70.0),
        DVec2::new(70.0, 33.0),
        DVec2::new(120.0, 50.0),
    );
    for (tx, rx) in [(inside, outside), (outside, inside)] {
        let link = tracer.trace(tx, rx).unwrap();
        assert!(link.paths.is_empty() && link.is_enclosed);
    }
    let link = tracer.trace(inside, other).unwrap();
    assert!(!link.paths.is_empty() && !link.is_enclosed);
}

#[test]
fn a_gate_lets_waves_out() {
    let scene = block(true);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let link = tracer
        .trace(DVec2::new(30.0, 70.0), DVec2::new(120.0, 50.0))
        .unwrap();
    assert!(!link.paths.is_empty() && !link.is_enclosed);
}

#[test]
fn courtyard_without_corners_sets_up_no_diffraction_and_one_with_them_does() {
    let walled = block(false);
    let tracer = Tracer::new(&walled, with_chains()).unwrap();
    assert_eq!(tracer.corner_count(), 4, "the block's own, outside");
    let inside = DVec2::new(30.0, 70.0);
    assert_eq!(tracer.transmitter(inside).unwrap().front_count(), 0);
    assert!(
        tracer
            .transmitter(DVec2::new(120.0, 50.0))
            .unwrap()
            .front_count()
            > 0
    );

    // A kiosk in the court: one beside its wall, one that touches the court's wall with a corner.
    for kiosk in [(40.0, 30.0), (20.0, 50.0)] {
        let (x, y) = kiosk;
        let turned = [
            (x, y),
            (x + 5.0, y - 5.0),
            (x + 10.0, y),
            (x + 5.0, y + 5.0),
        ];
        let court = Footprint {
            outer: square(0.0, 100.0),
            holes: vec![square(20.0, 80.0)],
            material: None,
        };
        let scene = Scene::new(&[court, Footprint::new(turned.map(DVec2::from))], None).unwrap();
        let tracer = Tracer::new(&scene, with_chains()).unwrap();
        let tx = tracer.transmitter(inside).unwrap();
        assert!(tx.front_count() > 0, "kiosk at {kiosk:?}");
        let link = tracer.trace(inside, DVec2::new(x + 5.0, y - 8.0)).unwrap();
        let bends = |p: &aps_raytrace::PathRecord| {
            p.interactions
                .iter()
                .any(|i| i.kind == aps_raytrace::InteractionKind::Diffraction)
        };
        assert!(link.paths.iter().any(bends), "kiosk at {kiosk:?}");
    }
}
