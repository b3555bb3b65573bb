//! `cargo xtask dataset merge`: joins shards into the data set that one run would have made.

use std::path::PathBuf;

use anyhow::Result;
use map2aps::{counted, merge};

use crate::command_line;
use crate::progress::Bar;
use crate::say;

/// Join what shards made into what one run would have made, byte for byte.
///
/// The data set holds every map that any of the folders holds or was to hold.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folders of the shards; none if all of them worked in the folder given by --out.
    folders: Vec<PathBuf>,
    /// Folder of the data set; an unfinished one is continued.
    #[arg(long)]
    out: PathBuf,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let bar = Bar::default();
        let command = command_line::own_without(&["--out"]);
        let control = bar.control(&command)?;
        let totals = merge(&self.folders, &self.out, &control)?;
        bar.clear();
        say!(
            "{}, {} links, {} bytes in data set '{}'",
            counted(totals.maps, "map", "maps"),
            totals.links,
            totals.bytes,
            self.out.display()
        )
    }
}
