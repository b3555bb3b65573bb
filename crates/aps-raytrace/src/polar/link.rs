//! A link as its receiver sees it: for each ray, the geometry of ways that arrive along it.

use glam::Vec2;

use super::error::PolarError;
use super::fan::KINDS;
use super::map::PolarMap;
use super::rays::{Passed, ReceiverRays, Segment};
use super::ways::{TransmitterWays, Way};

/// Features of a way: see [`PolarLink`].
pub const FEATURES: usize = 14;

/// Numbers that [`PolarLink::ways`] writes of a way: its features, the number of its ray, and that of its kind and bounces.
pub const PER_WAY: usize = FEATURES + 2;

/// Summand of a chord in the rank of a way: without it a way that goes straight on would come first, however long.
const LEAST_TURN: f32 = 0.05;

/// Least length in a logarithm \[m\].
const NEAREST_M: f32 = 0.1;

/// A link as its receiver sees it.
///
/// # Features
/// L is the way's length, s1 its part from the receiver to the corner and s2 the rest, d the distance of transmitter and receiver, at
/// least 1 m. A way is along a ray where the tangent of the angle between them is below the angle between neighbouring rays.
///
/// | feature | value |
/// |---|---|
/// | 0 | 1 less the tangent of the angle between the ray and the way, over the angle between neighbouring rays |
/// | 1 | 1 |
/// | 2 | half of that tangent, over the angle between neighbouring rays; positive counter-clockwise |
/// | 3 | ln(L / d), between -0.1 and 3 |
/// | 4 | sum of the angles by which the way turns at corners, over pi |
/// | 5 | 0.3 ln(angle \[rad\] by which it turns at the last corner + 0.03) |
/// | 6 | 0.3 ln(s1 s2 / (s1 + s2) \[m\]) |
/// | 7 | number of corners, at most 4, over 4 |
/// | 8, 9 | sum of the cosines of incidence at the walls between the receiver and the corner, and that of the wall next to the corner |
/// | 10 | sum of the cosines of incidence at the walls between the corner and the transmitter |
/// | 11 | 0.3 ln(L \[m\]) - 1 |
/// | 12, 13 | cosines of the angles between the corner's bisector, pointing into the building, and the ways to and from the corner |
///
/// A straight way has 0 for 4 to 7, 10, 12 and 13. Of several ways along a ray of one kind and number of bounces, the one that is
/// kept has the least (c + 0.05)^2 s1 s2 (s1 + s2) e^(2 t + i), c the chord of the last turn, t the sum of the turns before, i
/// feature 10: ways that turn little are kept rather than short ones.
#[derive(Debug, Clone, Copy)]
pub struct PolarLink<'a> {
    /// The map that made both.
    pub map: &'a PolarMap<'a>,
    /// Ways of the transmitter.
    pub transmitter: &'a TransmitterWays,
    /// Rays of the receiver.
    pub receiver: &'a ReceiverRays,
}

impl PolarLink<'_> {
    /// Length of the shortest way from transmitter to receiver around the buildings \[m\], exact; infinite if there is none. Costs a
    /// visibility test of each corner.
    ///
    /// # Errors
    /// [`PolarError::Foreign`].
    pub fn geodesic_m(&self) -> Result<f64, PolarError> {
        self.check()?;
        let (tx, rx, scene) = (self.transmitter, self.receiver, self.map.scene.local());
        if tx.place == rx.place || !scene.is_blocked(tx.place, rx.place) {
            return Ok(tx.place.distance(rx.place));
        }
        let in_sight = self.map.corners.in_sight(scene, rx.place);
        let last = self.map.corners.bending(&in_sight, rx.place);
        let over = |(corner, distance_m): (u32, f64)| tx.shortest_m[corner as usize] + distance_m;
        Ok(last.map(over).fold(f64::INFINITY, f64::min))
    }

    fn check(&self) -> Result<(), PolarError> {
        let id = self.map.scene.id;
        let terminals = [
            ("transmitter", self.transmitter.map),
            ("receiver", self.receiver.map),
        ];
        match terminals.into_iter().find(|&(_, map)| map != id) {
            Some((terminal, _)) => Err(PolarError::Foreign { terminal }),
            None => Ok(()),
        }
    }

    /// Appends the ways on this thread, [`PER_WAY`] numbers each: its features, the number of its ray, and kind times (most bounces + 1)
    /// plus bounces, which is below [`Fan::way_kinds`](super::Fan::way_kinds). They are ordered by these two numbers; no two ways have
    /// both in common. [`Mirror::turn_ways`](super::Mirror::turn_ways) makes those of a mirror image of them.
    ///
    /// # Errors
    /// [`PolarError::Foreign`].
    pub fn ways(&self, out: &mut Vec<f32>) -> Result<(), PolarError> {
        self.check()?;
        let seen = Seen::of(self);
        for ray in 0..self.map.fan().directions {
            seen.along_ray(ray, |kind, features| {
                out.extend(features);
                out.extend([ray as f32, kind as f32]);
            });
        }
        Ok(())
    }
}

