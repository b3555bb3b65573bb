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
    pub links: usize,
}

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

impl About<'_> {
    /// The parts that have files.
    pub fn parts(&self) -> impl Iterator<Item = Part> {
        let has_files = |part: &Part| self.written.iter().any(|file| file.part == Some(*part));
        Part::ALL.into_iter().filter(has_files)
    }

    /// The card: a header in YAML, then Markdown.
    pub fn card(&self) -> String {
        let manifest = self.dataset.manifest();
        let mut text = String::from(
            "---\npretty_name: Angle power spectra of city maps\nlicense: other\ntags:\n- radio\n- ray-tracing\n\
             - angle-power-spectrum\nconfigs:\n- config_name: links\n  default: true\n  data_files:\n",
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
             | split | maps | files | bytes |\n|---|---|---|---|\n",
            self.links,
            self.maps(None),
            env!("CARGO_PKG_VERSION")
        );
        for part in self.parts() {
            let files = || self.written.iter().filter(|file| file.part == Some(part));
            let bytes: u64 = files().map(|file| file.bytes).sum();
            let _ = writeln!(
                text,
                "| {} | {} | {} | {bytes} |",
                split_of(part),
                self.maps(Some(part)),
                files().count()
            );
        }
        text += "\n## Columns\n\nA row is a link.\n\n| column | type | unit | meaning |\n|---|---|---|---|\n";
        for column in self.columns {
            let kind = type_of(&column.values);
            let _ = writeln!(
                text,
                "| `{}` | {kind} | {} | {} |",
                column.name, column.unit, column.meaning
            );
        }
        if let Some(aps) = manifest.layout.aps {
            let (first, last) = (aps.axis.values().next(), aps.axis.values().last());
            let _ = write!(
                text,
                "\n`aps_db` has {} bins, from {} to {} deg in equal steps, counter-clockwise from x.",
                aps.axis.count,
                first.unwrap_or_default(),
                last.unwrap_or_default()
            );
        }
        let _ = write!(
            text,
            " Values of a link whose `status` is not `valid` mean nothing. `buildings.parquet` has the image of each map's buildings \
             under its number.\n\n## How it was made\n\nMaps: {}. Carrier: {} Hz. At most {} reflections, {} of diffraction and {} \
             interactions on a path. Labels: protocol {}, array {}. Seed: {}. All settings:\n\n```json\n{}\n```\n\n## Licence\n\n\
             The spectra follow from the maps: whoever passes them on needs the maps' licence, and names it in the header above. \
             Synthetic maps have none.\n\n## Citation\n\nName the authors of the maps, and map2aps {} with the settings above.\n",
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
