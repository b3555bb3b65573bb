//! Checks the traits of every public type, at compile time.

use std::fmt::Debug;

use aps_label::*;

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}
fn is_error<T: std::error::Error + Clone + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<LabelConfig>();
    is_shared::<DelayAxis>();
    is_shared::<Array>();
    is_shared::<Protocol>();
    is_shared::<Labeler>();
    is_shared::<Scratch>();
    is_shared::<Label>();
    is_shared::<Status>();
    is_shared::<PathSample>();
    is_shared::<Normalization>();
    is_shared::<Moments>();
    is_shared::<MeanStd>();
    is_error::<ConfigError>();
    is_error::<PathError>();
    is_error::<NormalizationError>();
    is_error::<ParseProtocolError>();
}
