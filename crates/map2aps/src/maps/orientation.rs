//! Copies of maps in the eight orientations of a square: quarter turns and their mirror images.

use std::collections::BTreeSet;

use aps_data::Split;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, Footprint};

use super::MapError;

/// Copy `k` of map `id` has the id `k * COPY_STRIDE + id`.
pub const COPY_STRIDE: u32 = 1_000_000;

/// Most orientations of a map.
pub const MAX_ORIENTATIONS: u32 = 8;

/// A map's orientation: so many quarter turns to the left, after a mirroring in east and west from the fourth on.
///
/// A copy is not another picture of the same links: a linear array keeps its direction while the city turns under it, and each
/// copy has terminals of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Orientation(u32);

impl Orientation {
    /// The map and orientation that an id stands for where maps have so many orientations.
    ///
    /// # Errors
    /// [`MapError::NoCopy`] and [`MapError::Orientations`].
    pub fn of_id(id: u32, orientations: u32) -> Result<(u32, Self), MapError> {
        check(orientations)?;
        if orientations == 1 {
            return Ok((id, Self::default()));
        }
        let (orientation, map) = (id / COPY_STRIDE, id % COPY_STRIDE);
        match orientation < orientations {
            true => Ok((map, Self(orientation))),
            false => Err(MapError::NoCopy { id, orientations }),
        }
    }

    /// The footprints in this orientation, about the middle of a square area.
    pub fn turn(self, mut footprints: Vec<Footprint>, area: Area) -> Vec<Footprint> {
        if self != Self::default() {
            for footprint in &mut footprints {
                let rings = std::iter::once(&mut footprint.outer).chain(&mut footprint.holes);
                for point in rings.flatten() {
                    *point = self.point(*point, area);
                }
            }
        }
        footprints
    }

    fn point(self, p: DVec2, Area { min, max }: Area) -> DVec2 {
        let p = match self.0 >= 4 {
            true => DVec2::new(min.x + max.x - p.x, p.y),
            false => p,
        };
        // Each coordinate is taken from one side, so that a turn there and back changes no more than the last digits.
        let (from_min, from_max) = (p - min, max - p);
        match self.0 % 4 {
            0 => p,
            1 => min + DVec2::new(from_max.y, from_min.x),
            2 => min + from_max,
            _ => min + DVec2::new(from_min.y, from_max.x),
        }
    }
}

/// Adds the copies of its training maps to a split of upright maps. Development and test maps have none: what is trained on
/// turned streets is scored on streets as they are.
///
/// # Errors
/// [`MapError::Orientations`], and [`MapError::NoRoomForCopies`] for ids of a million and more.
pub fn with_copies(mut split: Split, orientations: u32) -> Result<Split, MapError> {
    check(orientations)?;
    if orientations == 1 {
        return Ok(split);
    }
    if let Some(id) = split.all_maps().into_iter().find(|&id| id >= COPY_STRIDE) {
        return Err(MapError::NoRoomForCopies(id));
    }
    let copies = |k| split.train.iter().map(move |id| k * COPY_STRIDE + id);
    split.train = (0..orientations).flat_map(copies).collect();
    Ok(split)
}

/// Splits ascending maps by a seed, copies with the map that they are of.
///
/// # Errors
/// As [`with_copies`], and [`MapError::CopiesOfOthers`] for copies of maps that are trained on no more.
pub fn split(ids: &[u32], seed: u64, orientations: u32) -> Result<Split, MapError> {
    if orientations == 1 {
        return Ok(Split::of_maps(ids.iter().copied(), seed));
    }
    let upright = ids.iter().map(|id| id % COPY_STRIDE);
    let mut split = with_copies(Split::of_maps(upright, seed), orientations)?;
    let is_left = |id: &&u32| **id >= COPY_STRIDE && !split.train.contains(id);
    let left: Vec<u32> = ids.iter().filter(is_left).copied().collect();
    if !left.is_empty() {
        return Err(MapError::CopiesOfOthers(left));
    }
    split.train.retain(|id| ids.binary_search(id).is_ok());
    Ok(split)
}

