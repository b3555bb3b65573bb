//! The stored paths of a data set labelled anew.

use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use aps_data::{
    Access, Dataset, DatasetConfig, Layout, LinkStatus, Links, MapData, MapEntry, MapInput,
    PathTable, Stored,
};
use aps_label::{LabelConfig, Labeler, Status};

use super::builder::{DatasetBuilder, Made};
use super::map::Run;
use super::rows::Rows;
use crate::batch::Buffers;
use crate::control::Control;
use crate::error::{At, Place, Result};
use crate::maps::identity;
use crate::settings::{self, SettingsError};
use crate::tally::Tally;

/// Links labelled by one thread at a time.
const LINKS_AT_ONCE: usize = 500;

/// Makes a data set in the folder `out` with other labels for the links of `source`: another array, bandwidth, delay
/// grid or protocol, without a trace. Maps that the folder holds already are kept. [`LabelConfig::pdp`] of `label` is
/// taken from `stored`.
///
/// # Errors
/// A source without paths or that is damaged, settings out of range, a folder with a data set of other settings, and
/// cancellation: whole maps are then kept.
pub fn relabel(
    source: &Dataset,
    out: &Path,
    label: &LabelConfig,
    stored: Stored,
    control: &Control<'_>,
) -> Result<Made> {
    let manifest = source.manifest();
    if !manifest.layout.paths {
        return Err(SettingsError::NoPaths).at(Place::Dataset(source.root().into()));
    }
    if !stored.aps && !stored.pdp {
        return Err(SettingsError::NothingToLabel.into());
    }
    let label = LabelConfig {
        pdp: stored.pdp,
        ..label.clone()
    };
    let mut layout = Layout::of_labels(&label, manifest.layout.raster, stored);
    for (new, old) in [
        (&mut layout.aps, manifest.layout.aps),
        (&mut layout.pdp, manifest.layout.pdp),
    ] {
        if let (Some(new), Some(old)) = (new, old) {
            new.dtype = old.dtype;
        }
    }
    let mut configuration = manifest.configuration.clone();
    configuration["label"] = serde_json::to_value(&label)?;
    let config = DatasetConfig {
        seed: manifest.seed,
        layout,
        configuration,
    };
    let maps: Vec<u32> = manifest.maps.iter().map(|map| map.id).collect();
    let labeler = Labeler::new(&label)?;
    let builder = DatasetBuilder::open(out, config, labeler, &maps, Access::Whole)?;
    for there in builder.there() {
        let own = manifest.map(there.id);
        builder.must_have_outlines(&there, own.and_then(identity::stored_outlines))?;
        // What a relabelled map takes as it is.
        for name in ["buildings", "tx", "rx", "link_tx", "link_rx"].map(|n| format!("{n}.npy")) {
            let file = own.and_then(|own| own.files.iter().find(|file| file.name == name));
            let sha256 = file.map_or("", |file| &file.sha256);
            builder.must_have(&there, &name, sha256)?;
        }
    }
    let is_left = |map: &&MapEntry| builder.todo.contains(&map.id);
    let todo = manifest.maps.iter().filter(is_left);
    let links = todo.map(|map| map.links as u64).sum();
    let made = builder.run(links, control, |run, id| run.relabel(source, id))?;
    builder.writer.finish(&manifest.split)?;
    Ok(made)
}

impl Run<'_> {
    /// Labels the stored paths of one map; nothing of it stays on disk unless it is whole.
    fn relabel(&self, source: &Dataset, id: u32) -> Result<Tally> {
        let started = Instant::now();
        // Damage must not be given a new checksum.
        if let Some(problem) = source.verify_map(id).into_iter().next() {
            return Err(problem).at(Place::SourceMap(id));
        }
        let (map, paths) = (source.map(id)?, source.paths(id)?);
        let entry = source.manifest().map(id);
        let entry = entry.expect("the map was loaded");
        let mut tally = Tally {
            prepare: started.elapsed(),
            ..Tally::default()
        };
        let mut writer = self.writer.begin_map(
            id,
            &MapInput {
                buildings: &map.buildings,
                tx_m: &map.tx_m,
                rx_m: &map.rx_m,
                links: Links::WithRows,
            },
        )?;
        let ranges: Vec<Range<usize>> = (0..map.links.len())
            .step_by(LINKS_AT_ONCE)
            .map(|first| first..map.links.len().min(first + LINKS_AT_ONCE))
            .collect();
        self.write(&mut writer, &ranges, &mut tally, |links| {
            Ok(vec![self.label_links(&map, &paths, links.clone())?])
        })
        .at(Place::Map(id))?;
        let same_label = settings::label_of(&source.manifest().configuration)
            .is_ok_and(|label| label == *self.labeler.config());
        writer.set_statistics(tally.statistics_like(&entry.statistics, same_label));
        self.finish(writer, &mut tally)?;
        Ok(tally)
    }

    fn label_links(&self, map: &MapData, paths: &PathTable, links: Range<usize>) -> Result<Rows> {
        let mut rows = Rows::default();
        let mut buffers = Buffers::default();
        for link in links.clone() {
            self.control.check()?;
            let started = Instant::now();
            let labelled = buffers.label_stored(self.labeler, paths, link);
            let count = paths.paths_of(link).len();
            let status = match labelled.at(Place::Link(link))? {
                Status::Labelled => LinkStatus::Valid,
                Status::NoPath if count == 0 => map.status[link],
                Status::NoPath => LinkStatus::Unlabelled,
            };
            rows.tally.label += started.elapsed();
            let (ends, fallback) = (map.links[link], map.fallback[link]);
            rows.tally.stored_link(count, status, fallback);
            rows.push(self.labeler, ends, status, fallback, &buffers.label);
            rows.paths.push_link(paths, link);
        }
        rows.count_shapes(self.labeler, &self.writer.config().layout)?;
        self.control.progress.advance(links.len() as u64);
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use aps_data::Survey;

    use super::*;
    use crate::{DatasetPlan, synthetic};

    #[test]
    fn labels_of_another_source_are_not_put_beside_those_of_the_first() {
        let root = tempfile::tempdir().unwrap();
        let [own, other, out] = ["own", "other", "out"].map(|name| root.path().join(name));
        let stored = Stored {
            paths: true,
            ..Stored::default()
        };
        for (folder, seed) in [(&own, 42), (&other, 43)] {
            let plan = DatasetPlan {
                stored,
                seed,
                ..synthetic::plan(2, 1, 2)
            };
            plan.make(folder, &[0, 1], &Control::default()).unwrap();
            // So that nothing but the maps tells them apart.
            for name in ["manifest.json", "map_0000/map.json", "map_0001/map.json"] {
                let text = std::fs::read_to_string(folder.join(name)).unwrap();
                std::fs::write(
                    folder.join(name),
                    text.replace("\"seed\": 43", "\"seed\": 42"),
                )
                .unwrap();
            }
        }
        let [own, other] = [own, other].map(|folder| Dataset::open(folder).unwrap());
        let run = |source| {
            relabel(
                source,
                &out,
                &LabelConfig::paper(),
                stored,
                &Control::default(),
            )
        };
        run(&own).unwrap();
        let is_refused = || {
            let told = run(&other).unwrap_err().chain();
            let is_told = told.contains("map 0 in") && told.contains("made from another source");
            assert!(is_told, "{told}");
        };
        is_refused();
        std::fs::remove_file(out.join("manifest.json")).unwrap();
        std::fs::remove_dir_all(out.join("map_0001")).unwrap();
        is_refused();
        assert_eq!(Survey::of(&out).unwrap().maps.len(), 1);
        run(&own).unwrap();
    }
}
