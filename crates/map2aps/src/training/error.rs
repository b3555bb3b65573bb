//! Errors of training and prediction that are not those of the model.

use std::path::PathBuf;

use aps_model::weights::Label;
use aps_model::{ModelKind, candle_core};

use crate::differences::Difference;
use crate::maps::MapError;

/// Fault of a training, of its data, or of trained weights.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingError {
    /// The training was cancelled; everything is kept.
    #[error(
        "interrupted after {done}{} steps, all of which are kept in '{}'",
        total.map(|total| format!(" of {total}")).unwrap_or_default(), folder.display()
    )]
    Interrupted {
        /// Steps made.
        done: u64,
        /// Steps to make; `None` where time ends the training.
        total: Option<u64>,
        /// Folder of the run.
        folder: PathBuf,
    },
    /// A time budget that ended before the first step.
    #[error(
        "no step was made: {0:.1} s had gone by when the first could begin; give it more time, or less to load"
    )]
    NoStep(f64),
    /// A run is to be continued that was not begun.
    #[error("there is no run to continue in '{}'", .0.display())]
    NoRun(PathBuf),
    /// A folder of weights without their checkpoint.
    #[error(
        "'{}' would be replaced by a new run, and the checkpoint to go on from is not beside it; give another folder",
        .0.display()
    )]
    OnlyWeights(PathBuf),
    /// A device that is not there.
    #[error("the device {device} needs {hardware} and a build with the feature {device}")]
    Device {
        /// Name of the device.
        device: &'static str,
        /// Hardware that it needs.
        hardware: &'static str,
        /// Error of the device's driver.
        source: candle_core::Error,
    },
    /// A word that names no device.
    #[error("unknown device \"{0}\"; known are cpu, cuda, metal")]
    UnknownDevice(String),
    /// Spectra of another length than the models predict.
    #[error(
        "it has spectra of {found} bins, the models predict {}",
        aps_model::ANGLE_BINS
    )]
    Bins {
        /// Bins of the spectra.
        found: usize,
    },
    /// A chosen development map that is no training map.
    #[error("map {id} cannot be a development map; these must be among the training maps {pool:?}")]
    NotATrainingMap {
        /// The map.
        id: u32,
        /// Training and development maps of the data set.
        pool: Vec<u32>,
    },
    /// A data set without development maps, and none are chosen.
    #[error(
        "the data set has no development maps to choose the best weights by; {}",
        chosen_of(pool)
    )]
    NoDevelopmentMaps {
        /// Maps to choose from.
        pool: Vec<u32>,
    },
    /// A list of development maps that is none.
    #[error(transparent)]
    MapIds(#[from] MapError),
    /// A number of development maps that is none.
    #[error("'{0}' is not a number of maps; try count:4")]
    MapCount(String),
    /// Nothing to train on.
    #[error(
        "no map is left to train on beside the development maps {develop:?}; choose fewer, or make a data set of more maps"
    )]
    NoTrainingMaps {
        /// Maps that are held out.
        develop: Vec<u32>,
    },
    /// Maps without a labelled link.
    #[error("the {part} maps {maps:?} have no link with a label")]
    NoLinks {
        /// The part that the maps are for: training, development or test.
        part: &'static str,
        /// The maps.
        maps: Vec<u32>,
    },
    /// Labels of an unknown array, for a model that computes with it.
    #[error(
        "the model computes with the response of the array, and the data set does not say which one its labels are of"
    )]
    NoArray(#[source] crate::SettingsError),
    /// Images given to a model that takes other input.
    #[error("{0} takes no condition images")]
    NoImages(ModelKind),
    /// A run in the folder of a data set.
    #[error("'{}' is the folder of a data set; give the run another one", .0.display())]
    DatasetFolder(PathBuf),
    /// A single link's geometry given to a model that takes other input.
    #[error("{0} takes condition images, not the geometry of a link")]
    NoGeometry(ModelKind),
    /// Weights whose spectra cannot be turned into power.
    #[error(
        "the settings of the training of {0} are not known, or its targets do not tell their power"
    )]
    NoPower(ModelKind),
    /// Settings of another model beside weights.
    #[error(
        "it is of a training of {stored}, and the weights beside it are of {}, preset {}; move one of them elsewhere",
        found.kind, found.preset
    )]
    ForeignSettings {
        /// Model and preset of the settings.
        stored: String,
        /// Model and preset of the weights.
        found: Label,
    },
    /// A training whose weights predict no numbers any more.
    #[error(
        "after {0} steps the predictions of development links are not finite: the training diverged; try a lower learning rate"
    )]
    Diverged(u64),
    /// Statistics of targets that no power can be normalised by.
    #[error(
        "training_statistics are mean {mean} and deviation {std}: the deviation must be positive and no rounding; restore the file"
    )]
    Statistics {
        /// Mean of the training's powers.
        mean: f64,
        /// Their deviation.
        std: f64,
    },
    /// A width of the spots that no image can be drawn with.
    #[error("sigma_px is {0}: it must be positive; restore the file")]
    SpotWidth(f64),
    /// A run to continue whose best weights are gone.
    #[error(
        "the run has its best weights in '{}', which is not there; restore it, or start anew in another folder", .0.display()
    )]
    NoBest(PathBuf),
    /// A log of other columns.
    #[error("its columns are not those of this run; move it away to continue without it")]
    LogColumns,
    /// A log that lacks rows.
    #[error(
        "it has fewer rows than its checkpoint has seen; restore it, or move it away to continue without it"
    )]
    LogRows,
    /// A run without a score.
    #[error("no epoch has ended")]
    NoEpoch,
    /// A model of which no weights are shipped.
    #[error(
        "no weights of {kind} are shipped, only of {}; train it, or give a file",
        names(shipped)
    )]
    NotShipped {
        /// The model.
        kind: ModelKind,
        /// Models of which some are.
        shipped: Vec<ModelKind>,
    },
    /// Weights that do not name their model.
    #[error("'{}' does not say which model it is of; best.safetensors of a run does", .0.display())]
    Unnamed(PathBuf),
    /// Weights of another model.
    #[error(
        "'{}' holds weights of {}, preset {}, not of {}, preset {}",
        path.display(), found.kind, found.preset, expected.kind, expected.preset
    )]
    OtherModel {
        /// File of the weights.
        path: PathBuf,
        /// The model that the file names.
        found: Label,
        /// The model that was asked for.
        expected: Label,
    },
    /// Labels of another meaning than those that a model learnt.
    #[error(
        "{model} learnt labels of another {}, and its predictions cannot be held against these: {difference}{}",
        difference.setting, half_a_turn(difference)
    )]
    OtherLabels {
        /// The model.
        model: ModelKind,
        /// The setting in which they differ.
        difference: Difference,
    },
    /// A prediction from an image that is not finite.
    #[error(
        "the prediction of sample {0} is not finite: the weights are damaged, or belong elsewhere"
    )]
    NotFinite(usize),
}

/// Advice for a data set without development maps.
fn chosen_of(pool: &[u32]) -> String {
    match pool.len() {
        0 | 1 => {
            format!(
                "its training maps {pool:?} are too few to choose any: at least 3 maps give some to each part (--map-ids, --profile \
                 full, or a smaller --tile of a city)"
            )
        }
        _ => format!("choose some of {pool:?}"),
    }
}

/// The consequence of another protocol.
fn half_a_turn(difference: &Difference) -> &'static str {
    match difference.setting {
        "protocol" => "; their angles are half a turn away",
        _ => "",
    }
}

fn names(kinds: &[ModelKind]) -> String {
    let names: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
    names.join(", ")
}
