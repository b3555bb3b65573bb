//! The command line.

use anyhow::Result;
use aps_explore::{Maps, Server};
use map2aps::maps::NamedMaps;
use xtask::{SceneArgs, TileArgs, say};

/// Synthetic cities in the list unless a number is asked for.
const CITIES: u32 = 10;

/// Look at links live in a browser: drag a terminal through the city, and paths and spectrum follow.
///
/// Serves one page on 127.0.0.1 until Ctrl-C.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A folder of RadioMapSeer files, a city in a GeoJSON file, or synthetic[:N].
    #[arg(long, default_value = "synthetic")]
    maps: NamedMaps,
    /// Port of the page; 0 takes a free one.
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// Seed of the synthetic cities, and of the place where the terminals stand at first.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    tiles: TileArgs,
}

impl Args {
    /// Runs the command.
    ///
    /// # Errors
    /// Maps that cannot be read, and a port that is taken.
    pub fn run(self) -> Result<()> {
        let source = self.tiles.open(&self.maps, CITIES)?;
        let maps = Maps::new(source, self.seed, self.scene.settings())?;
        let server = Server::bind(maps, self.port)?;
        say!("http://{}/", server.address())?;
        Ok(server.serve()?)
    }
}
