//! Checkpoints: the whole state of a training in one safetensors file.
//!
//! Tensors are named `predictor.NAME`, `predictor.optimizer.NAME.first` and `.second`, and the same for `regularizer`.
//! The metadata has one entry, `training`: the [`Header`] in JSON.

use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::io;
use std::path::Path;
use std::time::Duration;

use candle_core::{DType, Device, Tensor, Var};
use candle_nn::{Optimizer, VarMap};
use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};

use super::{TrainConfig, TrainError};
use crate::condition::Link;
use crate::data::Examples;
use crate::optim::AdamW;
use crate::parameters::{is_variance, sorted, trainable};
use crate::random::fnv1a;
use crate::replace::replace;
use crate::weights::{has_no_sign, is_finite};

const METADATA_KEY: &str = "training";

/// Version of the format; only this one is read.
const VERSION: u64 = 1;

/// Metadata of a checkpoint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    /// Steps made.
    pub steps: u64,
    /// Time spent \[s\], of a training that time ends. Others hold no time, so that the same steps give the same bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    pub config: TrainConfig,
    pub image_size: usize,
    /// Number of examples.
    pub examples: usize,
    /// [`digest`] of the examples' links.
    pub links: u64,
    /// Notes of the caller.
    pub notes: String,
}

#[derive(Serialize, Deserialize)]
struct Versioned<T> {
    version: u64,
    #[serde(flatten)]
    header: T,
}

/// The parameters of a network and the optimizer that updates them, under the network's name in checkpoints.
pub(super) struct Optimized {
    pub name: &'static str,
    pub parameters: VarMap,
    pub optimizer: AdamW,
}

impl Optimized {
    /// Creates the optimizer of the trainable parameters, before its first step.
    ///
    /// # Errors
    /// [`TrainError::Config`] when there are none.
    pub fn new(
        name: &'static str,
        parameters: &VarMap,
        config: &TrainConfig,
    ) -> Result<Self, TrainError> {
        let vars = trainable(parameters).into_iter().map(|(_, var)| var);
        let vars: Vec<Var> = vars.collect();
        if vars.is_empty() {
            let problem = format!("the parameters of the {name} hold no trainable tensors");
            return Err(TrainError::Config(problem));
        }
        let params = config.optimizer.with_rate(config.learning_rate);
        Ok(Self {
            name,
            parameters: parameters.clone(),
            optimizer: AdamW::new(vars, params)?,
        })
    }

    /// Returns the names of all moments in a checkpoint, in the order of the optimizer's variables.
    fn moment_names(&self) -> impl Iterator<Item = [String; 2]> {
        let names = trainable(&self.parameters).into_iter();
        let name = self.name;
        names.map(move |(var, _)| {
            ["first", "second"].map(|moment| format!("{name}.optimizer.{var}.{moment}"))
        })
    }
}

/// Writes a checkpoint.
pub(super) fn save<'a>(
    path: &Path,
    header: &Header,
    networks: impl Iterator<Item = &'a Optimized>,
) -> Result<(), TrainError> {
    let mut tensors = Vec::new();
    for network in networks {
        for (name, var) in sorted(&network.parameters) {
            tensors.push((format!("{}.{name}", network.name), var.as_detached_tensor()));
        }
        for (names, moments) in network.moment_names().zip(network.optimizer.moments()?) {
            tensors.extend(names.into_iter().zip(moments));
        }
    }
    let version = VERSION;
    let header = serde_json::to_string(&Versioned { version, header });
    let header = header.expect("plain numbers and text");
    let metadata = HashMap::from([(METADATA_KEY.to_owned(), header)]);
    let written = replace(path, |partial| {
        safetensors::serialize_to_file(tensors, Some(metadata), partial).map_err(io::Error::other)
    });
    written.map_err(|e| crate::Error::weights_io("write", path, e).into())
}

