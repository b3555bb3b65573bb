//! Spreading in free space between isotropic antennas (Friis).

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

/// Free space at one carrier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Friis {
    pub wavelength_m: f64,
}

impl Friis {
    /// Amplitude lambda / (4 pi L).
    pub fn amplitude(self, length_m: f64) -> f64 {
        self.wavelength_m / (4.0 * PI * length_m)
    }

    /// Amplitude with the phase e^{-j k L}.
    pub fn gain(self, length_m: f64) -> Complex64 {
        let cycles = length_m / self.wavelength_m;
        let phase = -TAU * cycles.fract();
        Complex64::from_polar(self.amplitude(length_m), phase)
    }
}
