//! The tree of images of one terminal, clipped to beams.
//!
//! A node is a sequence of walls, the image of the terminal over all of them, and the window of
//! the last wall that can be lit. Nodes are grouped by their last wall: a link looks only at the
//! walls its other end sees, and tests their nodes with a few multiplications each.

use glam::DVec2;
use multiversion::multiversion;

use crate::beam::{Beam, Sweep, Window, visible_walls};
use crate::scene::Scene;

/// A wall that is seen from a point: the point in the wall's frame and the window it sees.
///
/// The four numbers carry a factor of the wall's length squared or length, so that the test of a
/// node needs no division.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VisibleWall {
    pub wall: u32,
    /// Distance along the wall from its start, times its length \[m^2\].
    pub along: f64,
    /// Distance in front of the wall, times its length \[m^2\]; positive.
    pub outward: f64,
    /// Start of the window, times the wall's length squared \[m^2\].
    pub lo: f64,
    /// End of the window, in the unit of `lo`.
    pub hi: f64,
}

/// View from a point: the parts of walls that are seen, and the nearest wall in each direction.
#[derive(Debug, Clone, Default)]
pub(crate) struct Visibility {
    /// The point \[m\].
    pub from: DVec2,
    sweep: Sweep,
    /// The parts of walls that are seen, one window a wall, by wall id.
    windows: Vec<Window>,
    /// Start directions of the nearest walls, in order, a quadrant counting two.
    nearest: Vec<(f64, u32)>,
}

impl Visibility {
    /// Looks around from an outdoor point, once.
    pub fn from(scene: &Scene, from: DVec2) -> Self {
        let mut visibility = Self::default();
        visibility.look(scene, from);
        visibility
    }

    /// Looks around from another outdoor point.
    pub fn look(&mut self, scene: &Scene, from: DVec2) {
        self.from = from;
        let (sweep, windows) = (&mut self.sweep, &mut self.windows);
        windows.clear();
        self.nearest.clear();
        for (quadrant, beam) in (0..4).zip(Beam::quadrants(from)) {
            let nearest_from = |k, wall| self.nearest.push((2.0 * f64::from(quadrant) + k, wall));
            visible_walls(scene, &beam, sweep, windows, nearest_from);
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

    /// Takes away windows.
    pub fn hide(&mut self, is_hidden: impl Fn(&Window) -> bool) {
        self.windows.retain(|window| !is_hidden(window));
    }

    /// The walls that are seen, by id.
    pub fn visible_walls(&self, scene: &Scene) -> Vec<VisibleWall> {
        let windows = self.windows.iter();
        windows
            .map(|&window| VisibleWall::new(scene, self.from, window))
            .collect()
    }

    /// Tells if a point is seen.
    #[inline]
    pub fn sees(&self, scene: &Scene, to: DVec2) -> bool {
        let from = self.from;
        // The nearest wall in that direction decides most cases, without a search for others.
        !scene.is_blocked_by(from, to, self.nearest(to - from)) && !scene.is_blocked(from, to)
    }

    /// The wall that is seen in a direction, if any, as far as rounding goes.
    fn nearest(&self, direction: DVec2) -> Option<u32> {
        let DVec2 { x, y } = direction;
        let key = if x.abs() >= y.abs() {
            y / x + if x > 0.0 { 0.0 } else { 4.0 }
        } else {
            -x / y + if y > 0.0 { 2.0 } else { 6.0 }
        };
        let after = self.nearest.partition_point(|&(from, _)| from <= key);
        Some(self.nearest[after.checked_sub(1)?].1)
    }
}

impl VisibleWall {
    fn new(scene: &Scene, from: DVec2, window: Window) -> Self {
        let wall = &scene.walls()[window.wall as usize];
        let (along, outward) = wall.frame(from);
        let length_squared = wall.along().length_squared();
        Self {
            wall: window.wall,
            along,
            outward,
            lo: window.lo * length_squared,
            hi: window.hi * length_squared,
        }
    }
}

/// Marker of a node of order 1.
pub(crate) const NO_PARENT: u32 = u32::MAX;

/// An image of a terminal over a sequence of walls.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Image {
    /// Position \[m\].
    pub point: DVec2,
    /// Last wall of the sequence.
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
    /// Parents of the images with the walls they see, by wall, then by image.
    rows: Vec<(VisibleWall, u32)>,
}

impl ImageTree {
    /// Builds the tree of an outdoor point from what is seen there.
    ///
    /// # Errors
    /// The order at which more than `max_images` would be stored.
    pub fn build(
        scene: &Scene,
        max_order: usize,
        max_images: usize,
        visibility: &mut Visibility,
    ) -> Result<Self, usize> {
        let mut tree = Self::default();
        let mut level = if max_order > 0 {
            visibility.windows.clone()
        } else {
            Vec::new()
        };
        let mut next_level = Vec::new();
        let limit = max_images.min(NO_PARENT as usize);
        tree.add(scene, visibility.from, NO_PARENT, &level, limit)
            .ok_or(1_usize)?;
        let sweep = &mut visibility.sweep;
        let mut begin = 0;
        for order in 2..=max_order {
            next_level.clear();
            for (image, &window) in (begin..).zip(&level) {
                let Image { point, wall, .. } = tree.images[image];
                let lit = next_level.len();
                if let Some(beam) = Beam::through(point, &scene.walls()[wall as usize], window) {
                    visible_walls(scene, &beam, sweep, &mut next_level, |_, _| {});
                }
                tree.empty_beams += usize::from(next_level.len() == lit);
                tree.add(scene, point, image as u32, &next_level[lit..], limit)
                    .ok_or(order)?;
            }
            begin += level.len();
            std::mem::swap(&mut level, &mut next_level);
        }
        tree.rows.sort_unstable_by_key(|row| (row.0.wall, row.1));
        let walls = tree.rows.iter().map(|row| row.0.wall);
        tree.first_row = group_starts(walls, scene.walls().len());
        Ok(tree)
    }

