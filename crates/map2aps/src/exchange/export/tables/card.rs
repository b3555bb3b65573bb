//! The card of the tables, as hubs of data sets show it.

use std::fmt::Write;

use aps_data::{Dataset, Part};

use super::Written;
use super::columns::{Column, Values, folder_of};

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

/// Names of the columns' types.
pub fn type_of(values: &Values) -> &'static str {
    match values {
        Values::Integers(_) => "int32",
        Values::Floats(_) => "float32",
        Values::Doubles(_) => "float64",
        Values::Texts(_) => "string",
        Values::Bytes(_) => "binary",
        Values::FloatLists(..) => "list of float32",
        Values::DoubleLists(..) => "list of float64",
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
        let (kind, name) = (type_of(&column.values), column.name);
        let _ = writeln!(
            text,
            "| `{name}` | {kind} | {} | {} |",
            column.unit, column.meaning
        );
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
        let mut text = format!(
            "---\npretty_name: Angle power spectra of city maps\nlicense: other\nlicense_name: {LICENCE}\n\
             annotations_creators:\n- machine-generated\nsource_datasets:\n- original\nsize_categories:\n- {}\n\
             task_categories:\n- tabular-regression\ntags:\n- radio\n- ray-tracing\n- angle-power-spectrum\n\
             configs:\n- config_name: links\n  default: true\n  data_files:\n",
            size_of(self.links)
        );
        for part in self.parts() {
            let (split, folder) = (split_of(part), folder_of(Some(part)));
            text += &format!("  - split: {split}\n    path: data/{folder}/*.parquet\n");
        }
        text += "- config_name: buildings\n  data_files: buildings.parquet\n---\n\n# Angle power spectra of city maps\n\n";
        let configuration = &manifest.configuration;
        let setting = |pointer: &str| {
            configuration
                .pointer(pointer)
                .map_or("unknown".into(), ToString::to_string)
        };
        let _ = write!(
            text,
            "{} radio links in {} city maps, each with the angle power spectrum that its propagation paths make at a receiving \
             array. Written by map2aps {}.\n\n## Splits\n\nMaps are in one part alone. `develop` is called `validation` here.\n\n\
             | split | maps | links | files | bytes |\n|---|---|---|---|---|\n",
            self.links,
            self.maps(None),
            env!("CARGO_PKG_VERSION")
        );
        for part in self.parts() {
            let files = || self.written.iter().filter(|file| file.part == Some(part));
            let bytes: u64 = files().map(|file| file.bytes).sum();
            let links: usize = files().map(|file| file.rows).sum();
            let _ = writeln!(
                text,
                "| {} | {} | {links} | {} | {bytes} |",
                split_of(part),
                self.maps(Some(part)),
                files().count()
            );
        }
        text += "\n## Columns\n\nA row is a link.\n\n";
        text += &table_of(self.columns);
        text += "\n";
        if let Some(aps) = manifest.layout.aps {
            let (first, last) = (aps.axis.values().next(), aps.axis.values().last());
            let _ = write!(
                text,
                "`aps_db` has {} bins, from {} to {} deg in equal steps, counter-clockwise from x. ",
                aps.axis.count,
                first.unwrap_or_default(),
                last.unwrap_or_default()
            );
        }
        let _ = write!(
            text,
            "Values of a link whose `status` is not `valid` mean nothing.\n\nA row of `buildings.parquet` is a map:\n\n{}\n\
             ## How it was made\n\nMaps: {}. Carrier: {} Hz. At most {} reflections, {} diffractions and {} \
             interactions on a path. Labels: protocol {}, array {}. Seed: {}. All settings:\n\n```json\n{}\n```\n\n## Licence\n\n\
             The spectra follow from the maps: whoever passes them on needs the maps' licence, and names it in the header above \
             in place of `{LICENCE}`, with a `license_link` to its text, and in `croissant.json`. Synthetic maps have none.\n\n\
             ## Citation\n\nName the authors of the maps, and map2aps {} with the settings above. The benchmark is that of\n\n\
             ```bibtex\n{CITATION}\n```\n",
            table_of(self.buildings),
            setting("/maps"),
            setting("/trace/frequency_hz"),
            setting("/trace/max_reflections"),
            setting("/trace/max_diffractions"),
            setting("/trace/max_interactions"),
            setting("/label/protocol"),
            setting("/label/array"),
            manifest.seed,
            serde_json::to_string_pretty(configuration).unwrap_or_default(),
            env!("CARGO_PKG_VERSION"),
        );
        text
    }

    /// Number of maps with files, of a part or in all.
    fn maps(&self, part: Option<Part>) -> usize {
        let first = |file: &&Written| !file.name.contains('-');
        let of_part = |file: &&Written| part.is_none() || file.part == part;
        self.written.iter().filter(first).filter(of_part).count()
    }
}
