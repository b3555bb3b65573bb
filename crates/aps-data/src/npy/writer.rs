//! Arrays that grow while they are written.

use std::io::{Seek, SeekFrom, Write};

use super::{CHUNK_BYTES, Element, Header, NpyError};

/// Writes an array row by row, when the number of rows is known only at the end.
///
/// The header is written twice: as a placeholder at once, with the final shape by
/// [`Writer::finish`]. A file whose writer was dropped before that has zero rows in its header and
/// is refused by every reader.
#[derive(Debug)]
pub struct Writer<W> {
    sink: W,
    dtype: &'static str,
    /// Length of each axis but the first.
    row_shape: Vec<usize>,
    elements: usize,
    bytes: Vec<u8>,
}

impl<W: Write + Seek> Writer<W> {
    /// Starts an array of rows of the given shape, whose elements are of a type by its [`Element::DTYPE`]; an empty shape
    /// makes rows of one number.
    ///
    /// # Errors
    /// [`NpyError::Io`].
    pub fn new(mut sink: W, dtype: &'static str, row_shape: &[usize]) -> Result<Self, NpyError> {
        let placeholder = [&[0], row_shape].concat();
        sink.write_all(&Header::bytes_for(dtype, &placeholder))?;
        Ok(Writer {
            sink,
            dtype,
            row_shape: row_shape.to_vec(),
            elements: 0,
            bytes: Vec::new(),
        })
    }

    /// Appends elements: any number of them, rows may be given in parts.
    ///
    /// # Errors
    /// [`NpyError::Dtype`] for elements of another type, [`NpyError::Io`].
    pub fn push<T: Element>(&mut self, data: &[T]) -> Result<(), NpyError> {
        if T::DTYPE != self.dtype {
            return Err(NpyError::Dtype {
                expected: self.dtype,
                found: T::DTYPE.into(),
            });
        }
        for part in data.chunks(CHUNK_BYTES / T::SIZE) {
            self.bytes.clear();
            T::encode(part, &mut self.bytes);
            self.sink.write_all(&self.bytes)?;
        }
        self.elements += data.len();
        Ok(())
    }

    /// Writes the final shape into the header and returns the sink, flushed, with the number of
    /// rows.
    ///
    /// # Errors
    /// [`NpyError::Length`] when the last row is incomplete; [`NpyError::Io`].
    pub fn finish(mut self) -> Result<(W, usize), NpyError> {
        let row = self.row_shape.iter().product::<usize>().max(1);
        let rows = self.elements / row;
        let shape = [&[rows], self.row_shape.as_slice()].concat();
        if !self.elements.is_multiple_of(row) {
            let bytes = self.elements as u64 * super::size_of_dtype(self.dtype) as u64;
            return Err(NpyError::Length {
                shape: self.row_shape,
                bytes,
            });
        }
        self.sink.seek(SeekFrom::Start(0))?;
        self.sink
            .write_all(&Header::bytes_for(self.dtype, &shape))?;
        self.sink.flush()?;
        Ok((self.sink, rows))
    }
}
