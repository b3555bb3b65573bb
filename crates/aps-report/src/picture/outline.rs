//! Buildings as rings to draw: from a scene, or traced around the pixels of a raster.

use std::collections::BTreeMap;

use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;

/// The buildings of a map and the area it covers.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlines {
    /// Rings \[m\]; what lies in an odd number of them is indoors.
    pub rings: Vec<Vec<DVec2>>,
    /// The part that a picture shows \[m\]; none for what the rings cover.
    pub area: Option<Area>,
}

impl Outlines {
    /// The walls of a scene.
    pub fn of_scene(scene: &Scene) -> Self {
        Self {
            rings: scene.outlines(),
            area: scene.area(),
        }
    }

    /// The borders of the set ones of `[columns, rows]` pixels, whose first has its centre at the origin: up to half a
    /// pixel outside of the walls.
    pub fn of_pixels(
        [width, height]: [usize; 2],
        metres: f64,
        is_set: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let is_set = |x: i32, y: i32| match (usize::try_from(x), usize::try_from(y)) {
            (Ok(x), Ok(y)) => x < width && y < height && is_set(x, y),
            _ => false,
        };
        // Borders between set and other pixels, from a vertex to the next, set ones to the left.
        // Vertex (x, y) is the lower left corner of pixel (x, y).
        let mut next: BTreeMap<(i32, i32), Vec<(i32, i32)>> = BTreeMap::new();
        for y in 0..height as i32 {
            for x in (0..width as i32).filter(|&x| is_set(x, y)) {
                let sides = [
                    ((x, y - 1), (x, y), (x + 1, y)),
                    ((x + 1, y), (x + 1, y), (x + 1, y + 1)),
                    ((x, y + 1), (x + 1, y + 1), (x, y + 1)),
                    ((x - 1, y), (x, y + 1), (x, y)),
                ];
                for (neighbour, from, to) in sides {
                    if !is_set(neighbour.0, neighbour.1) {
                        next.entry(from).or_default().push(to);
                    }
                }
            }
        }
        let mut rings = Vec::new();
        while let Some((&start, _)) = next.iter().next() {
            let mut ring = vec![start];
            loop {
                let at = ring[ring.len() - 1];
                let Some(ways) = next.get_mut(&at) else { break };
                // Two ways where pixels touch at a corner: either closes a ring.
                let to = ways.pop().expect("a vertex without ways is removed");
                if ways.is_empty() {
                    next.remove(&at);
                }
                if to == start {
                    break;
                }
                ring.push(to);
            }
            let place =
                |&(x, y): &(i32, i32)| DVec2::new(f64::from(x) - 0.5, f64::from(y) - 0.5) * metres;
            rings.push(corners(&ring).iter().map(place).collect());
        }
        let size = DVec2::new(width as f64, height as f64) * metres;
        Self {
            rings,
            area: Some(Area {
                min: DVec2::ZERO,
                max: size,
            }),
        }
    }
}

/// The vertices of a ring at which it turns.
fn corners(ring: &[(i32, i32)]) -> Vec<(i32, i32)> {
    let n = ring.len();
    let turns = |&i: &usize| {
        let (before, at, after) = (ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]);
        (at.0 - before.0, at.1 - before.1) != (after.0 - at.0, after.1 - at.1)
    };
    (0..n).filter(turns).map(|i| ring[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_rows(rows: &[&str]) -> Outlines {
        let size = [rows[0].len(), rows.len()];
        Outlines::of_pixels(size, 1.0, |x, y| rows[y].as_bytes()[x] == b'#')
    }

    /// Even-odd rule at a pixel's centre.
    fn is_inside(rings: &[Vec<DVec2>], p: DVec2) -> bool {
        let crosses = |(a, b): (DVec2, DVec2)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        let crossings = |ring: &Vec<DVec2>| {
            (0..ring.len())
                .filter(|&i| crosses((ring[i], ring[(i + 1) % ring.len()])))
                .count()
        };
        rings.iter().map(crossings).sum::<usize>() % 2 == 1
    }

    #[test]
    fn rings_hold_exactly_the_set_pixels() {
        let rows = [
            "##...#", "#.##..", "#####.", "#...##", "#.#.#.", "#...#.", "#####.", ".....#",
        ];
        let outlines = of_rows(&rows);
        for (y, row) in rows.iter().enumerate() {
            for (x, pixel) in row.bytes().enumerate() {
                let p = DVec2::new(x as f64, y as f64);
                assert_eq!(is_inside(&outlines.rings, p), pixel == b'#', "({x}, {y})");
            }
        }
    }

    #[test]
    fn a_rectangle_has_four_corners() {
        let outlines = of_rows(&["....", ".##.", "...."]);
        assert_eq!(outlines.rings.len(), 1);
        assert_eq!(outlines.rings[0].len(), 4);
    }

    #[test]
    fn no_building_no_ring() {
        assert!(of_rows(&["..", ".."]).rings.is_empty());
    }
}
