//! Devices on the command line.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use map2aps::training::Device;

/// Parser of `--device`.
pub fn devices() -> impl TypedValueParser<Value = Device> {
    let names = PossibleValuesParser::new(Device::ALL.map(Device::name));
    names.try_map(|name| name.parse::<Device>())
}
