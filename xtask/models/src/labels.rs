//! Links and labels of some maps in memory.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use aps_data::{Dataset, MapData};
use aps_label::Normalization;
use aps_model::ANGLE_BINS;
use aps_model::condition::Link;
use aps_model::data::Examples;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Which row of which map a link is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Number of the map.
    pub map: u32,
    /// Row of its link table.
    pub link: u32,
    /// Row of its transmitters.
    pub tx: u32,
    /// Row of its receivers.
    pub rx: u32,
}

/// Labelled links, in ascending order of map and row. 416 bytes a link: 0.96 GB for the paper's 2.3 million.
///
/// Labels are kept as they are stored, in dB and half precision, and made into targets when they are asked for: a few
/// microseconds each.
#[derive(Debug)]
pub struct Labels {
    rows: Vec<Row>,
    links: Vec<Link>,
    /// dB relative to each link's maximum; shape (links, bins).
    db: Vec<f16>,
    normalization: Normalization,
}

impl Labels {
    /// The labelled links of `maps`, ascending: all, or `limit` of them drawn by `seed`. `index_of` gives each map its
    /// place among the condition images.
    pub fn load(
        dataset: &Dataset,
        maps: &[u32],
        index_of: &BTreeMap<u32, u32>,
        limit: Option<usize>,
        seed: u64,
        normalization: Normalization,
    ) -> Result<Self> {
        let total = valid_links(dataset, maps);
        let chosen = limit.filter(|&limit| limit < total).map(|limit| {
            let mut generator = ChaCha8Rng::seed_from_u64(seed);
            let mut all: Vec<usize> = (0..total).collect();
            let mut chosen = all.partial_shuffle(&mut generator, limit).0.to_vec();
            chosen.sort_unstable();
            chosen
        });
        let count = chosen.as_ref().map_or(total, Vec::len);
        let mut labels = Labels {
            rows: Vec::with_capacity(count),
            links: Vec::with_capacity(count),
            db: Vec::with_capacity(count * ANGLE_BINS),
            normalization,
        };
        let (mut passed, mut wanted) = (0, chosen.iter().flatten().copied().peekable());
        for &id in maps {
            let map = dataset.map(id)?;
            for link in map.valid_links() {
                if chosen.is_none() || wanted.next_if_eq(&passed).is_some() {
                    labels.push(&map, link, index_of[&id])?;
                }
                passed += 1;
            }
        }
        ensure!(
            labels.rows.len() == count,
            "maps {maps:?} hold other numbers of labelled links than the manifest says; the data set is damaged"
        );
        Ok(labels)
    }

    fn push(&mut self, map: &MapData, link: usize, index: u32) -> Result<()> {
        let aps = xtask::targets::spectra(map);
        let ([tx, rx], (tx_m, rx_m)) = (map.links[link], map.ends_m(link));
        self.rows.push(Row {
            map: map.id,
            link: u32::try_from(link).context("too many links on a map")?,
            tx,
            rx,
        });
        self.links.push(Link {
            map: index,
            tx_m,
            rx_m,
        });
        let mut row = [0.0; ANGLE_BINS];
        aps.read_relative_db(link, &mut row);
        self.db.extend(row.map(f16::from_f32));
        Ok(())
    }

    /// Where each link comes from.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The links as the condition images need them.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The target of a link.
    pub fn target(&self, link: usize) -> [f64; ANGLE_BINS] {
        let mut stored = [0.0_f32; ANGLE_BINS];
        self.db[link * ANGLE_BINS..][..ANGLE_BINS].convert_to_f32_slice(&mut stored);
        let mut values = stored.map(f64::from);
        let normalised = self.normalization.apply(&mut values);
        normalised.expect(
            "the data set was checked to hold finite numbers, the statistics were used before",
        );
        values
    }
}

impl Examples for Labels {
    fn len(&self) -> usize {
        self.links.len()
    }

    fn link(&self, example: usize) -> Link {
        self.links[example]
    }

    fn write_target(&self, example: usize, target: &mut [f32]) {
        for (target, value) in target.iter_mut().zip(self.target(example)) {
            *target = value as f32;
        }
    }
}

/// Number of labelled links of some maps, by the manifest.
pub fn valid_links(dataset: &Dataset, maps: &[u32]) -> usize {
    let entries = dataset.manifest().maps.iter();
    let valid = entries
        .filter(|entry| maps.contains(&entry.id))
        .map(|entry| entry.status.get("valid").copied().unwrap_or(0));
    valid.sum::<u64>() as usize
}
