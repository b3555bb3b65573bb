//! The results of a benchmark, as its report takes them.

use std::path::Path;

use aps_data::Part as SplitPart;
use aps_report::benchmark::{DataSummary, Entry, FORMAT, Results};
use map2aps::targets::labelled_links;

use crate::config::Config;
use crate::data::is_synthetic;
use crate::entry::Context;
use crate::error::Result;
use crate::job::{Job, SIGHT, stem};
use crate::{answer, examples, model};

impl Context<'_> {
    /// Builds the results of the entries that succeeded.
    pub fn results(&self, mut entries: Vec<Entry>) -> Result<Results> {
        let (bed, config) = (&self.bed, &self.bench.config);
        let folder_of = |name: &str| self.bench.out.join("scores").join(stem(name));
        let (sight, _) = Job::Tracer(SIGHT).title();
        let mut line_of_sight = vec![true; bed.test.len()];
        for link in answer::substituted(&folder_of(&sight), bed.test.len())? {
            line_of_sight[link] = false;
        }
        let split = &bed.dataset.manifest().split;
        let develop = labelled_links(&bed.dataset, split.maps(SplitPart::Develop));
        let limit = config.training.develop_links.unwrap_or(usize::MAX);
        // The tracer that found the lines of sight is in the tables if it was asked for.
        let is_shown = config.tracer.interactions.contains(&SIGHT);
        entries.retain(|entry| is_shown || entry.name != sight);
        Ok(Results {
            format: FORMAT,
            profile: self.bench.profile.clone(),
            configuration: serde_json::to_value(config)?,
            machine: self.bench.machine.clone(),
            data: DataSummary {
                source: source(config),
                train_maps: split.train.clone(),
                dev_maps: split.develop.clone(),
                test_maps: split.test.clone(),
                train_links: self.train_links as u64,
                dev_links: develop.min(limit) as u64,
                chosen_by: model::CHOSEN_BY.key().into(),
                test_links: bed.test.len() as u64,
                invalid_test_links: bed.test.invalid,
                protocol: bed.test.protocol.to_string(),
            },
            links: bed.test.links(&line_of_sight)?,
            examples: examples::choose(&entries, &bed.test, &bed.plan, &self.bench.out, folder_of)?,
            entries,
            failed: Vec::new(),
            left_out: Vec::new(),
        })
    }
}

/// Origin of the maps, in words.
pub fn source(config: &Config) -> String {
    match is_synthetic(&config.data.maps) {
        true => format!("synthetic city, seed {}", config.seed),
        false => {
            let path = Path::new(&config.data.maps);
            let name = path.file_name().map(|name| name.to_string_lossy());
            format!("folder {}", name.unwrap_or_default())
        }
    }
}
