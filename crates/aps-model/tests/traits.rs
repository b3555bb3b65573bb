//! Traits that every public type implements, checked by the compiler.

use std::fmt::Debug;

use aps_model::condition::{ConditionConfig, Conditions, Link, Rasters};
use aps_model::data::{Examples, Samples};
use aps_model::layers::*;
use aps_model::models::*;
use aps_model::ops::{After, BatchNormTensors, ConvTensors};
use aps_model::optim::{Adam, AdamConfig, Schedule};
use aps_model::train::{Quantity, StepReport, TrainConfig, TrainError, Trainees, Trainer};
use aps_model::weights::LoadReport;
use aps_model::{Error, Init, Kind, Mode, Model, ModelKind, Parameter, Parameters, Preset, Scope};

fn is_shared<T: Debug + Clone + Send + Sync>() {}
/// Accepts a type that owns state, which must not be copied by accident.
fn is_sent<T: Debug + Send>() {}
fn is_dyn<T: Debug + Send + Sync + ?Sized>() {}
fn is_error<T: std::error::Error + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<ModelKind>();
    is_shared::<Preset>();
    is_shared::<Parameters>();
    is_shared::<Parameter>();
    is_shared::<Kind>();
    is_shared::<Scope>();
    is_shared::<Init>();
    is_shared::<Mode<'static>>();
    is_shared::<Conditions>();
    is_shared::<ConditionConfig>();
    is_shared::<Rasters<'static>>();
    is_shared::<Link>();
    is_shared::<Samples>();
    is_shared::<LoadReport>();
    is_shared::<AdamConfig>();
    is_shared::<Schedule>();
    is_shared::<TrainConfig>();
    is_shared::<StepReport>();
    is_shared::<Quantity>();
    is_sent::<Adam>();
    is_sent::<Trainees>();
    is_sent::<Trainer>();
    is_dyn::<dyn Model>();
    is_dyn::<dyn Examples>();
    is_error::<Error>();
    is_error::<TrainError>();
}

#[test]
fn networks_and_their_parts_too() {
    is_shared::<MsAreg>();
    is_shared::<MsMlp>();
    is_shared::<AdvMlp>();
    is_shared::<ResnetMlp>();
    is_shared::<RadioUnet>();
    is_shared::<VitReg>();
    is_shared::<VitRegConfig>();
    is_shared::<ResnetConv1d>();
    is_shared::<Regularizer>();
    is_shared::<BatchNorm>();
    is_shared::<Conv1d>();
    is_shared::<Conv2d>();
    is_shared::<ConvTranspose2x2>();
    is_shared::<NormedConv>();
    is_shared::<DoubleConv>();
    is_shared::<EncoderBlock>();
    is_shared::<SelfAttention>();
    is_shared::<Film>();
    is_shared::<LayerNorm>();
    is_shared::<Linear>();
    is_shared::<Mlp>();
    is_shared::<MultiScale>();
    is_shared::<MultiScaleEncoder>();
    is_shared::<ResNet18>();
    is_shared::<Stage>();
    is_shared::<After<'static>>();
    is_shared::<BatchNormTensors<'static>>();
    is_shared::<ConvTensors<'static>>();
}

#[test]
fn settings_survive_json_and_names_are_those_of_the_command_line() {
    for kind in ModelKind::ALL {
        let text = serde_json::to_string(&kind).unwrap();
        assert_eq!(text, format!("\"{}\"", kind.name()));
        assert_eq!(serde_json::from_str::<ModelKind>(&text).unwrap(), kind);
    }
    for preset in [Preset::Paper, Preset::Small] {
        let text = serde_json::to_string(&preset).unwrap();
        assert_eq!(text, format!("\"{preset}\""));
    }
    let settings = (ConditionConfig::default(), TrainConfig::regression());
    let text = serde_json::to_string(&settings).unwrap();
    let read: (ConditionConfig, TrainConfig) = serde_json::from_str(&text).unwrap();
    assert_eq!(read, settings);
}

#[test]
fn no_message_repeats_its_cause() {
    let io = || std::io::Error::other("the cause");
    let errors: [Box<dyn std::error::Error>; 2] = [
        Box::new(Error::WeightsIo {
            action: "read",
            path: "file".into(),
            source: io(),
        }),
        Box::new(TrainError::Io {
            action: "read",
            path: "file".into(),
            source: io(),
        }),
    ];
    for error in errors {
        assert!(
            error.source().is_some() && !error.to_string().contains("the cause"),
            "{error}"
        );
    }
}
