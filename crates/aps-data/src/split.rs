//! Split of the maps into training, development and test sets.
//!
//! A map belongs to one part with all its links, so that a test is always on streets never seen in
//! training.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One part of a [`Split`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// Maps to fit a model's weights on.
    Train,
    /// Maps that decide on the choice of a model or the end of its training; never trained on, never
    /// reported.
    Develop,
    /// Maps for the figures that are reported.
    Test,
}

impl Part {
    /// Every part of a split.
    pub const ALL: [Part; 3] = [Part::Train, Part::Develop, Part::Test];

    /// Its name: `train`, `develop` or `test`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Develop => "develop",
            Self::Test => "test",
        }
    }
}

/// The name of the part.
impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Part {
    type Err = UnknownPart;

    fn from_str(name: &str) -> Result<Self, UnknownPart> {
        let found = Self::ALL.into_iter().find(|part| part.name() == name);
        found.ok_or_else(|| UnknownPart(name.into()))
    }
}

/// A text that is the name of no part of a split.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is none of 'train', 'develop' and 'test'")]
pub struct UnknownPart(pub String);

/// The maps of each part, in ascending order; every map of a data set is in exactly one.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// Maps to train on.
    pub train: Vec<u32>,
    /// Maps to develop on.
    pub develop: Vec<u32>,
    /// Maps to test on.
    pub test: Vec<u32>,
}

impl Split {
    /// The split of the paper, maps 0 to 45 for training and 46 to 50 for tests, as far as these
    /// maps are there. Of any other choice of maps the last tenth by number, rounded, at least one of
    /// two, is for tests.
    ///
    /// A choice within 0..=50 follows the paper only if both its sides have a map. The paper has no
    /// development maps (its released code selects models on the test maps); a tenth of the
    /// training maps, rounded, is held out for that in either split. Which ones depends on `seed` and
    /// the maps' ids alone, not on the order given.
    ///
    /// ```
    /// use aps_data::Split;
    /// let split = Split::of_maps(0..=50, 0);
    /// assert_eq!(split.test, [46, 47, 48, 49, 50]);
    /// assert_eq!((split.train.len(), split.develop.len()), (41, 5));
    /// assert_eq!(Split::of_maps(0..10, 0).test, [9]);
    /// ```
    pub fn of_maps(ids: impl IntoIterator<Item = u32>, seed: u64) -> Self {
        let ids = sorted(ids);
        let (train, test): (Vec<u32>, Vec<u32>) = ids.iter().partition(|&&id| id <= 45);
        let is_paper = !train.is_empty() && !test.is_empty() && test.iter().all(|&id| id <= 50);
        if is_paper {
            Self::holding_out(train, test, seed)
        } else {
            let mut train = ids;
            let test = train.split_off(train.len() - tenth(train.len()));
            Self::holding_out(train, test, seed)
        }
    }

    fn holding_out(train: Vec<u32>, test: Vec<u32>, seed: u64) -> Self {
        let mut ranked = train;
        ranked.sort_by_key(|&id| (rank(seed, id), id));
        let train = ranked.split_off(tenth(ranked.len()));
        Split {
            train: sorted(train),
            develop: sorted(ranked),
            test,
        }
    }

    /// Returns the maps of one part.
    pub fn maps(&self, part: Part) -> &[u32] {
        match part {
            Part::Train => &self.train,
            Part::Develop => &self.develop,
            Part::Test => &self.test,
        }
    }

    /// Returns the part a map belongs to; `None` for a map of no part.
    pub fn part_of(&self, id: u32) -> Option<Part> {
        Part::ALL
            .into_iter()
            .find(|&part| self.maps(part).contains(&id))
    }

    /// Returns the split with each part in ascending order.
    pub(crate) fn sorted(mut self) -> Self {
        for part in [&mut self.train, &mut self.develop, &mut self.test] {
            part.sort_unstable();
        }
        self
    }

    /// Returns the maps of all parts in ascending order; a map given twice appears twice.
    pub fn all_maps(&self) -> Vec<u32> {
        let mut all = [self.train.as_slice(), &self.develop, &self.test].concat();
        all.sort_unstable();
        all
    }
}

/// A tenth of the maps, rounded, but at least one of two or more.
fn tenth(maps: usize) -> usize {
    if maps < 2 {
        0
    } else {
        ((maps + 5) / 10).max(1)
    }
}

fn sorted(ids: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut ids: Vec<u32> = ids.into_iter().collect();
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// A pseudo-random rank: output of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014) number `id + 1`
/// after `seed`.
fn rank(seed: u64, id: u32) -> u64 {
    let mut z = seed.wrapping_add((u64::from(id) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rank_is_splitmix64() {
        // First outputs for seed 1234567, as in the reference test of the Xoshiro authors' splitmix64.c.
        assert_eq!(rank(1_234_567, 0), 6_457_827_717_110_365_317);
        assert_eq!(rank(1_234_567, 1), 3_203_168_211_198_807_973);
    }

    const DEVELOP_SEED_0: [u32; 5] = [2, 32, 33, 42, 43];

    #[test]
    fn development_maps_of_the_paper_are_fixed() {
        assert_eq!(Split::of_maps(0..=50, 0).develop, DEVELOP_SEED_0);
        assert_ne!(Split::of_maps(0..=50, 1).develop, DEVELOP_SEED_0);
    }

    #[test]
    fn part_of_the_papers_maps_keeps_its_test_maps_out_of_training() {
        assert_eq!(Split::of_maps(40..=47, 0).test, [46, 47]);
        assert_eq!(Split::of_maps(46..=50, 0).test, [50]);
    }

    #[test]
    fn few_maps_train_first() {
        let parts = |maps| {
            let split = Split::of_maps(0..maps, 0);
            Part::ALL.map(|part| split.maps(part).len())
        };
        assert_eq!(
            [0, 1, 2, 3, 5].map(parts),
            [[0, 0, 0], [1, 0, 0], [1, 0, 1], [1, 1, 1], [3, 1, 1]]
        );
    }

    proptest! {
        #[test]
        fn every_map_is_in_one_part(ids in prop::collection::vec(0_u32..80, 0..80), seed: u64) {
            let split = Split::of_maps(ids.iter().rev().copied(), seed);
            prop_assert_eq!(split.all_maps(), sorted(ids.iter().copied()));
            prop_assert_eq!(&split, &Split::of_maps(ids.iter().copied(), seed));
            for part in Part::ALL {
                prop_assert!(split.maps(part).is_sorted());
                prop_assert!(split.maps(part).iter().all(|&id| split.part_of(id) == Some(part)));
            }
        }
    }
}
