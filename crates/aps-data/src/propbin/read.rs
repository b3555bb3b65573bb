//! Reading: the header first, then the length it promises, then the tables.

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path as FilePath;

use flate2::read::MultiGzDecoder;
use half::f16;

use super::{
    Direction, Entries, HEADER_BYTES, MAGIC, MAX_BYTES, Path, Propbin, PropbinError,
    RECEIVER_BYTES, Receiver, Stored, Version,
};

/// The first bytes of whatever gzip wrote.
const GZIP: [u8; 2] = [0x1f, 0x8b];

struct Header {
    version: Version,
    source_m: [f32; 3],
    receivers: usize,
    paths: usize,
    entries: usize,
}

impl Propbin {
    /// Reads a file, compressed or not, whatever its name says.
    ///
    /// # Errors
    /// [`PropbinError`]. Memory is taken as bytes arrive, at most as many as the header promises and [`MAX_BYTES`].
    pub fn read(path: impl AsRef<FilePath>) -> Result<Self, PropbinError> {
        Self::from_reader(File::open(path)?)
    }

    /// Reads the bytes of a file, compressed or not.
    ///
    /// # Errors
    /// As [`Propbin::read`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PropbinError> {
        Self::from_reader(bytes)
    }

    fn from_reader(mut reader: impl Read) -> Result<Self, PropbinError> {
        let mut start = Vec::new();
        reader
            .by_ref()
            .take(GZIP.len() as u64)
            .read_to_end(&mut start)?;
        let is_compressed = start == GZIP;
        let whole = start.as_slice().chain(reader);
        match is_compressed {
            true => Self::from_plain(MultiGzDecoder::new(whole)),
            false => Self::from_plain(whole),
        }
    }

    fn from_plain(mut reader: impl Read) -> Result<Self, PropbinError> {
        let mut bytes = Vec::with_capacity(HEADER_BYTES);
        reader
            .by_ref()
            .take(HEADER_BYTES as u64)
            .read_to_end(&mut bytes)?;
        let header = Header::parse(&bytes)?;
        let expected = header.file_bytes();
        if expected > MAX_BYTES {
            return Err(PropbinError::TooLarge { bytes: expected });
        }
        // One byte more tells a file that is too long.
        reader
            .take(expected - HEADER_BYTES as u64 + 1)
            .read_to_end(&mut bytes)?;
        if bytes.len() as u64 != expected {
            return Err(PropbinError::Length {
                expected,
                found: bytes.len() as u64,
            });
        }
        header.tables(&bytes[HEADER_BYTES..])
    }
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, PropbinError> {
        let mut fields = Fields(bytes);
        if bytes.len() >= 4 {
            let found = fields.u32();
            if found != MAGIC {
                return Err(PropbinError::Magic { found });
            }
        }
        if bytes.len() < HEADER_BYTES {
            return Err(PropbinError::Length {
                expected: HEADER_BYTES as u64,
                found: bytes.len() as u64,
            });
        }
        let version = match fields.u32() {
            1 => Version::Full,
            2 => Version::Compact,
            found => return Err(PropbinError::Version { found }),
        };
        let header = Header {
            version,
            source_m: fields.point(),
            receivers: fields.u32() as usize,
            paths: fields.u32() as usize,
            entries: fields.u32() as usize,
        };
        match header.source_m.iter().all(|v| v.is_finite()) {
            true => Ok(header),
            false => Err(entry("source", 0, "its place is not finite")),
        }
    }

    /// Length of the file: sums of products of u32 and small numbers fit u64.
    fn file_bytes(&self) -> u64 {
        let table = |count: usize, bytes: usize| count as u64 * bytes as u64;
        HEADER_BYTES as u64
            + table(self.receivers, RECEIVER_BYTES)
            + table(self.paths, self.version.path_bytes())
            + table(self.entries, self.version.entry_bytes())
    }

    /// Parses the tables, whose length was checked.
    fn tables(self, bytes: &[u8]) -> Result<Propbin, PropbinError> {
        let (receivers, rest) = bytes.split_at(self.receivers * RECEIVER_BYTES);
        let (paths, entries) = rest.split_at(self.paths * self.version.path_bytes());
        let mut of_receivers = 0_usize;
        let mut has_receiver = vec![false; self.paths];
        let receivers = receivers.chunks_exact(RECEIVER_BYTES).enumerate();
        let receivers = receivers.map(|(i, bytes)| {
            let receiver = receiver(Fields(bytes));
            of_receivers += receiver.paths.len();
            // Ranges that overlap would let a small file become a large data set.
            if receiver.paths.end > self.paths || of_receivers > self.paths {
                Err(entry("receiver", i, "it claims more paths than there are"))
            } else if !receiver.position_m.iter().all(|v| v.is_finite()) {
                Err(entry("receiver", i, "its place is not finite"))
            } else {
                has_receiver[receiver.paths.clone()].fill(true);
                Ok(receiver)
            }
        });
        let receivers = receivers.collect::<Result<_, _>>()?;
        if let Some(path) = has_receiver.iter().position(|has| !has) {
            return Err(entry("path", path, "it belongs to no receiver"));
        }
        let paths = paths.chunks_exact(self.version.path_bytes()).enumerate();
        let paths = paths.map(|(i, bytes)| {
            let stored = match self.version {
                Version::Full => full_path(Fields(bytes)),
                Version::Compact => compact_path(Fields(bytes)),
            };
            match stored.chain.end <= self.entries {
                true => Ok(stored),
                false => Err(entry("path", i, "its chain leads beyond the chain table")),
            }
        });
        let paths = paths.collect::<Result<_, _>>()?;
        let entries = match self.version {
            Version::Full => Entries::Points(
                entries
                    .chunks_exact(12)
                    .map(|b| Fields(b).point())
                    .collect(),
            ),
            Version::Compact => {
                Entries::Words(entries.chunks_exact(2).map(|b| Fields(b).u16()).collect())
            }
        };
        Ok(Propbin {
            version: self.version,
            source_m: self.source_m,
            receivers,
            paths,
            entries,
        })
    }
}

