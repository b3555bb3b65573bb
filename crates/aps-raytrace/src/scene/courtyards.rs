//! Courtyards: parts of the street that walls close on all sides.
//!
//! Outlines alone do not tell. Where two buildings touch in a point the union may run through it
//! either way, along one building and then the other, or around the yard they close in. Here the
//! walls are walked with the street to the right: at a corner where several buildings meet, to the
//! wall on the other side of the same piece of street. Each piece has one outer boundary; where
//! that turns clockwise the piece is a courtyard.

use std::collections::HashMap;

use glam::DVec2;

use super::wall::Wall;
use crate::predicates::orient;

/// Walls of each courtyard, the smallest courtyard first.
pub(super) fn courtyards(walls: &[Wall]) -> Vec<Vec<u32>> {
    let mut starting: HashMap<[u64; 2], Vec<u32>> = HashMap::with_capacity(walls.len());
    for (wall, id) in walls.iter().zip(0..) {
        starting.entry(key(wall.a)).or_default().push(id);
    }
    let next = |wall: &Wall| match starting.get(&key(wall.b)).map(Vec::as_slice) {
        Some(&[_, _, ..]) => across_the_street(walls, wall, &starting[&key(wall.b)]),
        _ => wall.next,
    };
    let mut seen = vec![false; walls.len()];
    let mut found = Vec::new();
    for first in 0..walls.len() as u32 {
        let mut ring = Vec::new();
        let mut doubled_area = 0.0;
        let origin = walls[first as usize].a;
        let mut at = first;
        while !seen[at as usize] {
            seen[at as usize] = true;
            ring.push(at);
            let wall = &walls[at as usize];
            doubled_area += (wall.a - origin).perp_dot(wall.b - origin);
            at = next(wall);
        }
        if doubled_area < 0.0 {
            found.push((-doubled_area, ring));
        }
    }
    found.sort_by(|p, q| p.0.total_cmp(&q.0));
    found.into_iter().map(|c| c.1).collect()
}

/// A place as a key; -0 is 0.
fn key(p: DVec2) -> [u64; 2] {
    [(p.x + 0.0).to_bits(), (p.y + 0.0).to_bits()]
}

/// Finds the first wall met when turning from `wall` at its end through the street,
/// counter-clockwise, among the walls that start there (`starting`).
fn across_the_street(walls: &[Wall], wall: &Wall, starting: &[u32]) -> u32 {
    let (corner, back) = (wall.b, wall.a);
    let to = |id: u32| walls[id as usize].b;
    // Sorts by the turn from the way back: less than half a turn, half a turn, more.
    let half = |id: u32| {
        orient(corner, back, to(id))
            .partial_cmp(&0.0)
            .map(std::cmp::Ordering::reverse)
    };
    let is_before = |p: u32, q: u32| match half(p).cmp(&half(q)) {
        std::cmp::Ordering::Equal => orient(corner, to(p), to(q)) > 0.0,
        order => order.is_lt(),
    };
    let first = starting.iter().copied();
    let first = first.reduce(|best, id| if is_before(id, best) { id } else { best });
    first.unwrap_or(wall.next)
}
