//! `cargo xtask verify`: checks that a data set is as its manifest says.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use aps_data::{Dataset, Layout, MapEntry, Stored};
use indicatif::ProgressBar;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::maps::{self, MapSource, SceneSettings};
use crate::output;
use crate::progress;
use crate::say;
use crate::settings;
use crate::tiles::TileArgs;

mod contents;
mod recompute;

use recompute::Recomputation;

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
    maps: Option<MapSource>,
    /// Compute so many random links anew and compare them with what is stored [default: 100 if the maps can be had].
    #[arg(long)]
    sample: Option<usize>,
    /// Seed of the choice of links.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Threads [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    #[command(flatten)]
    tiles: TileArgs,
}

/// Prints and counts findings.
pub struct Findings {
    progress: ProgressBar,
    count: usize,
    /// Failure to tell one.
    output: Result<()>,
}

impl Findings {
    /// One line about one thing that is wrong.
    fn add(&mut self, finding: impl std::fmt::Display) {
        let line = finding.to_string().replace('\n', " ");
        let said = self.progress.suspend(|| say!("{line}"));
        if self.output.is_ok() {
            self.output = said;
        }
        self.count += 1;
    }
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        progress::use_threads(self.threads)?;
        let dataset = Dataset::open(&self.dataset)?;
        let manifest = dataset.manifest();
        let source = self.source(&dataset)?;
        let recomputation = match &source {
            Some(_) => Recomputation::new(&dataset)?,
            None => None,
        };
        let sample = match (self.sample, &recomputation) {
            (None, Some(_)) => 100,
            (None, None) | (Some(0), _) => 0,
            (Some(sample), Some(_)) => sample,
            (Some(_), None) => bail!(
                "links can be computed anew only from the maps of a data set that was traced here: {}",
                match source {
                    None => format!("give {}", maps::wanted(&manifest.configuration)),
                    Some(_) => "this one was imported; use --sample 0".into(),
                }
            ),
        };
        let scene = SceneSettings::of_dataset(&manifest.configuration)?;
        let mut chosen = choose(&manifest.maps, sample, self.seed);
        let mut findings = Findings {
            progress: progress::bar(manifest.totals.bytes, "bytes"),
            count: 0,
            output: Ok(()),
        };
        for problem in dataset.verify_manifest() {
            findings.add(output::told(&problem));
        }
        check_axes(&dataset, &mut findings);
        for entry in &manifest.maps {
            findings.progress.set_message(format!("map {}", entry.id));
            let links = chosen.remove(&entry.id).unwrap_or_default();
            let problems = dataset.verify_map(entry.id);
            // Findings computed from damaged files would only repeat the news.
            if problems.is_empty() {
                let map = dataset.map(entry.id)?;
                contents::check(&dataset, entry, &map, source.is_some(), &mut findings)?;
                if let Some(source) = &source {
                    let place = || format!("map {} of the maps given", entry.id);
                    let given = source
                        .load(entry.id, manifest.seed, scene)
                        .with_context(place)?;
                    let is_it = contents::check_against(&dataset, &map, &given, &mut findings)?;
                    if let Some(recomputation) = recomputation.as_ref().filter(|_| is_it) {
                        recomputation.check(entry, &map, &given, &links, &mut findings)?;
                    }
                }
            }
            for problem in problems {
                findings.add(output::told(&problem));
            }
            let bytes = entry.files.iter().map(|file| file.bytes).sum();
            findings.progress.inc(bytes);
        }
        findings.progress.finish_and_clear();
        findings.output?;
        let place = self.dataset.display();
        if findings.count > 0 {
            bail!("{} findings in '{place}'", findings.count);
        }
        let anew = match (&source, sample) {
            (None, _) => format!(
                "maps not looked at: give {}",
                maps::wanted(&manifest.configuration)
            ),
            (_, sample) => format!("{sample} links computed anew"),
        };
        say!(
            "'{place}' is as it should be: {} maps, {} links, {} bytes; {anew}",
            manifest.totals.maps,
            manifest.totals.links,
            manifest.totals.bytes
        )?;
        Ok(())
    }

    /// The maps, given or made anew; refuses others than those the data set was made of, as far as that can be told.
    fn source(&self, dataset: &Dataset) -> Result<Option<MapSource>> {
        let configuration = &dataset.manifest().configuration;
        let Some(maps) = self.maps.clone() else {
            let is_synthetic = configuration["maps"] == "synthetic";
            return Ok(is_synthetic.then_some(MapSource::Synthetic { count: None }));
        };
        let maps = maps.cut_for(&self.dataset, configuration, &self.tiles)?;
        Ok(Some(maps))
    }
}

/// Axes that contradict the label settings.
fn check_axes(dataset: &Dataset, findings: &mut Findings) {
    let manifest = dataset.manifest();
    let Layout {
        raster,
        aps,
        pdp,
        paths,
    } = manifest.layout;
    let Ok(label) = settings::label_of(&manifest.configuration) else {
        return;
    };
    let stored = Stored {
        aps: aps.is_some(),
        pdp: pdp.is_some(),
        paths,
    };
    let made = Layout::of_labels(&label, raster, stored);
    for (name, stored, made) in [("aps", aps, made.aps), ("pdp", pdp, made.pdp)] {
        let (stored, made) = (stored.map(|p| p.axis), made.map(|p| p.axis));
        if stored != made {
            findings.add(format!(
                "layout.{name}.axis is {stored:?}, the label settings make {made:?}"
            ));
        }
    }
}

type Chosen = std::collections::BTreeMap<u32, Vec<usize>>;

/// Links drawn without replacement from all maps, by map, in ascending order.
fn choose(maps: &[MapEntry], sample: usize, seed: u64) -> Chosen {
    let total: usize = maps.iter().map(|map| map.links).sum();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = std::collections::BTreeSet::new();
    // Floyd's sampling (Bentley and Floyd, CACM 30(9), 1987): no list of all links is made.
    for last in total.saturating_sub(sample)..total {
        let link = rng.random_range(0..=last);
        if !drawn.insert(link) {
            drawn.insert(last);
        }
    }
    let mut chosen = Chosen::new();
    let mut maps = maps.iter();
    let (mut map, mut first) = (maps.next(), 0);
    for link in drawn {
        while let Some(entry) = map
            && link >= first + entry.links
        {
            first += entry.links;
            map = maps.next();
        }
        let entry = map.expect("links were drawn from those of the maps");
        chosen.entry(entry.id).or_default().push(link - first);
    }
    chosen
}
