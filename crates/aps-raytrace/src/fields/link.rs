//! A link as the model sees it: the fields of its transmitter at the positions of its receiver's rays.

use std::f64::consts::TAU;

use glam::DVec2;
use multiversion::multiversion;
use rayon::prelude::*;

use super::error::FieldError;
use super::exponential::exp_of_negative;
use super::map::FieldMap;
use super::mirror::Mirror;
use super::receiver::{NEAR_CORNER, ReceiverRays};
use super::transmitter::{STRAIGHT, TransmitterFields};

/// Planes of a link: see [`FieldLink`].
pub const PLANES: usize = 12;

/// Numbers of a link a direction: see [`FieldLink`].
pub const NUMBERS: usize = 4;

/// Lengths over which the planes of a detour fall to 1/e \[m\].
const DETOUR_M: [f32; 2] = [2.0, 20.0];

/// The same for what a reflected way is longer than the line \[m\].
const EXCESS_M: f32 = 100.0;

/// Farthest shortest way that is told apart \[m\].
const FARTHEST_M: f64 = 1200.0;

/// Positions that are computed together.
const LANES: usize = 64;

/// A link and the mirror image in which it is seen.
///
/// # Planes
/// Each has a number at every position of the receiver's rays; 3 to 10 are 0 outside of the grid and where the ray has ended.
/// r is the range of the position, g the length of the shortest way from the transmitter around the buildings, d the distance
/// of transmitter and receiver.
///
/// | plane | value |
/// |---|---|
/// | 0, 1, 2 | 1 before the first wall; after one reflection; after two |
/// | 3 | 1 where the transmitter is in sight |
/// | 4, 5 | e^(-detour / 2 m), e^(-detour / 20 m), detour = g(position) + r - g(receiver): 1 along a ray on which a wave arrives by corners first and reflections then |
/// | 6, 8 | 1 where the transmitter lights the position by one reflection; by two |
/// | 7, 9 | there e^(-(l + r - d) / 100 m), l the shortest such way's length |
/// | 10 | 1 near a corner |
/// | 11 | ln(r) / 3 - 1 |
///
/// # Numbers
/// For each direction: cosine and sine of the angle from the transmitter's bearing to it, ln(d) / 3 - 1, ln(g(receiver)) / 3 - 1,
/// d and g at least 1 m, g at most 1200 m, which stands for a receiver that no way leads to.
#[derive(Debug, Clone, Copy)]
pub struct FieldLink<'a> {
    /// The map that made both.
    pub map: &'a FieldMap<'a>,
    /// Fields of the transmitter.
    pub transmitter: &'a TransmitterFields,
    /// Rays of the receiver.
    pub receiver: &'a ReceiverRays,
    /// Image of the map in which the link is seen: its planes are these with directions in another order.
    pub mirror: Mirror,
}

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

    fn check(&self) -> Result<(), FieldError> {
        let (grid, fan) = (self.map.grid(), self.map.fan());
        let corners = self.map.corner_count();
        let (tx, rx) = (self.transmitter, self.receiver);
        let is_near = |&(corner, _): &(u32, f64)| (corner as usize) < corners;
        if tx.pixels.len() != grid.pixels() + 1 || tx.ways.lengths_m.len() != corners {
            Err(FieldError::Foreign {
                terminal: "transmitter",
            })
        } else if rx.pixels.len() != fan.positions() || !rx.corners.iter().all(is_near) {
            Err(FieldError::Foreign {
                terminal: "receiver",
            })
        } else {
            Ok(())
        }
    }

    /// Writes the planes (plane, range, direction) and the numbers (number, direction) on this thread.
    ///
    /// # Errors
    /// [`FieldError::Length`] unless the slices are as long as the results, [`FieldError::Foreign`].
    pub fn write(&self, planes: &mut [f32], numbers: &mut [f32]) -> Result<(), FieldError> {
        let fan = self.map.fan();
        check_length("planes", 1, PLANES * fan.positions(), planes.len())?;
        check_length("numbers", 1, NUMBERS * fan.directions, numbers.len())?;
        self.check()?;
        self.fill(planes, numbers);
        Ok(())
    }

    /// Does it, in slices of the right length. No memory is taken.
    fn fill(&self, planes: &mut [f32], numbers: &mut [f32]) {
        let fan = self.map.fan();
        let (tx, rx) = (self.transmitter, self.receiver);
        let geodesic_m = self.geodesic_m();
        let ahead = tx.place - rx.place;
        let distance_m = ahead.length();
        self.write_numbers(ahead, geodesic_m, numbers);
        let gather = Gather {
            tx,
            rx,
            directions: fan.directions,
            mirror: self.mirror,
            distance_m: distance_m as f32,
            // Nowhere is a detour on the way to a receiver that none leads to.
            geodesic_m: match geodesic_m.is_finite() {
                true => geodesic_m as f32,
                false => f32::NEG_INFINITY,
            },
        };
        let plane = fan.positions();
        let mut gathered = Gathered::default();
        let mut out = [[0.0; LANES]; PLANES];
        for (row, &range_m) in fan.ranges_m.iter().enumerate() {
            for from in (0..fan.directions).step_by(LANES) {
                let lanes = LANES.min(fan.directions - from);
                gather.collect(row, from, lanes, &mut gathered);
                compute(
                    &gathered,
                    gather.geodesic_m,
                    gather.distance_m,
                    range_m as f32,
                    &mut out,
                );
                let at = row * fan.directions + from;
                for (p, values) in out.iter().enumerate() {
                    planes[p * plane + at..][..lanes].copy_from_slice(&values[..lanes]);
                }
            }
        }
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

/// Writes the planes (link, plane, range, direction) and the numbers (link, number, direction) of many links, spread over the
/// threads; links may be of different maps with fans of one size.
///
/// # Errors
/// [`FieldError::Length`] unless the slices are as long as the results, [`FieldError::MixedFans`], [`FieldError::Foreign`].
pub fn gather(
    links: &[FieldLink<'_>],
    planes: &mut [f32],
    numbers: &mut [f32],
) -> Result<(), FieldError> {
    let Some(first) = links.first() else {
        return check_length("planes", 0, 0, planes.len()).and(check_length(
            "numbers",
            0,
            0,
            numbers.len(),
        ));
    };
    let size = |link: &FieldLink<'_>| (link.map.fan().directions, link.map.fan().ranges_m.len());
    if let Some(link) = links.iter().position(|link| size(link) != size(first)) {
        return Err(FieldError::MixedFans { link });
    }
    let (directions, ranges) = size(first);
    let (of_planes, of_numbers) = (PLANES * ranges * directions, NUMBERS * directions);
    check_length("planes", links.len(), of_planes, planes.len())?;
    check_length("numbers", links.len(), of_numbers, numbers.len())?;
    links.iter().try_for_each(FieldLink::check)?;
    let slices = planes
        .par_chunks_exact_mut(of_planes)
        .zip(numbers.par_chunks_exact_mut(of_numbers));
    let all = links.par_iter().zip(slices);
    all.for_each(|(link, (planes, numbers))| link.fill(planes, numbers));
    Ok(())
}

fn check_length(
    what: &'static str,
    links: usize,
    one: usize,
    found: usize,
) -> Result<(), FieldError> {
    let expected = links.saturating_mul(one);
    match found == expected {
        true => Ok(()),
        false => Err(FieldError::Length {
            what,
            links,
            expected,
            found,
        }),
    }
}

/// One link's sources of numbers.
struct Gather<'a> {
    tx: &'a TransmitterFields,
    rx: &'a ReceiverRays,
    directions: usize,
    mirror: Mirror,
    distance_m: f32,
    geodesic_m: f32,
}

/// Sources and positions looked up for neighbouring directions.
struct Gathered {
    x_m: [f32; LANES],
    y_m: [f32; LANES],
    /// For each field: the source's place and offset \[m\], and 1 if there is one.
    sources: [[[f32; LANES]; 4]; 3],
    in_sight: [f32; LANES],
    marks: [u8; LANES],
}

impl Default for Gathered {
    fn default() -> Self {
        Self {
            x_m: [0.0; LANES],
            y_m: [0.0; LANES],
            sources: [[[0.0; LANES]; 4]; 3],
            in_sight: [0.0; LANES],
            marks: [0; LANES],
        }
    }
}

impl Gather<'_> {
    fn collect(&self, row: usize, from: usize, lanes: usize, out: &mut Gathered) {
        for lane in 0..lanes {
            let direction = self.mirror.direction(from + lane, self.directions);
            let at = row * self.directions + direction;
            let pixel = self.tx.pixels[self.rx.pixels[at] as usize];
            out.x_m[lane] = self.rx.x_m[at];
            out.y_m[lane] = self.rx.y_m[at];
            out.marks[lane] = self.rx.marks[at];
            out.in_sight[lane] = f32::from(u8::from(pixel[0] == STRAIGHT));
            for (columns, source) in out.sources.iter_mut().zip(pixel) {
                let source = self.tx.sources[source as usize];
                for (column, value) in columns.iter_mut().zip(source) {
                    column[lane] = value;
                }
            }
        }
    }
}

