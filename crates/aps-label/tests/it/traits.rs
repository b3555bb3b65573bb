//! Checks the traits of every public type, at compile time.

use std::fmt::Debug;

use aps_label::*;

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}
fn is_error<T: std::error::Error + Clone + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<(LabelConfig, DelayAxis, Array, Protocol, Labeler, Scratch)>();
    is_shared::<(Label, Status, PathSample, Normalization, Moments, MeanStd)>();
    is_shared::<(Axis, ArrayForm)>();
    is_error::<ConfigError>();
    is_error::<PathError>();
    is_error::<NormalizationError>();
    is_error::<ParseProtocolError>();
}
