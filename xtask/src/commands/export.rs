//! `cargo xtask export`: a data set as the files of the published data.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result, bail, ensure};
use aps_data::released::LinkName;
use aps_data::{Dataset, MapData, Part, replace_unsynced};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::maps::{IdList, choose};
use crate::say;

mod released;
mod samples;

/// Kept in the folder, so that one export is not continued by another.
const RECORD_FILE: &str = "export.json";

/// Forms of export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// map_N/N_adps/{aps,pdp}/*.npy: labels with the places of their maxima, half precision.
    Released,
    /// samples/*.npz: normalised labels with their condition images, as models train on them.
    Samples,
}

/// Parts of a split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PartName {
    Train,
    Develop,
    Test,
}

/// Write a data set as the files of the published data: one or two a link.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the data set.
    data: PathBuf,
    /// Form of the files.
    #[arg(long, value_enum)]
    layout: Layout,
    /// Folder to write to; files that are there are kept, so that the same command continues.
    #[arg(long)]
    out: PathBuf,
    /// Only the maps of one part of the split.
    #[arg(long, value_enum)]
    part: Option<PartName>,
    /// Only these maps, like 0-4,7.
    #[arg(long)]
    map_ids: Option<IdList>,
    /// At most so many links in all.
    #[arg(long)]
    limit: Option<usize>,
    /// Export labels of another protocol than the released one as they are.
    #[arg(long)]
    any_protocol: bool,
    /// Write 0 for the places of maxima where neither they nor the paths are stored.
    #[arg(long)]
    zero_places: bool,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

/// Writes the files of one map's links.
trait Exporter: Sync {
    /// Buffers of one thread.
    type Scratch: Default;

    /// Folders that must be there.
    fn folders(&self, map: u32) -> Vec<PathBuf>;

