//! Ways of a transmitter's waves to the corners.

use glam::DVec2;

use super::error::PolarError;
use super::fan::KINDS;
use super::map::PolarMap;
use super::view::{Piece, Scratch, View};
use crate::scene::Scene;

/// Kinds of ways to a corner: straight, after one reflection, after two, over other corners.
const TO_CORNER: usize = KINDS - 1;

/// Most reflections before the first corner.
const REFLECTIONS: usize = TO_CORNER - 2;

/// Largest memory for the ways of a transmitter.
const MAX_BYTES: usize = 1 << 28;

/// A way from the transmitter to a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Way {
    /// Unfolded length \[m\].
    pub length_m: f32,
    /// Unit vector along which it arrives.
    pub unit: [f32; 2],
    /// Sum of the cosines of incidence at its walls.
    pub cos_sum: f32,
    /// Sum of the angles by which it has turned at corners before \[rad\].
    pub turned_rad: f32,
    /// Number of corners, this one included.
    pub corners: f32,
    /// Factor of the rank: e^(2 turned_rad + cos_sum).
    pub weight: f32,
}

impl Way {
    fn new(length_m: f64, arrives: DVec2, cos_sum: f64, turned_rad: f64, corners: u32) -> Self {
        Self {
            length_m: length_m as f32,
            unit: arrives.normalize_or_zero().as_vec2().to_array(),
            cos_sum: cos_sum as f32,
            turned_rad: turned_rad as f32,
            corners: corners as f32,
            weight: (2.0 * turned_rad + cos_sum).exp() as f32,
        }
    }
}

/// The ways of one transmitter to the corners of its map, some tens of bytes each.
#[derive(Debug, Clone)]
pub struct TransmitterWays {
    /// Identifier of the map that prepared it.
    pub(super) map: u64,
    /// Position in the local scene \[m\].
    pub(super) place: DVec2,
    /// Length of the shortest way around the buildings that bends at each corner \[m\]; infinite without one.
    pub(super) shortest_m: Vec<f64>,
    /// First and end index in `list` of the ways to each corner, by kind.
    first: [Vec<u32>; TO_CORNER],
    list: Vec<Way>,
}

impl PolarMap<'_> {
    /// Finds the ways of a transmitter to the corners.
    ///
    /// # Errors
    /// [`PolarError::Terminal`] where none can stand, [`PolarError::TooManyWays`].
    pub fn transmitter(&self, position: DVec2) -> Result<TransmitterWays, PolarError> {
        TransmitterWays::new(self, self.place(position)?)
    }
}

impl TransmitterWays {
    fn new(map: &PolarMap<'_>, place: DVec2) -> Result<Self, PolarError> {
        let (scene, corners) = (map.scene.local(), &map.corners.corners);
        let in_sight = map.corners.in_sight(scene, place);
        let strings = map.corners.strings(&in_sight, place);
        let straight = in_sight.iter().map(|&(corner, length_m)| Arrival {
            corner,
            length_m,
            from: place,
            cos_sum: 0.0,
        });
        let mut arrivals: [Vec<Arrival>; 1 + REFLECTIONS] = Default::default();
        arrivals[0] = straight.collect();
        let mut scratch = Scratch::default();
        let mut pieces = Vec::new();
        for view in View::around(place) {
            view.pieces(scene, &mut scratch, &mut pieces);
        }
        let mut images = Images {
            map,
            scratch,
            left: MAX_BYTES / size_of::<Arrival>(),
        };
        images.light(place, &pieces, &[], &mut arrivals[1..]);
        if images.left == 0 {
            return Err(PolarError::TooManyWays { limit: MAX_BYTES });
        }
        let mut list = Vec::new();
        let mut first = [(); TO_CORNER].map(|()| Vec::with_capacity(corners.len() + 1));
        for (first, mut arrivals) in first.iter_mut().zip(arrivals) {
            arrivals.sort_by(Arrival::order);
            // Two pieces of one view meet at a corner.
            arrivals.dedup_by(|p, q| p.corner == q.corner && p.from == q.from);
            let mut rest = arrivals.iter().peekable();
            for (c, corner) in (0..).zip(corners) {
                first.push(list.len() as u32);
                while let Some(way) = rest.next_if(|way| way.corner == c) {
                    let arrives = corner.point - way.from;
                    list.push(Way::new(way.length_m, arrives, way.cos_sum, 0.0, 1));
                }
            }
            first.push(list.len() as u32);
        }
        let bent = &mut first[TO_CORNER - 1];
        for (string, corner) in strings.iter().zip(corners) {
            bent.push(list.len() as u32);
            if string.corners > 1 {
                let (arrives, turned_rad) = (corner.point - string.before, string.turned_rad);
                let way = Way::new(string.length_m, arrives, 0.0, turned_rad, string.corners);
                list.push(way);
            }
        }
        bent.push(list.len() as u32);
        Ok(Self {
            map: map.scene.id,
            place,
            shortest_m: strings.iter().map(|string| string.length_m).collect(),
            first,
            list,
        })
    }

