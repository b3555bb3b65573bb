//! A file with tensors, of either format: names and shapes first, values one by one.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use candle_core::{DType, Device, Tensor};
use safetensors::SafeTensors;

use super::torch::{Archive, TensorRecord};
use crate::{Error, Result};

/// An open file.
pub(super) struct Source {
    path: PathBuf,
    content: Content,
}

enum Content {
    Safetensors {
        bytes: Vec<u8>,
        /// Shape, type and place of the values in `bytes`.
        tensors: BTreeMap<String, Stored>,
        metadata: HashMap<String, String>,
    },
    Torch {
        archive: Archive,
        tensors: BTreeMap<String, TensorRecord>,
    },
}

struct Stored {
    shape: Vec<usize>,
    dtype: DType,
    at: std::ops::Range<usize>,
}

impl Source {
    /// Reads the file and its list of tensors. Which format it has is told by its first bytes: an archive of `torch.save`
    /// is a ZIP file.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).map_err(|e| Error::weights_io("read", path, e))?;
        let content = if bytes.starts_with(b"PK\x03\x04") {
            let archive = Archive::new(bytes).map_err(|e| Error::weights_format(path, e))?;
            let tensors = archive
                .state_dict()
                .map_err(|e| Error::weights_format(path, e))?;
            Content::Torch { archive, tensors }
        } else {
            Self::safetensors(bytes).map_err(|e| Error::weights_format(path, e))?
        };
        Ok(Self {
            path: path.to_owned(),
            content,
        })
    }

    fn safetensors(bytes: Vec<u8>) -> std::result::Result<Content, String> {
        let explain = |e| {
            format!(
                "it is neither safetensors ({e}) nor an archive of torch.save; files of PyTorch before 1.6 must be saved \
                 again by a later one"
            )
        };
        // Checks that the tensors fill what follows the header, without gaps.
        let (header, metadata) =
            SafeTensors::read_metadata(&bytes).map_err(|e| explain(e.to_string()))?;
        let mut tensors = BTreeMap::new();
        for (name, info) in metadata.tensors() {
            let dtype = DType::try_from(info.dtype).map_err(|_| {
                format!(
                    "{name} has the type {:?}, which is not supported",
                    info.dtype
                )
            })?;
            let (start, end) = info.data_offsets;
            let data = size_of::<u64>() + header;
            let stored = Stored {
                shape: info.shape.clone(),
                dtype,
                at: data + start..data + end,
            };
            tensors.insert(name, stored);
        }
        let metadata = metadata.metadata().clone().unwrap_or_default();
        Ok(Content::Safetensors {
            tensors,
            metadata,
            bytes,
        })
    }

    /// Names of all tensors, in order.
    pub(super) fn names(&self) -> Box<dyn Iterator<Item = &str> + '_> {
        match &self.content {
            Content::Safetensors { tensors, .. } => Box::new(tensors.keys().map(String::as_str)),
            Content::Torch { tensors, .. } => Box::new(tensors.keys().map(String::as_str)),
        }
    }

    /// Remarks of the writer.
    pub(super) fn metadata(&self) -> HashMap<String, String> {
        match &self.content {
            Content::Safetensors { metadata, .. } => metadata.clone(),
            Content::Torch { .. } => HashMap::new(),
        }
    }

    /// Shape and type of the tensor `name`, one of [`Source::names`].
    pub(super) fn shape(&self, name: &str) -> (&[usize], DType) {
        match &self.content {
            Content::Safetensors { tensors, .. } => (&tensors[name].shape, tensors[name].dtype),
            Content::Torch { tensors, .. } => (&tensors[name].shape, tensors[name].dtype),
        }
    }

    /// Values of the tensor `name`, one of [`Source::names`].
    pub(super) fn tensor(&self, name: &str) -> Result<Tensor> {
        match &self.content {
            Content::Safetensors { bytes, tensors, .. } => {
                let stored = &tensors[name];
                let values = &bytes[stored.at.clone()];
                Ok(Tensor::from_raw_buffer(
                    values,
                    stored.dtype,
                    &stored.shape,
                    &Device::Cpu,
                )?)
            }
            Content::Torch { archive, tensors } => archive
                .tensor(&tensors[name])
                .map_err(|e| Error::weights_format(&self.path, format!("{name}: {e}"))),
        }
    }
}
