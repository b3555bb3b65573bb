//! A synthetic city, so that everything runs without any map.

use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Area, Footprint, Scene};
use crate::error::ConfigError;

/// Layout of a synthetic city: blocks between streets, filled with rows of touching houses,
/// perimeter blocks around a courtyard, L-shapes, parallel bars and slanted buildings.
///
/// Coordinates are whole metres, as in RadioMapSeer. One seed gives one city, on every machine.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CityConfig {
    /// Side of the square area \[m\].
    pub size_m: u32,
    /// Mean side of a block \[m\].
    pub block_m: u32,
    /// Mean street width \[m\].
    pub street_m: u32,
    /// Seed.
    pub seed: u64,
}

impl Default for CityConfig {
    fn default() -> Self {
        Self {
            size_m: 256,
            block_m: 30,
            street_m: 12,
            seed: 1,
        }
    }
}

/// A block: lower left corner and size, in whole metres.
#[derive(Clone, Copy)]
struct Block {
    x: i32,
    y: i32,
    w: i32,
    h: i32,
}

impl CityConfig {
    /// The footprints of this city.
    ///
    /// # Errors
    /// [`ConfigError::City`] for sizes that leave no room for a block or exceed 100 km, and for a city without a building.
    pub fn footprints(&self) -> Result<Vec<Footprint>, ConfigError> {
        if self.block_m < 24 || self.street_m < 4 {
            return Err(ConfigError::City(
                "blocks must be at least 24 m and streets at least 4 m wide".into(),
            ));
        }
        let least = self.street_m.saturating_mul(2).saturating_add(self.block_m);
        if self.size_m < least || self.size_m > 100_000 {
            return Err(ConfigError::City(format!(
                "a side of {} m has no room for a block of {} m between two streets, or exceeds 100 km",
                self.size_m, self.block_m
            )));
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let columns = self.strips(&mut rng);
        let rows = self.strips(&mut rng);
        let mut footprints = Vec::new();
        for &(y, h) in &rows {
            for &(x, w) in &columns {
                build_block(Block { x, y, w, h }, &mut rng, &mut footprints);
            }
        }
        if footprints.is_empty() {
            return Err(ConfigError::City(format!(
                "seed {} leaves an area {} m wide without a building: it has hardly room for a block of {} m; enlarge it, or take another seed",
                self.seed, self.size_m, self.block_m
            )));
        }
        Ok(footprints)
    }

    /// Block intervals along one axis: start and length.
    fn strips(&self, rng: &mut ChaCha8Rng) -> Vec<(i32, i32)> {
        let sizes = [self.size_m, self.block_m, self.street_m];
        let [size, block, street] = sizes.map(|size| size as i32);
        let mut strips = Vec::new();
        let mut at = rng.random_range(street / 2..=street);
        loop {
            let length = rng.random_range(block * 7 / 10..=block * 13 / 10);
            if at + length + street / 2 > size {
                break;
            }
            strips.push((at, length));
            at += length + rng.random_range(street * 7 / 10..=street * 16 / 10);
        }
        // The space left over at the far side widens the streets.
        let end = strips.last().map_or(0, |&(start, length)| start + length);
        let spare = (size - end - street / 2).max(0);
        let count = strips.len() as i32;
        for (strip, i) in strips.iter_mut().zip(0..) {
            strip.0 += spare * i / count;
        }
        strips
    }
}

impl Scene {
    /// The synthetic city of `config`, in its square area.
    ///
    /// # Errors
    /// [`ConfigError::City`] for an impossible layout.
    ///
    /// ```
    /// use aps_raytrace::{Scene, scene::CityConfig};
    /// let scene = Scene::synthetic(&CityConfig { seed: 7, ..CityConfig::default() })?;
    /// assert!(scene.walls().len() > 50);
    /// # Ok::<(), aps_raytrace::ConfigError>(())
    /// ```
    pub fn synthetic(config: &CityConfig) -> Result<Self, ConfigError> {
        let area = Area {
            min: DVec2::ZERO,
            max: DVec2::splat(f64::from(config.size_m)),
        };
        Self::new(&config.footprints()?, Some(area)).map_err(|e| ConfigError::City(e.to_string()))
    }
}

fn build_block(block: Block, rng: &mut ChaCha8Rng, out: &mut Vec<Footprint>) {
    match rng.random_range(0..100) {
        0..20 => perimeter(block, rng, out),
        20..45 => row(block, rng, out),
        45..60 => angle(block, rng, out),
        60..75 => bars(block, rng, out),
        75..95 => slanted(block, rng, out),
        _ => {} // a square
    }
}

fn polygon<const N: usize>(points: [(i32, i32); N]) -> Footprint {
    Footprint::new(points.map(|(x, y)| DVec2::new(f64::from(x), f64::from(y))))
}

fn rectangle(x: i32, y: i32, w: i32, h: i32) -> Footprint {
    polygon([(x, y), (x + w, y), (x + w, y + h), (x, y + h)])
}

/// Lays out a block around a courtyard, closed or with a gateway.
fn perimeter(Block { x, y, w, h }: Block, rng: &mut ChaCha8Rng, out: &mut Vec<Footprint>) {
    let depth = (w.min(h) / 4).max(5);
    let (l, b, r, t) = (x + depth, y + depth, x + w - depth, y + h - depth);
    if rng.random_bool(0.5) {
        let gate = rng.random_range(l..r - 4);
        out.push(polygon([
            (gate, y),
            (gate, b),
            (l, b),
            (l, t),
            (r, t),
            (r, b),
            (gate + 4, b),
            (gate + 4, y),
            (x + w, y),
            (x + w, y + h),
            (x, y + h),
            (x, y),
        ]));
    } else {
        let mut footprint = rectangle(x, y, w, h);
        footprint.holes.push(rectangle(l, b, r - l, t - b).outer);
        out.push(footprint);
    }
}

/// Touching houses of different depth along the street.
fn row(Block { x, y, w, h }: Block, rng: &mut ChaCha8Rng, out: &mut Vec<Footprint>) {
    let count = rng.random_range(2..=4);
    for i in 0..count {
        let (from, to) = (w * i / count, w * (i + 1) / count);
        let depth = rng.random_range(h / 2..=h);
        out.push(rectangle(x + from, y, to - from, depth));
    }
}

/// An L around two sides of the block.
fn angle(Block { x, y, w, h }: Block, rng: &mut ChaCha8Rng, out: &mut Vec<Footprint>) {
    let a = rng.random_range(w / 4..=w / 2);
    let b = rng.random_range(h / 4..=h / 2);
    out.push(polygon([
        (x, y),
        (x + w, y),
        (x + w, y + b),
        (x + a, y + b),
        (x + a, y + h),
        (x, y + h),
    ]));
}

/// Two parallel bars with a lane between them.
fn bars(Block { x, y, w, h }: Block, rng: &mut ChaCha8Rng, out: &mut Vec<Footprint>) {
    let lane = rng.random_range(4..=h / 3);
    let depth = (h - lane) / 2;
    out.push(rectangle(x, y, w, depth));
    let x = x + rng.random_range(0..=4);
    out.push(rectangle(x, y + h - depth, w - 4, depth));
}

/// A rectangle turned against the street grid.
fn slanted(Block { x, y, w, h }: Block, rng: &mut ChaCha8Rng, out: &mut Vec<Footprint>) {
    let centre = DVec2::new(f64::from(2 * x + w), f64::from(2 * y + h)) / 2.0;
    let angle = f64::from(rng.random_range(8..=82_i32)).to_radians();
    let half = f64::from(w.min(h)) / 2.0;
    let long = DVec2::from_angle(angle) * half * 0.95;
    let short = long.perp() * f64::from(rng.random_range(40..=90_i32)) / 100.0;
    let corners = [-long - short, long - short, long + short, short - long];
    out.push(Footprint::new(corners.map(|c| (centre + c).round())));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn footprints(seed: u64) -> Vec<Footprint> {
        let config = CityConfig {
            seed,
            ..CityConfig::default()
        };
        config.footprints().unwrap()
    }

    #[test]
    fn one_seed_is_one_city() {
        assert_eq!(footprints(1), footprints(1));
        assert_ne!(footprints(1), footprints(2));
    }

    #[test]
    fn cities_hold_every_kind_of_building() {
        let footprints: Vec<Footprint> = (0..8).flat_map(footprints).collect();
        assert!(footprints.iter().any(|f| !f.holes.is_empty()));
        assert!(footprints.iter().any(|f| f.outer.len() == 12));
        assert!(footprints.iter().any(|f| f.outer.len() == 6));
        assert!(footprints.iter().any(|f| f.outer[0].y != f.outer[1].y));
    }

    #[test]
    fn impossible_sizes_are_refused() {
        let tiny = CityConfig {
            size_m: 30,
            ..CityConfig::default()
        };
        assert!(tiny.footprints().is_err());
        let wide = CityConfig {
            street_m: u32::MAX,
            ..CityConfig::default()
        };
        assert!(wide.footprints().is_err());
    }

    /// With room for one block at most, which may turn out too long, or a square.
    #[test]
    fn a_city_has_a_building_or_is_refused() {
        let mut refused = 0;
        for seed in 0..200 {
            let small = CityConfig {
                size_m: 38,
                block_m: 30,
                street_m: 4,
                seed,
            };
            match small.footprints() {
                Ok(footprints) => assert!(!footprints.is_empty(), "seed {seed}"),
                Err(ConfigError::City(_)) => refused += 1,
                Err(error) => panic!("{error}"),
            }
        }
        assert!((1..200).contains(&refused), "{refused} refused");
    }
}
