//! Writes weights in half precision, as they are shipped: matrices and kernels as f16; vectors, running statistics and what a
//! model is given as a fact stay as they are.
//!
//! `cargo run --release -p aps-model --example halve -- best.safetensors weights.safetensors`

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use aps_model::candle_core::{DType, Device, safetensors as files};
use aps_model::weights::read_label;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [from, to] = [1, 2].map(|i| std::env::args().nth(i));
    let (from, to) = from
        .zip(to)
        .ok_or("give the file to read and the one to write")?;
    let label = read_label(Path::new(&from))?.ok_or("it does not say its model")?;
    let mut tensors = BTreeMap::new();
    for (name, tensor) in files::load(&from, &Device::Cpu)? {
        let is_large = tensor.rank() > 1 && tensor.dtype().is_float();
        let halved = match is_large && !name.starts_with("fixed.") {
            true => tensor.to_dtype(DType::F16)?,
            false => tensor,
        };
        tensors.insert(name, halved);
    }
    let label = format!("{} {}", label.kind, label.preset);
    let metadata = HashMap::from([("model".to_owned(), label)]);
    Ok(std::fs::write(
        to,
        safetensors::serialize(tensors, Some(metadata))?,
    )?)
}
