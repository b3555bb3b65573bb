//! Devices and models on the command line.

use aps_bench::Profile;
use aps_model::ModelKind;
use aps_model::condition::Frame;
use aps_model::train::Precision;
use clap::builder::{PossibleValue, TypedValueParser};
use map2aps::training::Device;
use xtask::named;

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
