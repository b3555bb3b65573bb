//! Terminal positions: outdoors, on the grid of whole metres, drawn without replacement.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::maps::MapError;

/// Seed of data sets and of random choices where no other is given.
pub const SEED: u64 = 42;

/// Spacing of the grid that terminals stand on \[m\].
pub const GRID_M: f64 = 1.0;

fn grid_m<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let found = f64::deserialize(from)?;
    let other = || D::Error::custom(format!("grid_m = {found}: only {GRID_M} is known"));
    (found == GRID_M).then_some(found).ok_or_else(other)
}

/// Points that receivers are chosen from, in receivers wanted of each transmitter.
const POOL: usize = 4;

/// Terminals of each map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// Transmitters.
    pub tx_per_map: usize,
    /// Receivers of each transmitter.
    pub rx_per_map: usize,
    /// Spacing of the grid they stand on \[m\], [`GRID_M`]: no other is read.
    #[serde(deserialize_with = "grid_m")]
    pub grid_m: f64,
    /// Choice of the points of receivers. Manifests of format version 1 do not state it: [`Receivers::Outdoor`].
    #[serde(default = "Receivers::of_version_1")]
    pub receivers: Receivers,
}

/// Choice of the receivers of a transmitter.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Receivers {
    /// The first points of a map's pool that the transmitter reaches inside the limits, as in published data: every link
    /// has a path.
    #[default]
    Reached,
    /// Points that all transmitters of a map share, reached or not.
    Outdoor,
}

/// Reads `reached` or `outdoor`.
impl FromStr for Receivers {
    type Err = MapError;

    fn from_str(text: &str) -> Result<Self, MapError> {
        let mut all = Self::ALL.into_iter();
        let found = all.find(|receivers| receivers.name() == text);
        found.ok_or_else(|| MapError::Receivers(text.into()))
    }
}

/// The name of the choice.
impl fmt::Display for Receivers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Receivers {
    /// Both choices, the default first.
    pub const ALL: [Self; 2] = [Self::Reached, Self::Outdoor];

    /// `reached` or `outdoor`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reached => "reached",
            Self::Outdoor => "outdoor",
        }
    }

    fn of_version_1() -> Self {
        Self::Outdoor
    }
}

impl Sampling {
    /// Fewest and most points that receivers of one map are chosen from.
    pub fn pool(&self) -> RangeInclusive<usize> {
        match self.receivers {
            Receivers::Reached => self.rx_per_map..=POOL.saturating_mul(self.rx_per_map),
            Receivers::Outdoor => self.rx_per_map..=self.rx_per_map,
        }
    }
}

/// Terminals of one map; no point is drawn twice.
#[derive(Debug, Clone, PartialEq)]
pub struct Terminals {
    /// Transmitters \[m\].
    pub tx: Vec<DVec2>,
    /// Points for receivers \[m\].
    pub rx: Vec<DVec2>,
}

/// Draws the terminals of map `id`: as many receivers of the range as there is room for. They depend on seed, id and the
/// scene alone, so that shards draw alike; the receivers do not depend on how many transmitters are drawn, unless
/// there are too few points for all.
///
/// # Errors
/// [`MapError::NoArea`], [`MapError::TooLarge`] and [`MapError::NoRoom`].
pub fn draw(
    scene: &Scene,
    seed: u64,
    id: u32,
    tx: usize,
    rx: RangeInclusive<usize>,
) -> Result<Terminals, MapError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(id));
    let Some(area) = scene.area() else {
        return Err(MapError::NoArea);
    };
    let (min, max) = (area.min.ceil(), area.max.floor());
    let size_m = max - min;
    let points = (size_m.x + 1.0) * (size_m.y + 1.0);
    if points > f64::from(u32::MAX) {
        return Err(MapError::TooLarge { id, size_m });
    }
    let columns = size_m.x as usize + 1;
    let rows = size_m.y as usize + 1;
    let wanted = tx.saturating_add(*rx.end());
    let mut outdoor = Vec::new();
    // Fisher-Yates from the front, of a list that tells only the points that are not at their own place; indoor points are passed over.
    let mut moved: HashMap<usize, usize> = HashMap::new();
    for i in 0..columns * rows {
        if outdoor.len() == wanted {
            break;
        }
        let j = rng.random_range(i..columns * rows);
        let first = moved.remove(&i).unwrap_or(i);
        let drawn = match j == i {
            true => first,
            false => moved.insert(j, first).unwrap_or(j),
        };
        let (row, column) = (drawn / columns, drawn % columns);
        let p = min + DVec2::new(column as f64, row as f64);
        if scene.locate(p) == Location::Outdoor {
            outdoor.push(p);
        }
    }
    if outdoor.len() < tx.saturating_add(*rx.start()) {
        return Err(MapError::NoRoom {
            id,
            points: outdoor.len(),
            tx,
            rx: *rx.start(),
        });
    }
    let tx = outdoor.split_off(outdoor.len() - tx);
    Ok(Terminals { tx, rx: outdoor })
}

