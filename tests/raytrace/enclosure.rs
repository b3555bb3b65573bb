//! A courtyard closed on all sides keeps waves in and out, and the link says so.

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Footprint, Scene, Tracer};
use aps_tests::links::{corners, with_chains};
use aps_tests::shapes::{block, points, polygon, ring, scene};

/// A block around a courtyard from 20 to 80 m.
fn closed() -> Footprint {
    block(
        ring([0.0, 100.0], [0.0, 100.0]),
        ring([20.0, 80.0], [20.0, 80.0]),
    )
}

#[test]
fn closed_courtyard_has_no_path_and_says_why() {
    let scene = scene(&[closed()]);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let [inside, other, outside] = points("30,70 70,33 120,50")[..] else {
        unreachable!("three points")
    };
    for (tx, rx) in [(inside, outside), (outside, inside)] {
        let link = tracer.trace(tx, rx).unwrap();
        assert!(link.paths.is_empty() && link.is_enclosed);
    }
    let link = tracer.trace(inside, other).unwrap();
    assert!(!link.paths.is_empty() && !link.is_enclosed);
}

#[test]
fn a_gate_lets_waves_out() {
    // The same with a way out to the south.
    let gate = "0,0 45,0 45,20 20,20 20,80 80,80 80,20 55,20 55,0 100,0 100,100 0,100";
    let scene = scene(&[polygon(gate)]);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let (tx, rx) = (DVec2::new(30.0, 70.0), DVec2::new(120.0, 50.0));
    let link = tracer.trace(tx, rx).unwrap();
    assert!(!link.paths.is_empty() && !link.is_enclosed);
}

#[test]
fn courtyard_without_corners_sets_up_no_diffraction_and_one_with_them_does() {
    let walled = scene(&[closed()]);
    let tracer = Tracer::new(&walled, with_chains()).unwrap();
    assert_eq!(tracer.corner_count(), 4, "the block's own, outside");
    let [inside, outside] = [DVec2::new(30.0, 70.0), DVec2::new(120.0, 50.0)];
    let fronts = |tracer: &Tracer, tx| tracer.transmitter(tx).unwrap().front_count();
    assert_eq!(fronts(&tracer, inside), 0);
    assert!(fronts(&tracer, outside) > 0);

    // A kiosk in the court: one beside its wall, one that touches the court's wall with a corner.
    for (kiosk, rx) in [
        ("40,30 45,25 50,30 45,35", DVec2::new(45.0, 22.0)),
        ("20,50 25,45 30,50 25,55", DVec2::new(25.0, 42.0)),
    ] {
        let scene: Scene = scene(&[closed(), polygon(kiosk)]);
        let tracer = Tracer::new(&scene, with_chains()).unwrap();
        assert!(fronts(&tracer, inside) > 0, "{kiosk}");
        let link = tracer.trace(inside, rx).unwrap();
        assert!(link.paths.iter().any(|p| corners(p) > 0), "{kiosk}");
    }
}
