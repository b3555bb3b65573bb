//! RayVerse's `.propbin` files: all paths from one source to its receivers, versions 1 and 2, plain or compressed.
//!
//! Little endian throughout. A header of 32 bytes, then the receivers, the paths, and the chains, one table after the
//! other; a receiver has a range of paths and a path a range of chain entries. Angles are in radians; those of
//! arrival are the direction of travel at the receiver, opposite to what a data set stores.
//!
//! | | version 1 | version 2 |
//! |---|---|---|
//! | header | u32 magic 0x50524F50, u32 version, f32 source x 3, u32 receivers, paths, chain entries | the same |
//! | receiver, 32 bytes | i32 id, f32 position x 3, f32 dBm in all, f32 loss in all, u16 paths, u16 -, u32 first path | the same |
//! | path | 36 bytes: f32 loss, length, departure az, el, arrival az, el, delay; u16 chain entries, u16 -, u32 first entry | 24 bytes: f16 loss, length, delay, departure az, el, arrival az, el; u16 chain entries, i8 kind, 3 bytes -, u32 first entry |
//! | chain entry | f32 x 3: a point | u16: the number of a vertex of the map; f16 x and y in turn where the kind is -1 |
//!
//! Half precision costs version 2 dearly in delays: 0.25 ns from 256 ns on, 0.5 ns from 512 ns on, where a pulse at
//! 200 MHz has its first zero after 5 ns.
//!
//! ```
//! use aps_data::propbin::{Chain, Direction, Path, Propbin, Version};
//!
//! let mut file = Propbin::new(Version::Full, [10.0, 20.0, 1.5]);
//! file.add_receiver(7, [30.0, 20.0, 1.5], Some(-60.0), Some(61.0));
//! let path = Path {
//!     loss_db: 61.0,
//!     length_m: 20.0,
//!     delay_ns: 66.7,
//!     departure: Direction::default(),
//!     arrival: Direction::default(),
//! };
//! file.add_path(&path, &Chain::Points([[10.0, 20.0, 1.5], [30.0, 20.0, 1.5]].as_slice().into()))?;
//!
//! let read = Propbin::from_bytes(&file.to_bytes()?)?;
//! let receiver = &read.receivers()[0];
//! let (same, _) = read.paths_of(receiver).next().unwrap();
//! assert_eq!((receiver.id, same), (7, &path));
//! # Ok::<(), aps_data::propbin::PropbinError>(())
//! ```

mod read;
mod write;

use std::borrow::Cow;
use std::io;
use std::ops::Range;

use half::f16;

/// Largest file accepted, after decompression \[bytes\].
pub const MAX_BYTES: u64 = 1 << 30;

const MAGIC: u32 = 0x5052_4F50;
const HEADER_BYTES: usize = 32;
const RECEIVER_BYTES: usize = 32;

/// Kind of a path of version 2 that goes over the roofs.
const ROOFTOP: i8 = -1;

/// The two forms of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// Version 1: single precision, chains of points.
    Full,
    /// Version 2: half precision, chains of vertex numbers.
    Compact,
}

impl Version {
    fn number(self) -> u32 {
        match self {
            Version::Full => 1,
            Version::Compact => 2,
        }
    }

    fn path_bytes(self) -> usize {
        match self {
            Version::Full => 36,
            Version::Compact => 24,
        }
    }

    fn entry_bytes(self) -> usize {
        match self {
            Version::Full => 12,
            Version::Compact => 2,
        }
    }
}

/// Azimuth and elevation \[rad\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Direction {
    /// Angle in the plane, from the x axis towards the y axis \[rad\].
    pub azimuth_rad: f32,
    /// Angle above the plane \[rad\].
    pub elevation_rad: f32,
}

/// One propagation path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    /// Path loss \[dB\].
    pub loss_db: f32,
    /// Length \[m\].
    pub length_m: f32,
    /// Delay \[ns\].
    pub delay_ns: f32,
    /// Direction of travel at the source.
    pub departure: Direction,
    /// Direction of travel at the receiver.
    pub arrival: Direction,
}

impl Path {
    fn is_finite(&self) -> bool {
        let lengths = [self.loss_db, self.length_m, self.delay_ns];
        let angles = self.angles();
        lengths.iter().chain(&angles).all(|v| v.is_finite())
    }

    /// Azimuth and elevation at the source, then at the receiver \[rad\].
    fn angles(&self) -> [f32; 4] {
        let [d, a] = [self.departure, self.arrival].map(|d| [d.azimuth_rad, d.elevation_rad]);
        [d[0], d[1], a[0], a[1]]
    }
}

