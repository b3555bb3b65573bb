//! Tests that paths left out for their weakness change labels by no more than the tracer says.

use aps_label::{LabelConfig, Labeler, PathSample};
use aps_raytrace::scene::CityConfig;
use aps_raytrace::{Link, Scene, TraceConfig, Tracer};
use aps_tests::links::{outdoor_points, with_chains};
use aps_tests::maps::real_map;

/// The APS in linear power; a bin is max over tau of a sum of path powers times kernels <= 1.
fn spectrum(labeler: &Labeler, link: &Link) -> Vec<f64> {
    let samples: Vec<PathSample> = link
        .paths
        .iter()
        .map(|p| PathSample {
            delay_s: p.delay_s,
            arrival_azimuth_rad: p.arrival_azimuth_rad,
            gain_db: p.gain_db(),
        })
        .collect();
    let label = labeler.label(&samples).unwrap().unwrap();
    label
        .aps_db
        .iter()
        .map(|db| 10_f64.powf(db / 10.0))
        .collect()
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

fn ten_maps() -> Vec<Scene> {
    let real: Option<Vec<Scene>> = (0..10)
        .map(|id| real_map(5 * id).map(|text| Scene::from_radiomapseer(&text).unwrap()))
        .collect();
    real.unwrap_or_else(|| {
        let city = |seed| {
            let config = CityConfig {
                seed,
                ..CityConfig::default()
            };
            Scene::synthetic(&config).unwrap()
        };
        (0..10).map(city).collect()
    })
}

#[test]
fn dynamic_range_keeps_its_bound_on_ten_maps() {
    for range_db in [60.0, 30.0] {
        let config = TraceConfig {
            dynamic_range_db: Some(range_db),
            ..with_chains()
        };
        let (mut links, mut worst_db, mut omitted) = (0, 0.0_f64, 0);
        for scene in ten_maps() {
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
