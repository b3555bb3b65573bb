//! Settings of a benchmark: a profile, changed by a file, changed by flags.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};
use aps_label::Protocol;
use aps_model::train::TrainConfig;
use aps_model::{ModelKind, Preset};
use clap::ValueEnum;
use map2aps::training::Device;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// Sizes of a benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// Under a minute: does it run?
    Smoke,
    /// Every model, small; some minutes on two cores.
    Quick,
    /// A night on a CPU.
    Standard,
    /// The paper's sizes, for a GPU.
    Paper,
}

/// Every setting of a benchmark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Seed of terminals, synthetic cities, weights, order and drawn links.
    pub seed: u64,
    /// Models by their names on the command line, in the order of their training.
    pub models: Vec<String>,
    /// Where models compute.
    pub device: Device,
    /// The data set.
    pub data: DataConfig,
    /// Training of every model for which [`Config::model`] says nothing else.
    pub training: TrainingConfig,
    /// The tracer as a baseline.
    pub tracer: TracerConfig,
    /// Measurement of run times.
    pub latency: LatencyConfig,
    /// Settings of single models, by name.
    #[serde(default)]
    pub model: BTreeMap<String, ModelConfig>,
    /// Weights that backbones begin with.
    #[serde(default)]
    pub pretrained: Pretrained,
    /// Predictions from elsewhere, by the name they get in the tables.
    #[serde(default)]
    pub external: BTreeMap<String, PathBuf>,
}

/// Data that models learn from and are scored on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataConfig {
    /// `synthetic`, or a folder of footprint files 0.json, 1.json, ...
    pub maps: String,
    /// Maps to learn from.
    pub train_maps: usize,
    /// Maps to choose the best epoch by.
    pub develop_maps: usize,
    /// Maps to score on.
    pub test_maps: usize,
    /// Transmitters a map.
    pub tx_per_map: usize,
    /// Receivers a map, shared by its transmitters.
    pub rx_per_map: usize,
    /// Definition of the labels.
    pub protocol: Protocol,
    /// Most reflections on a path of the labels.
    pub max_reflections: usize,
    /// Most diffractions on a path of the labels.
    pub max_diffractions: usize,
    /// Test links scored, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test_links: Option<usize>,
}

/// Settings of the training of models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingConfig {
    /// `paper` or `small`.
    pub preset: String,
    /// Rows and columns of condition images \[pixels\].
    pub image_size: usize,
    /// Times each link is learnt from.
    pub epochs: u64,
    /// Links a step; the model's own in the paper if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch: Option<usize>,
    /// Links to learn from, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<usize>,
    /// Development links scored each epoch, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub develop_links: Option<usize>,
}

/// Other settings for one model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModelConfig {
    /// As in [`TrainingConfig`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image_size: Option<usize>,
    /// As in [`TrainingConfig`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u64>,
    /// As in [`TrainingConfig`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub batch: Option<usize>,
    /// As in [`TrainingConfig`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub links: Option<usize>,
    /// Highest learning rate; the paper's if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning_rate: Option<f64>,
}

/// Limits with which the tracer is scored against the labels: each of one list with each of the other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracerConfig {
    /// Most reflections on a path.
    pub reflections: Vec<usize>,
    /// Most diffractions on a path.
    pub diffractions: Vec<usize>,
}

/// Settings of the measurement of run times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LatencyConfig {
    /// Links predicted at once, ascending.
    pub batches: Vec<usize>,
    /// Time spent on each of them \[s\]; a few repetitions are made in any case.
    pub seconds: f64,
}

/// torchvision weights.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pretrained {
    /// For the models with a ResNet-18 of full width.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resnet18: Option<PathBuf>,
    /// For `vit_reg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vit_b_16: Option<PathBuf>,
}

/// Settings whose flags hold for every model and replace the settings of single models in a profile.
const FOR_ALL_MODELS: [&str; 4] = ["epochs", "links", "batch", "image_size"];

