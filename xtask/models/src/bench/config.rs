//! Settings of a benchmark: a profile, changed by a file, changed by flags.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, ensure};
use aps_label::Protocol;
use aps_model::train::TrainConfig;
use aps_model::{ModelKind, Preset};
use clap::ValueEnum;
use map2aps::training::{Device, usual_image_size};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// Sizes of a benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// Under two minutes: does it run?
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

/// Every setting of a benchmark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Seed of terminals, synthetic cities, weights, order and drawn links.
    pub seed: u64,
    /// Models in the order of their training; all if not given.
    #[serde(default = "every_model")]
    pub models: Vec<ModelKind>,
    /// Device of the models.
    pub device: Device,
    /// The data set.
    pub data: DataConfig,
    /// Training of every model.
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
    /// Weights trained before, scored as they are, by the name they get in the tables.
    #[serde(default)]
    pub weights: BTreeMap<String, PathBuf>,
    /// Predictions from elsewhere, by the name they get in the tables.
    #[serde(default)]
    pub external: BTreeMap<String, PathBuf>,
}

/// Data that models learn from and are scored on. Limits of paths that are not given are as `dataset` makes them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataConfig {
    /// `synthetic`, or a folder of footprint files 0.json, 1.json, ...
    pub maps: String,
    /// Maps to learn from.
    pub train_maps: usize,
    /// Maps to choose the best weights by.
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_reflections: Option<usize>,
    /// Most diffractions on a path of the labels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_diffractions: Option<usize>,
    /// Test links scored, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test_links: Option<usize>,
}

/// Settings of the training of models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingConfig {
    /// `paper` or `small`.
    pub preset: Preset,
    /// Time of each model: `60s`, `10m`, `1h`. Without it `epochs` end a training.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub budget: Option<String>,
    /// Times each link is learnt from; the model's own in the paper if neither this nor `budget` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u64>,
    /// Links to learn from, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<usize>,
    /// Development links scored each time, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub develop_links: Option<usize>,
    /// Settings of every model for which [`Config::model`] says nothing else.
    #[serde(flatten)]
    pub all: ModelConfig,
}

/// Settings of a model; those that are not given are the paper's, and the image size that of the preset.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModelConfig {
    /// Rows and columns of condition images \[pixels\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image_size: Option<usize>,
    /// Links a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub batch: Option<usize>,
    /// Highest learning rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning_rate: Option<f64>,
    /// Steps on which the learning rate rises, within a tenth of the training.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warmup_steps: Option<u64>,
}

/// Settings with which the tracer is scored against the labels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracerConfig {
    /// Most interactions on a path, of those that the labels allow: an entry each.
    pub interactions: Vec<usize>,
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

fn every_model() -> Vec<ModelKind> {
    ModelKind::ALL.to_vec()
}

