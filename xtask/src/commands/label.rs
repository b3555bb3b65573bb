//! `cargo xtask label`: labels for path lists from anywhere.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use aps_data::{PartialFile, npy};
use aps_label::{LabelConfig, Labeler};

use map2aps::path_list::LinkList;

use crate::args::{DelayArgs, LabelArgs};
use crate::note;
use crate::output;

/// Make labels for path lists from anywhere: one row a link, dB, f64.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Paths in the JSON of `trace`; only delay_s, arrival_azimuth_rad (towards the source) and
    /// gain_db are needed.
    #[arg(long)]
    paths: PathBuf,
    #[command(flatten)]
    label: LabelArgs,
    #[command(flatten)]
    delays: DelayArgs,
    /// APS file to write: .npy, (links, 180), dB.
    #[arg(long)]
    out: PathBuf,
    /// PDP file to write: .npy, (links, delay points), dB.
    #[arg(long)]
    pdp: Option<PathBuf>,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        ensure!(
            self.pdp.as_ref() != Some(&self.out),
            "--out and --pdp are both '{}'; give each a file of its own",
            self.out.display()
        );
        let outputs = || [Some(&self.out), self.pdp.as_ref()].into_iter().flatten();
        // A file that is not there is no other's.
        let is_paths = |file: &PathBuf| {
            let [file, paths] = [file, &self.paths].map(|file| file.canonicalize().ok());
            file.is_some() && file == paths
        };
        ensure!(
            !outputs().any(is_paths),
            "'{}' holds the paths; write the labels to another file",
            self.paths.display()
        );
        let place = || format!("paths '{}'", self.paths.display());
        let file = File::open(&self.paths).with_context(place)?;
        let list = LinkList::read(BufReader::new(file)).with_context(place)?;
        let labeler = Labeler::new(&self.config())?;
        for file in outputs() {
            output::make_folder_of(file)?;
        }
        let labels = list.label(&labeler).with_context(place)?;
        let links = list.links.len();
        write_npy(
            &self.out,
            &labels.aps_db,
            [links, labeler.angles_deg().len()],
        )?;
        if let Some(file) = &self.pdp {
            write_npy(file, &labels.pdp_db, [links, labeler.delays_s().len()])?;
        }
        note!("{links} labels in '{}'", self.out.display());
        Ok(())
    }

    fn config(&self) -> LabelConfig {
        let own = self.label.config(self.pdp.is_some());
        LabelConfig {
            delay_axis: self.delays.over(own.delay_axis),
            ..own
        }
    }
}

fn write_npy(path: &Path, values: &[f64], shape: [usize; 2]) -> Result<()> {
    let (partial, mut file) = PartialFile::create(path)?;
    let written = npy::write_to(&mut file, &shape, values);
    written.with_context(|| format!("cannot write '{}'", path.display()))?;
    Ok(partial.complete(file)?)
}
