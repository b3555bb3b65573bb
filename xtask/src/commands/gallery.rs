//! `cargo xtask gallery`: a data set on one page, its links to look at and its statistics.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use aps_data::Profile;
use aps_label::Labeler;
use aps_report::document::{Block, Document, Section};
use aps_report::gallery::{LinkPanel, Statistics, legend};
use aps_report::link::{LinkView, Spectrum, dominant_peaks};
use map2aps::maps::NamedMaps;
use map2aps::sampling::{SEED, draw_links};

use crate::args::TileArgs;
use crate::output;
use crate::progress;
use crate::say;
use crate::source::{LinkId, Source, SourceMap};

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
    maps: Option<NamedMaps>,
    /// Seed of the random choices.
    #[arg(long, default_value_t = SEED)]
    seed: u64,
    #[command(flatten)]
    tiles: TileArgs,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let source = Source::open(&self.dataset, self.maps.as_ref(), &self.tiles)?;
        output::make_folder_of(&self.out)?;
        let manifest = source.dataset().manifest();
        let counts = || {
            let maps = manifest.maps.iter();
            maps.map(|map| (map.id, map.valid() as usize))
        };
        let sampled = draw_links(counts(), self.sample, self.seed);
        let shown = match self.links.is_empty() {
            true => draw_links(counts(), self.count, self.seed.wrapping_add(1)),
            false => BTreeMap::new(),
        };

        let progress = progress::bar(manifest.maps.len() as u64, "maps");
        let mut statistics = Statistics::new(source.label().protocol, manifest.totals.clone());
        let labeler = Labeler::new(source.label())?;
        let mut gallery = Section::new("Links");
        let mut has_paths = false;
        let mut exhibits = 0;
        for (id, _) in counts() {
            progress.set_message(format!("map {id}"));
            progress.inc(1);
            let asked: Vec<&LinkId> = self.links.iter().filter(|l| l.map == id).collect();
            if asked.is_empty() && !shown.contains_key(&id) && !sampled.contains_key(&id) {
                continue;
            }
            let map = source.map(id)?;
            has_paths |= map.map.has_paths();
            let valid: Vec<usize> = map.map.data.valid_links().collect();
            let rows = |drawn: &BTreeMap<u32, Vec<usize>>| -> Vec<usize> {
                let places = drawn.get(&id).into_iter().flatten();
                places.map(|&place| valid[place]).collect()
            };
            let (mut shown, sampled) = (rows(&shown), rows(&sampled));
            for link in asked {
                shown.push(map.row_of(link.tx, link.rx)?);
            }
            for (&row, view) in sampled.iter().zip(&map.links(&sampled)?) {
                let peaks = peaks(&labeler, &map, row, view)?;
                statistics.add(view, peaks, map.map.has_paths());
            }
            for (&row, view) in shown.iter().zip(&map.links(&shown)?) {
                exhibit(&source, &map, row, view)?.show(&mut gallery)?;
                exhibits += 1;
            }
        }
        progress.finish_and_clear();
        for link in &self.links {
            ensure!(
                counts().any(|(id, _)| id == link.map),
                "the data set has no map {}; it has {:?}",
                link.map,
                counts().map(|(id, _)| id).collect::<Vec<_>>()
            );
        }
        let reading = legend(source.label(), has_paths);
        gallery.blocks.insert(0, Block::Text(reading));
        let name = self
            .dataset
            .file_name()
            .map(|n| n.to_string_lossy().into_owned());
        let page = Document::new(format!("Data set {}", name.unwrap_or_default()))
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
}

/// Dominant peaks of a link: of its stored spectrum, or of the one that its paths make.
fn peaks(labeler: &Labeler, map: &SourceMap, row: usize, link: &LinkView) -> Result<Option<usize>> {
    let protocol = labeler.config().protocol;
    let peaks = match &map.map.data.aps {
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
) -> Result<LinkPanel<'a>> {
    let [tx, rx] = map.map.data.links[row];
    let status = map.map.data.status[row];
    Ok(LinkPanel {
        title: format!("Map {}, transmitter {tx}, receiver {rx}", map.map.data.id),
        outlines: &map.outlines,
        link,
        label: source.label(),
        no_label: (!status.is_valid()).then(|| status.to_string()),
        has_paths: map.map.has_paths(),
        fallback: map.map.data.fallback[row],
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
    let aps = map.map.data.aps.as_ref().zip(layout.aps);
    let pdp = match layout.pdp {
        None => Vec::new(),
        Some(layout) => {
            let powers = source.dataset().pdp(map.map.data.id)?;
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
