//! Footprints and scenes in a line each.

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::CityConfig;
use aps_raytrace::{Footprint, Scene};

/// Points from their coordinates \[m\], like `"0,0 20,0 20,10"`.
///
/// # Panics
/// When the text is none.
#[must_use]
pub fn points(text: &str) -> Vec<DVec2> {
    let number = |text: &str| -> f64 { text.parse().expect("a number") };
    let point = |pair: &str| {
        let (x, y) = pair.split_once(',').expect("x,y");
        DVec2::new(number(x), number(y))
    };
    text.split_whitespace().map(point).collect()
}

/// A footprint of the corners `x,y x,y ...` \[m\].
#[must_use]
pub fn polygon(text: &str) -> Footprint {
    Footprint::new(points(text))
}

/// The corners of a rectangle from its lowest to its highest, counter-clockwise.
#[must_use]
pub fn ring(x: [f64; 2], y: [f64; 2]) -> Vec<DVec2> {
    [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
        .map(DVec2::from)
        .into()
}

/// A rectangular footprint.
#[must_use]
pub fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Footprint {
    Footprint::new(ring([x0, x1], [y0, y1]))
}

/// A footprint with one courtyard.
#[must_use]
pub fn block(outer: Vec<DVec2>, courtyard: Vec<DVec2>) -> Footprint {
    Footprint {
        holes: vec![courtyard],
        ..Footprint::new(outer)
    }
}

/// The scene of these footprints.
///
/// # Panics
/// When there is none.
#[must_use]
pub fn scene(footprints: &[Footprint]) -> Scene {
    Scene::new(footprints, None).expect("a scene")
}

/// A synthetic city of this size.
#[must_use]
pub fn city(size_m: u32, seed: u64) -> CityConfig {
    CityConfig {
        size_m,
        seed,
        ..CityConfig::default()
    }
}

/// The scene of a synthetic city of this size.
///
/// # Panics
/// When the size makes none.
#[must_use]
pub fn city_scene(size_m: u32, seed: u64) -> Scene {
    Scene::synthetic(&city(size_m, seed)).expect("a city")
}

/// The footprints, every corner moved.
#[must_use]
pub fn moved(footprints: &[Footprint], motion: impl Fn(DVec2) -> DVec2) -> Vec<Footprint> {
    let ring = |ring: &Vec<DVec2>| ring.iter().map(|&p| motion(p)).collect();
    let one = |f: &Footprint| Footprint {
        outer: ring(&f.outer),
        holes: f.holes.iter().map(ring).collect(),
        ..f.clone()
    };
    footprints.iter().map(one).collect()
}