impl Profile {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Quick => "quick",
            Self::Standard => "standard",
            Self::Paper => "paper",
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Smoke => include_str!("../../profiles/smoke.toml"),
            Self::Quick => include_str!("../../profiles/quick.toml"),
            Self::Standard => include_str!("../../profiles/standard.toml"),
            Self::Paper => include_str!("../../profiles/paper.toml"),
        }
    }

    fn table(self) -> Table {
        self.text().parse().expect("profiles are TOML")
    }
}

impl Config {
    /// The settings of a profile, changed by those a file names, changed by `flags`.
    ///
    /// # Errors
    /// A file that cannot be read, a key that is not known, a value of another type or out of range; it is named.
    pub fn resolve(profile: Profile, file: Option<&Path>, flags: Table) -> Result<Self> {
        let mut table = profile.table();
        if let Some(path) = file {
            let place = || format!("configuration '{}'", path.display());
            let text = std::fs::read_to_string(path).with_context(place)?;
            let own: Table = text
                .parse()
                .map_err(|e| in_one_line(&e))
                .with_context(place)?;
            merge(&mut table, own);
            Config::of(table.clone()).with_context(place)?;
        }
        if let Some(Value::Table(training)) = flags.get("training")
            && let Some(Value::Table(models)) = table.get_mut("model")
        {
            for (_, model) in models.iter_mut() {
                let asked = FOR_ALL_MODELS
                    .iter()
                    .filter(|key| training.contains_key(**key));
                for key in asked {
                    model.as_table_mut().and_then(|table| table.remove(*key));
                }
            }
        }
        merge(&mut table, flags);
        Config::of(table)
    }

    fn of(table: Table) -> Result<Self> {
        let config: Config = table.try_into().map_err(|e| in_one_line(&e))?;
        config.check()?;
        Ok(config)
    }

    fn check(&self) -> Result<()> {
        for name in self.models.iter().chain(self.model.keys()) {
            name.parse::<ModelKind>()?;
        }
        self.preset()?;
        let data = &self.data;
        let counts = [
            ("data.train_maps", data.train_maps),
            ("data.develop_maps", data.develop_maps),
            ("data.test_maps", data.test_maps),
            ("data.tx_per_map", data.tx_per_map),
            ("data.rx_per_map", data.rx_per_map),
            ("data.test_links", data.test_links.unwrap_or(1)),
            (
                "latency.batches",
                self.latency.batches.iter().copied().min().unwrap_or(0),
            ),
        ];
        for (key, value) in counts {
            ensure!(value > 0, "{key} must be at least 1");
        }
        let seconds = self.latency.seconds;
        ensure!(
            seconds >= 0.0 && seconds.is_finite(),
            "latency.seconds is {seconds}: must be finite and not negative"
        );
        Ok(())
    }

    /// The models, in order, each once.
    pub fn kinds(&self) -> Result<Vec<ModelKind>> {
        let mut kinds: Vec<ModelKind> = Vec::new();
        for name in &self.models {
            let kind = name.parse()?;
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        Ok(kinds)
    }

    /// Sizes of the models.
    pub fn preset(&self) -> Result<Preset> {
        Ok(self.training.preset.parse()?)
    }

    /// Settings of one model; empty if there are none.
    pub fn model(&self, kind: ModelKind) -> ModelConfig {
        self.model.get(kind.name()).cloned().unwrap_or_default()
    }

    /// Size of a model's condition images \[pixels\].
    pub fn image_size(&self, kind: ModelKind) -> usize {
        self.model(kind)
            .image_size
            .unwrap_or(self.training.image_size)
    }

    /// Number of links a model is trained on; none for all.
    pub fn links(&self, kind: ModelKind) -> Option<usize> {
        self.model(kind).links.or(self.training.links)
    }

    /// Settings of a model's training.
    pub fn training(&self, kind: ModelKind) -> Result<TrainConfig> {
        let (own, usual) = (self.model(kind), kind.train_config(self.preset()?));
        Ok(TrainConfig {
            epochs: own.epochs.unwrap_or(self.training.epochs),
            batch: own.batch.or(self.training.batch).unwrap_or(usual.batch),
            learning_rate: own.learning_rate.unwrap_or(usual.learning_rate),
            seed: self.seed,
            ..usual
        })
    }

    /// The name of the profile whose sizes these are, whatever the maps, the seed and the choice of models; else `custom`.
    pub fn profile_name(&self, profile: Profile) -> &'static str {
        let own = Config::of(profile.table()).expect("profiles are valid");
        let same = Config {
            seed: self.seed,
            models: self.models.clone(),
            device: self.device,
            external: self.external.clone(),
            pretrained: self.pretrained.clone(),
            data: DataConfig {
                maps: self.data.maps.clone(),
                ..own.data.clone()
            },
            ..own
        };
        if same == *self {
            profile.name()
        } else {
            "custom"
        }
    }
}

