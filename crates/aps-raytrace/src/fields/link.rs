//! A link as the model sees it: the fields of its transmitter at the positions of its receiver's rays.

use std::f64::consts::TAU;

use glam::DVec2;
use rayon::prelude::*;

use super::map::FieldMap;
use super::mirror::Mirror;
use super::receiver::ReceiverRays;
use super::transmitter::TransmitterFields;

/// Features of a candidate.
pub const FEATURES: usize = 12;
/// Kinds of candidates.
pub const KINDS: usize = 4;
/// Numbers a direction.
pub const NUMBERS: usize = 4;
const FARTHEST_M: f64 = 1200.0;

/// A link and the mirror image in which it is seen.
#[derive(Debug, Clone, Copy)]
pub struct FieldLink<'a> {
    pub map: &'a FieldMap<'a>,
    pub transmitter: &'a TransmitterFields,
    pub receiver: &'a ReceiverRays,
    pub mirror: Mirror,
}

/// Rows of a link: candidates times features, and numbers.
pub fn rows(bounces: usize) -> usize { KINDS * (bounces + 1) * FEATURES + NUMBERS }

impl FieldLink<'_> {
    /// Length of the shortest way from transmitter to receiver around the buildings \[m\], exact; infinite if there is none.
    #[must_use]
    pub fn geodesic_m(&self) -> f64 {
        let (tx, rx) = (self.transmitter, self.receiver);
        if tx.place == rx.place || !self.map.scene().is_blocked(tx.place, rx.place, [None; 2]) {
            return tx.place.distance(rx.place);
        }
        let over =
            |&(corner, distance_m): &(u32, f64)| tx.ways.lengths_m[corner as usize] + distance_m;
        rx.corners.iter().map(over).fold(f64::INFINITY, f64::min)
    }

    fn write(&self, out: &mut [f32]) {
        let fan = self.map.fan();
        let (tx, rx) = (self.transmitter, self.receiver);
        let geodesic_m = self.geodesic_m();
        let ahead = tx.place - rx.place;
        let d = fan.directions;
        let beam = (TAU / d as f64) as f32;
        let turn = self.mirror.turn() as f32;
        let direct = (ahead.length() as f32).max(1.0);
        for kind in 0..KINDS {
            let field = kind.saturating_sub(1);
            for bounces in 0..=fan.max_bounces {
                let candidate = kind * (fan.max_bounces + 1) + bounces;
                let out = &mut out[candidate * FEATURES * d..][..FEATURES * d];
                let parity = if bounces % 2 == 0 { turn } else { -turn };
                for i in 0..d {
                    let dir = self.mirror.direction(i, d);
                    let segment = bounces * d + dir;
                    let [ux, uy, sum, last] = rx.units[segment];
                    let mut best = f32::INFINITY;
                    let mut kept = None;
                    for k in 0..fan.samples {
                        let at = (bounces * fan.samples + k) * d + dir;
                        let source = tx.pixels[rx.pixels[at] as usize][field];
                        if source == 0 || (kind == 0) != (source == 1) { continue }
                        let s = &tx.sources[source as usize];
                        let (vx, vy) = (s[0] - rx.x_m[at], s[1] - rx.y_m[at]);
                        let along = vx * ux + vy * uy;
                        let across = ux * vy - uy * vx;
                        if along <= 0.0 { continue }
                        let length = (vx * vx + vy * vy).sqrt();
                        let angle = across.atan2(along);
                        let total = rx.range_m[at] + length;
                        let delta = angle * length / total;
                        // The way goes on from the corner against the ray.
                        let last_turn = if kind > 0 {
                            let sense = (s[5] * vx - s[4] * vy).signum();
                            sense * (s[5] * ux - s[4] * uy).atan2(-(s[4] * ux + s[5] * uy))
                        } else { 0.0 };
                        let cost = (delta.abs() / beam).max(0.7) + last_turn.abs() + s[6] + 0.5 * s[7];
                        if cost < best {
                            best = cost;
                            kept = Some((s, total, delta, last_turn));
                        }
                    }
                    let mut f = [0.0_f32; FEATURES];
                    if let Some((s, total, delta, last_turn)) = kept {
                        let near = (-(delta.abs()) / (4.0 * beam)).exp();
                        let spread = if kind > 0 { total * s[2] / (total + s[2]) } else { 1.0 };
                        f = [
                            (1.0 - delta.abs() / beam).max(0.0),
                            near,
                            (delta * parity / beam).clamp(-2.0, 2.0) * 0.5,
                            ((total + s[2]) / direct).ln().clamp(-0.1, 3.0),
                            (s[6] + last_turn) / std::f32::consts::PI,
                            if kind > 0 { (last_turn.abs() + 0.03).ln() * 0.3 } else { 0.0 },
                            spread.max(0.1).ln() * 0.3,
                            s[7].min(4.0) * 0.25,
                            sum,
                            last,
                            s[8],
                            (total + s[2]).ln() * 0.3 - 1.0,
                        ];
                        for v in &mut f[2..] { *v *= near }
                    }
                    for (j, v) in f.into_iter().enumerate() { out[j * d + i] = v; }
                }
            }
        }
        let from = KINDS * (fan.max_bounces + 1) * FEATURES * d;
        self.write_numbers(ahead, geodesic_m, &mut out[from..]);
    }

    fn write_numbers(&self, ahead: DVec2, geodesic_m: f64, numbers: &mut [f32]) {
        let directions = self.map.fan().directions;
        let bearing_rad = ahead.y.atan2(ahead.x);
        let log = |length_m: f64| (length_m.clamp(1.0, FARTHEST_M).ln() / 3.0 - 1.0) as f32;
        let (distance, geodesic) = (log(ahead.length()), log(geodesic_m));
        for i in 0..directions {
            let of_map = self.mirror.direction(i, directions);
            let angle_rad = self.map.fan().angle_rad(of_map) - bearing_rad;
            let (sin, cos) = (angle_rad % TAU).sin_cos();
            numbers[i] = cos as f32;
            numbers[directions + i] = (sin * self.mirror.turn()) as f32;
            numbers[2 * directions + i] = distance;
            numbers[3 * directions + i] = geodesic;
        }
    }
}

/// Writes rows (link, row, direction).
pub fn gather(links: &[FieldLink<'_>], out: &mut [f32]) {
    let Some(first) = links.first() else { return };
    let fan = first.map.fan();
    let size = rows(fan.max_bounces) * fan.directions;
    links.par_iter().zip(out.par_chunks_exact_mut(size)).for_each(|(link, out)| link.write(out));
}
