//! The files of the data published with the benchmark: a file a link, named after the positions of its ends.
//!
//! | file | dtype | shape | what |
//! |---|---|---|---|
//! | `map_N/N_adps/aps/aps_N_TXX_TXY_RXX_RXY.npy` | `<f2` | (180, 2) | power over azimuth \[dB\], delay of each maximum \[ns\] |
//! | `map_N/N_adps/pdp/pdp_N_TXX_TXY_RXX_RXY.npy` | `<f2` | (128, 2) | power over delay \[dB\], azimuth of each maximum \[deg\] |
//! | `samples/aps_N_TXX_TXY_RXX_RXY.npz` | `<f4` | (180,), (3, 256, 256) | `aps_norm` and `cond_img`: target and input of a model, see [`Sample`] |
//!
//! A link without a path is a file of zeros here and has no sample.
//!
//! ```
//! use aps_data::released::{LinkName, ProfileFile};
//! let name: LinkName = "0_170_0_88_12".parse()?;
//! assert_eq!(name.aps_file().to_str(), Some("map_0/0_adps/aps/aps_0_170_0_88_12.npy"));
//!
//! let aps = ProfileFile::rounded(&[-80.0, -91.3], &[212.6, 212.6]);
//! assert_eq!(ProfileFile::from_bytes(&aps.to_bytes())?, aps);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod sample;

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use half::f16;

pub use sample::{MAX_SAMPLE_BYTES, Sample, SampleError};

use crate::npy::{self, NpyError};
use crate::round::to_f16;

/// Map and link in a file's name: `N_TXX_TXY_RXX_RXY`, coordinates in whole metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LinkName {
    /// Number of the map.
    pub map: u32,
    /// Place of the transmitter \[m\].
    pub tx_m: [i32; 2],
    /// Place of the receiver \[m\].
    pub rx_m: [i32; 2],
}

/// A name that is not made of five whole numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not the name of a link, MAP_TXX_TXY_RXX_RXY in whole numbers")]
pub struct LinkNameError(String);

impl LinkName {
    /// Returns the name of a link between two places \[m\], rounded as Python's `round` does; `None` when one is farther
    /// than 1,000 km from the origin.
    pub fn of(map: u32, tx_m: [f64; 2], rx_m: [f64; 2]) -> Option<Self> {
        let whole = |v: f64| (v.abs() <= 1e6).then(|| v.round_ties_even() as i32);
        let place = |[x, y]: [f64; 2]| Some([whole(x)?, whole(y)?]);
        Some(LinkName {
            map,
            tx_m: place(tx_m)?,
            rx_m: place(rx_m)?,
        })
    }

    /// Returns the path of the link's APS, below the root of the data.
    pub fn aps_file(&self) -> PathBuf {
        self.profile_file("aps")
    }

    /// Returns the path of the link's PDP, below the root of the data.
    pub fn pdp_file(&self) -> PathBuf {
        self.profile_file("pdp")
    }

    /// Returns the path of the link's sample, below the root of the preprocessed data.
    pub fn sample_file(&self) -> PathBuf {
        format!("samples/aps_{self}.npz").into()
    }

    fn profile_file(&self, kind: &str) -> PathBuf {
        let map = self.map;
        format!("map_{map}/{map}_adps/{kind}/{kind}_{self}.npy").into()
    }

    /// Parses the link of a file name with such a beginning and end, e.g. `aps_` and `.npy`; `None` for other files.
    pub fn of_file(name: &str, beginning: &str, end: &str) -> Option<Self> {
        name.strip_prefix(beginning)?
            .strip_suffix(end)?
            .parse()
            .ok()
    }
}

impl fmt::Display for LinkName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LinkName { map, tx_m, rx_m } = self;
        write!(f, "{map}_{}_{}_{}_{}", tx_m[0], tx_m[1], rx_m[0], rx_m[1])
    }
}

impl FromStr for LinkName {
    type Err = LinkNameError;

    fn from_str(text: &str) -> Result<Self, LinkNameError> {
        let wrong = || LinkNameError(text.to_owned());
        let (map, places) = text.split_once('_').ok_or_else(wrong)?;
        let places: Vec<i32> = places
            .split('_')
            .map(str::parse)
            .collect::<Result<_, _>>()
            .map_err(|_| wrong())?;
        match (map.parse(), places.as_slice()) {
            (Ok(map), &[tx_x, tx_y, rx_x, rx_y]) => Ok(LinkName {
                map,
                tx_m: [tx_x, tx_y],
                rx_m: [rx_x, rx_y],
            }),
            _ => Err(wrong()),
        }
    }
}

/// Content of a file of an APS or PDP: for each bin its power \[dB\], and the place of its maximum on the other axis,
/// delay \[ns\] or azimuth \[deg\].
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileFile {
    /// (power, place of the maximum) of each bin.
    pub bins: Vec<[f16; 2]>,
}

impl ProfileFile {
    /// Rounds powers \[dB\] and places, each once to the nearest half-precision number, as NumPy does.
    ///
    /// # Panics
    /// When there are not as many places as powers.
    pub fn rounded(db: &[f64], places: &[f64]) -> Self {
        assert_eq!(db.len(), places.len(), "a place for each power");
        let pairs = db.iter().zip(places);
        ProfileFile {
            bins: pairs
                .map(|(&db, &place)| [to_f16(db), to_f16(place)])
                .collect(),
        }
    }

    /// Returns true when every number is 0: the released code's file of a link without a path.
    pub fn is_all_zero(&self) -> bool {
        self.bins.as_flattened().iter().all(|v| v.to_f32() == 0.0)
    }

    /// Returns true when every number is finite.
    pub fn is_finite(&self) -> bool {
        self.bins.as_flattened().iter().all(|v| v.is_finite())
    }

    /// Returns the bytes of the file, as NumPy writes them.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        npy::write_to(&mut bytes, &[self.bins.len(), 2], self.bins.as_flattened())
            .expect("the shape is that of the data");
        bytes
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// [`NpyError`]; a shape other than (bins, 2) is [`NpyError::Length`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, NpyError> {
        let array = npy::from_bytes::<f16>(bytes)?;
        match array.shape.as_slice() {
            [_, 2] => {
                let (bins, _) = array.data.as_chunks();
                Ok(ProfileFile {
                    bins: bins.to_vec(),
                })
            }
            _ => Err(NpyError::Length {
                shape: array.shape,
                bytes: bytes.len() as u64,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_their_own_inverse() {
        for text in ["0_170_0_88_12", "50_-3_256_0_1"] {
            assert_eq!(text.parse::<LinkName>().unwrap().to_string(), text);
        }
        for text in [
            "",
            "0",
            "0_1_2_3",
            "0_1_2_3_4_5",
            "a_1_2_3_4",
            "0_1.5_2_3_4",
        ] {
            assert!(text.parse::<LinkName>().is_err(), "{text}");
        }
        assert!(LinkName::of_file("aps_0_1_2_3_4.npy", "aps_", ".npy").is_some());
        assert!(LinkName::of_file("pdp_0_1_2_3_4.npy", "aps_", ".npy").is_none());
    }

    #[test]
    fn places_are_rounded_as_python_does() {
        let name = LinkName::of(1, [0.5, 1.5], [-0.5, 2.4]).unwrap();
        assert_eq!(name.to_string(), "1_0_2_0_2");
        assert_eq!(LinkName::of(1, [f64::NAN, 0.0], [0.0, 0.0]), None);
        assert_eq!(LinkName::of(1, [1e7, 0.0], [0.0, 0.0]), None);
    }
}