    /// Adds the images of `point` over the walls it sees; `None` beyond the limit.
    fn add(
        &mut self,
        scene: &Scene,
        point: DVec2,
        parent: u32,
        seen: &[Window],
        limit: usize,
    ) -> Option<()> {
        if self.images.len() + seen.len() > limit {
            return None;
        }
        for &window in seen {
            let visible = VisibleWall::new(scene, point, window);
            self.rows.push((visible, self.images.len() as u32));
            self.images.push(Image {
                point: scene.walls()[window.wall as usize].mirror(point),
                wall: window.wall,
                parent,
            });
        }
        Some(())
    }

    fn rows(&self, wall: usize) -> &[(VisibleWall, u32)] {
        &self.rows[self.first_row[wall] as usize..self.first_row[wall + 1] as usize]
    }

    /// Calls `visit` with every image whose line to the point that sees these walls passes the
    /// windows of its last wall, on both sides: the candidates for a path.
    #[inline]
    pub fn for_each_candidate(&self, visible_walls: &[VisibleWall], mut visit: impl FnMut(u32)) {
        for seen in visible_walls {
            for (row, image) in self.rows(seen.wall as usize) {
                let [along, outward, lo, hi] = [seen.along, seen.outward, seen.lo, seen.hi];
                if row.is_candidate(along, outward, lo, hi) {
                    visit(*image);
                }
            }
        }
    }

    /// Finds the candidates for many points: point and image, in this order. `None` if they take more than `max_bytes`.
    pub fn candidates(
        &self,
        visible_walls: &VisibleWallColumns,
        max_bytes: usize,
    ) -> Option<Vec<(u32, u32)>> {
        let mut found = Vec::new();
        let mut hits = Vec::new();
        for (wall, ends) in visible_walls.first.windows(2).enumerate() {
            let seen = ends[0] as usize..ends[1] as usize;
            for (row, image) in self.rows(wall) {
                hits.clear();
                hits.resize(seen.len(), false);
                let columns = visible_walls.columns.each_ref().map(|c| &c[seen.clone()]);
                select(row, columns, &mut hits);
                let hits = hits.iter().zip(&visible_walls.points[seen.clone()]);
                let hits = hits.filter_map(|(&hit, &point)| hit.then_some((point, *image)));
                found.extend(hits);
                if size_of_val(&*found) > max_bytes {
                    return None;
                }
            }
        }
        found.sort_unstable();
        Some(found)
    }
}

impl VisibleWall {
    /// Tells if the line from here, through the wall, to a point seen from its other side passes the windows of both.
    #[inline(always)]
    fn is_candidate(&self, along: f64, outward: f64, lo: f64, hi: f64) -> bool {
        let crossing = self.along * outward + along * self.outward;
        let depth = self.outward + outward;
        (crossing >= self.lo.max(lo) * depth) & (crossing <= self.hi.min(hi) * depth)
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn select(row: &VisibleWall, columns: [&[f64]; 4], hits: &mut [bool]) {
    let [along, outward, lo, hi] = columns.map(|column| &column[..hits.len()]);
    for (i, hit) in hits.iter_mut().enumerate() {
        *hit = row.is_candidate(along[i], outward[i], lo[i], hi[i]);
    }
}

/// Walls visible from many points, by wall, in columns, so that one instruction takes several of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct VisibleWallColumns {
    /// First column entry of each wall, and the end.
    first: Vec<u32>,
    points: Vec<u32>,
    /// Columns `along`, `outward`, `lo`, `hi`.
    columns: [Vec<f64>; 4],
}

impl VisibleWallColumns {
    /// Memory of a visible wall.
    pub const BYTES: usize = size_of::<u32>() + 4 * size_of::<f64>();

    /// Sorts the visible walls of points by wall, then by point.
    pub fn new(by_point: &[Vec<VisibleWall>], walls: usize) -> Self {
        let first = group_starts(by_point.iter().flatten().map(|seen| seen.wall), walls);
        let (mut next, count) = (first.clone(), first[walls] as usize);
        let mut points = vec![0; count];
        let mut columns = [(); 4].map(|()| vec![0.0; count]);
        for (point, visible_walls) in (0..).zip(by_point) {
            for visible in visible_walls {
                let at = next[visible.wall as usize];
                next[visible.wall as usize] += 1;
                points[at as usize] = point;
                let fields = [visible.along, visible.outward, visible.lo, visible.hi];
                for (column, field) in columns.iter_mut().zip(fields) {
                    column[at as usize] = field;
                }
            }
        }
        Self {
            first,
            points,
            columns,
        }
    }
}

/// Start of each group in a sorted sequence of keys below `groups`, and the end.
pub(crate) fn group_starts(keys: impl Iterator<Item = u32>, groups: usize) -> Vec<u32> {
    let mut starts = vec![0_u32; groups + 1];
    for key in keys {
        starts[key as usize + 1] += 1;
    }
    for i in 0..groups {
        starts[i + 1] += starts[i];
    }
    starts
}
