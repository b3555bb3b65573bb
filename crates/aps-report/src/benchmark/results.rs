//! Results of a benchmark: `results.json`, from which a report is made again at any time.
//!
//! The file holds what was measured and nothing that follows from it: means, intervals and ranks
//! are computed when the report is written. Scores of single links are kept beside it, one
//! npy file an entry and protocol, because intervals, strata and distributions need them.
//!
//! Files of one [`FORMAT`] stay readable: fields are only added, and those added have a default. The
//! number is raised when that would no longer be enough, and a file with another number is refused.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::ReportError;

/// Version of the format that this code writes and reads.
pub const FORMAT: u32 = 3;

/// Name of the file in the folder of a benchmark.
pub const FILE: &str = "results.json";

/// Name of the baseline that the table in front always holds: the mean of the training targets, for every link.
pub const MEAN: &str = "mean spectrum";

/// Measurements that a report is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Version of the format: [`FORMAT`].
    pub format: u32,
    /// `smoke`, `quick`, `hour`, `night`, `paper` or `custom`.
    pub profile: String,
    /// Every setting, seeds included, as the command resolved it.
    pub configuration: serde_json::Value,
    /// Machine and time of the run.
    pub machine: Machine,
    /// The data learned from and scored on.
    pub data: DataSummary,
    /// The scored test links, in the order of the rows of all score files.
    pub links: Vec<TestLink>,
    /// The entries that were scored.
    pub entries: Vec<Entry>,
    /// Failures; the others went on without it.
    #[serde(default)]
    pub failed: Vec<Failure>,
    /// Left out because they predict labels of another meaning than these: of another protocol or array.
    #[serde(default)]
    pub left_out: Vec<Failure>,
    /// Links whose predictions are shown.
    #[serde(default)]
    pub examples: Vec<Example>,
}

/// The machine and the build a benchmark ran on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Machine {
    /// Name of the processor.
    pub cpu: String,
    /// Number of cores.
    pub cores: usize,
    /// Number of threads used.
    pub threads: usize,
    /// Memory \[bytes\].
    pub memory_bytes: u64,
    /// Operating system.
    pub os: String,
    /// Version of the compiler.
    pub rustc: String,
    /// Version of this program.
    pub version: String,
    /// Commit it was built from; empty if unknown.
    pub commit: String,
    /// Time of its beginning: ISO 8601, UTC.
    pub started: String,
    /// Time from the beginning to the end, reused parts not counted \[s\].
    pub seconds_total: f64,
}

/// The data of a benchmark.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DataSummary {
    /// Origin of the maps, in words: `synthetic city, seed 7` or the name of a folder.
    pub source: String,
    /// Maps learned from.
    pub train_maps: Vec<u32>,
    /// Maps on which the best weights were chosen.
    pub dev_maps: Vec<u32>,
    /// Maps scored on, seen by no model before.
    pub test_maps: Vec<u32>,
    /// Number of links learned from.
    pub train_links: u64,
    /// Number of links on which the best weights were chosen.
    pub dev_links: u64,
    /// Key of the metric by which they were chosen; empty where it was that of each model's loss.
    pub chosen_by: String,
    /// Number of links scored; equals the length of [`Results::links`].
    pub test_links: u64,
    /// Number of test links without any path: they have no label and are not scored.
    pub invalid_test_links: u64,
    /// Protocol of the labels: `paper` or `released`.
    pub protocol: String,
}

/// A test link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TestLink {
    /// Id of its map.
    pub map: u32,
    /// Number of its transmitter in the map.
    pub tx: u32,
    /// Number of its receiver in the map.
    pub rx: u32,
    /// Distance between the two \[m\].
    pub distance_m: f64,
    /// No building stands between the two.
    pub line_of_sight: bool,
    /// Number of dominant peaks of its label, by the paper's rule.
    pub dominant_peaks: u32,
}

/// A predictor of spectra, and how well it does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its name in tables, unique: `MS-AReg`, `tracer, 2 interactions`. The models of the paper have the names
    /// of its tables, by which its own figures are put beside theirs ([`super::paper`]).
    pub name: String,
    /// Its kind.
    pub kind: EntryKind,
    /// Name of the model that predicts, `MS-AReg`, which shipped weights share with the one trained here; none for what is no model.
    #[serde(default)]
    pub model: Option<String>,
    /// Number of parameters that are in use when it predicts.
    pub parameters: Option<u64>,
    /// Its training; none for what learns nothing or was trained elsewhere.
    pub training: Option<Training>,
    /// Measured run times; none for predictions from outside.
    pub latency: Vec<Latency>,
    /// Scores of all test links, once a protocol.
    pub scores: Vec<ProtocolScores>,
    /// Test links it had no answer for and for which the mean training spectrum was scored instead.
    #[serde(default)]
    pub substituted_links: u64,
}

