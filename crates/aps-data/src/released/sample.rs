//! Preprocessed samples: `.npz` archives of a model's target and input.

use std::io::{self, Cursor, Read, Seek, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::npy::{self, Array, NpyError};

/// Largest array of a sample that is read \[bytes\].
pub const MAX_SAMPLE_BYTES: u64 = 1 << 26;

/// Arrays of a preprocessed sample, as `np.load` finds them.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// The normalised APS, shape (bins,).
    pub aps_norm: Vec<f32>,
    /// Height and width of the condition image.
    pub size: [usize; 2],
    /// The condition image, shape (3, height, width): buildings, transmitter, receiver.
    pub cond_img: Vec<f32>,
}

/// Reason for which a sample cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SampleError {
    /// The file is no archive, or a damaged one.
    #[error("not a readable .npz archive")]
    Zip(#[from] ZipError),
    /// An array of the archive is compressed in a way that is not read.
    #[error(
        "array {array} is compressed by {method}; save it with numpy.savez or numpy.savez_compressed"
    )]
    Compression {
        /// Name of the array.
        array: &'static str,
        /// The method, or its number in the archive.
        method: String,
    },
    /// The archive has no array of that name.
    #[error(
        "no {array}.npy in the archive, {}; save it with numpy.savez(file, {TARGET}=..., {IMAGE}=...)",
        listed(found)
    )]
    Missing {
        /// Name of the array.
        array: &'static str,
        /// Names of the files in the archive.
        found: Vec<String>,
    },
    /// An array of the archive is not what it should be.
    #[error("array {array}")]
    Npy {
        /// Name of the array.
        array: &'static str,
        /// Fault of the array.
        source: NpyError,
    },
    /// An array is larger than any sample's.
    #[error("{array} is {bytes} bytes long, at most {MAX_SAMPLE_BYTES} are read")]
    TooLarge {
        /// Name of the array.
        array: &'static str,
        /// Length of the array according to the archive \[bytes\].
        bytes: u64,
    },
    /// An array has another shape.
    #[error("{array} has the shape {found:?}, expected {expected}")]
    Shape {
        /// Name of the array.
        array: &'static str,
        /// Shape expected.
        expected: &'static str,
        /// Shape of the array.
        found: Vec<usize>,
    },
    /// A number is NaN or infinite.
    #[error("{array} holds a number that is not finite")]
    NotFinite {
        /// Name of the array.
        array: &'static str,
    },
}

/// Most names of an archive's files in a message.
const MAX_TOLD_NAMES: usize = 8;

/// Lists the names of an archive's files in words.
fn listed(names: &[String]) -> String {
    let told: Vec<String> = names
        .iter()
        .take(MAX_TOLD_NAMES)
        .map(|n| format!("{n:?}"))
        .collect();
    match names.len().saturating_sub(told.len()) {
        0 if told.is_empty() => "which is empty".into(),
        0 => format!("which holds {}", told.join(", ")),
        more => format!("which holds {} and {more} more", told.join(", ")),
    }
}

const TARGET: &str = "aps_norm";
const IMAGE: &str = "cond_img";

impl Sample {
    /// Returns an archive as `np.savez_compressed` makes it: the same arrays, compressed; the same bytes each time.
    ///
    /// # Errors
    /// [`SampleError::Npy`] when the image does not have three planes of its size, [`SampleError::Zip`].
    pub fn to_npz(&self) -> Result<Vec<u8>, SampleError> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        // Spots and zeros compress well at any level; the fastest halves the time.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(1));
        let arrays = [
            (TARGET, vec![self.aps_norm.len()], &self.aps_norm),
            (IMAGE, vec![3, self.size[0], self.size[1]], &self.cond_img),
        ];
        for (array, shape, data) in arrays {
            let mut bytes = Vec::new();
            npy::write_to(&mut bytes, &shape, data)
                .map_err(|source| SampleError::Npy { array, source })?;
            zip.start_file(format!("{array}.npy"), options)?;
            zip.write_all(&bytes).map_err(ZipError::Io)?;
        }
        Ok(zip.finish()?.into_inner())
    }

    /// Reads an archive with these two arrays, compressed or not; others are passed over.
    ///
    /// # Errors
    /// [`SampleError`]. No array takes more memory than [`MAX_SAMPLE_BYTES`].
    pub fn from_npz(bytes: &[u8]) -> Result<Self, SampleError> {
        let mut zip = ZipArchive::new(Cursor::new(bytes))?;
        let target = array(&mut zip, TARGET)?;
        let image = array(&mut zip, IMAGE)?;
        let shape = |array, expected, found| SampleError::Shape {
            array,
            expected,
            found,
        };
        let [_] = target.shape[..] else {
            return Err(shape(TARGET, "(bins,)", target.shape));
        };
        let [3, height, width] = image.shape[..] else {
            return Err(shape(IMAGE, "(3, height, width)", image.shape));
        };
        Ok(Sample {
            aps_norm: target.data,
            size: [height, width],
            cond_img: image.data,
        })
    }
}

fn array<R: Read + Seek>(
    zip: &mut ZipArchive<R>,
    array: &'static str,
) -> Result<Array<f32>, SampleError> {
    let name = format!("{array}.npy");
    let Some(index) = zip.index_for_name(&name) else {
        let found = zip
            .file_names()
            .filter_map(|name| Some(name.ok()?.into_owned()))
            .collect();
        return Err(SampleError::Missing { array, found });
    };
    let mut file = zip.by_index(index)?;
    let method = file.compression();
    if !matches!(
        method,
        CompressionMethod::Stored | CompressionMethod::Deflated
    ) {
        let method = method.to_string();
        return Err(SampleError::Compression { array, method });
    }
    // Length of the array according to the archive; a wrong one is found when the array does not fit it.
    let bytes = file.size();
    if bytes > MAX_SAMPLE_BYTES {
        return Err(SampleError::TooLarge { array, bytes });
    }
    let found =
        npy::from_reader(&mut file, bytes).map_err(|source| SampleError::Npy { array, source })?;
    // The archive's checksum is compared at the end of the entry, where nothing may be left.
    let left = io::copy(&mut file, &mut io::sink()).map_err(ZipError::Io)?;
    if left > 0 {
        let (shape, extra) = (found.shape, left);
        let source = NpyError::Longer { shape, extra };
        return Err(SampleError::Npy { array, source });
    }
    match found.data.iter().all(|v: &f32| v.is_finite()) {
        true => Ok(found),
        false => Err(SampleError::NotFinite { array }),
    }
}
