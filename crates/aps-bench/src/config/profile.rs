//! Profiles: complete settings that come with the program.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use toml::Table;

use super::{Config, DataConfig};
use crate::error::Error;

/// Sizes of a benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// Two epochs of 72 links: whether everything runs.
    Smoke,
    /// A minute a model.
    Quick,
    /// Six minutes a model.
    Hour,
    /// An hour a model.
    Night,
    /// The paper's steps and sizes, for a GPU.
    Paper,
}

impl Profile {
    /// Every profile, the quickest first.
    pub const ALL: [Self; 5] = [
        Self::Smoke,
        Self::Quick,
        Self::Hour,
        Self::Night,
        Self::Paper,
    ];

    /// Its name, and the text of its file.
    fn files(self) -> (&'static str, &'static str) {
        macro_rules! file {
            ($name:literal) => {
                (
                    $name,
                    include_str!(concat!("../../profiles/", $name, ".toml")),
                )
            };
        }
        match self {
            Self::Smoke => file!("smoke"),
            Self::Quick => file!("quick"),
            Self::Hour => file!("hour"),
            Self::Night => file!("night"),
            Self::Paper => file!("paper"),
        }
    }

    /// Its name, which is that of its file too.
    pub fn name(self) -> &'static str {
        self.files().0
    }

    /// Purpose in a few words.
    pub fn purpose(self) -> &'static str {
        match self {
            Self::Smoke => "Under two minutes: does it run?",
            Self::Quick => "A minute a model",
            Self::Hour => "Six minutes a model",
            Self::Night => "An hour a model",
            Self::Paper => "The paper's steps and sizes, for a GPU",
        }
    }

    /// Its settings.
    pub fn config(self) -> Config {
        Config::of(self.table()).expect("profiles are valid")
    }

    /// Its file in the project that this program was built from: a choice of settings is written into it.
    pub fn path(self) -> PathBuf {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("profiles");
        folder.join(self.name()).with_extension("toml")
    }

    pub(super) fn table(self) -> Table {
        let own = |profile: Self| -> Table {
            let (_, text) = profile.files();
            text.parse().expect("profiles are TOML")
        };
        let mut table = own(self);
        // The trainings by which `hour` was searched last about as long as those of `quick`.
        if self == Self::Quick
            && let Some(models) = own(Self::Hour).remove("model")
        {
            table.entry("model").or_insert(models);
        }
        table
    }
}

impl FromStr for Profile {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|profile| profile.name() == name);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::Setting(format!("'{name}' is no profile: {names}"))
        })
    }
}

impl Config {
    /// The name of a profile if these are its settings, but for maps, seed, device, models and what comes from elsewhere; else `custom`.
    pub fn profile_name(&self, profile: Profile) -> &'static str {
        let own = profile.config();
        let same = Config {
            seed: self.seed,
            models: self.models.clone(),
            device: self.device,
            weights: self.weights.clone(),
            external: self.external.clone(),
            pretrained: self.pretrained.clone(),
            data: DataConfig {
                maps: self.data.maps.clone(),
                ..own.data.clone()
            },
            ..own
        };
        match same == *self {
            true => profile.name(),
            false => "custom",
        }
    }
}

#[cfg(test)]
mod tests {
    use aps_label::Protocol;
    use aps_model::ModelKind;
    use map2aps::Limits;

    use super::*;

    #[test]
    fn quick_has_the_settings_of_hour_and_night_its_own() {
        let models = |profile: Profile| profile.config().model;
        let hour = models(Profile::Hour);
        assert_eq!(hour.len(), ModelKind::ALL.len());
        assert_eq!(models(Profile::Quick), hour);
        let night = models(Profile::Night);
        assert!(night.keys().eq(hour.keys()) && night != hour);
        assert!(models(Profile::Smoke).is_empty() && models(Profile::Paper).is_empty());
    }

    #[test]
    fn profiles_are_valid_and_give_every_model_the_same_time() {
        for (profile, budget_s) in [
            (Profile::Smoke, None),
            (Profile::Quick, Some(60.0)),
            (Profile::Hour, Some(360.0)),
            (Profile::Night, Some(3600.0)),
            (Profile::Paper, None),
        ] {
            let config = profile.config();
            assert_eq!(config.profile_name(profile), profile.name());
            assert!(profile.path().is_file());
            assert_eq!(config.kinds(), ModelKind::ALL);
            // The weights that come with the program know no other labels.
            assert_eq!(config.data.protocol, Protocol::Paper);
            assert_eq!(config.data.limits, Limits::default());
            for kind in config.kinds() {
                assert_eq!(config.training(kind).unwrap().budget_s, budget_s);
            }
        }
    }

    #[test]
    fn paper_trains_with_the_papers_settings() {
        let config = Profile::Paper.config();
        let settings = |kind| {
            let training = config.training(kind).unwrap();
            (training.epochs, training.batch, training.learning_rate)
        };
        assert_eq!(settings(ModelKind::MsAreg), (20, 1024, 2e-4));
        assert_eq!(settings(ModelKind::RadioUnet), (20, 256, 3e-4));
        assert_eq!(settings(ModelKind::VitReg), (20, 512, 1e-4));
        assert_eq!(config.image_size(ModelKind::VitReg), 256);
        let data = config.data;
        assert_eq!((data.tx_per_map, data.rx_per_map), (100, 500));
        assert_eq!(data.train_maps + data.develop_maps, 46);
    }

    #[test]
    fn other_maps_and_models_leave_the_profile_its_name() {
        let flags = "models = ['ms_mlp']\ndata.maps = 'maps'";
        let config = Config::resolve(Profile::Quick, None, flags.parse().unwrap()).unwrap();
        assert_eq!(config.profile_name(Profile::Quick), "quick");
    }

    #[test]
    fn a_profile_says_the_protocol() {
        let mut table = Profile::Paper.table();
        let data = table["data"].as_table_mut().unwrap();
        assert!(data.remove("protocol").is_some());
        let error = Config::of(table).unwrap_err().to_string();
        assert!(error.contains("protocol"), "{error}");
    }
}