    /// The ways of a kind to a corner.
    #[inline]
    pub(super) fn to(&self, corner: u32, kind: usize) -> &[Way] {
        let first = &self.first[kind][corner as usize..];
        &self.list[first[0] as usize..first[1] as usize]
    }

    /// Memory that the ways take \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        let first: usize = self.first.iter().map(|first| size_of_val(&**first)).sum();
        first + size_of_val(&*self.shortest_m) + size_of_val(&*self.list)
    }
}

/// Arrival at a corner from a place or an image in its sight.
#[derive(Debug, Clone, Copy)]
struct Arrival {
    corner: u32,
    length_m: f64,
    from: DVec2,
    cos_sum: f64,
}

impl Arrival {
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        let by_corner = self.corner.cmp(&other.corner);
        let by_length = by_corner.then(self.length_m.total_cmp(&other.length_m));
        let by_x = by_length.then(self.from.x.total_cmp(&other.from.x));
        by_x.then(self.from.y.total_cmp(&other.from.y))
    }
}

/// Images of the transmitter, and the corners that they light.
struct Images<'a, 's> {
    map: &'a PolarMap<'s>,
    scratch: Scratch,
    /// Arrivals for which there is room.
    left: usize,
}

impl Images<'_, '_> {
    /// Finds the corners that the walls at the ends of a view light, given the unit normals of the walls before, as the image
    /// sees them; then those lit after one reflection more, and so on.
    fn light(
        &mut self,
        source: DVec2,
        view: &[Piece],
        normals: &[DVec2],
        out: &mut [Vec<Arrival>],
    ) {
        let Some((arrivals, further)) = out.split_first_mut() else {
            return;
        };
        let (scene, corners): (&Scene, _) = (self.map.scene.local(), &self.map.corners);
        let mut lit = Vec::new();
        for piece in view {
            let Some((view, image)) = View::reflected(scene, source, piece) else {
                continue;
            };
            lit.clear();
            view.pieces(scene, &mut self.scratch, &mut lit);
            let normal = scene.walls()[piece.wall as usize]
                .outward()
                .normalize_or_zero();
            let mirrored = |n: &DVec2| *n - normal * (2.0 * n.dot(normal));
            let mut seen: Vec<DVec2> = normals.iter().map(mirrored).collect();
            seen.push(normal);
            for piece in &lit {
                for end in piece.ends() {
                    let corner = corners.at_ends[piece.wall as usize][end];
                    let Some(found) = corners.corners.get(corner as usize) else {
                        continue;
                    };
                    if self.left == 0 {
                        return;
                    }
                    self.left -= 1;
                    let ray = found.point - image;
                    let length_m = ray.length();
                    arrivals.push(Arrival {
                        corner,
                        length_m,
                        from: image,
                        cos_sum: seen.iter().map(|n| n.dot(ray).abs() / length_m).sum(),
                    });
                }
            }
            self.light(image, &lit, &seen, further);
        }
    }
}
