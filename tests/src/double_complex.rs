//! Complex numbers of 32 digits, and the formulas of the tracer in them.

use std::ops::{Add, Div, Mul, Neg, Sub};

use aps_raytrace::{Complex64, SPEED_OF_LIGHT_M_PER_S};

use crate::double_double::{DoubleDouble, PI, dd};

/// re + j im.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleComplex {
    /// Real part.
    pub re: DoubleDouble,
    /// Imaginary part.
    pub im: DoubleDouble,
}

impl From<DoubleDouble> for DoubleComplex {
    fn from(re: DoubleDouble) -> Self {
        Self::new(re, DoubleDouble::ZERO)
    }
}

impl From<f64> for DoubleComplex {
    fn from(re: f64) -> Self {
        dd(re).into()
    }
}

impl From<Complex64> for DoubleComplex {
    fn from(z: Complex64) -> Self {
        Self::new(dd(z.re), dd(z.im))
    }
}

impl Add for DoubleComplex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.re + other.re, self.im + other.im)
    }
}

impl Neg for DoubleComplex {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.re, -self.im)
    }
}

impl Sub for DoubleComplex {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleComplex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let re = self.re * other.re - self.im * other.im;
        Self::new(re, self.re * other.im + self.im * other.re)
    }
}

impl Div for DoubleComplex {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let square = other.re * other.re + other.im * other.im;
        let product = self * Self::new(other.re, -other.im);
        Self::new(product.re / square, product.im / square)
    }
}

impl DoubleComplex {
    /// re + j im.
    #[must_use]
    pub const fn new(re: DoubleDouble, im: DoubleDouble) -> Self {
        Self { re, im }
    }

    /// r e^{j pi x}.
    #[must_use]
    pub fn from_half_turns(r: DoubleDouble, x: DoubleDouble) -> Self {
        let (sin, cos) = x.sin_cos_pi();
        Self::new(r * cos, r * sin)
    }

    /// Magnitude.
    #[must_use]
    pub fn norm(self) -> DoubleDouble {
        DoubleDouble::hypot(self.re, self.im)
    }

    /// Distance from `want` in parts of it.
    #[must_use]
    pub fn relative_error(self, want: Self) -> f64 {
        ((self - want).norm() / want.norm()).to_f64()
    }

    /// e to this power.
    #[must_use]
    pub fn exp(self) -> Self {
        Self::from_half_turns(self.re.exp(), self.im / PI)
    }

    /// The square root with a positive real part.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let half = dd(0.5);
        // The larger part first: the other one follows without cancellation.
        let large = ((self.norm() + self.re.abs()) * half).sqrt();
        let small = self.im * half / large;
        if self.re.high >= 0.0 {
            Self::new(large, small)
        } else {
            let sign = if self.im.high < 0.0 { -1.0 } else { 1.0 };
            Self::new(small.abs(), large * dd(sign))
        }
    }
}

/// lambda / (4 pi L) e^{-jkL}, the gain of free space over a length.
#[must_use]
pub fn spherical_wave(length_m: DoubleDouble, frequency_hz: f64) -> DoubleComplex {
    let wavelength_m = dd(SPEED_OF_LIGHT_M_PER_S) / dd(frequency_hz);
    let amplitude = wavelength_m / (dd(4.0) * PI * length_m);
    DoubleComplex::from_half_turns(amplitude, -(length_m / wavelength_m * dd(2.0)))
}

/// F(x) of [`crate::utd::transition`], by the same quadrature in 32 digits.
#[must_use]
pub fn transition(x: DoubleDouble) -> DoubleComplex {
    let w = x.sqrt();
    let direction = DoubleComplex::from_half_turns(DoubleDouble::ONE, 0.25.into());
    let scale = DoubleDouble::ONE / (DoubleDouble::ONE + w);
    let step = 1.0 / 32.0;
    let mut sum = DoubleComplex::from(0.0);
    for i in -144..=160 {
        let t = DoubleDouble::from(f64::from(i) * step);
        let falling = (-t).exp();
        let u = (t - falling).exp();
        let s = u * scale;
        let exponent =
            -(DoubleComplex::from(s * s) + DoubleComplex::from(w * s * 2.0.into()) * direction);
        if exponent.re.high > -80.0 {
            let weight = u * (DoubleDouble::ONE + falling);
            sum = sum + exponent.exp() * weight.into();
        }
    }
    let factor = w * scale * (2.0 * step).into();
    direction * sum * factor.into()
}

/// Fresnel's coefficient for the field parallel to a wall of this permittivity.
#[must_use]
pub fn reflection(permittivity: DoubleComplex, cos_incidence: DoubleDouble) -> DoubleComplex {
    let cos = DoubleComplex::from(cos_incidence);
    let root = (permittivity - DoubleComplex::from(1.0) + cos * cos).sqrt();
    (cos - root) / (cos + root)
}

/// D \[sqrt(m)\] as [`crate::utd::Radio::diffraction`], of a perfectly conducting wedge.
#[must_use]
pub fn diffraction(
    n: DoubleDouble,
    wavenumber_per_m: DoubleDouble,
    distance_m: DoubleDouble,
    phi: [DoubleDouble; 2],
) -> DoubleComplex {
    let two = DoubleDouble::from(2.0);
    let product = |beta: DoubleDouble, sign: f64| {
        let signed = PI * sign.into();
        let period = two * PI * n;
        let nearest = ((beta + signed) / period).to_f64().round();
        let half = (period * nearest.into() - beta) / two;
        let cos = half.sin_cos().1;
        let a = two * cos * cos;
        let (sin, cos) = ((PI + beta * sign.into()) / (two * n)).sin_cos();
        transition(wavenumber_per_m * distance_m * a) * (cos / sin).into()
    };
    let (difference, sum) = (phi[0] - phi[1], phi[0] + phi[1]);
    let bracket = product(difference, 1.0) + product(difference, -1.0)
        - product(sum, -1.0)
        - product(sum, 1.0);
    let root = (two * PI * wavenumber_per_m).sqrt();
    let factor = DoubleDouble::ONE / (two * n * root);
    -(DoubleComplex::from_half_turns(factor, (-0.25).into()) * bracket)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the table of 40 digits rounded to doubles: half an ulp is all that may differ.
    #[test]
    fn transition_is_that_of_the_table() {
        for (x, want) in crate::utd::transition_table().into_iter().step_by(9) {
            let error = transition(dd(x)).relative_error(want.into());
            assert!(error < 1.3e-16, "F({x}) is off by {error:e}");
        }
    }

    #[test]
    fn square_root_squares_back() {
        for (re, im) in [(3.0, -1.0), (-3.0, 1e-9), (-2.0, -5.0), (0.0, 7.0)] {
            let z = DoubleComplex::new(dd(re), dd(im));
            let root = z.sqrt();
            assert!((root * root).relative_error(z) < 1e-30 && root.re.high >= 0.0);
        }
    }
}