/// A link, and lengths that its features are relative to.
struct Seen<'a> {
    link: &'a PolarLink<'a>,
    beam_rad: f32,
    distance_m: f32,
}

impl<'a> Seen<'a> {
    fn of(link: &'a PolarLink<'a>) -> Self {
        let length_m = link.transmitter.place.distance(link.receiver.place);
        Self {
            link,
            beam_rad: link.map.fan().step_rad() as f32,
            distance_m: length_m.max(1.0) as f32,
        }
    }

    /// Hands over the ways along a ray: number of kind and bounces, and features.
    #[inline]
    fn along_ray(&self, ray: usize, mut take: impl FnMut(usize, [f32; FEATURES])) {
        let fan = self.link.map.fan();
        let mut number = 0;
        for kind in 0..KINDS {
            for bounces in 0..=fan.max_bounces {
                let segment = bounces * fan.directions + ray;
                let found = match kind {
                    0 => self.straight(segment, bounces),
                    over => self.over_corner(segment, bounces, over - 1),
                };
                if let Some(features) = found {
                    take(number, features);
                }
                number += 1;
            }
        }
    }

    /// Features of the straight way along a segment; `None` if the segment does not pass the transmitter.
    fn straight(&self, segment: usize, bounces: usize) -> Option<[f32; FEATURES]> {
        let segment = &self.link.receiver.segments[segment];
        let (scene, place) = (self.link.map.scene.local(), self.link.transmitter.place);
        let passed = segment.passes(scene, place, self.link.map.fan().step_rad(), &[])?;
        let [range_m, tangent] = passed.map(|x| x as f32);
        let mut features = self.along(segment, bounces, tangent);
        features[3] = self.excess(range_m);
        features[11] = 0.3 * range_m.max(NEAREST_M).ln() - 1.0;
        Some(features)
    }

    /// Features of the way of a kind along a segment that ranks first.
    fn over_corner(&self, segment: usize, bounces: usize, kind: usize) -> Option<[f32; FEATURES]> {
        let (tx, rx) = (self.link.transmitter, self.link.receiver);
        let passed = rx.passed(segment);
        let segment = &rx.segments[segment];
        let mut best: Option<(f32, &Passed, &Way, f32)> = None;
        for corner in passed {
            for way in tx.to(corner.corner, kind) {
                // The chord of an angle: exact for small ones.
                let (x, y) = (corner.ahead.x + way.unit[0], corner.ahead.y + way.unit[1]);
                let chord = (x * x + y * y).sqrt();
                let (s1, s2) = (corner.range_m, way.length_m);
                let turn = chord + LEAST_TURN;
                let rank = turn * turn * s1 * s2 * (s1 + s2) * way.weight;
                if best.is_none_or(|best| rank < best.0) {
                    best = Some((rank, corner, way, chord));
                }
            }
        }
        let (_, corner, way, chord) = best?;
        let (s1, s2) = (corner.range_m, way.length_m);
        // Twice the cosine of half the turn, as the chord is twice its sine: together they are exact near half a turn too.
        let across = corner.ahead - Vec2::from(way.unit);
        let turn_rad = 2.0 * chord.atan2(across.length());
        let inward = self.link.map.corners.corners[corner.corner as usize].inward;
        let inward = inward.as_vec2();
        let mut features = self.along(segment, bounces, corner.tangent);
        features[3] = self.excess(s1 + s2);
        features[4] = (way.turned_rad + turn_rad) / std::f32::consts::PI;
        features[5] = 0.3 * (turn_rad + 0.03).ln();
        features[6] = 0.3 * (s1 * s2 / (s1 + s2).max(NEAREST_M)).max(NEAREST_M).ln();
        features[7] = 0.25 * way.corners.min(4.0);
        features[10] = way.cos_sum;
        features[11] = 0.3 * (s1 + s2).max(NEAREST_M).ln() - 1.0;
        features[12] = way.unit[0] * inward.x + way.unit[1] * inward.y;
        features[13] = -corner.ahead.dot(inward);
        Some(features)
    }

    /// Features that depend on the segment and the angle from the ray alone.
    fn along(&self, segment: &Segment, bounces: usize, tangent: f32) -> [f32; FEATURES] {
        // Each bounce changes left and right.
        let turn = if bounces.is_multiple_of(2) { 1.0 } else { -1.0 };
        let offset = tangent / self.beam_rad;
        let mut features = [0.0; FEATURES];
        features[0] = (1.0 - offset.abs()).max(0.0);
        features[1] = 1.0;
        features[2] = 0.5 * offset * turn;
        [features[8], features[9]] = segment.cosines;
        features
    }

    fn excess(&self, length_m: f32) -> f32 {
        (length_m / self.distance_m).max(1e-6).ln().clamp(-0.1, 3.0)
    }
}