impl Profile {
    /// Its name, and its file beside the sources.
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

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        self.files().0
    }

    /// Its file in the project that this program was built from.
    pub fn path(self) -> PathBuf {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("profiles");
        folder.join(self.name()).with_extension("toml")
    }

    fn table(self) -> Table {
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
            let own = text.parse::<Table>().map_err(|e| in_one_line(&e));
            change(&mut table, own.with_context(place)?);
            Config::of(table.clone()).with_context(place)?;
        }
        // A flag is for all models: it replaces what a profile or file says of single ones.
        if let Some(Value::Table(training)) = flags.get("training")
            && let Some(Value::Table(models)) = table.get_mut("model")
        {
            for model in models.iter_mut().filter_map(|(_, m)| m.as_table_mut()) {
                model.retain(|key, _| !training.contains_key(key));
            }
        }
        change(&mut table, flags);
        Config::of(table)
    }

    fn of(table: Table) -> Result<Self> {
        let config: Config = table.try_into().map_err(|e| in_one_line(&e))?;
        config.check()?;
        Ok(config)
    }

    fn check(&self) -> Result<()> {
        for name in self.model.keys() {
            name.parse::<ModelKind>()?;
        }
        let data = &self.data;
        let smallest_batch = self.latency.batches.iter().copied().min();
        let counts = [
            ("data.train_maps", data.train_maps),
            ("data.develop_maps", data.develop_maps),
            ("data.test_maps", data.test_maps),
            ("data.tx_per_map", data.tx_per_map),
            ("data.rx_per_map", data.rx_per_map),
            ("data.test_links", data.test_links.unwrap_or(1)),
            ("latency.batches", smallest_batch.unwrap_or(0)),
        ];
        for (key, value) in counts {
            ensure!(value > 0, "{key} must be at least 1");
        }
        let seconds = self.latency.seconds;
        ensure!(
            seconds >= 0.0 && seconds.is_finite(),
            "latency.seconds is {seconds}: must be finite and not negative"
        );
        ensure!(
            self.training.epochs.is_none() || self.training.budget.is_none(),
            "training.budget and training.epochs both end a training: give one of them"
        );
        self.budget_s().map(|_| ())
    }

    /// The models, in order, each once.
    pub fn kinds(&self) -> Vec<ModelKind> {
        let mut seen = HashSet::new();
        let kinds = self.models.iter().copied();
        kinds.filter(|&kind| seen.insert(kind)).collect()
    }

    /// Time of each model's training \[s\]; none where epochs end it.
    pub fn budget_s(&self) -> Result<Option<f64>> {
        let parse = |text: &String| -> Result<f64> {
            let time = humantime::parse_duration(text);
            let time = time.with_context(|| format!("training.budget '{text}'"))?;
            ensure!(!time.is_zero(), "training.budget '{text}': must be above 0");
            Ok(time.as_secs_f64())
        };
        self.training.budget.as_ref().map(parse).transpose()
    }

    /// Settings of one model, its own before those of all.
    pub fn model(&self, kind: ModelKind) -> ModelConfig {
        let own = self.model.get(kind.name()).copied().unwrap_or_default();
        let all = self.training.all;
        ModelConfig {
            image_size: own.image_size.or(all.image_size),
            batch: own.batch.or(all.batch),
            learning_rate: own.learning_rate.or(all.learning_rate),
            warmup_steps: own.warmup_steps.or(all.warmup_steps),
        }
    }

    /// Size of a model's condition images \[pixels\].
    pub fn image_size(&self, kind: ModelKind) -> usize {
        let usual = usual_image_size(self.training.preset);
        self.model(kind).image_size.unwrap_or(usual)
    }

    /// Settings of a model's training.
    pub fn training(&self, kind: ModelKind) -> Result<TrainConfig> {
        let (own, usual) = (self.model(kind), kind.train_config(self.training.preset));
        Ok(TrainConfig {
            epochs: self.training.epochs.unwrap_or(usual.epochs),
            budget_s: self.budget_s()?,
            batch: own.batch.unwrap_or(usual.batch),
            learning_rate: own.learning_rate.unwrap_or(usual.learning_rate),
            warmup_steps: own.warmup_steps.unwrap_or(usual.warmup_steps),
            seed: self.seed,
            precision: self.device.usual_precision(),
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

/// Replaces values of `table` by those of `other`, table by table. Of budget and epochs, which both end a training, the later
/// one replaces the other.
fn change(table: &mut Table, other: Table) {
    if let (Some(Value::Table(own)), Some(Value::Table(new))) =
        (table.get_mut("training"), other.get("training"))
    {
        for [given, replaced] in [["epochs", "budget"], ["budget", "epochs"]] {
            if new.contains_key(given) {
                own.remove(replaced);
            }
        }
    }
    merge(table, other);
}

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

    fn with_file(text: &str, flags: &str) -> Result<Config> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bench.toml");
        std::fs::write(&path, text).unwrap();
        Config::resolve(Profile::Quick, Some(&path), flags.parse().unwrap())
    }

    #[test]
    fn quick_has_the_settings_of_hour_and_night_its_own() {
        let models = |profile| Config::resolve(profile, None, Table::new()).unwrap().model;
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
            (Profile::Smoke, Some(3.0)),
            (Profile::Quick, Some(60.0)),
            (Profile::Hour, Some(360.0)),
            (Profile::Night, Some(3600.0)),
            (Profile::Paper, None),
        ] {
            let config = Config::resolve(profile, None, Table::new()).unwrap();
            assert_eq!(config.profile_name(profile), profile.name());
            assert!(profile.path().is_file());
            assert_eq!(config.kinds(), ModelKind::ALL);
            // The weights that come with the program know no other labels.
            assert_eq!(config.data.protocol, Protocol::Paper);
            for kind in config.kinds() {
                assert_eq!(config.training(kind).unwrap().budget_s, budget_s);
            }
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
        let file =
            "seed = 7\n[training]\nbatch = 9\n[model.ms_areg]\nbatch = 11\nlearning_rate = 0.5";
        let config = with_file(file, "").unwrap();
        let batch = |config: &Config, kind| config.training(kind).unwrap().batch;
        assert_eq!(config.seed, 7);
        assert_eq!(batch(&config, ModelKind::MsAreg), 11);
        assert_eq!(config.profile_name(Profile::Quick), "custom");
        let config = with_file(file, "training.batch = 1").unwrap();
        assert!(ModelKind::ALL.iter().all(|&kind| batch(&config, kind) == 1));
        let areg = config.training(ModelKind::MsAreg).unwrap();
        assert_eq!(areg.learning_rate, 0.5);
    }

    #[test]
    fn of_budget_and_epochs_the_later_ends_a_training() {
        let ends = |file: &str, flags: &str| {
            let config = with_file(file, flags).unwrap();
            let training = config.training(ModelKind::MsMlp).unwrap();
            (training.budget_s, training.epochs)
        };
        assert_eq!(ends("[training]\nepochs = 3", ""), (None, 3));
        let minutes = "training.budget = '10m'";
        assert_eq!(ends("[training]\nepochs = 3", minutes), (Some(600.0), 20));
        let both = with_file("[training]\nepochs = 3\nbudget = '1h'", "").unwrap_err();
        assert!(format!("{both:#}").contains("give one"), "{both:#}");
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

    #[test]
    fn unknown_keys_are_named() {
        for (text, key) in [
            ("sead = 1", "sead"),
            ("[training]\nepoch = 1", "epoch"),
            ("[model.ms_areg]\nlr = 1.0", "lr"),
            ("[model.alexnet]\nbatch = 1", "alexnet"),
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
            ("[training]\nbudget = 'soon'", "training.budget"),
            ("[training]\nbudget = '0s'", "training.budget"),
            ("seed = 'x'", "seed"),
        ] {
            let error = format!("{:#}", with_file(text, "").unwrap_err());
            assert!(error.contains(key), "{error}");
        }
    }
}
