//! Faults of `.npy` files.

/// Fault of an `.npy` file, or of a request to write one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NpyError {
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file does not start with the magic bytes of `.npy`.
    #[error("not an .npy file: it does not start with \\x93NUMPY")]
    NotNpy,
    /// The file is a zip archive, which `.npz` files are.
    #[error(
        "an archive, not an .npy file: save one array of it alone, np.save(file, np.load(archive)[name])"
    )]
    Archive,
    /// A version of `.npy` other than 1.0, 2.0 and 3.0.
    #[error(".npy version {major}.{minor} is not known; save the array again with NumPy")]
    Version {
        /// Major version in the file.
        major: u8,
        /// Minor version in the file.
        minor: u8,
    },
    /// The header claims to be longer than the file or than [`MAX_HEADER_BYTES`](super::MAX_HEADER_BYTES).
    #[error("the header claims {claimed} bytes, but at most {limit} are possible here")]
    HeaderLength {
        /// Length given in the file \[bytes\].
        claimed: u64,
        /// Largest length accepted: the rest of the file, or [`MAX_HEADER_BYTES`](super::MAX_HEADER_BYTES).
        limit: u64,
    },
    /// The header is not the dictionary NumPy writes.
    #[error("the header is not readable at byte {at}: expected {expected}")]
    Header {
        /// Position in the header text \[bytes\].
        at: usize,
        /// Text expected there.
        expected: &'static str,
    },
    /// The elements are records of several values.
    #[error("the elements are records, {descr}, not single numbers; save one field, array[name]")]
    Structured {
        /// The beginning of NumPy's description of them.
        descr: String,
    },
    /// The elements have another type.
    #[error("the elements are {found:?}, expected {expected}; {}", remedy(found))]
    Dtype {
        /// NumPy's names of the wanted types.
        expected: &'static str,
        /// NumPy's name of the type in the file.
        found: String,
    },
    /// The array is stored column by column.
    #[error("the array is in Fortran order; save numpy.ascontiguousarray(array) instead")]
    FortranOrder,
    /// The number of bytes does not fit the shape.
    #[error("shape {shape:?} does not fit {bytes} bytes of data; the file is truncated or damaged")]
    Length {
        /// Shape in the header, or the shape asked for.
        shape: Vec<usize>,
        /// Bytes after the header, or bytes given.
        bytes: u64,
    },
    /// More bytes follow the header than the array takes.
    #[error(
        "the file goes on for {extra} bytes after its array of shape {shape:?}: more than one array, or one that was \
         not finished; save each array whole, in a file of its own"
    )]
    Longer {
        /// Shape in the header.
        shape: Vec<usize>,
        /// Bytes after the array.
        extra: u64,
    },
}

/// Tells how an array of such elements can be saved as one that is read.
fn remedy(dtype: &str) -> &'static str {
    match dtype.trim_start_matches(['<', '>', '|', '=']) {
        // NumPy has no cast from raw bytes, so it must be done before saving or by moving bits.
        "V2" => {
            "NumPy saves bfloat16 so: cast before saving, array.astype(np.float32), or convert this file, \
             (np.load(file).view(np.uint16).astype(np.uint32) << 16).view(np.float32)"
        }
        kind if kind.starts_with('V') => {
            "NumPy saves types so that it does not know: cast before saving, array.astype(np.float32)"
        }
        kind if kind.starts_with('c') => "save the absolute value, np.abs(array), or array.real",
        _ => "convert with NumPy's astype",
    }
}
