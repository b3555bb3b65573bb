//! Profiles, the APS or PDP of every link of a map: from dB in f64 to the stored form and back.
//!
//! A link's values are stored relative to its largest one, which is kept beside them: labels are
//! used that way, and half precision is finest near 0 dB. See [`Precision`] for its errors.

use std::ops::Range;

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::error::Error;
use crate::layout::{Precision, ProfileLayout};
use crate::round::{to_f16, to_f16s};
use crate::status::LinkStatus;

/// Stored in place of dB where a link has no label: the least finite half-precision number.
///
/// As a power it is exactly 0 in f32 and f64; values further down are stored as this, too.
pub const FILL_DB: f64 = -65504.0;

/// The profiles of some links to be written, one row a link.
///
/// Rows of links without label are ignored, whatever they hold.
#[derive(Debug, Clone, Copy)]
pub struct ProfileRows<'a> {
    /// Absolute values \[dB\]; shape (links, bins), finite.
    pub db: &'a [f64],
    /// Place of each bin's maximum on the other axis, delay \[ns\] for an APS, azimuth \[deg\] for a
    /// PDP; shape (links, bins), within the range of half precision. Given if and only if the layout
    /// stores it.
    pub argmax: Option<&'a [f64]>,
}

/// The profiles of all links of a map, as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    pub(crate) bins: usize,
    pub(crate) db: Samples,
    pub(crate) max_db: Vec<f32>,
    pub(crate) argmax: Option<Vec<f16>>,
}

/// Values in the precision in which they are stored; rows of links one after the other.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// Half precision.
    F16(Vec<f16>),
    /// Single precision.
    F32(Vec<f32>),
}

impl Samples {
    /// Creates an empty list of values of a precision, with room for `values` of them.
    pub fn with_capacity(precision: Precision, values: usize) -> Self {
        match precision {
            Precision::F16 => Samples::F16(Vec::with_capacity(values)),
            Precision::F32 => Samples::F32(Vec::with_capacity(values)),
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        match self {
            Samples::F16(values) => values.iter().all(|value| value.is_finite()),
            Samples::F32(values) => values.iter().all(|value| value.is_finite()),
        }
    }

    /// Appends some values of another list, as they are stored.
    ///
    /// # Panics
    /// When `other` is of another precision, or does not reach so far.
    pub fn append(&mut self, other: &Samples, range: Range<usize>) {
        match (self, other) {
            (Samples::F16(own), Samples::F16(other)) => own.extend_from_slice(&other[range]),
            (Samples::F32(own), Samples::F32(other)) => own.extend_from_slice(&other[range]),
            (Samples::F16(_), Samples::F32(_)) | (Samples::F32(_), Samples::F16(_)) => {
                panic!("values in half and in single precision are kept apart")
            }
        }
    }

    /// Writes some values, which double precision holds exactly, into `values`.
    ///
    /// # Panics
    /// When there are no such values, or `values` is not as long.
    pub fn read(&self, range: Range<usize>, values: &mut [f64]) {
        match self {
            Samples::F16(stored) => stored[range].convert_to_f64_slice(values),
            Samples::F32(stored) => {
                let stored = &stored[range];
                assert_eq!(stored.len(), values.len(), "a value for each");
                let pairs = values.iter_mut().zip(stored);
                pairs.for_each(|(value, &stored)| *value = f64::from(stored));
            }
        }
    }
}

impl Profile {
    /// Encodes rows in memory as they are stored: a reader of the data set would get the result.
    ///
    /// # Errors
    /// [`Error::Rows`] when they do not fit layout and states, or hold a value that is not finite.
    pub fn encode(
        rows: &ProfileRows<'_>,
        layout: &ProfileLayout,
        status: &[LinkStatus],
    ) -> Result<Self, Error> {
        encode(rows, layout, status, 0).map_err(|problem| Error::Rows { problem })
    }