/// Splits imported maps by a seed, the copies of a map in one part.
pub(crate) fn split_of_imported(ids: &[u32], seed: u64) -> Split {
    let upright: BTreeSet<u32> = ids.iter().map(|id| id % COPY_STRIDE).collect();
    let mut split = Split::of_maps(upright, seed);
    for part in [&mut split.train, &mut split.develop, &mut split.test] {
        let of_part = |id: &&u32| part.contains(&(**id % COPY_STRIDE));
        *part = ids.iter().filter(of_part).copied().collect();
    }
    split
}

/// Refuses numbers of orientations that a square has not.
fn check(orientations: u32) -> Result<(), MapError> {
    match (1..=MAX_ORIENTATIONS).contains(&orientations) {
        true => Ok(()),
        false => Err(MapError::Orientations(orientations)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: Area = Area {
        min: DVec2::new(-3.0, 5.0),
        max: DVec2::new(1.0, 9.0),
    };

    #[test]
    fn a_square_has_eight_orientations() {
        let corner = DVec2::new(-3.0, 6.0);
        let all: Vec<[f64; 2]> = (0..8)
            .map(|k| Orientation(k).point(corner, AREA).to_array())
            .collect();
        let turned = [[-3., 6.], [0., 5.], [1., 8.], [-2., 9.]];
        let mirrored = [[1., 6.], [0., 9.], [-3., 8.], [-2., 5.]];
        assert_eq!(all[..4], turned);
        assert_eq!(all[4..], mirrored);
    }

    #[test]
    fn imported_copies_are_in_the_part_of_their_map() {
        // Of map 9 there are copies alone.
        let copies = [0, 3, 9, COPY_STRIDE + 9].map(|id| COPY_STRIDE + id);
        let ids = [&[0, 1, 2, 3], &copies[..]].concat();
        let upright = Split::of_maps([0, 1, 2, 3, 9], 7);
        let split = split_of_imported(&ids, 7);
        for (own, with) in [
            (&upright.train, &split.train),
            (&upright.develop, &split.develop),
            (&upright.test, &split.test),
        ] {
            let of_part = |id: &u32| own.contains(&(id % COPY_STRIDE));
            let expected: Vec<u32> = ids.iter().copied().filter(of_part).collect();
            assert_eq!(*with, expected);
        }
    }

    #[test]
    fn four_quarter_turns_change_nothing() {
        let p = DVec2::new(-1.37, 8.11);
        let quarter = |p| Orientation(1).point(p, AREA);
        let round = quarter(quarter(quarter(quarter(p))));
        assert!(round.abs_diff_eq(p, 1e-14), "{round}");
        let half = quarter(quarter(p));
        assert!(half.abs_diff_eq(Orientation(2).point(p, AREA), 1e-14));
        let mirrored = Orientation(4).point(Orientation(4).point(p, AREA), AREA);
        assert!(mirrored.abs_diff_eq(p, 1e-14));
    }

    #[test]
    fn copies_are_in_the_part_of_their_map() {
        let upright = Split::of_maps(0..=50, 42);
        let all = with_copies(upright.clone(), 8).unwrap();
        assert_eq!(all.train.len(), 8 * upright.train.len());
        assert!(all.train.is_sorted());
        assert_eq!((&all.develop, &all.test), (&upright.develop, &upright.test));
        assert_eq!(split(&all.all_maps(), 42, 8).unwrap(), all);
        for &id in &all.train {
            let (map, _) = Orientation::of_id(id, 8).unwrap();
            assert!(upright.train.contains(&map), "{id}");
        }
    }

    #[test]
    fn ids_of_no_copy_are_refused() {
        assert_eq!(Orientation::of_id(7_000_003, 8), Ok((3, Orientation(7))));
        let no_copy = MapError::NoCopy {
            id: 2_000_003,
            orientations: 2,
        };
        assert_eq!(Orientation::of_id(2_000_003, 2), Err(no_copy));
        assert_eq!(
            Orientation::of_id(2_000_003, 1),
            Ok((2_000_003, Orientation(0)))
        );
        for wrong in [0, 9] {
            assert_eq!(
                Orientation::of_id(1, wrong),
                Err(MapError::Orientations(wrong))
            );
        }
        let large = Split::of_maps([1_000_000], 0);
        assert_eq!(
            with_copies(large, 2),
            Err(MapError::NoRoomForCopies(1_000_000))
        );
    }
}
