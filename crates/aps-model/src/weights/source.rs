//! A file with tensors, of either format: names and shapes first, values one by one.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use candle_core::{DType, Device, Tensor};
use safetensors::SafeTensors;

use super::torch::{Archive, Entries, TensorRecord};
use crate::{Error, Result};

/// Open file with tensors.
pub(super) struct Source {
    path: PathBuf,
    content: Content,
    /// Entries that cannot be read as tensors.
    others: Vec<String>,
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

/// Content of a file, and descriptions of its entries that cannot be read as tensors.
type Opened = std::result::Result<(Content, Vec<String>), String>;

struct Stored {
    shape: Vec<usize>,
    dtype: DType,
    at: std::ops::Range<usize>,
}

impl Source {
    /// Reads the file and its list of tensors. The first bytes tell the format: an archive of `torch.save` is a ZIP file.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).map_err(|e| Error::weights_io("read", path, e))?;
        Self::of_bytes(path, bytes)
    }

    /// Reads the list of tensors of a file's bytes; errors name the file `path`.
    pub(super) fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self> {
        let opened = match bytes.starts_with(b"PK\x03\x04") {
            true => Self::archive(bytes),
            false => Self::safetensors(bytes),
        };
        let (content, others) = opened.map_err(|e| Error::weights_format(path, e))?;
        Ok(Self {
            path: path.to_owned(),
            content,
            others,
        })
    }

    fn archive(bytes: Vec<u8>) -> Opened {
        let archive = Archive::new(bytes)?;
        let Entries { tensors, others } = archive.entries()?;
        Ok((Content::Torch { archive, tensors }, others))
    }

    fn safetensors(bytes: Vec<u8>) -> Opened {
        let explain = |e| {
            format!(
                "it is neither safetensors ({e}) nor an archive of torch.save; files of PyTorch before 1.6 must be saved \
                 again by a later one"
            )
        };
        // Checks that the tensors fill what follows the header, without gaps.
        let (header, metadata) =
            SafeTensors::read_metadata(&bytes).map_err(|e| explain(e.to_string()))?;
        let (mut tensors, mut others) = (BTreeMap::new(), Vec::new());
        for (name, info) in metadata.tensors() {
            let kind = info.dtype;
            let dtype = DType::try_from(kind).ok();
            let Some(dtype) = dtype.filter(|&dtype| can_be_converted(dtype)) else {
                let text = format!("{name} (values of the type {kind:?} are not supported)");
                others.push(text);
                continue;
            };
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
        let content = Content::Safetensors {
            tensors,
            metadata,
            bytes,
        };
        Ok((content, others))
    }

    /// The file, which errors name.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Names of all tensors, in order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> + Clone {
        let (ours, theirs) = match &self.content {
            Content::Safetensors { tensors, .. } => (Some(tensors.keys()), None),
            Content::Torch { tensors, .. } => (None, Some(tensors.keys())),
        };
        let ours = ours.into_iter().flatten();
        let all = ours.chain(theirs.into_iter().flatten());
        all.map(String::as_str)
    }

    /// Entries that are no tensors, or such as cannot be read, with the reason.
    pub(super) fn others(&self) -> &[String] {
        &self.others
    }

    /// Returns the metadata of the file, remarks of its writer.
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
                let (dtype, shape) = (stored.dtype, &stored.shape);
                Ok(Tensor::from_raw_buffer(values, dtype, shape, &Device::Cpu)?)
            }
            Content::Torch { archive, tensors } => archive
                .tensor(&tensors[name])
                .map_err(|e| Error::weights_format(&self.path, format!("{name}: {e}"))),
        }
    }
}

/// True for types that candle converts: of those below 8 bits, and of exponents alone, it knows the name only.
fn can_be_converted(dtype: DType) -> bool {
    use DType::{F4, F6E2M3, F6E3M2, F8E8M0};
    !matches!(dtype, F4 | F6E2M3 | F6E3M2 | F8E8M0)
}
