//! One map of a data set with other labels: load, label, write.

use std::ops::Range;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use aps_data::{Dataset, LinkStatus, Links, MapData, MapInput, PathTable};
use aps_label::{Label, PathSample, Scratch, Status};

use super::rows::Rows;
use super::{GROUP, Run};
use crate::settings;
use crate::summary::Tally;

/// Links labelled by one thread at a time.
const LINKS_AT_ONCE: usize = 500;

impl Run<'_> {
    /// Labels the stored paths of one map; nothing of it stays on disk unless it is whole.
    pub fn relabel(&self, source: &Dataset, id: u32) -> Result<Tally> {
        let started = Instant::now();
        // Damage must not be given a new checksum.
        if let Some(problem) = source.verify_map(id).into_iter().next() {
            return Err(problem).with_context(|| format!("map {id} of the source"));
        }
        let (map, paths) = (source.map(id)?, source.paths(id)?);
        let entry = source.manifest().maps.iter().find(|map| map.id == id);
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
        for group in ranges.chunks(GROUP) {
            self.write_group(&mut writer, group, &mut tally, |links| {
                self.label_links(&map, &paths, links.clone())
            })
            .with_context(|| format!("map {id}"))?;
        }
        let same_label = settings::label_of(&source.manifest().configuration)
            .is_ok_and(|label| label == *self.labeler.config());
        writer.set_statistics(tally.statistics_like(&entry.statistics, same_label));
        self.finish(writer, &mut tally)?;
        Ok(tally)
    }

    fn label_links(&self, map: &MapData, paths: &PathTable, links: Range<usize>) -> Result<Rows> {
        let mut rows = Rows::default();
        let (mut scratch, mut label) = (Scratch::default(), Label::default());
        let mut samples: Vec<PathSample> = Vec::new();
        for link in links.clone() {
            if self.is_interrupted() {
                bail!("interrupted");
            }
            let started = Instant::now();
            samples.clear();
            samples.extend(paths.paths_of(link).map(|path| paths.sample(path)));
            let labelled = self
                .labeler
                .label_into(&samples, &mut scratch, &mut label)
                .with_context(|| format!("link {link}"))?;
            let status = match labelled {
                Status::Labelled => LinkStatus::Valid,
                _ if samples.is_empty() => map.status[link],
                _ => LinkStatus::Unlabelled,
            };
            rows.tally.label += started.elapsed();
            rows.tally
                .stored_link(samples.len(), status, map.fallback[link]);
            rows.push(
                self.labeler,
                map.links[link],
                status,
                map.fallback[link],
                &label,
            );
            rows.paths.push_link(paths, link);
        }
        rows.count_shapes(self.labeler, &self.writer.config().layout)?;
        self.progress.inc(links.len() as u64);
        Ok(rows)
    }
}
