//! The header of an `.npy` file: a Python dictionary with three keys, padded to 64 bytes.
//!
//! Source: NumPy's `numpy/lib/format.py`, "NPY format version 1.0".

use std::io::Read;

use super::{Element, NpyError};

/// Longest header text accepted \[bytes\]. NumPy's own reader stops at 10,000; a plain array needs
/// about 60.
pub const MAX_HEADER_BYTES: u64 = 10_000;

/// Most axes accepted, as in NumPy before version 2.
const MAX_AXES: usize = 32;

const MAGIC: &[u8; 6] = b"\x93NUMPY";

/// First bytes of a zip archive.
const ZIP_MAGIC: &[u8; 4] = b"PK\x03\x04";

/// Most characters of a description of records in a message.
const MAX_TOLD_CHARS: usize = 80;

/// Writes a shape as NumPy does, e.g. `(3,)` or `(3, 2)`.
pub fn shape_text(shape: &[usize]) -> String {
    let comma = if shape.len() == 1 { "," } else { "" };
    let axes: Vec<String> = shape.iter().map(usize::to_string).collect();
    format!("({}{comma})", axes.join(", "))
}

/// Header of an `.npy` file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// NumPy's name of the element type, e.g. `<f2`. A float without a byte order, `f2` or `=f2`, is told as
    /// little endian: NumPy takes the reading machine's order.
    pub dtype: String,
    /// True if the first axis is the fastest.
    pub fortran_order: bool,
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// Bytes from the start of the file to the first element.
    pub length: u64,
}

impl Header {
    /// Reads the header of a file of `file_length` bytes, leaving the reader at the first element.
    ///
    /// # Errors
    /// [`NpyError`] for anything but a header of a plain array.
    pub fn read(reader: &mut impl Read, file_length: u64) -> Result<Header, NpyError> {
        let mut start = [0; 8];
        if file_length < 10 {
            return Err(NpyError::NotNpy);
        }
        reader.read_exact(&mut start)?;
        if start.starts_with(ZIP_MAGIC) {
            return Err(NpyError::Archive);
        }
        if !start.starts_with(MAGIC) {
            return Err(NpyError::NotNpy);
        }
        // Version 1 has a 16 bit length, 2 and 3 have 32 bits.
        let (claimed, before_text) = match (start[6], start[7]) {
            (1, 0) => {
                let mut length = [0; 2];
                reader.read_exact(&mut length)?;
                (u64::from(u16::from_le_bytes(length)), 10)
            }
            (2 | 3, 0) if file_length >= 12 => {
                let mut length = [0; 4];
                reader.read_exact(&mut length)?;
                (u64::from(u32::from_le_bytes(length)), 12)
            }
            (2 | 3, 0) => return Err(NpyError::NotNpy),
            (major, minor) => return Err(NpyError::Version { major, minor }),
        };
        let limit = MAX_HEADER_BYTES.min(file_length - before_text);
        if claimed > limit {
            return Err(NpyError::HeaderLength { claimed, limit });
        }
        let mut text = vec![0; claimed as usize];
        reader.read_exact(&mut text)?;
        Parser { text: &text, at: 0 }.header(before_text + claimed)
    }

    /// Checks type, order and size against a file of `file_length` bytes; returns the number of
    /// elements.
    pub(super) fn check<T: Element>(&self, file_length: u64) -> Result<usize, NpyError> {
        if self.dtype != T::DTYPE {
            return Err(NpyError::Dtype {
                expected: T::DTYPE,
                found: self.dtype.clone(),
            });
        }
        if self.fortran_order && self.shape.len() > 1 {
            return Err(NpyError::FortranOrder);
        }
        self.count(T::SIZE, file_length)
    }

    /// Number of elements, each of so many bytes, in a file of `file_length` bytes.
    ///
    /// # Errors
    /// [`NpyError::Length`] or [`NpyError::Longer`] when the file holds less or more than the shape says.
    pub fn count(&self, element_bytes: usize, file_length: u64) -> Result<usize, NpyError> {
        let bytes = file_length.saturating_sub(self.length);
        let count = self
            .shape
            .iter()
            .try_fold(1, |product: usize, &n| product.checked_mul(n));
        let wanted = count.and_then(|count| (count as u64).checked_mul(element_bytes as u64));
        match (count, wanted) {
            (Some(count), Some(wanted)) if wanted == bytes => Ok(count),
            (_, Some(wanted)) if wanted < bytes => Err(NpyError::Longer {
                shape: self.shape.clone(),
                extra: bytes - wanted,
            }),
            _ => Err(NpyError::Length {
                shape: self.shape.clone(),
                bytes,
            }),
        }
    }

