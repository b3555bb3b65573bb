//! Writes weights in half precision, as they are shipped: matrices and kernels as f16; vectors, running statistics and what a
//! model is given as a fact stay as they are.
//!
//! `cargo run --release -p aps-model --example halve -- best.safetensors weights.safetensors`
//!
//! It takes the predictor of a checkpoint, `last.safetensors`, too; that does not say its model, which is then named
//! behind the files with its preset: `"ms_areg small"`.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use aps_model::candle_core::{DType, Device, safetensors as files};
use aps_model::weights::read_label;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let files = words.next().zip(words.next());
    let (from, to) = files.ok_or("give the file to read and the one to write")?;
    let label =
        match (words.next(), read_label(Path::new(&from))?) {
            (Some(label), _) => label,
            (None, Some(label)) => format!("{} {}", label.kind, label.preset),
            (None, None) => return Err(
                "it does not say its model: name it behind the files, such as \"ms_areg small\""
                    .into(),
            ),
        };
    let read = files::load(&from, &Device::Cpu)?;
    let is_checkpoint = read.keys().any(|name| name.starts_with("predictor."));
    let mut tensors = BTreeMap::new();
    for (name, tensor) in read {
        let name = match (is_checkpoint, name.strip_prefix("predictor.")) {
            (false, _) => name,
            (true, Some(name)) if !name.starts_with("optimizer.") => name.to_owned(),
            (true, _) => continue,
        };
        let is_large = tensor.rank() > 1 && tensor.dtype().is_float();
        let halved = match is_large && !name.starts_with("fixed.") {
            true => tensor.to_dtype(DType::F16)?,
            false => tensor,
        };
        tensors.insert(name, halved);
    }
    let metadata = HashMap::from([("model".to_owned(), label)]);
    let bytes = safetensors::serialize(tensors, Some(metadata))?;
    Ok(std::fs::write(to, bytes)?)
}