/// Replaces values of `table` by those of `other`, table by table.
fn merge(table: &mut Table, other: Table) {
    for (key, value) in other {
        match (table.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(other)) => merge(inner, other),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

/// TOML's messages show the place over several lines; the runner prints one.
fn in_one_line(error: &toml::de::Error) -> anyhow::Error {
    anyhow!("{}", error.to_string().trim().replace('\n', " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Profile; 4] = [
        Profile::Smoke,
        Profile::Quick,
        Profile::Standard,
        Profile::Paper,
    ];

    fn with_file(text: &str, flags: &str) -> Result<Config> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bench.toml");
        std::fs::write(&path, text).unwrap();
        Config::resolve(Profile::Quick, Some(&path), flags.parse().unwrap())
    }

    #[test]
    fn profiles_are_valid_and_know_their_names() {
        for profile in ALL {
            let config = Config::resolve(profile, None, Table::new()).unwrap();
            assert_eq!(config.profile_name(profile), profile.name());
            assert!(!config.kinds().unwrap().is_empty());
        }
    }

    #[test]
    fn paper_trains_with_the_papers_settings() {
        let config = Config::resolve(Profile::Paper, None, Table::new()).unwrap();
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
    fn flag_overrides_file_and_file_overrides_profile() {
        let file = "seed = 7\n[training]\nepochs = 9\n[model.ms_areg]\nepochs = 11\nlinks = 5";
        let config = with_file(file, "").unwrap();
        let epochs = |config: &Config, kind| config.training(kind).unwrap().epochs;
        assert_eq!((config.seed, epochs(&config, ModelKind::MsMlp)), (7, 9));
        assert_eq!(epochs(&config, ModelKind::MsAreg), 11);
        assert_eq!(config.links(ModelKind::MsAreg), Some(5));
        assert_eq!(config.profile_name(Profile::Quick), "custom");
        let config = with_file(file, "training.epochs = 1").unwrap();
        assert_eq!(epochs(&config, ModelKind::MsAreg), 1);
        assert_eq!(config.links(ModelKind::MsAreg), Some(5));
    }

    #[test]
    fn other_maps_and_models_leave_the_profile_its_name() {
        let flags = "models = ['ms_mlp']\ndata.maps = 'maps'";
        let config = Config::resolve(Profile::Quick, None, flags.parse().unwrap()).unwrap();
        assert_eq!(config.profile_name(Profile::Quick), "quick");
    }

    #[test]
    fn unknown_keys_are_named() {
        for (text, key) in [
            ("sead = 1", "sead"),
            ("[training]\nepoch = 1", "epoch"),
            ("[model.ms_areg]\nlr = 1.0", "lr"),
            ("[model.alexnet]\nepochs = 1", "alexnet"),
            ("models = ['lenet']", "lenet"),
        ] {
            let error = format!("{:#}", with_file(text, "").unwrap_err());
            assert!(
                error.contains(key) && error.contains("bench.toml"),
                "{error}"
            );
            assert!(!error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn values_out_of_range_are_named() {
        for (text, key) in [
            ("[data]\ntest_maps = 0", "data.test_maps"),
            ("[latency]\nbatches = []", "latency.batches"),
            ("[latency]\nseconds = nan", "latency.seconds"),
            ("seed = 'x'", "seed"),
        ] {
            let error = format!("{:#}", with_file(text, "").unwrap_err());
            assert!(error.contains(key), "{error}");
        }
    }
}
