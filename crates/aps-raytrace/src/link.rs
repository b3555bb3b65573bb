//! The result of a trace of one link.

use crate::path::PathRecord;
use crate::search::Buffers;

/// Result of a trace of one link. Reuse it from link to link to save allocations.
#[derive(Debug, Clone, Default)]
pub struct Link {
    /// The paths, by length, then by interactions. Empty when there is none.
    pub paths: Vec<PathRecord>,
    /// Paths inside the limits that were left out for their weakness.
    pub omitted: Omitted,
    /// Number of diffractions of the paths when there was none inside the limits.
    pub fallback_diffractions: Option<usize>,
    /// True when a building closed on all sides lies between the ends: the reason for no path.
    pub is_enclosed: bool,
    pub(crate) leaves_out_interactions: bool,
    pub(crate) buffers: Buffers,
}

/// Paths left out because they lie more than `dynamic_range_db` below the strongest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Omitted {
    /// Paths whose upper bound was too low: their gain was never computed.
    pub by_bound: usize,
    /// Paths whose computed gain was too low.
    pub by_gain: usize,
    /// Upper bound of the sum of their power gains, linear.
    pub power: f64,
}

impl Omitted {
    /// The most that the omitted paths could add to a spectrum where it is at least
    /// `spectrum_power` (linear, same scale as the path powers) \[dB\].
    #[must_use]
    pub fn effect_db(&self, spectrum_power: f64) -> f64 {
        if self.power == 0.0 {
            0.0
        } else {
            10.0 * (self.power / spectrum_power).ln_1p() * std::f64::consts::LOG10_E
        }
    }
}

impl Link {
    /// A link whose paths have no [`PathRecord::interactions`], whatever they meet: lengths, azimuths and gains are those of any other
    /// link, to the bit, and all that a label sees. It takes about a tenth less time. [`PathRecord::is_line_of_sight`] means nothing
    /// for them.
    #[must_use]
    pub fn without_interactions() -> Self {
        Self {
            leaves_out_interactions: true,
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::config::TraceConfig;
    use crate::scene::{CityConfig, Footprint, Scene};
    use crate::tracer::Tracer;

    /// Checks that links of all pairs are the same with and without interactions; returns the number of paths, and of those as long as
    /// the one before.
    fn check(scene: &Scene, config: TraceConfig, places: &[DVec2]) -> [usize; 2] {
        let tracer = Tracer::new(scene, config).unwrap();
        let tx: Vec<_> = places
            .iter()
            .map(|&at| tracer.transmitter(at).unwrap())
            .collect();
        let (mut whole, mut short) = (Link::default(), Link::without_interactions());
        let mut counts = [0; 2];
        for &at in places {
            let rx = tracer.receiver(at).unwrap();
            for tx in tx.iter().filter(|tx| tx.position() != at) {
                tracer.link(tx, &rx, &mut whole).unwrap();
                tracer.link(tx, &rx, &mut short).unwrap();
                counts[0] += whole.paths.len();
                let ties = whole
                    .paths
                    .windows(2)
                    .filter(|two| two[0].length_m == two[1].length_m);
                counts[1] += ties.count();
                let paths = whole.paths.iter().map(|path| PathRecord {
                    interactions: Default::default(),
                    ..path.clone()
                });
                assert_eq!(short.paths, paths.collect::<Vec<_>>());
                assert_eq!(short.omitted, whole.omitted);
                assert_eq!(short.fallback_diffractions, whole.fallback_diffractions);
                assert_eq!(short.is_enclosed, whole.is_enclosed);
            }
        }
        counts
    }

    #[test]
    fn paths_without_interactions_are_the_same_in_the_same_order() {
        let city = CityConfig {
            size_m: 128,
            ..CityConfig::default()
        };
        let city = Scene::synthetic(&city).unwrap();
        let places =
            (0..).map(|i| DVec2::new(f64::from(i * 37 % 127), f64::from(i * 53 % 125)) + 0.5);
        let outdoors = places.filter(|&at| city.check_terminal(at).is_ok());
        let outdoors: Vec<DVec2> = outdoors.take(8).collect();
        let all_paths = TraceConfig {
            dynamic_range_db: None,
            ..TraceConfig::within(2, 1)
        };
        let chains = TraceConfig {
            max_fallback_diffractions: 8,
            ..TraceConfig::within(1, 0)
        };
        for config in [
            TraceConfig::converged(),
            TraceConfig::within(1, 3),
            all_paths,
            chains,
        ] {
            let [paths, _] = check(&city, config, &outdoors);
            assert!(paths > 50, "{paths} paths");
        }
        // Both ways around a house are as long.
        let house = [(-8.0, -5.0), (8.0, -5.0), (8.0, 5.0), (-8.0, 5.0)].map(DVec2::from);
        let walls = [20.0, -24.0]
            .map(|y| [(-30.0, y), (30.0, y), (30.0, y + 4.0), (-30.0, y + 4.0)].map(DVec2::from));
        let houses: Vec<Footprint> = [house]
            .into_iter()
            .chain(walls)
            .map(Footprint::new)
            .collect();
        let street = Scene::new(&houses, None).unwrap();
        let [_, ties] = check(
            &street,
            TraceConfig::converged(),
            &[(-20.0, 0.0), (20.0, 0.0), (14.0, 0.0)].map(DVec2::from),
        );
        assert!(ties >= 8, "{ties} ties");
    }
}
