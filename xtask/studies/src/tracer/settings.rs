//! Settings that are swept, and the setting that they are compared with.

use aps_raytrace::TraceConfig;

use crate::profile::Profile;

/// One setting of the tracer.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Group in the sweep, like `dynamic range`.
    pub group: &'static str,
    /// Name in words, unique in the sweep.
    pub name: String,
    pub config: TraceConfig,
}

/// Name of the setting that the commands take by default.
pub const DEFAULT: &str = "R5 D2, 20 dB";

const LIMITS: [&str; 3] = ["D0", "D1", "D2"];
const RANGES: &str = "dynamic range";
const FAR: &str = "far limits";

impl Setting {
    /// The sweep: limits, then the dynamic range at R2 D1, then at R5 D2.
    pub fn sweep(profile: Profile) -> Vec<Self> {
        let mut sweep = Vec::new();
        let most = profile.choose(1, 2);
        for (diffractions, group) in LIMITS.into_iter().enumerate().take(most + 1) {
            for reflections in 0..=profile.choose(2, 5) {
                sweep.push(Self {
                    group,
                    name: format!("R{reflections} D{diffractions}"),
                    config: TraceConfig::within(reflections, diffractions),
                });
            }
        }
        let of_r2_d1 = TraceConfig::within(2, 1);
        for range_db in [20.0, 30.0, 40.0, 50.0, 80.0] {
            sweep.push(Self {
                group: RANGES,
                name: format!("R2 D1, {range_db} dB"),
                config: TraceConfig {
                    dynamic_range_db: Some(range_db),
                    ..of_r2_d1.clone()
                },
            });
        }
        sweep.push(Self {
            group: RANGES,
            name: "R2 D1, all paths".into(),
            config: TraceConfig {
                dynamic_range_db: None,
                ..of_r2_d1
            },
        });
        for range_db in profile.choose(vec![20.0], vec![10.0, 15.0, 20.0, 25.0, 30.0]) {
            sweep.push(Self {
                group: FAR,
                name: format!("R5 D2, {range_db} dB"),
                config: TraceConfig {
                    dynamic_range_db: Some(range_db),
                    ..TraceConfig::converged()
                },
            });
        }
        sweep
    }
}

/// Returns the reference: the highest limits that the profile can afford, without omissions.
pub fn reference(profile: Profile) -> TraceConfig {
    TraceConfig {
        dynamic_range_db: None,
        ..profile.choose(TraceConfig::within(3, 1), TraceConfig::within(6, 2))
    }
}

#[cfg(test)]
mod tests {
    use map2aps::Limits;

    use super::*;

    #[test]
    fn every_setting_has_a_name_of_its_own_and_the_default_is_among_them() {
        for profile in [Profile::Smoke, Profile::Full] {
            let sweep = Setting::sweep(profile);
            let mut names: Vec<&str> = sweep.iter().map(|s| &*s.name).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), sweep.len());
            let default = sweep.iter().find(|s| s.name == DEFAULT).unwrap();
            assert_eq!(default.config, Limits::default().config());
            assert!(sweep.iter().all(|s| s.config.validate().is_ok()));
        }
    }
}
