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
    is_shared::<Control<'static>>();
    is_shared::<DatasetPlan>();
    is_shared::<Examples>();
    is_shared::<Export>();
    is_shared::<ImportPropbin>();
    is_shared::<ImportReleased>();
    is_shared::<ImportSamples>();
    is_shared::<LinkList>();
    is_shared::<Made>();
    is_shared::<MapSource>();
    is_shared::<Sampling>();
    is_shared::<Scores>();
    is_shared::<Tally>();
    is_shared::<TileSettings>();
    is_shared::<Verify>();
    is_sent::<ArrayFile>();
    is_sent::<City>();
    is_sent::<Prediction<'static>>();
    is_sent::<Scoring>();
    is_sent::<Truth>();
    is_error::<Error>();
    is_error::<PathListError>();
}
