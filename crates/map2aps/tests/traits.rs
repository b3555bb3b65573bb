//! Traits that every public type implements, checked by the compiler. Errors are not copied: they carry the operating
//! system's error. Spectra that are read from a file are not copied either: they hold it.

use std::fmt::Debug;

use map2aps::maps::{City, TileSettings};
use map2aps::path_list::{LinkList, PathListError};
use map2aps::sampling::Sampling;
use map2aps::*;

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}
fn is_sent<T: Debug + Send + Sync + 'static>() {}
fn is_error<T: std::error::Error + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<(Control<'static>, DatasetPlan, Examples, Export)>();
    is_shared::<(ImportPropbin, ImportReleased, ImportSamples, LinkList)>();
    is_shared::<(Made, MapSource, Sampling, Scores, Tally, TileSettings)>();
    is_shared::<(City, Verify)>();
    is_sent::<(ArrayFile, Prediction<'static>, Scoring, Truth)>();
    is_error::<Error>();
    is_error::<PathListError>();
}

#[cfg(feature = "models")]
#[test]
fn types_of_training_can_be_shown_and_sent() {
    use map2aps::training::*;

    is_shared::<(ClosingScores, DevelopmentMaps, DevelopmentScores, Device)>();
    is_shared::<(InitialWeights, RunFolder, Settings, Training)>();
    // A run reads its next batch from a channel, which has one receiver.
    fn is_moved<T: Debug + Send + 'static>() {}
    is_moved::<Run>();
    is_sent::<Trained>();
    is_error::<TrainingError>();
}
