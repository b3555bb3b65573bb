//! Checks that a data set is as its manifest says, and as its maps make it.

mod contents;
mod findings;
mod recompute;

use aps_data::{Dataset, Layout};

use findings::Findings;
use recompute::Recomputation;

use crate::control::{Control, Work};
use crate::error::{At, Place, Result, chain};
use crate::maps::MapSource;
use crate::sampling::{SEED, draw_links};
use crate::settings::{self, SettingsError};

/// Check of a data set: bytes, values, counts, statistics, and a sample of its links computed anew from the maps.
#[derive(Debug, Clone)]
pub struct Verify {
    /// Maps that the data set was made of; without them, what they tell is not checked.
    pub maps: Option<MapSource>,
    /// Number of random links to compute anew; if not given, 100 where that is possible.
    pub sample: Option<usize>,
    /// Seed of the choice of links.
    pub seed: u64,
}

/// Result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Verified {
    /// Number of findings.
    pub findings: usize,
    /// Links computed anew.
    pub sampled: usize,
}

impl Default for Verify {
    fn default() -> Self {
        Self {
            maps: None,
            sample: None,
            seed: SEED,
        }
    }
}

impl Verify {
    /// Checks a data set; hands over each finding, one line about one thing that is wrong.
    ///
    /// # Errors
    /// Maps that cannot be read or are not those of the data set, links to be computed anew where that is impossible,
    /// and cancellation.
    pub fn run(
        &self,
        dataset: &Dataset,
        control: &Control<'_>,
        found: &mut dyn FnMut(String),
    ) -> Result<Verified> {
        let manifest = dataset.manifest();
        if let Some(maps) = &self.maps {
            maps.must_be_of(&manifest.configuration)?;
        }
        let recomputation = match &self.maps {
            Some(_) => Recomputation::new(dataset)?,
            None => None,
        };
        let sample = match (self.sample, &recomputation, &self.maps) {
            (None, Some(_), _) => 100,
            (None, None, _) | (Some(0), ..) => 0,
            (Some(sample), Some(_), _) => sample,
            (Some(_), None, None) => return Err(SettingsError::NoMaps.into()),
            (Some(_), None, Some(_)) => return Err(SettingsError::NotTraced.into()),
        };
        let scene = settings::scene_of(&manifest.configuration)?;
        let counts = manifest.maps.iter().map(|map| (map.id, map.links));
        let mut chosen = draw_links(counts, sample, self.seed);
        let (mut findings, mut sampled) = (Findings { found, count: 0 }, 0);
        control.progress.begin(Work {
            units: manifest.totals.bytes,
            name: "bytes",
            finished_maps: 0,
            maps: manifest.maps.len(),
        });
        for problem in dataset.verify_manifest() {
            findings.add(chain(&problem));
        }
        check_axes(dataset, &mut findings);
        for entry in &manifest.maps {
            control.check()?;
            control.progress.map(entry.id);
            let links = chosen.remove(&entry.id).unwrap_or_default();
            let problems = dataset.verify_map(entry.id);
            // Findings computed from damaged files would only repeat the news.
            if problems.is_empty() {
                let map = dataset.map(entry.id)?;
                contents::check(dataset, entry, &map, self.maps.is_some(), &mut findings)?;
                if let Some(source) = &self.maps {
                    let given = source.load(entry.id, manifest.seed, scene);
                    let given = given.at(Place::GivenMap(entry.id))?;
                    let is_it = contents::check_against(dataset, &map, &given, &mut findings)?;
                    if let Some(recomputation) = recomputation.as_ref().filter(|_| is_it) {
                        recomputation.check(entry, &map, &given, &links, &mut findings)?;
                        sampled += links.len();
                    }
                }
            }
            for problem in problems {
                findings.add(chain(&problem));
            }
            let bytes = entry.files.iter().map(|file| file.bytes).sum();
            control.progress.advance(bytes);
        }
        Ok(Verified {
            findings: findings.count,
            sampled,
        })
    }
}

/// Axes that contradict the label settings.
fn check_axes(dataset: &Dataset, findings: &mut Findings<'_>) {
    let manifest = dataset.manifest();
    let layout = &manifest.layout;
    let Ok(label) = settings::label_of(&manifest.configuration) else {
        return;
    };
    let made = Layout::of_labels(&label, layout.raster, layout.stored());
    for (name, stored, made) in [("aps", layout.aps, made.aps), ("pdp", layout.pdp, made.pdp)] {
        let (stored, made) = (stored.map(|p| p.axis), made.map(|p| p.axis));
        if stored != made {
            findings.add(format!(
                "layout.{name}.axis is {stored:?}, the label settings make {made:?}"
            ));
        }
    }
}
