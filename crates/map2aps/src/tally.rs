//! Counts and times of the making of a data set.

use std::collections::BTreeMap;
use std::sync::LazyLock;
use std::time::Duration;

use aps_data::{LinkStatus, Profile, Samples};
use aps_label::{Label, MeanStd, Moments, Protocol, relative_power};
use aps_raytrace::Link;
use half::f16;
use serde_json::{Value, json};

use crate::error::Result;

/// Below its maximum a spectrum is noise by this much \[dB\]; what omissions can change is told above it.
const EFFECT_RANGE_DB: f64 = 40.0;

/// Names of the two statistics of omissions that depend on the label.
const LARGEST_EFFECT: &str = "largest_effect_above_40_db_below_maximum_db";
const LINKS_AFFECTED: &str = "links_where_it_may_exceed_0_1_db";

/// Mean number of peaks and share of links with at most two, of links by their number of peaks; `None` without any.
pub(crate) fn peaks(links: &BTreeMap<usize, u64>) -> Option<(f64, f64)> {
    // In floating point: a foreign manifest may tell any numbers.
    let labelled: f64 = links.values().map(|&n| n as f64).sum();
    let all: f64 = links
        .iter()
        .map(|(&number, &n)| number as f64 * n as f64)
        .sum();
    let at_most_two: f64 = links.range(..=2).map(|(_, &n)| n as f64).sum();
    (labelled > 0.0).then(|| (all / labelled, at_most_two / labelled))
}

/// Powers of the half-precision numbers of decibels that are not above 0, by their bits less the sign's: a spectrum is stored in few
/// numbers, and a power takes ten times as long as to look it up.
static POWERS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let power = |bits: u16| {
        let mut beside_the_largest = [0.0, -f16::from_bits(bits).to_f64()];
        relative_power(&mut beside_the_largest).expect("decibels of a half-precision number");
        beside_the_largest[1]
    };
    (0..f16::INFINITY.to_bits()).map(power).collect()
});

/// Powers of a stored spectrum relative to its largest value: [`relative_power`] of it, to the bit.
fn stored_power(aps: &Profile, link: usize, power: &mut [f64]) -> Result<()> {
    let range = link * aps.bins()..(link + 1) * aps.bins();
    let is_relative = |stored: &[f16]| {
        let is_sound = |value: &f16| value.is_finite() && *value <= f16::ZERO;
        stored.iter().all(is_sound) && stored.contains(&f16::ZERO)
    };
    match aps.samples() {
        Samples::F16(stored) if is_relative(&stored[range.clone()]) => {
            let powers = &*POWERS;
            for (power, stored) in power.iter_mut().zip(&stored[range]) {
                *power = powers[usize::from(stored.to_bits() & 0x7fff)];
            }
        }
        samples => {
            samples.read(range, power);
            relative_power(power)?;
        }
    }
    Ok(())
}

/// Counts and times over some links; sums of parts are the whole.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Tally {
    /// Links.
    pub links: u64,
    /// Paths of the links.
    pub paths: u64,
    /// Links by their state.
    pub status: BTreeMap<String, u64>,
    /// Labelled links by the number of dominant peaks of their APS.
    pub dominant_peaks: BTreeMap<usize, u64>,
    /// Moments of all values of all APS, relative to their link's largest one, as stored.
    pub relative_power: Moments,
    /// Links beyond the limits, by their number of diffractions.
    pub fallback: BTreeMap<usize, u64>,
    /// Points passed over since a transmitter does not reach them, by the reason.
    pub passed_over: BTreeMap<String, u64>,
    /// Links wanted for which too few points were reached.
    pub missing_links: u64,
    /// Maps on which nothing can reflect: reflection was never set up.
    pub maps_without_walls: u64,
    /// Maps on which nothing can diffract, or the limits allow none: diffraction was never set up.
    pub maps_without_corners: u64,
    /// Links whose ends are nearer to each other than a wavelength.
    pub near_links: u64,
    /// Images of transmitters that light no further wall: branches that ended.
    pub empty_beams: u64,
    /// Paths left out by an upper bound of their gain.
    pub omitted_by_bound: u64,
    /// Paths left out by their gain.
    pub omitted_by_gain: u64,
    /// Largest possible effect of what was left out on any label above -40 dB of its maximum \[dB\].
    pub omission_effect_db: f64,
    /// Links on which it may exceed 0.1 dB.
    pub links_affected: u64,
    /// Bytes written.
    pub bytes: u64,
    /// Thread time for maps and terminals.
    pub prepare: Duration,
    /// Thread time for paths.
    pub trace: Duration,
    /// Thread time for labels.
    pub label: Duration,
    /// Thread time for files.
    pub write: Duration,
}