    /// Writes the files of one link that are not there; returns the bytes written.
    fn link(
        &self,
        link: usize,
        name: &LinkName,
        out: &Path,
        scratch: &mut Self::Scratch,
    ) -> Result<u64>;
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        if let Some(threads) = self.threads {
            ensure!(threads > 0, "--threads must be at least 1");
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global()?;
        }
        let dataset = Dataset::open(&self.data)?;
        self.check_protocol(&dataset)?;
        let ids = self.map_ids(&dataset)?;
        self.record(&dataset)?;
        let progress = progress_bar(self.links(&dataset, &ids));
        let written = AtomicU64::new(0);
        let mut left = self.limit.unwrap_or(usize::MAX);
        let mut names = Vec::new();
        for id in ids {
            if left == 0 {
                break;
            }
            let map = dataset.map(id)?;
            let mut links = names_of(&map)?;
            links.truncate(left);
            left -= links.len();
            progress.set_message(format!("map {id}"));
            let bytes = match self.layout {
                Layout::Released => {
                    let exporter = released::Released::new(&dataset, &map, self.zero_places)?;
                    self.export(&exporter, id, &links, &progress)?
                }
                Layout::Samples => {
                    let exporter = samples::Samples::new(&map)?;
                    samples::write_buildings(&map, &self.out)?;
                    self.export(&exporter, id, &links, &progress)?
                }
            };
            written.fetch_add(bytes, Ordering::Relaxed);
            names.extend(links.into_iter().map(|(_, name)| name));
        }
        if self.layout == Layout::Samples {
            samples::write_table(&names, &self.out)?;
        }
        progress.finish_and_clear();
        say!(
            "{} links in '{}', {:.1} MB written",
            names.len(),
            self.out.display(),
            written.into_inner() as f64 / 1e6
        )?;
        Ok(())
    }

    fn export<E: Exporter>(
        &self,
        exporter: &E,
        map: u32,
        links: &[(usize, LinkName)],
        progress: &ProgressBar,
    ) -> Result<u64> {
        for folder in exporter.folders(map) {
            let folder = self.out.join(folder);
            fs::create_dir_all(&folder)
                .with_context(|| format!("cannot create '{}'", folder.display()))?;
        }
        links
            .par_iter()
            .map_init(E::Scratch::default, |scratch, (link, name)| {
                let bytes = exporter.link(*link, name, &self.out, scratch);
                progress.inc(1);
                bytes.with_context(|| format!("map {map}, link {link}"))
            })
            .try_reduce(|| 0, |a, b| Ok(a + b))
    }

    fn check_protocol(&self, dataset: &Dataset) -> Result<()> {
        let found = dataset.manifest().configuration["label"]["protocol"].as_str();
        ensure!(
            self.any_protocol || found == Some("released"),
            "the labels follow the protocol {}, the published data `released`; make labels of that protocol, or give --any-protocol",
            found.map_or("of nobody knows what".into(), |name| format!("`{name}`"))
        );
        Ok(())
    }

    fn map_ids(&self, dataset: &Dataset) -> Result<Vec<u32>> {
        let manifest = dataset.manifest();
        let available = match self.part {
            None => manifest.maps.iter().map(|map| map.id).collect(),
            Some(PartName::Train) => manifest.split.maps(Part::Train).to_vec(),
            Some(PartName::Develop) => manifest.split.maps(Part::Develop).to_vec(),
            Some(PartName::Test) => manifest.split.maps(Part::Test).to_vec(),
        };
        match &self.map_ids {
            Some(chosen) => choose(&available, chosen),
            None => Ok(available),
        }
    }

    fn links(&self, dataset: &Dataset, ids: &[u32]) -> u64 {
        let maps = dataset
            .manifest()
            .maps
            .iter()
            .filter(|map| ids.contains(&map.id));
        let valid: u64 = maps.filter_map(|map| map.status.get("valid")).sum();
        valid.min(self.limit.map_or(u64::MAX, |limit| limit as u64))
    }

    /// Notes what is exported, or refuses to go on with another export.
    fn record(&self, dataset: &Dataset) -> Result<()> {
        let manifest = dataset.manifest();
        let name = self
            .layout
            .to_possible_value()
            .expect("no variant is hidden");
        let record = json!({
            "layout": name.get_name(),
            "seed": manifest.seed,
            "stored": manifest.layout,
            "configuration": manifest.configuration,
        });
        fs::create_dir_all(&self.out)
            .with_context(|| format!("cannot create '{}'", self.out.display()))?;
        let path = self.out.join(RECORD_FILE);
        match fs::read(&path) {
            Ok(bytes) => {
                let found: Value = serde_json::from_slice(&bytes).unwrap_or_default();
                // Through text, as the stored one went.
                let given: Value = serde_json::from_slice(&serde_json::to_vec(&record)?)?;
                if found != given {
                    bail!(
                        "'{}' is of another export; give another folder",
                        path.display()
                    );
                }
                Ok(())
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(replace_unsynced(
                &path,
                &serde_json::to_vec_pretty(&record)?,
            )?),
            Err(error) => Err(error).with_context(|| format!("cannot read '{}'", path.display())),
        }
    }
}

/// The links with a label and the names of their files, which must differ.
fn names_of(map: &MapData) -> Result<Vec<(usize, LinkName)>> {
    let mut seen = HashSet::new();
    map.valid_links()
        .map(|link| {
            let (tx, rx) = map.ends_m(link);
            let place = || format!("map {}, link {link} from {tx:?} to {rx:?} m", map.id);
            let name = LinkName::of(map.id, tx, rx).with_context(|| format!("{}: too far away for a name", place()))?;
            ensure!(
                seen.insert(name),
                "{}: another link has the same places in whole metres, so the same file name {name}",
                place()
            );
            Ok((link, name))
        })
        .collect()
}

fn progress_bar(links: u64) -> ProgressBar {
    let style = ProgressStyle::with_template(
        "{msg:8} [{bar:40}] {human_pos}/{human_len} links, {per_sec}, {eta} left",
    )
    .expect("the template is well formed")
    .progress_chars("=> ");
    ProgressBar::new(links).with_style(style)
}
