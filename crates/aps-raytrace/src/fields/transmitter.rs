//! The fields of a transmitter: for each pixel the sources of the shortest ways to it.

use glam::DVec2;

use super::canvas::{Canvas, DARK, Source};
use super::corners::{Seed, Ways};
use super::error::FieldError;
use super::map::FieldMap;
use super::view::{Piece, Scratch, View};
use crate::scene::Scene;


/// Marks in [`TransmitterFields::pixels`]: no way, and the transmitter itself.
pub(super) const NO_SOURCE: u16 = 0;
pub(super) const STRAIGHT: u16 = 1;

/// Fields of a transmitter: corners after no, one and two reflections.
pub const FIELDS: usize = 3;

/// Largest number of sources: their numbers take two bytes.
const MAX_SOURCES: usize = u16::MAX as usize;

/// The fields of one transmitter.
#[derive(Debug, Clone)]
pub struct TransmitterFields {
    pub(super) place: DVec2,
    /// Shortest ways to the corners.
    pub(super) ways: Ways,
    /// Sources by pixel, and one pixel without any.
    pub(super) pixels: Vec<[u16; FIELDS]>,
    /// x, y, offset, 1, unit vector of arrival x, y, turned so far \[rad\], corners + 64 * sum of cosines.
    pub(super) sources: Vec<[f32; 9]>,
}

impl TransmitterFields {
    pub(super) fn new(map: &FieldMap<'_>, position: DVec2) -> Result<Self, FieldError> {
        let scene = map.scene();
        let place = position - map.origin();
        let mut scratch = Scratch::default();
        let mut pieces = Vec::new();
        for view in View::around(place) {
            view.pieces(scene, map.reach(), &mut scratch, &mut pieces);
        }
        let ways = map.corners.ways(scene, place);
        let mut seeds = [(); 2].map(|()| Vec::new());
        Seeds { scene, map, scratch }.collect(place, &pieces, &mut Vec::new(), &mut seeds);
        let [once, twice] = seeds.map(|s| map.corners.ways_of(s.into_iter()));
        let all = [&ways, &once, &twice];
        let n = map.corner_count();
        let mut sources = vec![Source { point: place, offset_m: 0.0 }];
        let mut details = vec![[0.0; 5]];
        for w in all {
            for c in 0..n {
                sources.push(map.corners.source(w, c));
                let dir = (map.corners.corners[c].point - w.before[c]).normalize_or_zero();
                details.push([dir.x, dir.y, w.turned_rad[c], w.count[c].into(), w.cos_sum[c]]);
            }
        }
        let mut canvases = [(); FIELDS].map(|()| Canvas::new(map.local_grid()));
        for piece in &pieces {
            let sides = piece.sides(scene, None);
            canvases[0].paint(piece.heights_m(), sides, 0, &sources[0]);
        }
        for (i, w) in all.into_iter().enumerate() {
            map.corners.paint(scene, w, (1 + i * n) as u32, &mut canvases[i]);
        }
        for canvas in &mut canvases {
            map.extend_to_rim(canvas, &sources);
        }
        let first_m = map.local_grid().first_m;
        let (pixels, sources) = number(&canvases, &sources, &details, first_m).map_err(|sources| {
            FieldError::TooManySources { position, sources, limit: MAX_SOURCES }
        })?;
        Ok(Self { place, ways, pixels, sources })
    }
}

/// Collects the corners that images light.
struct Seeds<'a, 's> {
    scene: &'a Scene,
    map: &'a FieldMap<'s>,
    scratch: Scratch,
}

impl Seeds<'_, '_> {
    fn collect(&mut self, source: DVec2, pieces: &[Piece], normals: &mut Vec<DVec2>, seeds: &mut [Vec<Seed>]) {
        let Some((of_images, further)) = seeds.split_first_mut() else {
            return;
        };
        let mut lit = Vec::new();
        for piece in pieces {
            let Some((view, image)) = View::reflected(self.scene, source, piece) else {
                continue;
            };
            lit.clear();
            view.pieces(self.scene, self.map.reach(), &mut self.scratch, &mut lit);
            let wall = &self.scene.walls()[piece.wall.expect("reflects") as usize];
            let normal = wall.outward().normalize();
            let mut seen: Vec<DVec2> = normals.iter().map(|n| *n - normal * (2.0 * n.dot(normal))).collect();
            seen.push(normal);
            for lit in &lit {
                let Some(id) = lit.wall else { continue };
                for (at, end) in lit.at.into_iter().flat_map(|at| [(at, 0), (at, 1)]) {
                    if (at - end as f64).abs() > 1e-9 { continue }
                    let corner = self.map.corners.at_end[id as usize][end];
                    if corner == u32::MAX { continue }
                    let c = &self.map.corners.corners[corner as usize];
                    if c.bends(image) {
                        let ray = c.point - image;
                        let length_m = ray.length();
                        let cos_sum = seen.iter().map(|n| n.dot(ray).abs() / length_m).sum();
                        of_images.push(Seed { corner, length_m, from: image, cos_sum });
                    }
                }
            }
            let mut seen = seen;
            self.collect(image, &lit, &mut seen, further);
        }
    }
}

#[expect(clippy::type_complexity, reason = "taken apart where it is called")]
fn number(
    canvases: &[Canvas; FIELDS],
    sources: &[Source],
    details: &[[f64; 5]],
    first_m: DVec2,
) -> Result<(Vec<[u16; FIELDS]>, Vec<[f32; 9]>), usize> {
    let mut numbers = vec![None; sources.len()];
    let mut places = vec![[0.0; 9]];
    let mut number = |source: usize| {
        *numbers[source].get_or_insert_with(|| {
            let Source { point, offset_m } = sources[source];
            let place = point - first_m;
            let [a, b, c, d, e] = details[source];
            places.push([place.x, place.y, offset_m, 1.0, a, b, c, d, e].map(|value| value as f32));
            (places.len() - 1) as u16
        })
    };
    number(0);
    let mut pixels = vec![[NO_SOURCE; FIELDS]; canvases[0].sources.len() + 1];
    for (field, canvas) in canvases.iter().enumerate() {
        for (pixel, &source) in pixels.iter_mut().zip(&canvas.sources) {
            if source != DARK {
                pixel[field] = number(source as usize);
            }
        }
    }
    match places.len() - 1 {
        count if count > MAX_SOURCES => Err(count),
        _ => Ok((pixels, places)),
    }
}
