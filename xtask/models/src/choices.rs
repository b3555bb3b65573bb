//! Devices and models on the command line.

use aps_model::ModelKind;
use aps_model::condition::Frame;
use aps_model::train::Precision;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use map2aps::training::Device;

/// Parser of `--device`.
pub fn devices() -> impl TypedValueParser<Value = Device> {
    let value = |device: Device| {
        PossibleValue::new(device.name()).help(match device {
            Device::Cpu => "The processor",
            Device::Cuda => "The first NVIDIA GPU",
            Device::Metal => "The first Apple GPU",
        })
    };
    let parser = PossibleValuesParser::new(Device::ALL.map(value));
    parser.try_map(|name| name.parse::<Device>())
}

/// Parser of a model's name.
pub fn models() -> impl TypedValueParser<Value = ModelKind> {
    let value = |kind: ModelKind| PossibleValue::new(kind.name()).help(kind.title());
    let parser = PossibleValuesParser::new(ModelKind::ALL.map(value));
    parser.try_map(|name| name.parse::<ModelKind>())
}

/// Parser of `--precision`.
pub fn precisions() -> impl TypedValueParser<Value = Precision> {
    let value = |precision: Precision| {
        PossibleValue::new(precision.name()).help(match precision {
            Precision::Full => "Everything in f32",
            Precision::Mixed => "Activations and factors of products in bf16, all else in f32",
        })
    };
    let parser = PossibleValuesParser::new(Precision::ALL.map(value));
    parser.try_map(|name| name.parse::<Precision>())
}

/// Parser of `--frame`.
pub fn frames() -> impl TypedValueParser<Value = Frame> {
    let parser = PossibleValuesParser::new(Frame::ALL.map(Frame::name));
    parser.try_map(|name| name.parse::<Frame>())
}
