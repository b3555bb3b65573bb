//! Checkpoints: the whole state of a training in one safetensors file.
//!
//! Tensors are named `predictor.NAME`, `predictor.optimizer.NAME.first` and `.second`, and the same for `regularizer`.
//! The metadata has one entry, `training`: the [`Header`] in JSON.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io;
use std::path::Path;

use candle_core::{Device, Tensor, Var};
use safetensors::SafeTensors;
use serde::{Deserialize, Serialize};

use super::{TrainConfig, TrainError};
use crate::Parameters;
use crate::data::Examples;
use crate::optim::Adam;

const METADATA_KEY: &str = "training";

/// Version of the format; only this one is read.
const VERSION: u64 = 1;

/// Metadata of a checkpoint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Steps made.
    pub steps: u64,
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

/// A network's name, tensors and optimizer.
pub type Network<'a> = (&'static str, &'a Parameters, &'a mut Adam);

pub fn save(path: &Path, header: &Header, networks: Vec<Network<'_>>) -> Result<(), TrainError> {
    let mut tensors = Vec::new();
    for (network, parameters, adam) in networks {
        for (name, parameter) in parameters.all() {
            tensors.push((
                format!("{network}.{name}"),
                parameter.var.as_detached_tensor(),
            ));
        }
        for (name, moment) in adam.state()? {
            tensors.push((format!("{network}.optimizer.{name}"), moment));
        }
    }
    let header = serde_json::to_string(&Versioned {
        version: VERSION,
        header,
    })
    .expect("plain numbers and text");
    let metadata = HashMap::from([(METADATA_KEY.to_owned(), header)]);
    replace(path, |partial| {
        safetensors::serialize_to_file(tensors, Some(metadata), partial).map_err(io::Error::other)
    })
}

/// Reads a checkpoint into networks of the same kind. The checkpoint's header must agree with `own`.
pub fn load(
    path: &Path,
    own: &Header,
    total: u64,
    networks: Vec<Network<'_>>,
) -> Result<Header, TrainError> {
    let bad = |problem: String| TrainError::Checkpoint {
        path: path.into(),
        problem,
    };
    let bytes = fs::read(path).map_err(io_error("read", path))?;
    let header = read_header(&bytes).map_err(bad)?;
    if let Some(problem) = difference(&header, own) {
        return Err(bad(problem));
    }
    if header.steps > total {
        return Err(bad(format!(
            "{} steps of only {total} are made",
            header.steps
        )));
    }
    let mut tensors = candle_core::safetensors::load_buffer(&bytes, &Device::Cpu)
        .map_err(|e| bad(format!("{e}; the file is damaged")))?;
    drop(bytes);
    // Everything is found and checked before anything moves.
    let mut values: Vec<(Var, Tensor)> = Vec::new();
    let mut moments = Vec::new();
    for (network, parameters, adam) in networks {
        for (name, parameter) in parameters.all() {
            let name = format!("{network}.{name}");
            let tensor = take(&mut tensors, &name, &parameter.var).map_err(bad)?;
            values.push((parameter.var, tensor));
        }
        let mut state = HashMap::new();
        for (name, var) in parameters.trainable() {
            for moment in ["first", "second"] {
                let name = format!("{name}.{moment}");
                let tensor = take(&mut tensors, &format!("{network}.optimizer.{name}"), &var)
                    .map_err(bad)?;
                state.insert(name, tensor);
            }
        }
        moments.push((adam, state));
    }
    if let Some(name) = tensors.keys().min() {
        return Err(bad(format!(
            "tensor '{name}' belongs to no network of this training"
        )));
    }
    for (var, tensor) in values {
        let there = tensor
            .to_device(var.device())
            .and_then(|t| t.to_dtype(var.dtype()));
        there
            .and_then(|tensor| var.set(&tensor))
            .map_err(crate::Error::from)?;
    }
    for (adam, state) in moments {
        adam.restore(header.steps, &state)?;
    }
    Ok(header)
}

fn read_header(bytes: &[u8]) -> Result<Header, String> {
    let foreign = "not a checkpoint of a training; weights alone cannot be continued";
    let (_, metadata) = SafeTensors::read_metadata(bytes)
        .map_err(|e| format!("{e}; the file is damaged or {foreign}"))?;
    let text = metadata
        .metadata()
        .as_ref()
        .and_then(|m| m.get(METADATA_KEY))
        .ok_or(foreign)?;
    let versioned: Versioned<serde_json::Value> =
        serde_json::from_str(text).map_err(|e| format!("its header cannot be read: {e}"))?;
    if versioned.version != VERSION {
        return Err(format!(
            "version {} is not known, only {VERSION}",
            versioned.version
        ));
    }
    serde_json::from_value(versioned.header).map_err(|e| format!("its header cannot be read: {e}"))
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

fn take(tensors: &mut HashMap<String, Tensor>, name: &str, var: &Var) -> Result<Tensor, String> {
    let tensor = tensors.remove(name);
    let tensor =
        tensor.ok_or_else(|| format!("tensor '{name}' is missing; is it of another model?"))?;
    if tensor.shape() != var.shape() {
        let (found, wanted) = (tensor.dims(), var.dims());
        return Err(format!(
            "tensor '{name}' has shape {found:?}, the network {wanted:?}; is it of another model?"
        ));
    }
    Ok(tensor)
}

/// FNV-1a of all links: tells one set of examples from another. O(examples).
pub fn digest(examples: &dyn Examples) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut eat = |word: u64| {
        for byte in word.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for example in 0..examples.len() {
        let link = examples.link(example);
        eat(link.map.into());
        link.tx_m
            .iter()
            .chain(&link.rx_m)
            .for_each(|x| eat(x.to_bits()));
    }
    hash
}

/// Writes a file such that at any moment the old or the new one is there, whole.
fn replace(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<(), TrainError> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = folder.join(format!(".{name}.partial"));
    let written = write(&partial)
        .and_then(|()| File::open(&partial)?.sync_all())
        .and_then(|()| fs::rename(&partial, path));
    if written.is_err() {
        // Best effort: the error that matters is the one returned.
        let _ = fs::remove_file(&partial);
    }
    written.map_err(io_error("write", path))?;
    if cfg!(unix) {
        let synced = File::open(folder).and_then(|folder| folder.sync_all());
        synced.map_err(io_error("write", folder))?;
    }
    Ok(())
}

fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> TrainError {
    let path = path.into();
    move |source| TrainError::Io {
        action,
        path,
        source,
    }
}
