//! A map in memory.

use std::collections::BTreeMap;

use crate::profile::Profile;
use crate::raster::Raster;
use crate::status::LinkStatus;

/// Buildings, link table and labels of one map, as loaded by [`Dataset::map`](crate::Dataset::map).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MapData {
    /// Number of the map.
    pub id: u32,
    /// Image of the buildings.
    pub buildings: Raster,
    /// Positions of the transmitters \[m\].
    pub tx_m: Vec<[f64; 2]>,
    /// Positions of the receivers \[m\].
    pub rx_m: Vec<[f64; 2]>,
    /// The links: (index of transmitter, index of receiver).
    pub links: Vec<[u32; 2]>,
    /// The state of each link.
    pub status: Vec<LinkStatus>,
    /// For each link whose paths lie beyond the tracer's limits, their number of diffractions; else 0.
    pub fallback: Vec<u8>,
    /// The APS of each link, if stored and loaded.
    pub aps: Option<Profile>,
}

impl MapData {
    /// Returns the links that have a label, as indices into the rows.
    pub fn valid_links(&self) -> impl Iterator<Item = usize> {
        let valid = |(link, status): (usize, &LinkStatus)| status.is_valid().then_some(link);
        self.status.iter().enumerate().filter_map(valid)
    }

    /// Returns the positions of transmitter and receiver of a link \[m\].
    ///
    /// # Panics
    /// When there is no such link.
    pub fn ends_m(&self, link: usize) -> ([f64; 2], [f64; 2]) {
        let [tx, rx] = self.links[link];
        (self.tx_m[tx as usize], self.rx_m[rx as usize])
    }

    /// Counts the links in each state that occurs, by name.
    pub(crate) fn status_counts(&self) -> BTreeMap<String, u64> {
        let mut counts = BTreeMap::new();
        for status in &self.status {
            *counts.entry(status.to_string()).or_insert(0) += 1;
        }
        counts
    }
}