fn receiver(mut fields: Fields<'_>) -> Receiver {
    let id = fields.u32().cast_signed();
    let position_m = fields.point();
    let mut total = || Some(fields.f32()).filter(|v| v.is_finite());
    let (total_power_dbm, total_loss_db) = (total(), total());
    Receiver {
        id,
        position_m,
        total_power_dbm,
        total_loss_db,
        paths: fields.range(),
    }
}

fn full_path(mut fields: Fields<'_>) -> Stored {
    let (loss_db, length_m) = (fields.f32(), fields.f32());
    let mut direction = || Direction {
        azimuth_rad: fields.f32(),
        elevation_rad: fields.f32(),
    };
    let (departure, arrival) = (direction(), direction());
    let path = Path {
        loss_db,
        length_m,
        delay_ns: fields.f32(),
        departure,
        arrival,
    };
    Stored {
        path,
        kind: 0,
        chain: fields.range(),
    }
}

fn compact_path(mut fields: Fields<'_>) -> Stored {
    let (loss_db, length_m, delay_ns) = (fields.f16(), fields.f16(), fields.f16());
    let mut direction = || Direction {
        azimuth_rad: fields.f16(),
        elevation_rad: fields.f16(),
    };
    let path = Path {
        loss_db,
        length_m,
        delay_ns,
        departure: direction(),
        arrival: direction(),
    };
    let entries = usize::from(fields.u16());
    let [kind] = fields.take();
    let _unused: [u8; 3] = fields.take();
    let first = fields.u32() as usize;
    Stored {
        path,
        kind: kind.cast_signed(),
        chain: first..first.saturating_add(entries),
    }
}

fn entry(what: &'static str, index: usize, problem: &'static str) -> PropbinError {
    PropbinError::Entry {
        what,
        index,
        problem,
    }
}

/// The fields of a table entry, one after the other; its length was checked.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (field, rest) = self
            .0
            .split_first_chunk()
            .expect("entries are cut to length");
        self.0 = rest;
        *field
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn f16(&mut self) -> f32 {
        f16::from_le_bytes(self.take()).to_f32()
    }

    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    fn point(&mut self) -> [f32; 3] {
        [self.f32(), self.f32(), self.f32()]
    }

    /// u16 length, u16 unused, u32 start.
    fn range(&mut self) -> Range<usize> {
        let length = usize::from(self.u16());
        self.u16();
        let first = self.u32() as usize;
        first..first.saturating_add(length)
    }
}
