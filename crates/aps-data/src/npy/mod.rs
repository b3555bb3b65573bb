//! NumPy's `.npy` files: read with every size checked, written as `np.save` writes them.
//!
//! Only what this project stores: C order, little endian, plain numbers. Bytes may come from
//! anywhere: a header longer than [`MAX_HEADER_BYTES`] is refused, the shape must account for
//! exactly the bytes that follow, and memory is taken only after both hold. That is why the dozen
//! lines of a header are parsed here and not by a general crate, which would read it as a nested
//! Python expression and multiply its lengths unchecked.
//!
//! ```
//! use aps_data::npy;
//! let mut file = Vec::new();
//! npy::write_to(&mut file, &[2, 3], &[1.0_f64, 2.0, 3.0, 4.0, 5.0, 6.0])?;
//! let array = npy::from_bytes::<f64>(&file)?;
//! assert_eq!((array.shape.as_slice(), array.data[5]), ([2, 3].as_slice(), 6.0));
//! assert!(npy::from_bytes::<f64>(&file[..file.len() - 1]).is_err());
//! # Ok::<(), npy::NpyError>(())
//! ```

mod element;
mod error;
mod header;
mod writer;

use std::fs::File;
use std::io::{Read, Seek, Write};
use std::ops::Range;
use std::path::Path;

pub use element::Element;
pub use error::NpyError;
pub use header::{Header, MAX_HEADER_BYTES, shape_text};
pub use writer::Writer;

/// Bytes decoded at a time: large enough to be quick, small beside any array of a map.
const CHUNK_BYTES: usize = 1 << 20;

/// Bytes an element of one of the types of [`Element`] takes.
pub(crate) fn size_of_dtype(dtype: &str) -> usize {
    dtype[2..].parse().expect("all types end in their size")
}

/// An array in memory, in C order.
#[derive(Debug, Clone, PartialEq)]
pub struct Array<T> {
    /// Length of each axis; empty for a single number.
    pub shape: Vec<usize>,
    /// The elements, last axis fastest.
    pub data: Vec<T>,
}

/// Reads a file; its length on disk must be exactly what the header says.
///
/// # Errors
/// Any [`NpyError`]; foreign bytes never panic and never make this take more memory than the file
/// is long.
pub fn read<T: Element>(path: impl AsRef<Path>) -> Result<Array<T>, NpyError> {
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    from_reader(file, length)
}

/// Reads rows, along the first axis, of the array in a file, which is checked as [`read`] checks it. The shape is that of the file,
/// the data are those of the rows alone.
///
/// # Errors
/// As [`read`], and [`NpyError::Length`] for rows that the array has not.
pub fn read_rows<T: Element>(
    path: impl AsRef<Path>,
    rows: Range<usize>,
) -> Result<Array<T>, NpyError> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let header = Header::read(&mut file, length)?;
    let count = header.check::<T>(length)?;
    let (shape, bytes) = (header.shape, length - header.length);
    let all = shape.first().copied().unwrap_or(0);
    if rows.end > all {
        return Err(NpyError::Length { shape, bytes });
    }
    let row_bytes = count.checked_div(all).unwrap_or(0) * T::SIZE;
    file.seek_relative((rows.start * row_bytes) as i64)?;
    let mut bytes = vec![0; rows.len() * row_bytes];
    file.read_exact(&mut bytes)?;
    let mut data = Vec::with_capacity(bytes.len() / T::SIZE);
    T::decode(&bytes, &mut data);
    Ok(Array { shape, data })
}

/// Reads an array from `length` bytes of a reader; see [`read`].
///
/// # Errors
/// As [`read`].
pub fn from_reader<T: Element>(mut reader: impl Read, length: u64) -> Result<Array<T>, NpyError> {
    let header = Header::read(&mut reader, length)?;
    let count = header.check::<T>(length)?;
    let mut data = Vec::with_capacity(count);
    let mut bytes = vec![0; (count * T::SIZE).min(CHUNK_BYTES / T::SIZE * T::SIZE)];
    while data.len() < count {
        let part = ((count - data.len()) * T::SIZE).min(bytes.len());
        reader.read_exact(&mut bytes[..part])?;
        T::decode(&bytes[..part], &mut data);
    }
    Ok(Array {
        shape: header.shape,
        data,
    })
}

/// Reads an array from bytes in memory; see [`read`].
///
/// # Errors
/// As [`read`].
pub fn from_bytes<T: Element>(bytes: &[u8]) -> Result<Array<T>, NpyError> {
    from_reader(bytes, bytes.len() as u64)
}

/// Writes an array, byte for byte as `np.save` of NumPy 2 does.
///
/// # Errors
/// [`NpyError::Length`] when `data` does not fill `shape`; [`NpyError::Io`].
pub fn write_to<T: Element>(
    sink: &mut impl Write,
    shape: &[usize],
    data: &[T],
) -> Result<(), NpyError> {
    let wanted = shape
        .iter()
        .try_fold(1, |product: usize, &n| product.checked_mul(n));
    if wanted != Some(data.len()) {
        return Err(NpyError::Length {
            shape: shape.to_vec(),
            bytes: (data.len() * T::SIZE) as u64,
        });
    }
    sink.write_all(&Header::bytes_for(T::DTYPE, shape))?;
    let mut bytes = Vec::new();
    for part in data.chunks(CHUNK_BYTES / T::SIZE) {
        bytes.clear();
        T::encode(part, &mut bytes);
        sink.write_all(&bytes)?;
    }
    Ok(())
}

/// Writes an array into a new file (an existing one is replaced); see [`write_to`].
///
/// # Errors
/// As [`write_to`].
pub fn write<T: Element>(
    path: impl AsRef<Path>,
    shape: &[usize],
    data: &[T],
) -> Result<(), NpyError> {
    write_to(&mut File::create(path)?, shape, data)
}
