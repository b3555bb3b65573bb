//! The fields of a transmitter: for each pixel the sources of the shortest ways to it.

use glam::DVec2;

use super::canvas::{Canvas, DARK, Source};
use super::corners::Ways;
use super::error::FieldError;
use super::map::FieldMap;
use super::view::{Piece, Scratch, View};
use crate::scene::Scene;

/// Ways from the transmitter to a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Field {
    /// The shortest way around the buildings, straight where the transmitter is in sight.
    Geodesic,
    /// The shortest way with one specular reflection.
    Once,
    /// The shortest way with two specular reflections.
    Twice,
}

impl Field {
    /// All of them, in the order in which they are kept.
    pub const ALL: [Self; 3] = [Self::Geodesic, Self::Once, Self::Twice];
}

/// Marks in [`TransmitterFields::pixels`]: no way, and the transmitter itself.
pub(super) const NO_SOURCE: u16 = 0;
pub(super) const STRAIGHT: u16 = 1;

/// Largest number of sources: their numbers take two bytes.
const MAX_SOURCES: usize = u16::MAX as usize;

/// The fields of one transmitter: 6 bytes a pixel, and 16 a source.
///
/// A pixel holds no lengths but the source of the shortest way: the transmitter, an image of it, or a corner with the length
/// of the way to it. So the length at any position within the pixel is exact, as far as the way to its centre is open.
#[derive(Debug, Clone)]
pub struct TransmitterFields {
    pub(super) position: DVec2,
    /// In the fields' own coordinates.
    pub(super) place: DVec2,
    /// Shortest ways to the corners.
    pub(super) ways: Ways,
    /// Sources by pixel in the order of [`Field::ALL`], and one pixel without any.
    pub(super) pixels: Vec<[u16; 3]>,
    /// Place of each source, counted from the first pixel, the length of the way to it \[m\], and 1; zeros for none.
    pub(super) sources: Vec<[f32; 4]>,
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
        let mut sources = vec![Source {
            point: place,
            offset_m: 0.0,
        }];
        let mut canvases = [(); 3].map(|()| Canvas::new(map.local_grid()));
        let [geodesic, reflected @ ..] = &mut canvases;
        for piece in &pieces {
            let sides = piece.sides(scene, None);
            geodesic.paint(piece.heights_m(), sides, 0, &sources[0]);
        }
        map.corners.paint(scene, &ways, 1, geodesic);
        sources.extend((0..ways.lengths_m.len()).map(|c| map.corners.source(&ways, c)));
        let mut painter = Painter {
            scene,
            reach: map.reach(),
            scratch,
            sources: &mut sources,
        };
        painter.reflect(place, &pieces, reflected);
        for canvas in &mut canvases {
            map.extend_to_rim(canvas, &sources);
        }
        let first_m = map.local_grid().first_m;
        let (pixels, sources) =
            number(&canvases, &sources, first_m).map_err(|sources| FieldError::TooManySources {
                position,
                sources,
                limit: MAX_SOURCES,
            })?;
        Ok(Self {
            position,
            place,
            ways,
            pixels,
            sources,
        })
    }

    /// Position of the transmitter \[m\].
    #[must_use]
    pub fn position(&self) -> DVec2 {
        self.position
    }

    /// Memory they take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.pixels) + size_of_val(&*self.sources) + self.ways.bytes()
    }

    /// Returns, pixel by pixel, 1 where the transmitter is in sight of the pixel and 0 elsewhere.
    #[must_use]
    pub fn in_sight(&self) -> Vec<u8> {
        let is_straight = |pixel: &[u16; 3]| u8::from(pixel[0] == STRAIGHT);
        self.grid_pixels().iter().map(is_straight).collect()
    }

    /// Returns, pixel by pixel, the unfolded length of a field's way to the pixel's centre \[m\]; infinity where there is none.
    #[must_use]
    pub fn lengths_m(&self, map: &FieldMap<'_>, field: Field) -> Vec<f32> {
        let grid = map.grid();
        let length = |(i, pixel): (usize, &[u16; 3])| {
            let at = (grid.centre(i) - grid.first_m).as_vec2();
            match pixel[field as usize] {
                NO_SOURCE => f32::INFINITY,
                source => {
                    let [x, y, offset_m, _] = self.sources[source as usize];
                    offset_m + at.distance(glam::Vec2::new(x, y))
                }
            }
        };
        self.grid_pixels().iter().enumerate().map(length).collect()
    }

    fn grid_pixels(&self) -> &[[u16; 3]] {
        &self.pixels[..self.pixels.len() - 1]
    }
}

/// Paints what images light.
struct Painter<'a> {
    scene: &'a Scene,
    reach: [DVec2; 2],
    scratch: Scratch,
    sources: &'a mut Vec<Source>,
}

impl Painter<'_> {
    /// Paints what the walls at the ends of a source's view reflect onto the first canvas, what the walls at the ends of these
    /// reflect onto the second, and so on.
    fn reflect(&mut self, source: DVec2, pieces: &[Piece], canvases: &mut [Canvas]) {
        let Some((canvas, further)) = canvases.split_first_mut() else {
            return;
        };
        let mut lit = Vec::new();
        for piece in pieces {
            let Some((view, image)) = View::reflected(self.scene, source, piece) else {
                continue;
            };
            lit.clear();
            view.pieces(self.scene, self.reach, &mut self.scratch, &mut lit);
            let id = self.sources.len() as u32;
            self.sources.push(Source {
                point: image,
                offset_m: 0.0,
            });
            for lit in &lit {
                let sides = lit.sides(self.scene, piece.wall);
                canvas.paint(lit.heights_m(), sides, id, &self.sources[id as usize]);
            }
            self.reflect(image, &lit, further);
        }
    }
}

/// Numbers the sources that rule a pixel, the transmitter as [`STRAIGHT`]: sources by pixel, and their places. `Err` with
/// their number if it is too large.
#[expect(clippy::type_complexity, reason = "taken apart where it is called")]
fn number(
    canvases: &[Canvas; 3],
    sources: &[Source],
    first_m: DVec2,
) -> Result<(Vec<[u16; 3]>, Vec<[f32; 4]>), usize> {
    let mut numbers = vec![None; sources.len()];
    let mut places = vec![[0.0; 4]];
    let mut number = |source: usize| {
        *numbers[source].get_or_insert_with(|| {
            let Source { point, offset_m } = sources[source];
            let place = point - first_m;
            places.push([place.x, place.y, offset_m, 1.0].map(|value| value as f32));
            // Too many are counted, but not kept.
            (places.len() - 1) as u16
        })
    };
    number(0);
    let mut pixels = vec![[NO_SOURCE; 3]; canvases[0].sources.len() + 1];
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