    /// Returns the bytes that `np.save` of NumPy 2 writes before the elements.
    ///
    /// Their number does not depend on the length of the first axis, so that it may be filled in
    /// later.
    ///
    /// # Panics
    /// When the shape has more than a few thousand axes: a bug of the caller.
    pub fn bytes_for(dtype: &str, shape: &[usize]) -> Vec<u8> {
        let axes = shape_text(shape);
        let mut text = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {axes}, }}");
        if let Some(first) = shape.first() {
            // NumPy leaves room for the first axis to grow to 21 digits.
            text.extend(std::iter::repeat_n(' ', 21 - first.to_string().len()));
        }
        let unpadded = MAGIC.len() + 4 + text.len() + 1;
        text.extend(std::iter::repeat_n(' ', 64 - unpadded % 64));
        text.push('\n');
        let length = u16::try_from(text.len()).expect("a header of a few axes is short");
        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&[1, 0]);
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
        bytes
    }
}

/// Reads the one form of dictionary that describes a plain array; no recursion, so no depth to
/// exhaust.
struct Parser<'a> {
    text: &'a [u8],
    at: usize,
}

impl Parser<'_> {
    fn header(mut self, length: u64) -> Result<Header, NpyError> {
        let (mut dtype, mut fortran_order, mut shape) = (None, None, None);
        self.expect(b'{', "'{'")?;
        while !self.take(b'}') {
            match self.string()?.as_str() {
                "descr" if dtype.is_none() => {
                    self.expect(b':', "':'")?;
                    dtype = Some(self.dtype()?);
                }
                "fortran_order" if fortran_order.is_none() => {
                    self.expect(b':', "':'")?;
                    fortran_order = Some(self.boolean()?);
                }
                "shape" if shape.is_none() => {
                    self.expect(b':', "':'")?;
                    shape = Some(self.shape()?);
                }
                _ => return self.fail("one of 'descr', 'fortran_order', 'shape', each once"),
            }
            if !self.take(b',') && self.peek() != Some(b'}') {
                return self.fail("',' or '}'");
            }
        }
        if self.peek().is_some() {
            return self.fail("nothing but blanks after the dictionary");
        }
        match (dtype, fortran_order, shape) {
            (Some(dtype), Some(fortran_order), Some(shape)) => Ok(Header {
                dtype,
                fortran_order,
                shape,
                length,
            }),
            _ => self.fail("all of 'descr', 'fortran_order', 'shape'"),
        }
    }

    fn fail<T>(&self, expected: &'static str) -> Result<T, NpyError> {
        Err(NpyError::Header {
            at: self.at,
            expected,
        })
    }

    /// The next byte that is not blank, without taking it.
    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), NpyError> {
        if self.take(byte) {
            Ok(())
        } else {
            self.fail(expected)
        }
    }

    /// The description of the elements: a quoted name, or a list of the fields of a record.
    fn dtype(&mut self) -> Result<String, NpyError> {
        if matches!(self.peek(), Some(b'[' | b'(')) {
            let rest = String::from_utf8_lossy(&self.text[self.at..]);
            let fields = rest.split(']').next().unwrap_or_default();
            let mut descr: String = fields.chars().take(MAX_TOLD_CHARS).collect();
            descr.push_str(if descr.len() < fields.len() {
                "..."
            } else {
                "]"
            });
            return Err(NpyError::Structured { descr });
        }
        let name = self.string()?;
        Ok(match name.trim_start_matches('=') {
            native @ ("f2" | "f4" | "f8") => format!("<{native}"),
            _ => name,
        })
    }

    /// A quoted string without escapes.
    fn string(&mut self) -> Result<String, NpyError> {
        let quote = match self.peek() {
            Some(quote @ (b'\'' | b'"')) => quote,
            _ => return self.fail("a quoted string"),
        };
        let rest = &self.text[self.at + 1..];
        let end = rest
            .iter()
            .position(|&byte| byte == quote || byte == b'\\' || !byte.is_ascii());
        match end {
            Some(end) if rest[end] == quote => {
                self.at += end + 2;
                Ok(rest[..end].iter().map(|&byte| char::from(byte)).collect())
            }
            _ => self.fail("a quoted string"),
        }
    }

    fn boolean(&mut self) -> Result<bool, NpyError> {
        self.peek();
        for (word, value) in [("True", true), ("False", false)] {
            if self.text[self.at..].starts_with(word.as_bytes()) {
                self.at += word.len();
                return Ok(value);
            }
        }
        self.fail("True or False")
    }

    fn shape(&mut self) -> Result<Vec<usize>, NpyError> {
        self.expect(b'(', "'('")?;
        let mut shape = Vec::new();
        while !self.take(b')') {
            if shape.len() == MAX_AXES {
                return self.fail("at most 32 axes");
            }
            shape.push(self.length()?);
            if !self.take(b',') && self.peek() != Some(b')') {
                return self.fail("',' or ')'");
            }
        }
        Ok(shape)
    }

    fn length(&mut self) -> Result<usize, NpyError> {
        self.peek();
        let rest = &self.text[self.at..];
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let number = std::str::from_utf8(&rest[..digits])
            .ok()
            .and_then(|digits| digits.parse().ok());
        match number {
            Some(number) => {
                // Python 2 marked its long integers.
                let is_long = rest.get(digits) == Some(&b'L');
                self.at += digits + usize::from(is_long);
                Ok(number)
            }
            None => self.fail("the length of an axis"),
        }
    }
}
