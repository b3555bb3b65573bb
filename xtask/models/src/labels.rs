//! Links and labels of some maps in memory.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use aps_data::{Dataset, MapData, Samples};
use aps_label::Normalization;
use aps_model::ANGLE_BINS;
use aps_model::condition::Link;
use aps_model::data::Examples;
use map2aps::targets::{self, Target};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Place of a link in the data set: its map and its rows there.
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

/// Labelled links, in ascending order of map and row. Labels are kept as the data set stores them, in dB and in its precision,
/// and made into targets when they are asked for, as `metrics` makes them: a few microseconds each.
///
/// 416 bytes a link in half precision, 776 in single precision, as imported data have it: 0.96 and 1.8 GB for the paper's
/// 2.3 million.
#[derive(Debug)]
pub struct Labels {
    rows: Vec<Row>,
    links: Vec<Link>,
    /// dB relative to each link's maximum; shape (links, bins).
    db: Samples,
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
        let layout = dataset.manifest().layout;
        let aps = layout.aps.context("the data set stores no spectra")?;
        let mut labels = Labels {
            rows: Vec::with_capacity(count),
            links: Vec::with_capacity(count),
            db: Samples::with_capacity(aps.dtype, count * ANGLE_BINS),
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
        let aps = targets::spectra(map);
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
        let bins = link * ANGLE_BINS..(link + 1) * ANGLE_BINS;
        self.db.append(aps.samples(), bins);
        Ok(())
    }

    /// Place of each link in the data set.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The links as the condition images need them.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The target of a link.
    pub fn target(&self, link: usize) -> [f64; ANGLE_BINS] {
        let mut values = [0.0; ANGLE_BINS];
        let written = Target::Normalised(self.normalization).write(&self.db, link, &mut values);
        written.expect(
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

#[cfg(test)]
mod tests {
    use aps_data::{
        Axis, DatasetConfig, DatasetWriter, Layout, LinkRows, LinkStatus, Links, MapInput, Part,
        Precision, ProfileLayout, ProfileRows, Raster, RasterGrid, Split,
    };
    use serde_json::json;

    use super::*;
    use crate::data;

    /// Two maps of 3 x 3 links, one of each without a label, with values that take all digits a precision has.
    fn dataset(dtype: Precision, protocol: &str) -> (tempfile::TempDir, Dataset) {
        let root = tempfile::tempdir().unwrap();
        let aps = ProfileLayout {
            dtype,
            ..ProfileLayout::over(Axis::ANGLE_PAPER_DEG)
        };
        let config = DatasetConfig {
            configuration: json!({ "label": { "protocol": protocol } }),
            layout: Layout {
                aps: Some(aps),
                ..Layout::default()
            },
            ..DatasetConfig::default()
        };
        let writer = DatasetWriter::open(root.path(), config).unwrap();
        let buildings = Raster::empty(RasterGrid::default()).unwrap();
        let at = [[10.0, 20.0], [30.0, 5.0], [90.5, 90.0]];
        for id in 0..2 {
            let input = MapInput {
                buildings: &buildings,
                tx_m: &at,
                rx_m: &at,
                links: Links::Grid,
            };
            let mut map = writer.begin_map(id, &input).unwrap();
            let value = |i: usize| -90.0 - 40.0 * (f64::from(id) + (i as f64 * 0.7).sin()).abs();
            let db: Vec<f64> = (0..9 * ANGLE_BINS).map(value).collect();
            let mut status = [LinkStatus::Valid; 9];
            status[4] = LinkStatus::NoPath;
            let aps = ProfileRows {
                db: &db,
                argmax: None,
            };
            map.push(&LinkRows {
                status: &status,
                aps: Some(aps),
                ..LinkRows::default()
            })
            .unwrap();
            map.finish().unwrap();
        }
        let split = Split {
            train: vec![0],
            develop: vec![],
            test: vec![1],
        };
        writer.finish(&split).unwrap();
        let dataset = data::open(root.path()).unwrap();
        (root, dataset)
    }

    /// Whatever a data set stores, a model learns what it is scored against.
    #[test]
    fn targets_learnt_and_scored_have_the_same_bits() {
        for dtype in [Precision::F16, Precision::F32] {
            for protocol in ["paper", "released"] {
                let (_root, dataset) = dataset(dtype, protocol);
                let (_, _, normalization) = data::target(&dataset).unwrap();
                let index_of = BTreeMap::from([(1, 0)]);
                let labels =
                    Labels::load(&dataset, &[1], &index_of, None, 0, normalization).unwrap();
                let (mut scored, target) = (Vec::new(), Target::Normalised(normalization));
                let found =
                    targets::for_each_block(&dataset, Part::Test, target, 3, |rows, map| {
                        assert_eq!(map, 1);
                        scored.extend_from_slice(rows);
                        Ok(())
                    });
                assert_eq!((found.unwrap(), labels.len()), (8, 8));
                let map = dataset.map(1).unwrap();
                for (link, expected) in scored.chunks(ANGLE_BINS).enumerate() {
                    let learnt = labels.target(link);
                    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect();
                    let (learnt, expected): (Vec<u64>, Vec<u64>) = (bits(&learnt), bits(expected));
                    assert_eq!(learnt, expected, "{dtype:?}, {protocol}, link {link}");
                    // By the shortest way there is.
                    let mut stored = [0.0_f32; ANGLE_BINS];
                    let row = labels.rows()[link].link as usize;
                    targets::spectra(&map).read_relative_db(row, &mut stored);
                    let mut own = stored.map(f64::from);
                    normalization.apply(&mut own).unwrap();
                    assert_eq!(bits(&own), learnt, "{dtype:?}, {protocol}, link {link}");
                    // A network's tensors are in single precision.
                    let mut single = [0.0; ANGLE_BINS];
                    labels.write_target(link, &mut single);
                    assert!(single.iter().zip(own).all(|(&s, x)| s == x as f32));
                }
            }
        }
    }
}
