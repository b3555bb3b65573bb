//! `.npy` files of numbers, read some rows at a time.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use aps_data::npy::{Header, NpyError};
use aps_metrics::Shape;
use half::f16;

use super::ScoreError;
use crate::error::{At, Place, Result, must_be_file};

/// An open `.npy` file, its header checked against its length, at its first unread row.
#[derive(Debug)]
pub struct ArrayFile {
    path: PathBuf,
    reader: BufReader<File>,
    shape: Shape,
    number: Number,
    bytes: Vec<u8>,
    /// Place of the first row.
    start: u64,
}

/// The type of the elements, with their size \[bytes\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    Float(usize),
    Signed(usize),
    Unsigned(usize),
}

impl ArrayFile {
    /// Opens spectra: two axes, floating point.
    ///
    /// # Errors
    /// A file that cannot be read or holds something else.
    pub fn open_spectra(path: &Path) -> Result<Self> {
        let (header, number, reader) = open(path)?;
        let shape = match header.shape[..] {
            [samples, bins] if bins > 0 => Shape { samples, bins },
            _ => {
                let expected = "(samples, bins); reshape it with NumPy, one row a spectrum";
                return Err(of_shape(path, header.shape, expected).into());
            }
        };
        if !matches!(number, Number::Float(_)) {
            return of_type(path, header.dtype, "spectra in <f2, <f4 or <f8");
        }
        Self::new(path, reader, shape, number)
    }

    /// Opens ids: one axis, integers.
    ///
    /// # Errors
    /// A file that cannot be read or holds something else.
    pub fn open_ids(path: &Path) -> Result<Self> {
        let (header, number, reader) = open(path)?;
        let [samples] = header.shape[..] else {
            let expected = "(samples,): one id a sample; flatten it with NumPy";
            return Err(of_shape(path, header.shape, expected).into());
        };
        if matches!(number, Number::Float(_)) {
            return of_type(path, header.dtype, "integers");
        }
        Self::new(path, reader, Shape { samples, bins: 1 }, number)
    }

    fn new(path: &Path, mut reader: BufReader<File>, shape: Shape, number: Number) -> Result<Self> {
        Ok(Self {
            start: reader.stream_position().at_file(Place::Reading, path)?,
            path: path.into(),
            reader,
            shape,
            number,
            bytes: Vec::new(),
        })
    }

    /// Goes back to the first row.
    pub(super) fn rewind(&mut self) -> Result<()> {
        let start = SeekFrom::Start(self.start);
        self.reader
            .seek(start)
            .at_file(Place::Reading, &self.path)?;
        Ok(())
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Rows and columns of the whole file.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Replaces `values` by the next `rows` rows.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read_rows(&mut self, rows: usize, values: &mut Vec<f64>) -> Result<()> {
        self.bytes
            .resize(rows * self.shape.bins * self.number.size(), 0);
        self.reader
            .read_exact(&mut self.bytes)
            .at_file(Place::Reading, &self.path)?;
        values.clear();
        self.number.decode(&self.bytes, values);
        Ok(())
    }

    /// The next `rows` ids.
    ///
    /// # Errors
    /// A file that cannot be read, and [`ScoreError::MapId`].
    pub fn read_ids(&mut self, rows: usize) -> Result<Vec<u32>> {
        let mut values = Vec::new();
        self.read_rows(rows, &mut values)?;
        let id = |&value: &f64| {
            // Integers beyond 2^53 round, and are out of range all the same.
            let fits = (0.0..=f64::from(u32::MAX)).contains(&value);
            match fits {
                true => Ok(value as u32),
                false => Err(ScoreError::MapId {
                    path: self.path.clone(),
                    value,
                }),
            }
        };
        Ok(values.iter().map(id).collect::<Result<_, _>>()?)
    }
}

/// Header and element type of a file whose length agrees with them.
fn open(path: &Path) -> Result<(Header, Number, BufReader<File>)> {
    must_be_file(path).at_file(Place::File, path)?;
    let file = File::open(path).at_file(Place::File, path)?;
    let length = file.metadata().at_file(Place::File, path)?.len();
    let mut reader = BufReader::new(file);
    let header = Header::read(&mut reader, length).at_file(Place::File, path)?;
    let Some(number) = Number::of(&header.dtype) else {
        let expected = "little-endian floats or integers";
        return of_type(path, header.dtype, expected);
    };
    if header.fortran_order && header.shape.len() > 1 {
        return Err(NpyError::FortranOrder).at_file(Place::File, path);
    }
    header
        .count(number.size(), length)
        .at_file(Place::File, path)?;
    Ok((header, number, reader))
}

/// Refuses a file whose elements are of another type.
fn of_type<T>(path: &Path, found: String, expected: &'static str) -> Result<T> {
    Err(NpyError::Dtype { expected, found }).at_file(Place::File, path)
}

/// The refusal of a file with other axes.
fn of_shape(path: &Path, found: Vec<usize>, expected: &'static str) -> ScoreError {
    ScoreError::Shape {
        path: path.into(),
        found,
        expected,
    }
}

impl Number {
    fn of(dtype: &str) -> Option<Self> {
        let (kind, size) = dtype.split_at_checked(2)?;
        let size = size.parse().ok()?;
        match (kind, size) {
            ("<f", 2 | 4 | 8) => Some(Number::Float(size)),
            ("|i", 1) | ("<i", 2 | 4 | 8) => Some(Number::Signed(size)),
            ("|u", 1) | ("<u", 2 | 4 | 8) => Some(Number::Unsigned(size)),
            _ => None,
        }
    }

    fn size(self) -> usize {
        let (Number::Float(size) | Number::Signed(size) | Number::Unsigned(size)) = self;
        size
    }

    /// Appends the elements in `bytes` to `values`.
    fn decode(self, bytes: &[u8], values: &mut Vec<f64>) {
        let value = |b: &[u8]| match self {
            Number::Float(2) => f16::from_bits(unsigned(b) as u16).to_f64(),
            Number::Float(4) => f64::from(f32::from_bits(unsigned(b) as u32)),
            Number::Float(_) => f64::from_bits(unsigned(b)),
            Number::Unsigned(_) => unsigned(b) as f64,
            Number::Signed(size) => {
                // The sign bit moves to the top, and back with copies of itself.
                let unused = 64 - 8 * size as u32;
                ((unsigned(b) << unused) as i64 >> unused) as f64
            }
        };
        values.extend(bytes.chunks_exact(self.size()).map(value));
    }
}

fn unsigned(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_is_read() {
        let read = |dtype, bytes: &[u8]| {
            let mut values = Vec::new();
            Number::of(dtype).unwrap().decode(bytes, &mut values);
            values
        };
        assert_eq!(read("<f2", &[0x00, 0x3c, 0x00, 0xc0]), [1.0, -2.0]);
        assert_eq!(read("<f4", &1.5_f32.to_le_bytes()), [1.5]);
        assert_eq!(read("<f8", &(-0.1_f64).to_le_bytes()), [-0.1]);
        assert_eq!(read("|i1", &[0xff, 46]), [-1.0, 46.0]);
        assert_eq!(read("<i8", &(-7_i64).to_le_bytes()), [-7.0]);
        assert_eq!(read("<u2", &[0x00, 0xff]), [65_280.0]);
        assert_eq!(read("<u4", &u32::MAX.to_le_bytes()), [4_294_967_295.0]);
        assert!(Number::of(">f4").is_none());
    }
}
