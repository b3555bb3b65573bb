//! From longitude and latitude to metres: transverse Mercator about a point of one's own.
//!
//! Source: J. P. Snyder, Map Projections: A Working Manual, USGS Professional Paper 1395, 1987, equations 3-21, 8-9 and
//! 8-10 with k0 = 1, on the ellipsoid of WGS84. The projection keeps angles, and lengths up to a factor
//! 1 + (x / 6.4e6 m)^2 / 2: over a city of 40 km that is 5e-6, or 1 mm over a map of 256 m. (An equirectangular plane
//! would shear a map at the edge of that city by 1e-2.) The series is off by less than 1 mm up to
//! [`LocalPlane::REACH_DEG`] from the centre.

use glam::DVec2;

use super::wgs84::{EQUATOR_M, INVERSE_FLATTENING};

/// Flattening.
const FLATTENING: f64 = 1.0 / INVERSE_FLATTENING;
/// Squared eccentricity.
const E2: f64 = FLATTENING * (2.0 - FLATTENING);

/// A plane that touches the Earth along the meridian of its origin: x to the east, y to the north \[m\].
///
/// ```
/// use aps_raytrace::scene::LocalPlane;
/// let plane = LocalPlane::at(24.945, 60.168);
/// let p = plane.project(24.946, 60.169);
/// assert!((p.x - 55.5).abs() < 0.1 && (p.y - 111.4).abs() < 0.1);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalPlane {
    longitude_deg: f64,
    latitude_deg: f64,
    /// Meridian arc from the equator to the origin \[m\].
    meridian_m: f64,
}

impl LocalPlane {
    /// Farthest longitude and latitude from the origin for which [`LocalPlane::project`] is meant \[deg\].
    pub const REACH_DEG: f64 = 2.0;

    /// Creates the plane about a point \[deg\].
    #[must_use]
    pub fn at(longitude_deg: f64, latitude_deg: f64) -> Self {
        Self {
            longitude_deg,
            latitude_deg,
            meridian_m: meridian_arc_m(latitude_deg.to_radians()),
        }
    }

    /// Longitude and latitude of the origin \[deg\].
    #[must_use]
    pub fn origin_deg(&self) -> [f64; 2] {
        [self.longitude_deg, self.latitude_deg]
    }

    /// Projects a point of the Earth to the plane \[m\]; longitudes may be any number of turns away.
    #[must_use]
    pub fn project(&self, longitude_deg: f64, latitude_deg: f64) -> DVec2 {
        let phi = latitude_deg.to_radians();
        let turn = longitude_deg - self.longitude_deg;
        let lambda = without_turns(turn).to_radians();
        let (sin, cos) = phi.sin_cos();
        let second_e2 = E2 / (1.0 - E2);
        let n = EQUATOR_M / (1.0 - E2 * sin * sin).sqrt();
        let t = (sin / cos).powi(2);
        let c = second_e2 * cos * cos;
        let a = lambda * cos;
        let (a2, a3) = (a * a, a * a * a);
        let x = n
            * (a + (1.0 - t + c) * a3 / 6.0
                + (5.0 - 18.0 * t + t * t + 72.0 * c - 58.0 * second_e2) * a2 * a3 / 120.0);
        let y = meridian_arc_m(phi) - self.meridian_m
            + n * (sin / cos)
                * (a2 / 2.0
                    + (5.0 - t + 9.0 * c + 4.0 * c * c) * a2 * a2 / 24.0
                    + (61.0 - 58.0 * t + t * t + 600.0 * c - 330.0 * second_e2) * a3 * a3 / 720.0);
        DVec2::new(x, y)
    }
}

/// Takes whole turns from an angle \[deg\], to within half a turn of zero.
pub(super) fn without_turns(deg: f64) -> f64 {
    deg - 360.0 * (deg / 360.0).round()
}

/// Distance from the equator along a meridian \[m\], Snyder's equation 3-21; latitude in radians.
fn meridian_arc_m(phi: f64) -> f64 {
    let (e4, e6) = (E2 * E2, E2 * E2 * E2);
    EQUATOR_M
        * ((1.0 - E2 / 4.0 - 3.0 * e4 / 64.0 - 5.0 * e6 / 256.0) * phi
            - (3.0 * E2 / 8.0 + 3.0 * e4 / 32.0 + 45.0 * e6 / 1024.0) * (2.0 * phi).sin()
            + (15.0 * e4 / 256.0 + 45.0 * e6 / 1024.0) * (4.0 * phi).sin()
            - (35.0 * e6 / 3072.0) * (6.0 * phi).sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Origin, point \[deg\], and where PROJ puts it \[m\]; made by tests/golden/plane.py of the workspace.
    const GOLDEN: &str = include_str!("../../../../tests/golden/plane.csv");

    #[test]
    fn points_lie_where_proj_puts_them() {
        let mut worst = 0.0_f64;
        for line in GOLDEN.lines().skip(1) {
            let v: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
            let p = LocalPlane::at(v[0], v[1]).project(v[2], v[3]);
            worst = worst.max(p.distance(DVec2::new(v[4], v[5])));
        }
        assert!(worst < 1e-3, "{worst} m");
        assert!(GOLDEN.lines().count() > 100);
    }

    #[test]
    fn date_line_is_no_border() {
        let plane = LocalPlane::at(179.999, 10.0);
        assert!(plane.project(-179.999, 10.0).x < 250.0);
    }
}