/// Kinds of entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EntryKind {
    /// A model that the benchmark trained.
    Model,
    /// Weights that were trained before: those that come with the project, or of any file.
    Shipped,
    /// Predictions made elsewhere.
    External,
    /// A predictor that learns nothing from maps: the mean spectrum, the line of sight.
    Baseline,
    /// The ray tracer, with at most the interactions that the labels were made with.
    Tracer,
    /// A part of what the tracer finds, which says how far an answer of that part can come.
    Ceiling,
}

impl EntryKind {
    /// True for what was learnt from data.
    pub fn is_learned(self) -> bool {
        matches!(self, Self::Model | Self::Shipped | Self::External)
    }
}

/// The training of a model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Training {
    /// Time it took before its last scores, those before included \[s\].
    pub seconds: f64,
    /// Passes over the training links.
    pub epochs: f64,
    /// Steps before the scores of the weights that were kept.
    pub best_steps: Option<u64>,
    /// Number of links seen, repeats counted.
    pub links_seen: u64,
    /// Batch size \[links\].
    pub batch: usize,
    /// Highest learning rate.
    pub learning_rate: f64,
    /// Rows and columns of the images \[pixels\].
    pub image_size: usize,
    /// Scores of the development links while it learns.
    pub curve: Vec<CurvePoint>,
}

/// Scores of the development links after some steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CurvePoint {
    /// Steps made.
    pub steps: u64,
    /// Time spent before these scores \[s\].
    pub seconds: f64,
    /// Mean training loss since the scores before.
    pub train_loss: f64,
    /// Mean cosine similarity; none if it is not finite.
    pub dev_cosine: Option<f64>,
    /// Mean recall within 4 degrees; none if it is not finite.
    pub dev_recall: Option<f64>,
}

/// A measured run time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Latency {
    /// Links predicted at once.
    pub batch: usize,
    /// Median time a link, input excluded \[ms\].
    pub median_ms_per_link: f64,
    /// 95th percentile of the same \[ms\].
    pub p95_ms_per_link: f64,
    /// Median time a link to build the input \[ms\]; 0 where there is nothing to build.
    pub input_ms_per_link: f64,
    /// The device: `cpu`, `cuda:0`.
    pub device: String,
}

impl Latency {
    /// Time a link from positions to spectrum: input and prediction \[ms\].
    pub fn total_ms_per_link(&self) -> f64 {
        self.median_ms_per_link + self.input_ms_per_link
    }
}

/// Scores of an entry under one protocol.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProtocolScores {
    /// `paper` or `released`.
    pub protocol: String,
    /// Keys of the columns: [`aps_metrics::Metric::key`] of each of `Metric::ALL`.
    pub metrics: Vec<String>,
    /// The npy file, relative to the folder of `results.json`: links x metrics, f64, C order,
    /// every value finite.
    pub file: PathBuf,
}

/// An entry that was not scored.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Name of the entry.
    pub name: String,
    /// The reason.
    pub message: String,
}

/// A link whose prediction by the best of what was learnt is shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// Rank of the prediction among all links: `best`, `median` or `worst`.
    pub rank: String,
    /// Its place in [`Results::links`].
    pub link: usize,
    /// Its label, normalised as the models learn it.
    pub truth: Vec<f64>,
    /// Predictions, as many bins each.
    pub predictions: Vec<Prediction>,
    /// Rings of the buildings `[x, y]` \[m\]; what lies in an odd number of them is indoors.
    pub buildings: Vec<Vec<[f64; 2]>>,
    /// The transmitter `[x, y]` \[m\].
    pub tx_m: [f64; 2],
    /// The receiver `[x, y]` \[m\].
    pub rx_m: [f64; 2],
}

/// A predicted spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// Name of the entry.
    pub entry: String,
    /// Its prediction, normalised as the truth is.
    pub spectrum: Vec<f64>,
}

impl Results {
    /// Reads `results.json` in a folder.
    ///
    /// # Errors
    /// A file that cannot be read, is none of this format, or is of another version than [`FORMAT`].
    pub fn load(folder: &Path) -> Result<Self, ReportError> {
        /// The one field every version has.
        #[derive(Deserialize)]
        struct Version {
            format: u32,
        }
        let file = folder.join(FILE);
        let text =
            std::fs::read_to_string(&file).map_err(ReportError::at("read the results", &file))?;
        let unreadable = ReportError::at("take for results", &file);
        let Version { format } = serde_json::from_str(&text).map_err(&unreadable)?;
        if format != FORMAT {
            return Err(ReportError::Results(format!(
                "'{}' has format {format}; this version reads format {FORMAT}: use the one that wrote it",
                file.display(),
            )));
        }
        serde_json::from_str(&text).map_err(unreadable)
    }

    /// Writes `results.json` into a folder, whole or not at all.
    ///
    /// # Errors
    /// The file that cannot be written, and why.
    pub fn save(&self, folder: &Path) -> Result<(), ReportError> {
        let file = folder.join(FILE);
        let text = serde_json::to_string_pretty(self);
        let text = text.map_err(ReportError::at("write the results", &file))?;
        aps_data::replace_file(&file, (text + "\n").as_bytes())
            .map_err(ReportError::at("write the results", &file))
    }
}