impl Tally {
    /// Counts one traced link.
    pub(crate) fn link(
        &mut self,
        link: &Link,
        fallback: u8,
        label: &Label,
        status: LinkStatus,
        protocol: Protocol,
    ) {
        self.stored_link(link.paths.len(), status, fallback);
        self.omitted_by_bound += link.omitted.by_bound as u64;
        self.omitted_by_gain += link.omitted.by_gain as u64;
        if !status.is_valid() {
            return;
        }
        let spectrum = label.aps_db.iter().copied();
        let top_db = spectrum.fold(f64::NEG_INFINITY, f64::max);
        // The weakest bin that counts, as a path gain.
        let weakest_db = top_db - EFFECT_RANGE_DB - protocol.sent_power_db();
        let effect_db = link.omitted.effect_db(10_f64.powf(weakest_db / 10.0));
        self.omission_effect_db = self.omission_effect_db.max(effect_db);
        self.links_affected += u64::from(effect_db > 0.1);
    }

    /// Counts a point that is no receiver, because it is not reached.
    pub(crate) fn pass_over(&mut self, reason: LinkStatus) {
        *self.passed_over.entry(reason.to_string()).or_default() += 1;
    }

    /// Counts the stored values of one link.
    pub(crate) fn stored_link(&mut self, paths: usize, status: LinkStatus, fallback: u8) {
        self.links += 1;
        self.paths += paths as u64;
        *self.status.entry(status.to_string()).or_default() += 1;
        if fallback > 0 {
            *self.fallback.entry(fallback.into()).or_default() += 1;
        }
    }

    /// Counts the shapes of labelled links' spectra, as they are stored.
    pub(crate) fn shapes(
        &mut self,
        aps: &Profile,
        links: impl Iterator<Item = usize>,
        protocol: Protocol,
    ) -> Result<()> {
        let definition = aps_metrics::Protocol::from(protocol).definition();
        let mut shape = vec![0.0; aps.bins()];
        for link in links {
            stored_power(aps, link, &mut shape)?;
            self.relative_power.add(&shape)?;
            let peaks = aps_metrics::spectrum_peaks(&shape, &definition)?;
            let count = peaks.dominant().len();
            *self.dominant_peaks.entry(count).or_default() += 1;
        }
        Ok(())
    }

    /// Statistics for the manifest: findings that follow from the settings.
    pub(crate) fn statistics(&self) -> Value {
        json!({
            "paths": self.paths,
            "dominant_peaks": self.dominant_peaks,
            "relative_power": self.relative_power_json(),
            "fallback_diffractions": self.fallback,
            "points_not_reached": self.passed_over,
            "missing_links": self.missing_links,
            "omitted": {
                "reflection_without_walls": self.maps_without_walls > 0,
                "diffraction_without_corners": self.maps_without_corners > 0,
                "empty_beams": self.empty_beams,
                "paths_by_bound": self.omitted_by_bound,
                "paths_by_gain": self.omitted_by_gain,
                LARGEST_EFFECT: self.omission_effect_db,
                LINKS_AFFECTED: self.links_affected,
            },
        })
    }

