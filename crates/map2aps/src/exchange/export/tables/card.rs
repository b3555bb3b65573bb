//! The card of the tables, as hubs of data sets show it.

use aps_data::{Dataset, Part};

use super::columns::{Column, folder_of};
use super::written::Written;

/// Everything that the card and the description tell.
pub struct About<'a> {
    pub dataset: &'a Dataset,
    pub written: &'a [Written],
    /// Columns of the links, without rows.
    pub columns: &'a [Column],
    /// Columns of the images of the buildings, without rows.
    pub buildings: &'a [Column],
    pub links: usize,
}

/// The paper that defines the benchmark, in BibTeX. Its year is not stated in it.
pub const CITATION: &str = "@misc{map2aps,
  title = {{Map2APS}: A Physically Grounded Benchmark for Direct Angle Power Spectrum Prediction from Urban Geometry},
  author = {Junxi Huang and Xiucheng Wang and Nan Cheng and Kailong Wang and Ruijin Sun and Zhisheng Yin},
  url = {https://github.com/UNIC-Lab/aps-data},
}";

/// Placeholder for the licence of the maps, which whoever passes the tables on puts in.
pub const LICENCE: &str = "licence-of-the-maps";

/// Name of a part as hubs know it.
pub fn split_of(part: Part) -> &'static str {
    match part {
        Part::Train => "train",
        Part::Develop => "validation",
        Part::Test => "test",
    }
}

/// Number of rows as hubs sort data sets by it.
fn size_of(links: usize) -> &'static str {
    match links {
        0..1_000 => "n<1K",
        1_000..10_000 => "1K<n<10K",
        10_000..100_000 => "10K<n<100K",
        100_000..1_000_000 => "100K<n<1M",
        1_000_000..10_000_000 => "1M<n<10M",
        10_000_000..100_000_000 => "10M<n<100M",
        _ => "100M<n<1B",
    }
}

/// A table of columns: name, type, unit and meaning of each.
fn table_of(columns: &[Column]) -> String {
    let mut text = String::from("| column | type | unit | meaning |\n|---|---|---|---|\n");
    for column in columns {
        let (name, values) = (column.name, &column.values);
        let list = if values.are_lists() { "list of " } else { "" };
        let [_, kind, _] = values.types();
        let (unit, meaning) = (column.unit, column.meaning);
        text += &format!("| `{name}` | {list}{kind} | {unit} | {meaning} |\n");
    }
    text
}

impl About<'_> {
    /// The parts that have files.
    pub fn parts(&self) -> impl Iterator<Item = Part> {
        let has_files = |part: &Part| self.written.iter().any(|file| file.part == Some(*part));
        Part::ALL.into_iter().filter(has_files)
    }

    /// The card: a header in YAML, then Markdown.
    pub fn card(&self) -> String {
        let manifest = self.dataset.manifest();
        let setting = |pointer: &str| {
            let found = manifest.configuration.pointer(pointer);
            found.map_or("unknown".into(), ToString::to_string)
        };
        let (mut files_of_parts, mut splits) = (String::new(), String::new());
        for part in self.parts() {
            let (split, folder) = (split_of(part), folder_of(Some(part)));
            files_of_parts += &format!("  - split: {split}\n    path: data/{folder}/*.parquet\n");
            let files = || self.written.iter().filter(|file| file.part == Some(part));
            let bytes: u64 = files().map(|file| file.bytes).sum();
            let links: usize = files().map(|file| file.rows).sum();
            let (maps, files) = (self.maps(Some(part)), files().count());
            splits += &format!("| {split} | {maps} | {links} | {files} | {bytes} |\n");
        }
        let bins = manifest.layout.aps.map(|aps| {
            let (first, last) = (aps.axis.values().next(), aps.axis.values().last());
            format!(
                "`aps_db` has {} bins, from {} to {} deg in equal steps, counter-clockwise from x. ",
                aps.axis.count,
                first.unwrap_or_default(),
                last.unwrap_or_default()
            )
        });
        format!(
            include_str!("card.txt"),
            licence = LICENCE,
            size = size_of(self.links),
            files = files_of_parts,
            links = self.links,
            maps = self.maps(None),
            version = env!("CARGO_PKG_VERSION"),
            splits = splits,
            columns = table_of(self.columns),
            bins = bins.unwrap_or_default(),
            buildings = table_of(self.buildings),
            source = setting("/maps"),
            frequency_hz = setting("/trace/frequency_hz"),
            reflections = setting("/trace/max_reflections"),
            diffractions = setting("/trace/max_diffractions"),
            interactions = setting("/trace/max_interactions"),
            protocol = setting("/label/protocol"),
            array = setting("/label/array"),
            seed = manifest.seed,
            settings = serde_json::to_string_pretty(&manifest.configuration).unwrap_or_default(),
            citation = CITATION,
        )
    }

    /// Number of maps with files, of a part or in all.
    fn maps(&self, part: Option<Part>) -> usize {
        let first = |file: &&Written| !file.name.contains('-');
        let of_part = |file: &&Written| part.is_none() || file.part == part;
        self.written.iter().filter(first).filter(of_part).count()
    }
}
