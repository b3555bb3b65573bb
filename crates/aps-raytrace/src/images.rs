//! The tree of images of one terminal, clipped to beams.
//!
//! A node is a sequence of walls, the image of the terminal over all of them, and the window of
//! the last wall that can be lit. Nodes are grouped by their last wall, in plain columns: a link
//! looks only at the walls its other end sees, and tests their nodes with a few multiplications
//! each.

use glam::DVec2;

use crate::beam::{Beam, Sweep, Window, visible_walls};
use crate::error::TerminalError;
use crate::scene::Scene;

/// A wall as seen from a point: the point in the wall's frame and the window it sees.
///
/// The four numbers carry a factor of the wall's length squared or length, so that the test of a
/// node needs no division.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sight {
    pub wall: u32,
    /// Distance along the wall from its start, times its length \[m^2\].
    pub along: f64,
    /// Distance in front of the wall, times its length \[m^2\]; positive.
    pub outward: f64,
    /// Window, times the wall's length squared \[m^2\].
    pub lo: f64,
    /// See `lo`.
    pub hi: f64,
}

/// Reusable memory for building trees and sights.
#[derive(Debug, Default)]
pub(crate) struct TreeScratch {
    sweep: Sweep,
    windows: Vec<Window>,
}

/// Finds all walls seen from an outdoor point, by id. `is_hidden` drops windows.
pub(crate) fn sights(
    scene: &Scene,
    from: DVec2,
    scratch: &mut TreeScratch,
    is_hidden: impl Fn(Window) -> bool,
) -> Vec<Sight> {
    root_windows(scene, from, scratch);
    scratch
        .windows
        .iter()
        .filter(|&&w| !is_hidden(w))
        .map(|&w| sight(scene, from, w))
        .collect()
}

fn sight(scene: &Scene, from: DVec2, window: Window) -> Sight {
    let wall = &scene.walls()[window.wall as usize];
    let (along, outward) = wall.frame(from);
    let length_squared = wall.along().length_squared();
    Sight {
        wall: window.wall,
        along,
        outward,
        lo: window.lo * length_squared,
        hi: window.hi * length_squared,
    }
}

/// Fills `scratch.windows` with the parts of walls that a point sees, one window a wall, by wall id.
fn root_windows(scene: &Scene, from: DVec2, scratch: &mut TreeScratch) {
    let TreeScratch { sweep, windows } = scratch;
    windows.clear();
    for beam in Beam::quadrants(from) {
        visible_walls(scene.walls(), scene.index(), &beam, sweep, windows);
    }
    windows.sort_unstable_by_key(|w| w.wall);
    windows.dedup_by(|later, first| {
        let same = later.wall == first.wall;
        if same {
            first.lo = first.lo.min(later.lo);
            first.hi = first.hi.max(later.hi);
        }
        same
    });
}

/// Marks a node of order 1.
pub(crate) const NO_PARENT: u32 = u32::MAX;

/// One image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Image {
    /// Where it is \[m\].
    pub point: DVec2,
    /// Last wall of its sequence.
    pub wall: u32,
    /// The image before that wall, or [`NO_PARENT`].
    pub parent: u32,
}

/// The images of one terminal up to some order.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImageTree {
    pub images: Vec<Image>,
    /// Images, below the highest order, through whose window no further wall is seen: branches
    /// that end there.
    pub empty_beams: usize,
    /// First row of each wall in `rows`, and the end.
    first_row: Vec<u32>,
    /// The images' parents as seen from the last wall; `Row::image` tells whose.
    rows: Vec<Row>,
}

#[derive(Debug, Clone, Copy)]
struct Row {
    along: f64,
    outward: f64,
    lo: f64,
    hi: f64,
    image: u32,
    order: u32,
}