/// Reads a checkpoint into networks of the same kind. The checkpoint's header must agree with `own`. Nothing changes unless
/// everything fits.
pub(super) fn load<'a>(
    path: &Path,
    own: &Header,
    total: u64,
    networks: impl Iterator<Item = &'a mut Optimized>,
) -> Result<Header, TrainError> {
    let bad = |problem: String| TrainError::Checkpoint {
        path: path.into(),
        problem,
    };
    let bytes = fs::read(path).map_err(|e| crate::Error::weights_io("read", path, e))?;
    let header = read_header(&bytes).map_err(bad)?;
    if let Some(problem) = difference(&header, own) {
        return Err(bad(problem));
    }
    if header.steps > total {
        let steps = header.steps;
        return Err(bad(format!("{steps} steps of only {total} are made")));
    }
    let seconds = header.seconds.unwrap_or_default();
    if Duration::try_from_secs_f64(seconds).is_err() {
        return Err(bad(format!("{seconds} s cannot have been spent")));
    }
    let mut tensors = candle_core::safetensors::load_buffer(&bytes, &Device::Cpu)
        .map_err(|e| bad(format!("{e}; the file is damaged")))?;
    drop(bytes);
    let mut found = Vec::new();
    for network in networks {
        let mut values = Vec::new();
        for (name, var) in sorted(&network.parameters) {
            let stored = format!("{}.{name}", network.name);
            let tensor = take(&mut tensors, &stored, &var, var.dtype()).map_err(bad)?;
            if is_variance(&name) && !has_no_sign(&tensor)? {
                return Err(bad(format!("tensor '{stored}' holds a variance below 0")));
            }
            values.push((var, tensor));
        }
        let mut moments = Vec::new();
        let vars = trainable(&network.parameters).into_iter();
        for ([first, second], (_, var)) in network.moment_names().zip(vars) {
            let mut take = |name: &str| take(&mut tensors, name, &var, DType::F32).map_err(bad);
            moments.push([take(&first)?, take(&second)?]);
            if !has_no_sign(&moments[moments.len() - 1][1])? {
                return Err(bad(format!("tensor '{second}' holds a square below 0")));
            }
        }
        found.push((network, values, moments));
    }
    if let Some(name) = tensors.keys().min() {
        let text = format!("tensor '{name}' belongs to no network of this training");
        return Err(bad(text));
    }
    for (network, values, moments) in found {
        for (var, tensor) in values {
            var.set(&tensor.to_device(var.device())?)?;
        }
        network.optimizer.restore(header.steps, &moments)?;
    }
    Ok(header)
}

fn read_header(bytes: &[u8]) -> Result<Header, String> {
    let foreign = "not a checkpoint of a training; weights alone cannot be continued";
    let (_, metadata) = SafeTensors::read_metadata(bytes)
        .map_err(|e| format!("{e}; the file is damaged or {foreign}"))?;
    let metadata = metadata.metadata().as_ref();
    let text = metadata.and_then(|m| m.get(METADATA_KEY)).ok_or(foreign)?;
    let unreadable = |e| format!("its header cannot be read: {e}");
    let found: Versioned<serde_json::Value> = serde_json::from_str(text).map_err(unreadable)?;
    if found.version != VERSION {
        let version = found.version;
        return Err(format!("version {version} is not known, only {VERSION}"));
    }
    serde_json::from_value(found.header).map_err(unreadable)
}

/// Returns the first setting in which a checkpoint differs from the training it shall continue.
fn difference(stored: &Header, own: &Header) -> Option<String> {
    if (stored.examples, stored.links) != (own.examples, own.links) {
        return Some(format!(
            "it was written for {} other examples, this training has {}; give the same data, limit and development maps",
            stored.examples, own.examples
        ));
    }
    // Read back from text, as the stored one was: JSON may lose the last bit of a number with 17 digits.
    let text = serde_json::to_string(own).ok()?;
    let own: Header = serde_json::from_str(&text).ok()?;
    let settings = |header: &Header| -> Option<serde_json::Value> {
        let mut settings = serde_json::to_value(&header.config).ok()?;
        settings["image_size"] = header.image_size.into();
        Some(settings)
    };
    let (stored, own) = (settings(stored)?, settings(&own)?);
    let (key, value) = own
        .as_object()?
        .iter()
        .find(|(key, value)| stored.get(key) != Some(value))?;
    Some(format!(
        "it was written with {key} = {}, now it is {value}; continue with the same settings, or start anew elsewhere",
        stored[key]
    ))
}

/// Takes the finite tensor of a name, of the shape of `var`, in another type.
fn take(
    tensors: &mut HashMap<String, Tensor>,
    name: &str,
    var: &Var,
    dtype: DType,
) -> Result<Tensor, String> {
    let missing = || format!("tensor '{name}' is missing; is it of another model?");
    let tensor = tensors.remove(name).ok_or_else(missing)?;
    if tensor.shape() != var.shape() {
        let (found, wanted) = (tensor.dims(), var.dims());
        return Err(format!(
            "tensor '{name}' has shape {found:?}, the network {wanted:?}; is it of another model?"
        ));
    }
    let damaged = |e: &dyn Error| format!("tensor '{name}': {e}; the file is damaged");
    let tensor = tensor.to_dtype(dtype).map_err(|e| damaged(&e))?;
    match is_finite(&tensor).map_err(|e| damaged(&e))? {
        true => Ok(tensor),
        false => Err(format!("tensor '{name}' holds values that are not finite")),
    }
}

/// Computes the FNV-1a hash of all links, which tells one set of examples from another. O(examples).
pub(super) fn digest(examples: &dyn Examples) -> u64 {
    let words = (0..examples.len()).flat_map(|example| {
        let Link { map, tx_m, rx_m } = examples.link(example);
        let ends = [tx_m, rx_m].concat();
        std::iter::once(map.into()).chain(ends.into_iter().map(f64::to_bits))
    });
    fnv1a(words.flat_map(u64::to_le_bytes))
}
