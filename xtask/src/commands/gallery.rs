//! `cargo xtask gallery`: a data set on one page, its links to look at and its statistics.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use aps_data::Profile;
use aps_label::Labeler;
use aps_report::document::{Block, Document, Section};
use aps_report::gallery::{Exhibit, LEGEND, Statistics};
use aps_report::link::{LinkView, Spectrum, dominant_peaks};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::args::{MapsArg, TileArgs};
use crate::progress;
use crate::say;
use crate::source::{LinkId, Source, SourceMap};

/// Random streams of the two choices, so that one does not depend on the size of the other.
const LINK_STREAM: u64 = 0;
const SAMPLE_STREAM: u64 = 1;

/// Show a data set on one page: links with maps, paths and spectra, and statistics.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a data set.
    dataset: PathBuf,
    /// Page to write.
    #[arg(long, default_value = "gallery.html")]
    out: PathBuf,
    /// Links to show: MAP,TX,RX, the rows of transmitter and receiver [default: random ones].
    #[arg(long, num_args = 1..)]
    links: Vec<LinkId>,
    /// Number of random links to show.
    #[arg(long, default_value_t = 12)]
    count: usize,
    /// Links that the statistics are taken from, drawn from all maps.
    #[arg(long, default_value_t = 20_000)]
    sample: usize,
    /// The maps the data set was made from: a folder of RadioMapSeer files, or the GeoJSON file of
    /// the city, which is cut as it was. Gives paths where none are stored, and exact walls.
    /// Synthetic ones are found without.
    #[arg(long)]
    maps: Option<MapsArg>,
    /// Seed of the random choices.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    #[command(flatten)]
    tiles: TileArgs,
}

/// Rows of a map that are needed.
#[derive(Default)]
struct Wanted {
    shown: Vec<usize>,
    sampled: Vec<usize>,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let source = Source::open(&self.dataset, self.maps.as_ref(), &self.tiles)?;
        let manifest = source.dataset().manifest();
        let valid = |map: &aps_data::MapEntry| map.status.get("valid").copied().unwrap_or(0);
        let counts: Vec<(u32, u64)> = manifest.maps.iter().map(|m| (m.id, valid(m))).collect();
        let sampled = shares(&counts, self.sample as u64, &mut self.random(SAMPLE_STREAM));
        let shown = match self.links.is_empty() {
            true => shares(&counts, self.count as u64, &mut self.random(LINK_STREAM)),
            false => BTreeMap::new(),
        };

        let progress = progress::bar(counts.len() as u64, "maps");
        let totals = &manifest.totals;
        let (maps, status) = (totals.maps, totals.status.clone());
        let mut statistics = Statistics::new(source.label().protocol, maps, totals.links, status);
        let labeler = Labeler::new(source.label())?;
        let mut gallery = Section::new("Links");
        gallery.text(LEGEND);
        let mut exhibits = 0;
        for &(id, _) in &counts {
            progress.set_message(format!("map {id}"));
            let asked: Vec<&LinkId> = self.links.iter().filter(|l| l.map == id).collect();
            let (n_shown, n_sampled) = (shown.get(&id), sampled.get(&id));
            if asked.is_empty() && n_shown.is_none() && n_sampled.is_none() {
                progress.inc(1);
                continue;
            }
            let map = source.map(id)?;
            let rows: Vec<usize> = map.data.valid_links().collect();
            let draw = |n: Option<&u64>, stream: u64| {
                let mut rng = self.random(stream);
                rng.set_word_pos((u128::from(id) + 1) << 32);
                choose(&rows, n.copied().unwrap_or(0) as usize, &mut rng)
            };
            let mut wanted = Wanted {
                shown: draw(n_shown, LINK_STREAM),
                sampled: draw(n_sampled, SAMPLE_STREAM),
            };
            for link in asked {
                wanted.shown.push(map.row_of(link.tx, link.rx)?);
            }
            let views = map.links(&wanted.sampled)?;
            for (&row, view) in wanted.sampled.iter().zip(&views) {
                let peaks = peaks(&labeler, &map, row, view)?;
                statistics.add(view, peaks, map.has_paths());
            }
            let views = map.links(&wanted.shown)?;
            for (&row, view) in wanted.shown.iter().zip(&views) {
                exhibit(&source, &map, row, view)?.show(&mut gallery)?;
                exhibits += 1;
            }
            progress.inc(1);
        }
        progress.finish_and_clear();
        for link in &self.links {
            ensure!(
                counts.iter().any(|c| c.0 == link.map),
                "the data set has no map {}; it has {:?}",
                link.map,
                counts.iter().map(|c| c.0).collect::<Vec<_>>()
            );
        }
        let name = self
            .dataset
            .file_name()
            .map(|n| n.to_string_lossy().into_owned());
        let page = Document::new(format!("Data set {}", name.unwrap_or_default()))
            .lead(statistics.summary())
            .section(statistics.section())
            .section(gallery)
            .section(settings(&source)?);
        page.save_html(&self.out)?;
        say!(
            "{exhibits} links of '{}' on '{}'",
            self.dataset.display(),
            self.out.display()
        )?;
        Ok(())
    }

    fn random(&self, stream: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(stream);
        rng
    }
}

