//! Diffraction and reflection by the textbook: each formula as it is printed, each quantity by
//! another way than the tracer's.
//!
//! The transition function comes from quadrature, the cotangents and the transition functions
//! are multiplied as they stand (so that nothing is defined on a boundary itself), and the
//! reflection coefficient is written in the angles of incidence and refraction.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use aps_raytrace::{Complex64, Material};

/// Speed of light \[m/s\].
const C: f64 = 299_792_458.0;
/// Vacuum permittivity \[F/m\].
const EPS_0: f64 = 8.854_187_812_8e-12;

/// Material of the walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wall {
    /// ITU-R P.2040 concrete.
    Concrete,
    /// A perfect conductor.
    Perfect,
}

/// The tracer's names of them.
pub const MATERIALS: [(Material, Wall); 2] = [
    (Material::Concrete, Wall::Concrete),
    (Material::PerfectConductor, Wall::Perfect),
];

/// Carrier and wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radio {
    /// Carrier \[Hz\].
    pub frequency_hz: f64,
    /// Material of every wall.
    pub wall: Wall,
}

impl Radio {
    /// At the tracer's default carrier.
    #[must_use]
    pub const fn of(wall: Wall) -> Self {
        Self {
            frequency_hz: 3.5e9,
            wall,
        }
    }

    /// 2 pi f / c \[1/m\].
    #[must_use]
    pub fn wavenumber_per_m(&self) -> f64 {
        TAU * self.frequency_hz / C
    }

    /// lambda / (4 pi) e^{-j k L} \[m\]; over L it is the gain of free space.
    #[must_use]
    pub fn spherical_wave(&self, length_m: f64) -> Complex64 {
        Complex64::cis(-self.wavenumber_per_m() * length_m) * (C / self.frequency_hz / (4.0 * PI))
    }

    /// Fresnel's formula for the electric field parallel to the wall, with Snell's angle of
    /// refraction: (cos i - m cos t) / (cos i + m cos t), sin i = m sin t.
    #[must_use]
    pub fn reflection(&self, incidence_rad: f64) -> Complex64 {
        if self.wall == Wall::Perfect {
            return Complex64::new(-1.0, 0.0);
        }
        let sigma = 0.0462 * (self.frequency_hz / 1e9).powf(0.7822);
        let loss = sigma / (TAU * self.frequency_hz * EPS_0);
        let m = Complex64::new(5.24, -loss).sqrt();
        let sin_t = Complex64::from(incidence_rad.sin()) / m;
        let cos_t = (1.0 - sin_t * sin_t).sqrt();
        let cos_i = incidence_rad.cos();
        (cos_i - m * cos_t) / (cos_i + m * cos_t)
    }

    /// D \[sqrt(m)\]: Kouyoumjian and Pathak 1974, eq. 25, with a reflection coefficient for each
    /// face, `phi` in 0..=`n` pi.
    #[must_use]
    pub fn diffraction(&self, n: f64, distance_m: f64, phi: [f64; 2]) -> Complex64 {
        let k = self.wavenumber_per_m();
        let (difference, sum) = (phi[0] - phi[1], phi[0] + phi[1]);
        let product = |beta: f64, sign: f64| {
            // The integer N that most nearly satisfies 2 pi n N - beta = +-pi.
            let nearest = ((beta + sign * PI) / (TAU * n)).round();
            let a = 2.0 * ((TAU * n * nearest - beta) / 2.0).cos().powi(2);
            let cot = 1.0 / ((PI + sign * beta) / (2.0 * n)).tan();
            transition(k * distance_m * a) * cot
        };
        // Each face reflects by the angle of the ray that is nearer to it.
        let near_0 = phi[0].min(phi[1]);
        let near_n = n * PI - phi[0].max(phi[1]);
        let gamma = |from_face: f64| self.reflection(from_face.sin().abs().acos());
        let bracket = product(difference, 1.0)
            + product(difference, -1.0)
            + gamma(near_0) * product(sum, -1.0)
            + gamma(near_n) * product(sum, 1.0);
        -Complex64::cis(-FRAC_PI_4) / (2.0 * n * (TAU * k).sqrt()) * bracket
    }
}

/// F(x) = 2 j w e^{jx} int_w^inf e^{-j t^2} dt with w = sqrt(x), along the ray
/// t = w + s e^{-j pi/4}, where the integrand falls off without oscillation:
/// F = 2 w e^{j pi/4} int_0^inf e^{-s^2 - 2 w s e^{j pi/4}} ds, by the double exponential rule.
#[must_use]
pub fn transition(x: f64) -> Complex64 {
    let w = x.sqrt();
    let direction = Complex64::cis(FRAC_PI_4);
    let scale = 1.0 / (1.0 + w);
    let step = 0.05;
    let sum: Complex64 = (-120..=100)
        .map(|i| {
            let t = f64::from(i) * step;
            let u = (t - (-t).exp()).exp();
            let weight = u * (1.0 + (-t).exp());
            let s = u * scale;
            (-s * s - 2.0 * w * s * direction).exp() * weight
        })
        .sum();
    2.0 * w * direction * sum * (step * scale)
}

/// x and F(x) for x from 1e-9 to 1e9, correct to the last digit of a double: `tests/golden/transition.py`.
///
/// # Panics
/// Never: the table is part of the program.
#[must_use]
pub fn transition_table() -> Vec<(f64, Complex64)> {
    let table = include_str!("../golden/transition.csv");
    let row = |line: &str| {
        let x: Vec<f64> = line.split(',').map(|s| s.parse().unwrap()).collect();
        (x[0], Complex64::new(x[1], x[2]))
    };
    table.lines().skip(1).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_agrees_with_the_high_precision_table() {
        for (x, exact) in transition_table() {
            let error = (transition(x) - exact).norm() / exact.norm();
            assert!(error < 1e-12, "F({x}) is off by {error:e}");
        }
    }
}
