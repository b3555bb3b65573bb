//! Sums over what the maps of a data set tell, finished or not.

use std::collections::BTreeMap;

use aps_data::{MapEntry, Part, Survey};
use aps_label::MeanStd;
use serde_json::{Value, json};

use crate::tally;

/// Sums over what the whole maps of a data set tell, beside those of [`Survey::totals`].
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Overview {
    /// Links that were wanted, and not made because their transmitter reaches too few points.
    pub missing_links: u64,
    /// Paths of the trace, stored or not, if the maps tell them.
    pub traced_paths: Option<u64>,
    /// Mean number of dominant peaks of a labelled link, and the share of links with at most two, if the maps tell them.
    pub dominant_peaks: Option<(f64, f64)>,
    /// Mean and deviation of power relative to the link's largest, over the training maps.
    pub training: Option<MeanStd>,
}

impl Overview {
    /// Sums over what a survey found.
    pub fn of(survey: &Survey) -> Self {
        let mut sums = Self::default();
        let mut peaks: BTreeMap<usize, u64> = BTreeMap::new();
        for map in &survey.maps {
            let of_map = map.statistics["dominant_peaks"].as_object();
            for (number, count) in of_map.into_iter().flatten() {
                if let (Ok(number), Some(count)) = (number.parse(), count.as_u64()) {
                    let sum = peaks.entry(number).or_default();
                    *sum = sum.saturating_add(count);
                }
            }
            let missing = map.statistics["missing_links"].as_u64().unwrap_or(0);
            sums.missing_links = sums.missing_links.saturating_add(missing);
            if let Some(paths) = map.statistics["paths"].as_u64() {
                let sum = sums.traced_paths.get_or_insert(0);
                *sum = sum.saturating_add(paths);
            }
        }
        sums.dominant_peaks = tally::peaks(&peaks);
        if let Some(manifest) = &survey.manifest {
            let train = manifest.split.maps(Part::Train);
            let maps = survey.maps.iter().filter(|map| train.contains(&map.id));
            sums.training = pooled(maps);
        }
        sums
    }

    /// The sums, the maps and the settings as JSON.
    pub fn json(&self, survey: &Survey) -> Value {
        let config = survey.config.as_ref();
        json!({
            "finished": survey.manifest.is_some(),
            "missing_maps": survey.missing(),
            "maps": survey.maps.iter().map(|map| json!({
                "id": map.id,
                "tx": map.tx,
                "rx": map.rx,
                "links": map.links,
                "status": map.status,
                "statistics": map.statistics,
            })).collect::<Vec<_>>(),
            "links": survey.totals.links,
            "missing_links": self.missing_links,
            "status": survey.totals.status,
            "stored_paths": survey.totals.paths,
            "stored_interactions": survey.totals.interactions,
            "bytes": survey.totals.bytes,
            "dominant_peaks_a_link": self.dominant_peaks.map(|(mean, _)| mean),
            "share_with_at_most_two_dominant_peaks": self.dominant_peaks.map(|(_, share)| share),
            "training_relative_power": self.training,
            "split": survey.manifest.as_ref().map(|manifest| &manifest.split),
            "seed": config.map(|config| config.seed),
            "layout": config.map(|config| config.layout),
            "configuration": config.map(|config| &config.configuration),
        })
    }
}

/// Mean and deviation over some maps from those of each; a map without labels has none.
pub(crate) fn pooled<'m>(maps: impl Iterator<Item = &'m MapEntry>) -> Option<MeanStd> {
    let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for map in maps {
        let number = |name| map.statistics["relative_power"][name].as_f64();
        let numbers = (number("values"), number("mean"), number("std"));
        if let (Some(values), Some(mean), Some(std)) = numbers {
            n += values;
            sum += values * mean;
            squares += values * (std * std + mean * mean);
        }
    }
    let mean = sum / n;
    let std = (squares / n - mean * mean).max(0.0).sqrt();
    (n > 0.0).then_some(MeanStd { mean, std })
}
