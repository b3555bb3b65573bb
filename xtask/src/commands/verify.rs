//! `cargo xtask verify`: checks that a data set is as its manifest says.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use aps_data::Dataset;
use map2aps::maps::NamedMaps;
use map2aps::{MapSource, SEED, SettingsError, Verify, counted};

use crate::args::TileArgs;
use crate::progress::{self, Bar};
use crate::say;
use crate::source::wanted_maps;

/// Check a data set: bytes, values, counts, statistics, and a sample of its links computed anew from the maps.
///
/// Every finding is one line; the exit code is 1 if there is any.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the data set.
    dataset: PathBuf,
    /// The maps it was made of; a city in GeoJSON is cut as it was [default: synthetic cities are made anew; other maps
    /// are not looked at].
    #[arg(long)]
    maps: Option<NamedMaps>,
    /// Compute so many random links anew and compare them with what is stored [default: 100 if the maps can be had].
    #[arg(long)]
    sample: Option<usize>,
    /// Seed of the choice of links.
    #[arg(long, default_value_t = SEED)]
    seed: u64,
    /// Threads [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    #[command(flatten)]
    tiles: TileArgs,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        progress::use_threads(self.threads)?;
        let dataset = Dataset::open(&self.dataset)?;
        let manifest = dataset.manifest();
        let configuration = &manifest.configuration;
        let named = self.tiles.open_for(self.maps.as_ref(), configuration)?;
        let maps = named.or_else(|| MapSource::of_dataset(configuration));
        let verify = Verify {
            maps,
            sample: self.sample,
            seed: self.seed,
        };
        let bar = Bar::default();
        let control = bar.control(&[])?;
        let mut printed = Ok(());
        let verified = verify.run(&dataset, &control, &mut |finding| {
            let said = bar.suspend(|| say!("{finding}"));
            if printed.is_ok() {
                printed = said;
            }
        });
        let place = self.dataset.display();
        let verified = verified.map_err(|error| match error {
            map2aps::Error::Settings(SettingsError::NoMaps) => {
                anyhow::anyhow!("{error}: give {}", wanted_maps(configuration))
            }
            error => error.into(),
        });
        let verified = verified.with_context(|| format!("data set '{place}'"))?;
        bar.clear();
        printed?;
        if verified.findings > 0 {
            bail!("{} findings in '{place}'", verified.findings);
        }
        let anew = match &verify.maps {
            None => format!("maps not looked at: give {}", wanted_maps(configuration)),
            Some(_) => format!("{} links computed anew", verified.sampled),
        };
        say!(
            "'{place}' is as it should be: {}, {} links, {} bytes; {anew}",
            counted(manifest.totals.maps, "map", "maps"),
            manifest.totals.links,
            manifest.totals.bytes
        )
    }
}