/// Draws links without replacement from all maps, given with their numbers of links by ascending id; returns their places
/// in each map, ascending.
pub fn draw_links(
    maps: impl IntoIterator<Item = (u32, usize)>,
    links: usize,
    seed: u64,
) -> BTreeMap<u32, Vec<usize>> {
    let maps: Vec<(u32, usize)> = maps.into_iter().collect();
    let total: usize = maps.iter().map(|(_, links)| links).sum();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = BTreeSet::new();
    // Floyd's sampling (Bentley and Floyd, CACM 30(9), 1987): no list of all links is made.
    for last in total.saturating_sub(links)..total {
        let link = rng.random_range(0..=last);
        if !drawn.insert(link) {
            drawn.insert(last);
        }
    }
    let mut chosen: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut first = 0;
    let mut drawn = drawn.into_iter().peekable();
    for (id, links) in maps {
        while let Some(link) = drawn.next_if(|&link| link < first + links) {
            chosen.entry(id).or_default().push(link - first);
        }
        first += links;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use aps_raytrace::scene::{Area, SceneConfig};

    #[test]
    fn a_map_with_more_points_than_numbers_for_them_is_refused() {
        let side = 70_000.0;
        let area = Area {
            min: DVec2::ZERO,
            max: DVec2::splat(side),
        };
        let config = SceneConfig {
            area: Some(area),
            ..SceneConfig::default()
        };
        let scene = Scene::with_config(&[], &config).unwrap();
        let size_m = DVec2::splat(side);
        assert_eq!(
            draw(&scene, 1, 3, 1, 1..=1),
            Err(MapError::TooLarge { id: 3, size_m })
        );
    }

    #[test]
    fn terminals_are_those_of_a_shuffle_of_all_points() {
        let scene = synthetic_scene();
        let area = scene.area().unwrap();
        let columns = (area.max.x.floor() - area.min.x.ceil()) as usize + 1;
        let rows = (area.max.y.floor() - area.min.y.ceil()) as usize + 1;
        // Some, and more than there are.
        for wanted in [30, columns * rows] {
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            rng.set_stream(3);
            let mut grid: Vec<usize> = (0..columns * rows).collect();
            let mut outdoor = Vec::new();
            for i in 0..grid.len() {
                let j = rng.random_range(i..grid.len());
                grid.swap(i, j);
                let steps = DVec2::new((grid[i] % columns) as f64, (grid[i] / columns) as f64);
                let place = area.min.ceil() + steps;
                if outdoor.len() < wanted && scene.locate(place) == Location::Outdoor {
                    outdoor.push(place);
                }
            }
            let found = draw(&scene, 7, 3, 2, 0..=wanted - 2).unwrap();
            assert_eq!(found.tx, outdoor.split_off(outdoor.len() - 2));
            assert_eq!(found.rx, outdoor);
        }
    }

    /// A house in an area of 41 m x 31 m.
    fn synthetic_scene() -> Scene {
        let house = [(5.0, 5.0), (25.0, 5.0), (25.0, 22.0), (5.0, 22.0)].map(DVec2::from);
        let area = Area {
            min: DVec2::new(-0.5, 0.0),
            max: DVec2::new(40.0, 30.7),
        };
        let config = SceneConfig {
            area: Some(area),
            ..SceneConfig::default()
        };
        Scene::with_config(&[aps_raytrace::Footprint::new(house)], &config).unwrap()
    }

    #[test]
    fn another_grid_is_refused() {
        let read = |grid_m: &str| {
            let text = format!(r#"{{"tx_per_map":1,"rx_per_map":2,"grid_m":{grid_m}}}"#);
            serde_json::from_str::<Sampling>(&text)
        };
        assert_eq!(read("1").unwrap().receivers, Receivers::Outdoor);
        let refused = read("0.5").unwrap_err().to_string();
        assert!(
            refused.starts_with("grid_m = 0.5: only 1 is known"),
            "{refused}"
        );
    }

    #[test]
    fn choices_of_receivers_are_read_back() {
        for receivers in Receivers::ALL {
            assert_eq!(receivers.to_string().parse(), Ok(receivers));
            let text = serde_json::to_string(&receivers).unwrap();
            assert_eq!(text, format!("\"{receivers}\""));
        }
    }

    #[test]
    fn links_are_drawn_without_replacement_and_repeatably() {
        let maps = [(0, 3), (4, 0), (7, 1000)];
        let drawn = draw_links(maps, 100, 1);
        assert_eq!(drawn, draw_links(maps, 100, 1));
        assert_eq!(drawn.values().map(Vec::len).sum::<usize>(), 100);
        for links in drawn.values() {
            assert!(links.is_sorted_by(|a, b| a < b), "{links:?}");
        }
        let all = draw_links(maps, usize::MAX, 1);
        assert_eq!(
            all,
            BTreeMap::from([(0, vec![0, 1, 2]), (7, (0..1000).collect())])
        );
    }
}
