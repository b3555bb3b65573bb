//! The array files of a map: the one list that writer, reader and checks go by.

use crate::layout::{Layout, Precision, ProfileLayout};
use crate::npy::{Header, size_of_dtype};

/// The lengths that decide the shapes of a map's arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Counts {
    pub tx: usize,
    pub rx: usize,
    pub links: usize,
    pub paths: usize,
    pub interactions: usize,
}

/// Name, type and shape of an array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ArraySpec {
    pub name: &'static str,
    pub dtype: &'static str,
    pub shape: Vec<usize>,
}

impl ArraySpec {
    /// Size of the file \[bytes\]; `None` beyond what can be addressed.
    pub fn file_bytes(&self) -> Option<u64> {
        let size = size_of_dtype(self.dtype) as u64;
        let header = Header::bytes_for(self.dtype, &self.shape).len() as u64;
        let data = self
            .shape
            .iter()
            .try_fold(size, |product, &n| product.checked_mul(n as u64));
        data?.checked_add(header)
    }
}

/// The arrays of a map in the order in which the manifest lists them; `None` when the counts
/// overflow.
pub(crate) fn arrays_of(layout: &Layout, counts: &Counts) -> Option<Vec<ArraySpec>> {
    let (links, paths, interactions) = (counts.links, counts.paths, counts.interactions);
    let mut arrays = Vec::new();
    let mut add = |name, dtype, shape: &[usize]| {
        let shape = shape.to_vec();
        arrays.push(ArraySpec { name, dtype, shape })
    };
    let raster = layout.raster;
    add("buildings", "|u1", &[raster.height, raster.width]);
    add("tx", "<f8", &[counts.tx, 2]);
    add("rx", "<f8", &[counts.rx, 2]);
    add("link_tx", "<u4", &[links]);
    add("link_rx", "<u4", &[links]);
    add("status", "|u1", &[links]);
    add("fallback", "|u1", &[links]);
    let profiles = [
        (layout.aps, ProfileNames::APS),
        (layout.pdp, ProfileNames::PDP),
    ];
    for (profile, names) in profiles {
        let Some(profile) = profile else { continue };
        let bins = profile.axis.count;
        add(names.db, profile.dtype_name(), &[links, bins]);
        add(names.max_db, "<f4", &[links]);
        if profile.argmax {
            add(names.argmax, "<f2", &[links, bins]);
        }
    }
    if layout.paths {
        add("path_offset", "<u8", &[links.checked_add(1)?]);
        add("path_delay_s", "<f8", &[paths]);
        add("path_departure_azimuth_rad", "<f8", &[paths]);
        add("path_arrival_azimuth_rad", "<f8", &[paths]);
        add("path_gain", "<c16", &[paths]);
        add("interaction_offset", "<u8", &[paths.checked_add(1)?]);
        add("interaction_kind", "|u1", &[interactions]);
        add("interaction_id", "<u4", &[interactions]);
        add("interaction_point", "<f8", &[interactions, 2]);
    }
    Some(arrays)
}

/// The names of a profile's arrays.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProfileNames {
    pub db: &'static str,
    pub max_db: &'static str,
    pub argmax: &'static str,
}

impl ProfileNames {
    pub const APS: Self = ProfileNames {
        db: "aps_db",
        max_db: "aps_max_db",
        argmax: "aps_delay_ns",
    };
    pub const PDP: Self = ProfileNames {
        db: "pdp_db",
        max_db: "pdp_max_db",
        argmax: "pdp_angle_deg",
    };
}

impl ProfileLayout {
    fn dtype_name(&self) -> &'static str {
        match self.dtype {
            Precision::F16 => "<f2",
            Precision::F32 => "<f4",
        }
    }
}
