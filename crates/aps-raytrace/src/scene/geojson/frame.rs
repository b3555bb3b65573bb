//! Conversion of a file's numbers to metres.

use glam::DVec2;

use super::GeoJsonError;
use super::geometry::Polygon;
use crate::scene::plane::{LocalPlane, without_turns};
use crate::scene::ring;

/// Parts of a metre that coordinates are rounded to.
const PARTS_PER_METRE: f64 = 1024.0;

/// Largest coordinate in metres: beyond any plane of the Earth.
const MAX_METRES: f64 = 1e8;

/// Nearest that a building comes to a pole \[deg\].
const FROM_POLE_DEG: f64 = 1.0;

/// Conversion of a file's numbers to metres.
pub(super) enum Frame {
    /// Degrees: by a projection about their middle.
    Plane(LocalPlane),
    /// Metres: counted from a whole one near their middle, so that they keep their fractions.
    Shift(DVec2),
}

impl Frame {
    /// Creates the frame for longitudes and latitudes, about an origin or their middle.
    pub(super) fn of_degrees(
        polygons: &[Polygon],
        origin: Option<[f64; 2]>,
    ) -> Result<Self, GeoJsonError> {
        for polygon in polygons {
            for &[x, y] in polygon.rings.iter().flatten() {
                check_degrees(polygon.feature, x, y)?;
            }
        }
        if let Some([longitude, latitude]) = origin {
            let is_place = longitude.abs() <= 360.0 && latitude.abs() <= 90.0 - FROM_POLE_DEG;
            return match is_place {
                true => Ok(Self::Plane(LocalPlane::at(wrap(longitude), latitude))),
                false => Err(GeoJsonError::Origin([longitude, latitude])),
            };
        }
        let longitudes = |f: fn(f64) -> f64| bounds(polygons, move |[x, y]| DVec2::new(f(x), y));
        let (mut min, mut max) = longitudes(wrap);
        // Half a turn apart or more: nearer each other over the date line.
        if max.x - min.x > 180.0 {
            (min, max) = longitudes(eastward);
        }
        let middle = (min + max) / 2.0;
        Ok(Self::Plane(LocalPlane::at(wrap(middle.x), middle.y)))
    }

    /// Creates the frame for eastings and northings, from an origin or their middle.
    pub(super) fn of_metres(
        polygons: &[Polygon],
        origin: Option<[f64; 2]>,
    ) -> Result<Self, GeoJsonError> {
        match origin {
            None => {
                let (min, max) = bounds(polygons, DVec2::from);
                Ok(Self::Shift(((min + max) / 2.0).floor()))
            }
            Some(origin) if origin.iter().all(|x| x.abs() <= MAX_METRES) => {
                Ok(Self::Shift(origin.into()))
            }
            Some(origin) => Err(GeoJsonError::Origin(origin)),
        }
    }

    /// Position of (0, 0), in the unit of the file's numbers.
    pub(super) fn origin(&self) -> [f64; 2] {
        match self {
            Self::Plane(plane) => plane.origin_deg(),
            Self::Shift(origin) => origin.to_array(),
        }
    }

    /// A position in metres, rounded.
    pub(super) fn metres(&self, feature: usize, [x, y]: [f64; 2]) -> Result<DVec2, GeoJsonError> {
        let p = match self {
            Self::Plane(plane) => {
                let [longitude, latitude] = plane.origin_deg();
                let distance_deg = wrap(x - longitude).abs().max((y - latitude).abs());
                if distance_deg > LocalPlane::REACH_DEG {
                    return Err(GeoJsonError::TooLarge {
                        feature,
                        x,
                        y,
                        distance_deg,
                        limit_deg: LocalPlane::REACH_DEG,
                    });
                }
                if y.abs() > 90.0 - FROM_POLE_DEG {
                    return Err(GeoJsonError::Pole {
                        feature,
                        limit_deg: FROM_POLE_DEG,
                    });
                }
                plane.project(x, y)
            }
            Self::Shift(origin) => {
                if !(x.abs() <= MAX_METRES && y.abs() <= MAX_METRES) {
                    return Err(coordinate(feature, x, y, "position in metres"));
                }
                DVec2::new(x, y) - *origin
            }
        };
        Ok((p * PARTS_PER_METRE).round() / PARTS_PER_METRE)
    }
}

/// Makes the error of a coordinate that is not the `expected` kind of position.
pub(super) fn coordinate(
    feature: usize,
    x: f64,
    y: f64,
    expected: impl Into<String>,
) -> GeoJsonError {
    GeoJsonError::Coordinate {
        feature,
        x,
        y,
        expected: expected.into(),
    }
}

/// Longitudes may run on beyond 180 degrees, as some programs write them over the date line, or go from 0 to 360.
fn check_degrees(feature: usize, x: f64, y: f64) -> Result<(), GeoJsonError> {
    match (x.abs(), y.abs()) {
        (0.0..=360.0, 0.0..=90.0) => Ok(()),
        (0.0..=90.0, 90.0..=360.0) => Err(GeoJsonError::Latitude { feature, x, y }),
        _ => Err(coordinate(feature, x, y, "longitude and latitude")),
    }
}

fn bounds(polygons: &[Polygon], point: impl Fn([f64; 2]) -> DVec2) -> (DVec2, DVec2) {
    let positions = polygons.iter().flat_map(|p| p.rings.iter().flatten());
    ring::bounds(positions.map(|&p| point(p)))
}

/// Brings a longitude between -180 and 180 degrees; unchanged to the bit if it is there.
fn wrap(longitude_deg: f64) -> f64 {
    match longitude_deg {
        -180.0..=180.0 => longitude_deg,
        _ => without_turns(longitude_deg),
    }
}

/// Brings a longitude between 0 and 360 degrees.
fn eastward(longitude_deg: f64) -> f64 {
    longitude_deg.rem_euclid(360.0)
}