    /// Statistics of stored links, as [`Tally::statistics`]: values that only a trace can tell are taken from `source`, except
    /// those that depend on the label unless `same_label`.
    pub(crate) fn statistics_like(&self, source: &Value, same_label: bool) -> Value {
        let mut statistics = match source {
            Value::Object(source) => source.clone(),
            _ => serde_json::Map::new(),
        };
        let mut own = self.statistics();
        let of_stored = [
            "paths",
            "dominant_peaks",
            "relative_power",
            "fallback_diffractions",
        ];
        statistics.extend(of_stored.map(|key| (key.into(), own[key].take())));
        if let Some(Value::Object(omitted)) = statistics.get_mut("omitted")
            && !same_label
        {
            omitted.remove(LARGEST_EFFECT);
            omitted.remove(LINKS_AFFECTED);
        }
        Value::Object(statistics)
    }

    fn relative_power_json(&self) -> Value {
        let values = self.relative_power.count();
        let told = |s: MeanStd| json!({ "values": values, "mean": s.mean, "std": s.std });
        self.relative_power.mean_std().map_or(Value::Null, told)
    }

    /// Adds the counts of a part.
    pub(crate) fn add(&mut self, part: &Self) {
        fn merge<K: Ord + Clone>(into: &mut BTreeMap<K, u64>, from: &BTreeMap<K, u64>) {
            for (key, count) in from {
                *into.entry(key.clone()).or_default() += count;
            }
        }
        self.links += part.links;
        self.near_links += part.near_links;
        self.paths += part.paths;
        merge(&mut self.status, &part.status);
        merge(&mut self.dominant_peaks, &part.dominant_peaks);
        self.relative_power.merge(&part.relative_power);
        merge(&mut self.fallback, &part.fallback);
        merge(&mut self.passed_over, &part.passed_over);
        self.missing_links += part.missing_links;
        self.maps_without_walls += part.maps_without_walls;
        self.maps_without_corners += part.maps_without_corners;
        self.empty_beams += part.empty_beams;
        self.omitted_by_bound += part.omitted_by_bound;
        self.omitted_by_gain += part.omitted_by_gain;
        self.omission_effect_db = self.omission_effect_db.max(part.omission_effect_db);
        self.links_affected += part.links_affected;
        self.bytes += part.bytes;
        self.prepare += part.prepare;
        self.trace += part.trace;
        self.label += part.label;
        self.write += part.write;
    }

    /// Mean number of dominant peaks of a labelled link, and the share of links with at most two; `None` without any.
    pub fn peaks(&self) -> Option<(f64, f64)> {
        peaks(&self.dominant_peaks)
    }

    /// Links with a label.
    pub fn valid(&self) -> u64 {
        self.status.get("valid").copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use aps_data::{Axis, Precision, ProfileLayout, ProfileRows};

    use super::*;

    #[test]
    fn powers_looked_up_are_those_of_the_definition() {
        let db: Vec<f64> = (0..512).map(|i| -70.0 - f64::from(i * i) * 0.31).collect();
        for dtype in [Precision::F16, Precision::F32] {
            let axis = Axis {
                count: db.len(),
                ..Axis::ANGLE_PAPER_DEG
            };
            let layout = ProfileLayout {
                dtype,
                ..ProfileLayout::over(axis)
            };
            let rows = ProfileRows {
                db: &db,
                argmax: None,
            };
            let aps = Profile::encode(&rows, &layout, &[LinkStatus::Valid]).unwrap();
            let (mut found, mut expected) = (vec![0.0; db.len()], vec![0.0; db.len()]);
            stored_power(&aps, 0, &mut found).unwrap();
            aps.samples().read(0..db.len(), &mut expected);
            relative_power(&mut expected).unwrap();
            assert!(found == expected && found[0] == 1.0 && found[511] == 0.0);
        }
    }
}
