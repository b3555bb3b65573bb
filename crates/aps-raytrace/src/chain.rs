//! Chains of reflections between a terminal and a point: the decision whether a candidate from
//! the image tree is a path, and its geometry.
//!
//! The decision treats both ends alike. At each wall it takes the image of the one end over the
//! walls before and of the other end over the walls after; the point of reflection is where the
//! line between the two crosses the wall. The legs between are checked along the lines through the
//! same images, not through the rounded points of reflection: whether a corner is touched is
//! exact wherever the images are, as on whole metres between walls along the axes. Exchanging the
//! ends gives the same numbers bit for bit, so a link and its reverse have the same paths even
//! where a path hits a corner.

use glam::DVec2;
use num_complex::Complex64;
use smallvec::SmallVec;

use crate::images::{ImageTree, NO_PARENT};
use crate::material::Reflector;
use crate::occlusion::{LegSegment, is_at_or_behind};
use crate::path::{Interaction, InteractionKind};
use crate::scene::Scene;

/// A specular chain from a terminal to a point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chain {
    /// Reflections in order from the terminal.
    pub reflections: SmallVec<[Interaction; 4]>,
    /// Unfolded length \[m\].
    pub length_m: f64,
    /// Product of the reflection coefficients.
    pub coefficient: Complex64,
    /// The far end as seen from the terminal: mirrored over all walls, last to first \[m\].
    pub far_image: DVec2,
}

impl Chain {
    /// The straight line.
    pub fn direct(from: DVec2, to: DVec2) -> Self {
        Self {
            reflections: SmallVec::new(),
            length_m: from.distance(to),
            coefficient: Complex64::ONE,
            far_image: to,
        }
    }
}

/// Decides the candidate `image` of the terminal at `from` for the point `to`.
///
/// A reflection point at a wall's start belongs to the wall, at its end to the next one.
pub(crate) fn resolve(
    scene: &Scene,
    reflectors: &[Reflector],
    tree: &ImageTree,
    image: u32,
    from: DVec2,
    to: DVec2,
) -> Option<Chain> {
    let mut reflections: SmallVec<[Interaction; 4]> = SmallVec::new();
    let mut depths: SmallVec<[f64; 4]> = SmallVec::new();
    let mut lines: SmallVec<[[DVec2; 2]; 4]> = SmallVec::new();
    let mut target = to;
    let mut node = image;
    while node != NO_PARENT {
        let reflected = &tree.images[node as usize];
        let wall = &scene.walls()[reflected.wall as usize];
        let source = match reflected.parent {
            NO_PARENT => from,
            parent => {
                let before = &tree.images[parent as usize];
                // Rounding lets a wave at the tip of a corner go from one of its outer faces to the other.
                if is_at_or_behind(scene.walls(), reflected.wall, before.wall) {
                    return None;
                }
                before.point
            }
        };
        let (source_along, source_out) = wall.frame(source);
        let (target_along, target_out) = wall.frame(target);
        if source_out <= 0.0 || target_out <= 0.0 {
            return None;
        }
        let length_squared = wall.along().length_squared();
        let depth = source_out + target_out;
        let crossing = source_along * target_out + target_along * source_out;
        // From the end the wall's length would round away what a corner decides.
        let (source_back, source_out) = wall.frame_from_end(source);
        let (target_back, target_out) = wall.frame_from_end(target);
        let crossing_back = source_back * target_out + target_back * source_out;
        if crossing < 0.0 || crossing_back <= 0.0 {
            return None;
        }
        reflections.push(Interaction {
            kind: InteractionKind::Reflection,
            id: reflected.wall,
            point: wall.a + wall.along() * (crossing / (depth * length_squared)),
        });
        target = wall.mirror(target);
        lines.push([source, target]);
        depths.push(depth / length_squared.sqrt());
        node = reflected.parent;
    }
    reflections.reverse();
    lines.reverse();
    let last = &tree.images[image as usize];
    lines.push([last.point, to]);
    if is_obstructed(scene, from, to, &reflections, &lines) {
        return None;
    }
    let length_m = from.distance(target);
    // Depth over length is the cosine of the angle of incidence.
    let coefficient = depths
        .iter()
        .zip(reflections.iter().rev())
        .map(|(depth, r)| reflectors[r.id as usize].reflection(depth / length_m))
        .product();
    Some(Chain {
        reflections,
        length_m,
        coefficient,
        far_image: target,
    })
}

fn is_obstructed(
    scene: &Scene,
    from: DVec2,
    to: DVec2,
    reflections: &[Interaction],
    lines: &[[DVec2; 2]],
) -> bool {
    let mut start = (from, None);
    let ends = reflections.iter().map(|r| (r.point, Some(r.id)));
    ends.chain([(to, None)]).zip(lines).any(|(end, &line)| {
        let leg = LegSegment {
            ends: [start.0, end.0],
            line,
            skip: [start.1, end.1],
        };
        start = end;
        scene.is_obstructed(&leg)
    })
}
