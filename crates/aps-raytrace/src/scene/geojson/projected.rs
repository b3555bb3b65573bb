//! Longitude and latitude of projected maps.

use crate::scene::wgs84::{EQUATOR_M, INVERSE_FLATTENING};

/// Third flattening f / (2 - f).
const N: f64 = 1.0 / (2.0 * INVERSE_FLATTENING - 1.0);

/// Converts a point in EPSG:3857 \[m\] to longitude and latitude \[deg\]; `None` far beyond the edges of the map. Its sphere
/// has the radius of the equator, and the sphere's formulas give latitudes of the ellipsoid, by definition.
pub(super) fn from_web_mercator(x: f64, y: f64) -> Option<[f64; 2]> {
    // Half around the equator, and a hundredth more for files that run on over the date line.
    const REACH_M: f64 = 1.01 * std::f64::consts::PI * EQUATOR_M;
    (x.abs() <= REACH_M && y.abs() <= 2.0 * REACH_M).then(|| {
        let latitude = (y / EQUATOR_M).sinh().atan();
        [(x / EQUATOR_M).to_degrees(), latitude.to_degrees()]
    })
}

/// Converts a point in UTM \[m\] to longitude and latitude \[deg\]; `None` more than 1000 km from the central meridian or
/// 10,000 km from the equator.
///
/// Kruger's series up to the fourth power of the third flattening: C. F. F. Karney, Transverse Mercator with an accuracy of a
/// few nanometers, J. Geodesy 85, 2011, equations 11, 15, 26 and 36 and its table of inverse series as given by K. Engsager
/// and K. Poder. The error is less than 10 um up to 1000 km from the central meridian. The ellipsoid is that of WGS 84; the
/// one of ETRS89 moves a point by 0.1 mm.
pub(super) fn from_utm(zone: u32, is_south: bool, easting: f64, northing: f64) -> Option<[f64; 2]> {
    const REACH_M: f64 = 1e6;
    let x = easting - 500_000.0;
    let y = northing - if is_south { 10_000_000.0 } else { 0.0 };
    if !(x.abs() <= REACH_M && y.abs() <= 1e7) {
        return None;
    }
    let (n2, n3, n4) = (N * N, N * N * N, N * N * N * N);
    let rectifying_m = EQUATOR_M / (1.0 + N) * (1.0 + n2 / 4.0 + n4 / 64.0);
    let beta = [
        N / 2.0 - 2.0 * n2 / 3.0 + 37.0 * n3 / 96.0 - n4 / 360.0,
        n2 / 48.0 + n3 / 15.0 - 437.0 * n4 / 1440.0,
        17.0 * n3 / 480.0 - 37.0 * n4 / 840.0,
        4397.0 * n4 / 161_280.0,
    ];
    let delta = [
        2.0 * N - 2.0 * n2 / 3.0 - 2.0 * n3 + 116.0 * n4 / 45.0,
        7.0 * n2 / 3.0 - 8.0 * n3 / 5.0 - 227.0 * n4 / 45.0,
        56.0 * n3 / 15.0 - 136.0 * n4 / 35.0,
        4279.0 * n4 / 630.0,
    ];
    let xi = y / (0.9996 * rectifying_m);
    let eta = x / (0.9996 * rectifying_m);
    let (mut xi1, mut eta1) = (xi, eta);
    for (beta, j) in beta.iter().zip([2.0, 4.0, 6.0, 8.0]) {
        xi1 -= beta * (j * xi).sin() * (j * eta).cosh();
        eta1 -= beta * (j * xi).cos() * (j * eta).sinh();
    }
    let chi = (xi1.sin() / eta1.cosh()).asin();
    let delta = delta.iter().zip([2.0, 4.0, 6.0, 8.0]);
    let latitude = chi + delta.map(|(delta, j)| delta * (j * chi).sin()).sum::<f64>();
    let longitude = eta1.sinh().atan2(xi1.cos());
    let central_deg = 6.0 * f64::from(zone) - 183.0;
    Some([central_deg + longitude.to_degrees(), latitude.to_degrees()])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// EPSG code, coordinates \[m\], and where PROJ puts them \[deg\]; made by tests/golden/projected.py of the workspace.
    const GOLDEN: &str = include_str!("../../../../../tests/golden/projected.csv");

    #[test]
    fn points_lie_where_proj_puts_them() {
        for line in GOLDEN.lines().skip(1) {
            let v: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
            let code = v[0] as u32;
            let [longitude, latitude] = match code {
                3857 => from_web_mercator(v[1], v[2]),
                _ => from_utm(code % 100, code / 100 == 327, v[1], v[2]),
            }
            .unwrap();
            let turn = (longitude - v[3] + 180.0).rem_euclid(360.0) - 180.0;
            let east = turn * latitude.to_radians().cos();
            let error_deg = east.abs().max((latitude - v[4]).abs());
            // 10 um, and the 0.1 mm between the ellipsoids.
            let allowed_deg = if code / 100 == 258 { 2e-9 } else { 9e-11 };
            assert!(error_deg < allowed_deg, "{line}: {error_deg} degrees");
        }
        assert!(GOLDEN.lines().count() > 200);
    }
}
