//! Maps of a training: which are learnt from, and which the best weights are chosen by.

use std::str::FromStr;

use aps_data::Split;

use super::TrainingError;
use crate::maps::{Orientation, ascending, parse_ids};

/// Choice of the maps by which the best weights are chosen.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum DevelopmentMaps {
    /// The data set's own.
    #[default]
    OfSplit,
    /// These, out of the training and development maps; in text `0-4,7`.
    Ids(Vec<u32>),
    /// Number of maps: the data set's own first, then training maps from the end; in text `count:N`.
    Count(usize),
}

impl FromStr for DevelopmentMaps {
    type Err = TrainingError;

    fn from_str(text: &str) -> Result<Self, TrainingError> {
        match text.strip_prefix("count:") {
            None => Ok(Self::Ids(parse_ids(text)?)),
            Some(count) => match count.parse() {
                Ok(count) if count > 0 => Ok(Self::Count(count)),
                _ => Err(TrainingError::MapCount(count.into())),
            },
        }
    }
}

/// Returns the maps to train on and those to choose the weights by, both ascending; test maps are neither, and no copy of a map
/// is trained on whose other copies choose.
pub fn divide(
    split: &Split,
    chosen: &DevelopmentMaps,
    orientations: u32,
) -> Result<(Vec<u32>, Vec<u32>), TrainingError> {
    let mut pool = [split.train.as_slice(), &split.develop].concat();
    pool.sort_unstable();
    let develop = match chosen {
        DevelopmentMaps::OfSplit => split.develop.clone(),
        DevelopmentMaps::Ids(ids) => {
            if let Some(&id) = ids.iter().find(|id| !pool.contains(id)) {
                return Err(TrainingError::NotATrainingMap { id, pool });
            }
            ids.clone()
        }
        &DevelopmentMaps::Count(count) => {
            let order = split.develop.iter().chain(split.train.iter().rev());
            order.copied().take(count).collect()
        }
    };
    let develop = ascending(develop);
    if develop.is_empty() {
        return Err(TrainingError::NoDevelopmentMaps { pool });
    }
    let map = |&id: &u32| Orientation::of_id(id, orientations).map_or(id, |(map, _)| map);
    let chosen: Vec<u32> = develop.iter().map(map).collect();
    pool.retain(|id| !chosen.contains(&map(id)));
    match pool.is_empty() {
        true => Err(TrainingError::NoTrainingMaps { develop }),
        false => Ok((pool, develop)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Parts = (Vec<u32>, Vec<u32>);

    fn parts(chosen: Option<&str>) -> Result<Parts, TrainingError> {
        let split = Split {
            train: vec![0, 1, 4, 5],
            develop: vec![2, 3],
            test: vec![6],
        };
        let chosen = chosen.map_or(DevelopmentMaps::OfSplit, |text| text.parse().unwrap());
        divide(&split, &chosen, 1)
    }

    #[test]
    fn development_maps_are_held_out_of_the_training_maps() {
        assert_eq!(parts(None).unwrap(), (vec![0, 1, 4, 5], vec![2, 3]));
        assert_eq!(parts(Some("0,5")).unwrap(), (vec![1, 2, 3, 4], vec![0, 5]));
        assert_eq!(
            parts(Some("count:1")).unwrap(),
            (vec![0, 1, 3, 4, 5], vec![2])
        );
        assert_eq!(
            parts(Some("count:3")).unwrap(),
            (vec![0, 1, 4], vec![2, 3, 5])
        );
    }

    #[test]
    fn copies_of_development_maps_are_not_trained_on() {
        let split = Split {
            train: vec![0, 1, 1_000_000, 1_000_001],
            develop: vec![2],
            test: vec![3],
        };
        let of = |chosen: &str| divide(&split, &chosen.parse().unwrap(), 2).unwrap();
        assert_eq!(of("1000001"), (vec![0, 2, 1_000_000], vec![1_000_001]));
        assert_eq!(of("count:1"), (vec![0, 1, 1_000_000, 1_000_001], vec![2]));
    }

    #[test]
    fn test_maps_are_never_developed_on() {
        assert!(
            parts(Some("2,6"))
                .unwrap_err()
                .to_string()
                .contains("map 6")
        );
        assert!(parts(Some("count:6")).is_err());
        let told = |text: &str| text.parse::<DevelopmentMaps>().unwrap_err().to_string();
        assert_eq!(told("count:x"), "'x' is not a number of maps; try count:4");
        assert_eq!(told("4-x"), "'4-x' is not a map id or a range like 0-4");
    }
}