/// Chain of a path: the points or vertices it meets on its way from the source.
#[derive(Debug, Clone, PartialEq)]
pub enum Chain<'a> {
    /// Points \[m\], those of source and receiver included; all of version 1.
    Points(Cow<'a, [[f32; 3]]>),
    /// Numbers of vertices of the map.
    Vertices(Cow<'a, [u16]>),
    /// Points \[m\] where a path of version 2 bends over roofs.
    Rooftop(Cow<'a, [[f32; 2]]>),
}

/// One receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct Receiver {
    /// Number of the receiver in the map.
    pub id: i32,
    /// Position of the receiver \[m\].
    pub position_m: [f32; 3],
    /// Power received over all paths \[dBm\], where it is finite.
    pub total_power_dbm: Option<f32>,
    /// Loss over all paths \[dB\], where it is finite.
    pub total_loss_db: Option<f32>,
    paths: Range<usize>,
}

/// A path as the file has it; its numbers may be anything.
#[derive(Debug, Clone, PartialEq)]
struct Stored {
    path: Path,
    kind: i8,
    chain: Range<usize>,
}

/// The chain entries of all paths.
#[derive(Debug, Clone, PartialEq)]
enum Entries {
    Points(Vec<[f32; 3]>),
    Words(Vec<u16>),
}

/// The contents of one file: a source, its receivers, and the paths between.
///
/// Takes no more than a few times the memory of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Propbin {
    version: Version,
    source_m: [f32; 3],
    receivers: Vec<Receiver>,
    paths: Vec<Stored>,
    entries: Entries,
}

/// Reason for which a file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PropbinError {
    /// Reading, writing or decompressing failed.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file does not start with the magic number.
    #[error("not a .propbin file: it starts with {found:#010x}, not 0x50524f50")]
    Magic {
        /// The first four bytes as a number.
        found: u32,
    },
    /// A version other than 1 and 2.
    #[error(".propbin version {found} is not known, only 1 and 2 are")]
    Version {
        /// Version in the file.
        found: u32,
    },
    /// The length differs from the header's.
    #[error("{found} bytes, but its header promises {expected}; the file is truncated or damaged")]
    Length {
        /// Length according to the header \[bytes\].
        expected: u64,
        /// Length of the file, decompressed, as far as it was read \[bytes\].
        found: u64,
    },
    /// The header promises more than [`MAX_BYTES`].
    #[error("its header promises {bytes} bytes, at most {MAX_BYTES} are read")]
    TooLarge {
        /// Length according to the header \[bytes\].
        bytes: u64,
    },
    /// A table entry contradicts the file.
    #[error("{what} {index}: {problem}")]
    Entry {
        /// `source`, `receiver` or `path`.
        what: &'static str,
        /// Index of the entry in its table.
        index: usize,
        /// The contradiction.
        problem: &'static str,
    },
}

impl Propbin {
    /// A file with a source \[m\] and nothing else.
    pub fn new(version: Version, source_m: [f32; 3]) -> Self {
        Propbin {
            version,
            source_m,
            receivers: Vec::new(),
            paths: Vec::new(),
            entries: match version {
                Version::Full => Entries::Points(Vec::new()),
                Version::Compact => Entries::Words(Vec::new()),
            },
        }
    }

    /// Returns the version of the format.
    pub fn version(&self) -> Version {
        self.version
    }

    /// Returns the position of the source \[m\].
    pub fn source_m(&self) -> [f32; 3] {
        self.source_m
    }

    /// Returns the receivers, in the order of the file.
    pub fn receivers(&self) -> &[Receiver] {
        &self.receivers
    }

    /// Returns the paths to a receiver of this file with their chains, in the order of the file.
    ///
    /// Paths with a number that is not finite are passed over (see [`Propbin::unusable_paths`]), and so are such points
    /// of a chain.
    pub fn paths_of(&self, receiver: &Receiver) -> impl Iterator<Item = (&Path, Chain<'_>)> {
        let stored = &self.paths[receiver.paths.clone()];
        let usable = stored.iter().filter(|stored| stored.path.is_finite());
        usable.map(|stored| (&stored.path, self.chain_of(stored)))
    }

    /// Returns the number of paths with a number that is not finite.
    pub fn unusable_paths(&self) -> usize {
        self.paths
            .iter()
            .filter(|stored| !stored.path.is_finite())
            .count()
    }

    fn chain_of(&self, stored: &Stored) -> Chain<'_> {
        match &self.entries {
            Entries::Points(points) => {
                let points = &points[stored.chain.clone()];
                let is_finite = |point: &[f32; 3]| point.iter().all(|v| v.is_finite());
                Chain::Points(match points.iter().all(is_finite) {
                    true => points.into(),
                    false => points.iter().copied().filter(is_finite).collect(),
                })
            }
            Entries::Words(words) if stored.kind == ROOFTOP => {
                let (pairs, _) = words[stored.chain.clone()].as_chunks::<2>();
                let points = pairs
                    .iter()
                    .map(|pair| pair.map(|word| f16::from_bits(word).to_f32()));
                Chain::Rooftop(
                    points
                        .filter(|point| point.iter().all(|v| v.is_finite()))
                        .collect(),
                )
            }
            Entries::Words(words) => Chain::Vertices(words[stored.chain.clone()].into()),
        }
    }
}