/// Computes the planes of neighbouring directions.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn compute(
    of: &Gathered,
    geodesic_m: f32,
    distance_m: f32,
    range_m: f32,
    out: &mut [[f32; LANES]; PLANES],
) {
    for (bounces, plane) in (0..3).zip(&mut *out) {
        for (value, marks) in plane.iter_mut().zip(of.marks) {
            *value = f32::from(u8::from(marks & !NEAR_CORNER == bounces));
        }
    }
    out[3] = of.in_sight;
    for (value, marks) in out[10].iter_mut().zip(of.marks) {
        *value = f32::from(u8::from(marks & NEAR_CORNER != 0));
    }
    out[11] = [range_m.ln() / 3.0 - 1.0; LANES];
    let [geodesic, reflected @ ..] = &of.sources;
    for lane in 0..LANES {
        let length_m = length_m(of, geodesic, lane);
        let detour_m = (length_m + range_m - geodesic_m).max(0.0);
        let is_reached = geodesic[3][lane];
        out[4][lane] = is_reached * exp_of_negative(detour_m * (-1.0 / DETOUR_M[0]));
        out[5][lane] = is_reached * exp_of_negative(detour_m * (-1.0 / DETOUR_M[1]));
    }
    for (field, plane) in reflected.iter().zip([6, 8]) {
        for lane in 0..LANES {
            let excess_m = (length_m(of, field, lane) + range_m - distance_m).max(0.0);
            out[plane][lane] = field[3][lane];
            out[plane + 1][lane] = field[3][lane] * exp_of_negative(excess_m * (-1.0 / EXCESS_M));
        }
    }
}

#[inline(always)]
fn length_m(of: &Gathered, [x, y, offset_m, _]: &[[f32; LANES]; 4], lane: usize) -> f32 {
    let (dx, dy) = (of.x_m[lane] - x[lane], of.y_m[lane] - y[lane]);
    offset_m[lane] + (dx * dx + dy * dy).sqrt()
}
