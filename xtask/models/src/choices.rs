//! Devices and models on the command line.

use std::path::Path;

use anyhow::{Result, ensure};
use aps_bench::Profile;
use aps_model::condition::Frame;
use aps_model::train::Precision;
use aps_model::weights::Label;
use aps_model::{ModelKind, Preset};
use clap::builder::{PossibleValue, TypedValueParser};
use map2aps::training::Device;
use xtask::named;

/// Refuses a preset in which no weights come with the program, where these are taken for want of a file.
pub fn must_be_shipped(weights: Option<&Path>, asked: Option<Preset>, taken: Label) -> Result<()> {
    let is_shipped = weights.is_some() || asked.is_none_or(|asked| asked == taken.preset);
    ensure!(
        is_shipped,
        "the weights of {} that come with the program are of preset {}; leave --preset away, or name a file with --weights",
        taken.kind,
        taken.preset
    );
    Ok(())
}

/// Parser of `--device`.
pub fn devices() -> impl TypedValueParser<Value = Device> {
    named(Device::ALL.map(|device| {
        PossibleValue::new(device.name()).help(match device {
            Device::Cpu => "The processor",
            Device::Cuda => "The first NVIDIA GPU",
            Device::Metal => "The first Apple GPU",
        })
    }))
}

/// Parser of a model's name.
pub fn models() -> impl TypedValueParser<Value = ModelKind> {
    named(ModelKind::ALL.map(|kind| PossibleValue::new(kind.name()).help(kind.title())))
}

/// Parser of `--profile`.
pub fn profiles() -> impl TypedValueParser<Value = Profile> {
    named(Profile::ALL.map(|profile| PossibleValue::new(profile.name()).help(profile.purpose())))
}

/// Parser of `--precision`.
pub fn precisions() -> impl TypedValueParser<Value = Precision> {
    named(Precision::ALL.map(|precision| {
        PossibleValue::new(precision.name()).help(match precision {
            Precision::Full => "Everything in f32",
            Precision::Mixed => "Activations and factors of products in bf16, all else in f32",
        })
    }))
}

/// Parser of `--frame`.
pub fn frames() -> impl TypedValueParser<Value = Frame> {
    named(Frame::ALL.map(Frame::name))
}
