//! Tests that paths left out for their weakness change labels by no more than the tracer says.

use aps_label::{LabelConfig, Labeler};
use aps_raytrace::{Link, Scene, TraceConfig, Tracer};
use aps_tests::links::{outdoor_points, sample, with_chains};
use aps_tests::maps::real_cities;
use aps_tests::shapes::city_scene;

/// The APS in linear power; a bin is max over tau of a sum of path powers times kernels <= 1.
fn spectrum(labeler: &Labeler, link: &Link) -> Vec<f64> {
    let samples: Vec<_> = link.paths.iter().map(sample).collect();
    let label = labeler.label(&samples).unwrap().unwrap();
    let power = |db: &f64| 10_f64.powf(db / 10.0);
    label.aps_db.iter().map(power).collect()
}

/// Compares a configuration that leaves paths out with one that keeps all. Returns the links
/// compared, the largest change above -40 dB of the maximum [dB], and the paths left out.
fn check(scene: &Scene, config: &TraceConfig) -> (usize, f64, usize) {
    let all = TraceConfig {
        dynamic_range_db: None,
        ..config.clone()
    };
    let (pruned, full) = (
        Tracer::new(scene, config.clone()).unwrap(),
        Tracer::new(scene, all).unwrap(),
    );
    let labeler = Labeler::new(&LabelConfig::paper()).unwrap();
    let ends = outdoor_points(scene, 16, 0);
    let (mut links, mut worst_db, mut omitted) = (0, 0.0_f64, 0);
    for &tx in &ends[..4] {
        for &rx in &ends[4..] {
            let (a, b) = (pruned.trace(tx, rx).unwrap(), full.trace(tx, rx).unwrap());
            if b.paths.is_empty() {
                assert!(a.paths.is_empty());
                continue;
            }
            assert!(
                a.paths.iter().all(|p| b.paths.contains(p)),
                "a path of its own"
            );
            // Links beyond the limits are not pruned against the limits.
            if a.fallback_diffractions.is_some() {
                continue;
            }
            let left_out = a.omitted.by_bound + a.omitted.by_gain;
            assert!(b.paths.len() - a.paths.len() <= left_out);
            let (with, without) = (spectrum(&labeler, &b), spectrum(&labeler, &a));
            let top = without.iter().copied().fold(0.0, f64::max);
            for (with, without) in with.iter().zip(&without) {
                if *without < 1e-4 * top {
                    continue;
                }
                let change_db = 10.0 * (with / without).log10();
                let bound_db = a.omitted.effect_db(*without);
                assert!(
                    change_db <= bound_db + 1e-9,
                    "{tx} -> {rx}: {change_db} > {bound_db}"
                );
                worst_db = worst_db.max(change_db);
            }
            omitted += left_out;
            links += 1;
        }
    }
    (links, worst_db, omitted)
}

/// Real cities, and as many synthetic ones as make ten.
fn ten_cities() -> Vec<Scene> {
    let real = real_cities(&[0, 10, 20, 30, 40, 50]);
    let real = real.into_iter().map(|(_, scene)| scene);
    let synthetic = (0..).map(|seed| city_scene(256, seed));
    real.chain(synthetic).take(10).collect()
}

#[test]
fn dynamic_range_keeps_its_bound_on_ten_cities() {
    for range_db in [60.0, 30.0] {
        let config = TraceConfig {
            dynamic_range_db: Some(range_db),
            ..with_chains()
        };
        let (mut links, mut worst_db, mut omitted) = (0, 0.0_f64, 0);
        for scene in ten_cities() {
            let found = check(&scene, &config);
            links += found.0;
            worst_db = worst_db.max(found.1);
            omitted += found.2;
        }
        eprintln!(
            "{range_db} dB: {links} links, {omitted} paths left out, largest change {worst_db:.3} dB"
        );
        assert!(links > 50 && omitted > 100);
    }
}