impl ImageTree {
    /// Builds the tree of an outdoor point.
    ///
    /// # Errors
    /// [`TerminalError::TooManyImages`] before more than `max_images` are stored.
    pub fn build(
        scene: &Scene,
        from: DVec2,
        max_order: usize,
        max_images: usize,
        scratch: &mut TreeScratch,
    ) -> Result<Self, TerminalError> {
        if max_order == 0 {
            return Ok(Self::default());
        }
        let walls = scene.walls();
        let mut builder = Builder {
            scene,
            from,
            max_images,
            tree: Self::default(),
            rows: Vec::new(),
        };
        root_windows(scene, from, scratch);
        let mut level = scratch.windows.clone();
        builder.add(&level, from, NO_PARENT, 1)?;
        let mut begin = 0;
        for order in 2..=max_order {
            let mut next_level = Vec::new();
            for (image, &window) in (begin..).zip(&level) {
                let Image { point, wall, .. } = builder.tree.images[image];
                let lit = next_level.len();
                if let Some(beam) = Beam::through(point, &walls[wall as usize], window) {
                    let sweep = &mut scratch.sweep;
                    visible_walls(walls, scene.index(), &beam, sweep, &mut next_level);
                }
                builder.tree.empty_beams += usize::from(next_level.len() == lit);
                builder.add(&next_level[lit..], point, image as u32, order)?;
            }
            begin += level.len();
            level = next_level;
        }
        Ok(builder.finish())
    }

    /// Calls `visit` with every image whose line to the point with these sights passes the
    /// windows of its last wall, on both sides: the candidates for a path.
    #[inline]
    pub fn for_each_candidate(
        &self,
        sights: &[Sight],
        max_order: usize,
        mut visit: impl FnMut(u32),
    ) {
        if self.rows.is_empty() || max_order == 0 {
            return;
        }
        for sight in sights {
            let wall = sight.wall as usize;
            let rows = self.first_row[wall] as usize..self.first_row[wall + 1] as usize;
            for row in &self.rows[rows] {
                if row.order as usize > max_order {
                    break;
                }
                let crossing = row.along * sight.outward + sight.along * row.outward;
                let depth = row.outward + sight.outward;
                let (lo, hi) = (row.lo.max(sight.lo), row.hi.min(sight.hi));
                if crossing >= lo * depth && crossing <= hi * depth {
                    visit(row.image);
                }
            }
        }
    }
}

/// A tree in the making: rows still in the order of the images.
struct Builder<'s> {
    scene: &'s Scene,
    from: DVec2,
    max_images: usize,
    tree: ImageTree,
    rows: Vec<(u32, Row)>,
}

impl Builder<'_> {
    /// Adds the images of `point` over the walls it sees.
    fn add(
        &mut self,
        seen: &[Window],
        point: DVec2,
        parent: u32,
        order: usize,
    ) -> Result<(), TerminalError> {
        let images = &mut self.tree.images;
        if images.len() + seen.len() > self.max_images.min(NO_PARENT as usize) {
            return Err(TerminalError::TooManyImages {
                position: self.from,
                order,
                limit: self.max_images,
            });
        }
        for &window in seen {
            let sight = sight(self.scene, point, window);
            let row = Row {
                along: sight.along,
                outward: sight.outward,
                lo: sight.lo,
                hi: sight.hi,
                image: images.len() as u32,
                order: order as u32,
            };
            self.rows.push((window.wall, row));
            images.push(Image {
                point: self.scene.walls()[window.wall as usize].mirror(point),
                wall: window.wall,
                parent,
            });
        }
        Ok(())
    }

    /// Groups the rows by wall; within a wall by order, then by image.
    fn finish(mut self) -> ImageTree {
        self.rows
            .sort_unstable_by_key(|&(wall, row)| (wall, row.order, row.image));
        let walls = self.scene.walls().len();
        self.tree.first_row = group_starts(self.rows.iter().map(|r| r.0), walls);
        self.tree.rows = self.rows.into_iter().map(|r| r.1).collect();
        self.tree
    }
}

/// Start of each group in a sorted sequence of keys below `groups`, and the end.
fn group_starts(keys: impl Iterator<Item = u32>, groups: usize) -> Vec<u32> {
    let mut starts = vec![0_u32; groups + 1];
    for key in keys {
        starts[key as usize + 1] += 1;
    }
    for i in 0..groups {
        starts[i + 1] += starts[i];
    }
    starts
}
