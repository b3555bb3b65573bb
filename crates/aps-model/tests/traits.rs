//! Traits that every public type implements, checked by the compiler.

use std::fmt::Debug;

use aps_model::condition::{
    ConditionConfig, ConditionImages, Frame, InputKind, InputShape, Link, ModelInput, PolarShape,
    Rasters,
};
use aps_model::data::{Examples, Mirrored, Samples};
use aps_model::optim::{AdamConfig, AdamW};
use aps_model::train::{StepReport, TrainConfig, TrainError, Trainer};
use aps_model::weights::{Label, LoadReport};
use aps_model::{Error, LabelFacts, Loss, Model, ModelKind, Preset, Regularizer};

fn is_shared<T: Debug + Clone + Send + Sync>() {}
/// Accepts a type that owns state, which must not be copied by accident.
fn is_sent<T: Debug + Send>() {}
fn is_dyn<T: Debug + Send + Sync + ?Sized>() {}
fn is_error<T: std::error::Error + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<(ModelKind, Preset, Regularizer, ConditionImages)>();
    is_shared::<(ConditionConfig, Rasters<'static>, InputKind, InputShape)>();
    is_shared::<(PolarShape, LabelFacts, Loss, Link, Samples, Label)>();
    is_shared::<(LoadReport, AdamConfig, TrainConfig, StepReport)>();
    is_sent::<(AdamW, Trainer, Mirrored<Samples>)>();
    is_dyn::<dyn Model>();
    is_dyn::<dyn ModelInput>();
    is_dyn::<dyn Examples>();
    is_error::<Error>();
    is_error::<TrainError>();
}

#[test]
fn settings_survive_json_and_names_are_those_of_the_command_line() {
    for kind in ModelKind::ALL {
        let text = serde_json::to_string(&kind).unwrap();
        assert_eq!(text, format!("\"{}\"", kind.name()));
        assert_eq!(serde_json::from_str::<ModelKind>(&text).unwrap(), kind);
    }
    for preset in Preset::ALL {
        let text = serde_json::to_string(&preset).unwrap();
        assert_eq!(text, format!("\"{preset}\""));
    }
    for frame in Frame::ALL {
        assert_eq!(frame.to_string().parse::<Frame>().unwrap(), frame);
    }
    let told = "west".parse::<Frame>().unwrap_err().to_string();
    assert_eq!(told, "unknown frame \"west\"; known are map, receiver");
    let settings = (ConditionConfig::default(), TrainConfig::regression());
    let text = serde_json::to_string(&settings).unwrap();
    let read: (ConditionConfig, TrainConfig) = serde_json::from_str(&text).unwrap();
    assert_eq!(read, settings);
}

#[test]
fn no_message_repeats_its_cause() {
    let io = || std::io::Error::other("the cause");
    let unread = || Error::WeightsIo {
        action: "read",
        path: "file".into(),
        source: io(),
    };
    let errors: [Box<dyn std::error::Error>; 2] =
        [Box::new(unread()), Box::new(TrainError::Model(unread()))];
    for error in errors {
        assert!(error.source().is_some());
        assert!(!error.to_string().contains("the cause"), "{error}");
    }
}