    /// Returns true when two links, of this profile and another one, have the same bits in every array.
    ///
    /// # Panics
    /// When there are no such links.
    pub fn is_same_row(&self, link: usize, other: &Profile, other_link: usize) -> bool {
        fn same<T: Copy, B: PartialEq>(a: &[T], b: &[T], bits: impl Fn(T) -> B) -> bool {
            a.len() == b.len() && a.iter().zip(b).all(|(&a, &b)| bits(a) == bits(b))
        }
        let row = |profile: &Profile, link| link * profile.bins..(link + 1) * profile.bins;
        let (here, there) = (row(self, link), row(other, other_link));
        let same_db = match (&self.db, &other.db) {
            (Samples::F16(a), Samples::F16(b)) => {
                same(&a[here.clone()], &b[there.clone()], f16::to_bits)
            }
            (Samples::F32(a), Samples::F32(b)) => {
                same(&a[here.clone()], &b[there.clone()], f32::to_bits)
            }
            (Samples::F16(_), Samples::F32(_)) | (Samples::F32(_), Samples::F16(_)) => false,
        };
        let same_places = match (&self.argmax, &other.argmax) {
            (Some(a), Some(b)) => same(&a[here], &b[there], f16::to_bits),
            (a, b) => a.is_none() && b.is_none(),
        };
        same_db && same_places && self.max_db[link].to_bits() == other.max_db[other_link].to_bits()
    }

    /// Number of bins of each link.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Returns the values of all links relative to each link's maximum \[dB\], shape (links, bins);
    /// [`FILL_DB`] without label.
    pub fn samples(&self) -> &Samples {
        &self.db
    }

    /// Returns the maximum of each link \[dB\]; [`FILL_DB`] without label.
    pub fn max_db(&self) -> &[f32] {
        &self.max_db
    }

    /// Returns the place of each bin's maximum on the other axis, if stored: delay \[ns\] for an APS,
    /// azimuth \[deg\] for a PDP; shape (links, bins), 0 without label.
    pub fn argmax(&self) -> Option<&[f16]> {
        self.argmax.as_deref()
    }

    /// Writes one link's values relative to its maximum \[dB\] into `row`: at most 0, and 0 at the
    /// maximum.
    ///
    /// # Panics
    /// When there is no such link or `row` is not [`Profile::bins`] long.
    pub fn read_relative_db(&self, link: usize, row: &mut [f32]) {
        let range = link * self.bins..(link + 1) * self.bins;
        match &self.db {
            Samples::F16(values) => values[range].convert_to_f32_slice(row),
            Samples::F32(values) => row.copy_from_slice(&values[range]),
        }
    }