/// Dominant peaks of a link: of its stored spectrum, or of the one that its paths make.
fn peaks(labeler: &Labeler, map: &SourceMap, row: usize, link: &LinkView) -> Result<Option<usize>> {
    let protocol = labeler.config().protocol;
    let peaks = match &map.data.aps {
        Some(aps) => Some(dominant_peaks(&relative_db(aps, row), protocol)),
        None => Spectrum::of(labeler, &link.samples())?.map(|s| s.dominant_peaks()),
    };
    Ok(peaks.map(|peaks| peaks.dominant().len()))
}

fn relative_db(profile: &Profile, row: usize) -> Vec<f64> {
    let mut relative = vec![0.0; profile.bins()];
    profile.read_relative_db(row, &mut relative);
    relative.into_iter().map(f64::from).collect()
}

fn exhibit<'a>(
    source: &'a Source,
    map: &'a SourceMap,
    row: usize,
    link: &'a LinkView,
) -> Result<Exhibit<'a>> {
    let [tx, rx] = map.data.links[row];
    let status = map.data.status[row];
    Ok(Exhibit {
        title: format!("Map {}, transmitter {tx}, receiver {rx}", map.data.id),
        outlines: &map.outlines,
        link,
        label: source.label(),
        no_label: (!status.is_valid()).then(|| status.to_string()),
        has_paths: map.has_paths(),
        fallback: map.data.fallback[row],
        stored: match status.is_valid() && link.paths.is_empty() {
            true => Some(stored(source, map, row)?),
            false => None,
        },
    })
}

/// The stored spectrum of a link, over the power sent.
fn stored(source: &Source, map: &SourceMap, row: usize) -> Result<Spectrum> {
    let layout = source.dataset().manifest().layout;
    let protocol = source.label().protocol;
    let absolute = |profile: &Profile| {
        let top_db = f64::from(profile.max_db()[row]) - protocol.sent_power_db();
        let relative = relative_db(profile, row).into_iter();
        relative.map(move |db| top_db + db)
    };
    let aps = map.data.aps.as_ref().zip(layout.aps);
    let pdp = match layout.pdp {
        None => Vec::new(),
        Some(layout) => {
            let powers = source.dataset().pdp(map.data.id)?;
            let points = layout.axis.values().zip(absolute(&powers));
            points.map(|(ns, db)| [ns, db]).collect()
        }
    };
    Ok(Spectrum {
        protocol,
        angles_deg: aps.map_or(Vec::new(), |(_, aps)| aps.axis.values().collect()),
        aps_db: aps.map_or(Vec::new(), |(aps, _)| absolute(aps).collect()),
        delay_s: Vec::new(),
        pdp,
    })
}

/// Numbers of `n` links, drawn without replacement, that fall on each map that has some.
fn shares(counts: &[(u32, u64)], n: u64, rng: &mut ChaCha8Rng) -> BTreeMap<u32, u64> {
    let mut left: Vec<(u32, u64)> = counts.to_vec();
    let mut total: u64 = left.iter().map(|c| c.1).sum();
    let mut drawn = BTreeMap::new();
    for _ in 0..n.min(total) {
        let mut ticket = rng.random_range(0..total);
        for (id, count) in &mut left {
            if ticket < *count {
                *count -= 1;
                *drawn.entry(*id).or_default() += 1;
                break;
            }
            ticket -= *count;
        }
        total -= 1;
    }
    drawn
}

/// Some of the rows, each at most once, in ascending order.
fn choose(rows: &[usize], n: usize, rng: &mut ChaCha8Rng) -> Vec<usize> {
    let mut rows = rows.to_vec();
    let n = n.min(rows.len());
    for i in 0..n {
        let j = rng.random_range(i..rows.len());
        rows.swap(i, j);
    }
    rows.truncate(n);
    rows.sort_unstable();
    rows
}

fn settings(source: &Source) -> Result<Section> {
    let manifest = source.dataset().manifest();
    let mut section = Section::new("Settings");
    section.text("As the manifest keeps them.");
    let text = serde_json::to_string_pretty(&serde_json::json!({
        "seed": manifest.seed,
        "layout": manifest.layout,
        "configuration": manifest.configuration,
    }))?;
    let title = "Show".into();
    section.blocks.push(Block::Folded { title, text });
    Ok(section)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_without_replacement_and_repeatable() {
        let counts = [(0, 3), (4, 0), (7, 1000)];
        let rng = || ChaCha8Rng::seed_from_u64(1);
        let drawn = shares(&counts, 100, &mut rng());
        assert_eq!(drawn, shares(&counts, 100, &mut rng()));
        assert_eq!(drawn.values().sum::<u64>(), 100);
        let all = shares(&counts, u64::MAX, &mut rng());
        assert_eq!(all, BTreeMap::from([(0, 3), (7, 1000)]));
        let rows: Vec<usize> = (10..20).collect();
        assert_eq!(choose(&rows, 99, &mut rng()), rows);
        let some = choose(&rows, 4, &mut rng());
        assert!(
            some.len() == 4 && some.is_sorted_by(|a, b| a < b),
            "{some:?}"
        );
    }
}
