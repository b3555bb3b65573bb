//! Terminal positions: outdoors, on the grid of whole metres, drawn without replacement.

use anyhow::{Result, bail};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Transmitters and receivers of one map [m]; no point is drawn twice.
pub struct Terminals {
    pub tx: Vec<DVec2>,
    pub rx: Vec<DVec2>,
}

impl Terminals {
    /// Transmitter and receiver of each link.
    pub fn pairs(&self) -> impl Iterator<Item = (DVec2, DVec2)> {
        let of_tx = |&tx| self.rx.iter().map(move |&rx| (tx, rx));
        self.tx.iter().flat_map(of_tx)
    }
}

/// Draws the terminals of map `id`. Depends on seed, id and the scene alone, so that shards draw
/// alike; the receivers do not depend on how many transmitters are drawn.
pub fn draw(scene: &Scene, seed: u64, id: u32, tx: usize, rx: usize) -> Result<Terminals> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(id));
    let Some(area) = scene.area() else {
        bail!("the map has no area to draw terminals from");
    };
    let (min, max) = (area.min.ceil(), area.max.floor());
    let columns = (max.x - min.x) as usize + 1;
    let rows = (max.y - min.y) as usize + 1;
    let mut grid: Vec<u32> = (0..(columns * rows) as u32).collect();
    let mut outdoor = Vec::with_capacity(tx + rx);
    // Fisher-Yates from the front; indoor points are passed over.
    for i in 0..grid.len() {
        if outdoor.len() == tx + rx {
            break;
        }
        let j = rng.random_range(i..grid.len());
        grid.swap(i, j);
        let (row, column) = (grid[i] as usize / columns, grid[i] as usize % columns);
        let p = min + DVec2::new(column as f64, row as f64);
        if scene.locate(p) == Location::Outdoor {
            outdoor.push(p);
        }
    }
    if outdoor.len() < tx + rx {
        bail!(
            "map {id} has only {} outdoor grid points for {tx} transmitters and {rx} receivers",
            outdoor.len()
        );
    }
    let tx = outdoor.split_off(rx);
    Ok(Terminals { tx, rx: outdoor })
}