    /// Describes a contradiction to the states of the links; `None` if there is none.
    pub(crate) fn problem(&self, status: &[LinkStatus]) -> Option<String> {
        let mut row = vec![0.0; self.bins];
        for (link, status) in status.iter().enumerate() {
            self.read_relative_db(link, &mut row);
            let max_db = self.max_db[link];
            let places = self.argmax.as_deref();
            let places = places.map_or(&[][..], |all| &all[link * self.bins..][..self.bins]);
            let (is_sound, wanted) = if status.is_valid() {
                let peak = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                let is_sound = max_db.is_finite()
                    && peak == 0.0
                    && row.iter().all(|value| value.is_finite())
                    && places.iter().all(|place| place.is_finite());
                (is_sound, "finite values with maximum 0")
            } else {
                let fill = FILL_DB as f32;
                let is_sound = max_db == fill
                    && row.iter().all(|&value| value == fill)
                    && places.iter().all(|place| place.to_bits() == 0);
                (is_sound, "fill values")
            };
            if !is_sound {
                return Some(format!(
                    "link {link} is {status}, but its row is not made of {wanted}"
                ));
            }
        }
        None
    }
}

/// Encodes the rows of links with the given states, of which the first is link number `first`.
///
/// The error describes the fault of the rows.
pub(crate) fn encode(
    rows: &ProfileRows<'_>,
    layout: &ProfileLayout,
    status: &[LinkStatus],
    first: usize,
) -> Result<Profile, String> {
    let bins = layout.axis.count;
    let wanted = status.len() * bins;
    if rows.db.len() != wanted {
        return Err(format!(
            "{} values for {} links of {bins} bins",
            rows.db.len(),
            status.len()
        ));
    }
    if rows.argmax.map(<[f64]>::len) != layout.argmax.then_some(wanted) {
        return Err(
            "places of the maxima must be given if and only if the layout stores them".into(),
        );
    }
    let mut db = match layout.dtype {
        Precision::F16 => Samples::F16(vec![to_f16(FILL_DB); wanted]),
        Precision::F32 => Samples::F32(vec![FILL_DB as f32; wanted]),
    };
    let (mut relative, mut scratch) = (Vec::with_capacity(bins), Vec::with_capacity(bins));
    let mut max_db = vec![FILL_DB as f32; status.len()];
    for i in (0..status.len()).filter(|&i| status[i].is_valid()) {
        let row = &rows.db[i * bins..][..bins];
        let peak = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let link = first + i;
        if let Some(bin) = row.iter().position(|value| !value.is_finite()) {
            let db = row[bin];
            return Err(format!(
                "link {link}, bin {bin}: {db} dB is not a finite value"
            ));
        }
        max_db[i] = peak as f32;
        if !max_db[i].is_finite() {
            return Err(format!(
                "link {link}: a maximum of {peak} dB is out of range"
            ));
        }
        relative.clear();
        relative.extend(row.iter().map(|value| (value - peak).max(FILL_DB)));
        match &mut db {
            Samples::F16(all) => to_f16s(&relative, &mut scratch, &mut all[i * bins..][..bins]),
            Samples::F32(all) => {
                let row = all[i * bins..][..bins].iter_mut().zip(&relative);
                row.for_each(|(stored, &value)| *stored = value as f32);
            }
        }
    }
    let argmax = rows
        .argmax
        .map(|places| encode_places(places, bins, status, first))
        .transpose()?;
    Ok(Profile {
        bins,
        db,
        max_db,
        argmax,
    })
}

fn encode_places(
    places: &[f64],
    bins: usize,
    status: &[LinkStatus],
    first: usize,
) -> Result<Vec<f16>, String> {
    let mut encoded = vec![f16::ZERO; places.len()];
    for i in (0..status.len()).filter(|&i| status[i].is_valid()) {
        for bin in 0..bins {
            let (link, at) = (first + i, i * bins + bin);
            encoded[at] = to_f16(places[at]);
            if !encoded[at].is_finite() {
                let place = places[at];
                return Err(format!(
                    "link {link}, bin {bin}: {place} is out of range for a place"
                ));
            }
        }
    }
    Ok(encoded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use aps_label::Axis;

    fn layout(dtype: Precision, bins: usize) -> ProfileLayout {
        let axis = Axis {
            start: 0.0,
            stop: 1.0,
            count: bins,
            endpoint: true,
        };
        ProfileLayout {
            dtype,
            ..ProfileLayout::over(axis)
        }
    }

    /// Encodes one row, that of link 7.
    fn encoded(db: &[f64], dtype: Precision, status: LinkStatus) -> Result<Profile, String> {
        let rows = ProfileRows { db, argmax: None };
        encode(&rows, &layout(dtype, db.len()), &[status], 7)
    }

    /// Absolute values after a round trip of one row.
    fn round_trip(row: &[f64], dtype: Precision) -> Vec<f64> {
        let profile = encoded(row, dtype, LinkStatus::Valid).unwrap();
        assert_eq!(profile.problem(&[LinkStatus::Valid]), None);
        let mut relative = vec![0.0; row.len()];
        profile.read_relative_db(0, &mut relative);
        let max_db = f64::from(profile.max_db()[0]);
        let relative = relative.into_iter().map(f64::from);
        relative.map(|value| value + max_db).collect()
    }

    #[test]
    fn single_precision_returns_half_precision_input_exactly() {
        // Released labels: absolute dB in half precision, floor -350 dB.
        let released: Vec<f64> = (0..2000)
            .map(|i| f16::from_f64(-60.3 - f64::from(i) * 0.145).to_f64())
            .collect();
        assert_eq!(round_trip(&released, Precision::F32), released);
    }

    #[test]
    fn infinite_value_of_labelled_link_is_named() {
        let row = [0.0, f64::NEG_INFINITY];
        let problem = encoded(&row, Precision::F16, LinkStatus::Valid).unwrap_err();
        assert_eq!(problem, "link 7, bin 1: -inf dB is not a finite value");
    }

    #[test]
    fn rows_without_label_may_hold_anything() {
        let row = [f64::NAN, f64::INFINITY];
        let encoded = encoded(&row, Precision::F16, LinkStatus::NoPath).unwrap();
        assert_eq!(encoded.db, Samples::F16(vec![f16::MIN; 2]));
        assert_eq!(encoded.max_db, [FILL_DB as f32]);
    }
}
