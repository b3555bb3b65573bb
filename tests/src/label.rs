//! A label's formulas in 32 digits, term by term.

use aps_label::{Array, LabelConfig, PathSample, Protocol};

use crate::double_double::{DoubleDouble, PI, dd};

/// A path of three numbers.
#[must_use]
pub fn path(delay_s: f64, arrival_azimuth_rad: f64, gain_db: f64) -> PathSample {
    PathSample {
        delay_s,
        arrival_azimuth_rad,
        gain_db,
    }
}

/// A uniform linear array.
#[must_use]
pub fn linear(elements: usize, spacing_wavelengths: f64) -> Array {
    Array::UniformLinear {
        elements,
        spacing_wavelengths,
    }
}

/// \[sin(pi x) / (pi x)\]^2.
#[must_use]
pub fn squared_sinc(x: DoubleDouble) -> DoubleDouble {
    if x == DoubleDouble::ZERO {
        return DoubleDouble::ONE;
    }
    let sinc = x.sin_cos_pi().0 / (PI * x);
    sinc * sinc
}

/// The squared, normalised array factor between two directions \[half turns\].
#[must_use]
pub fn array_response(array: &Array, theta: DoubleDouble, theta_k: DoubleDouble) -> DoubleDouble {
    match *array {
        Array::UniformLinear {
            elements,
            spacing_wavelengths,
        } => {
            let psi = dd(spacing_wavelengths) * (theta.sin_cos_pi().0 - theta_k.sin_cos_pi().0);
            let n = dd(elements as f64);
            let below = psi.sin_cos_pi().0;
            // Closer to a multiple of pi than the digits reach.
            if below.abs().high < 1e-28 {
                return DoubleDouble::ONE;
            }
            let ratio = (n * psi).sin_cos_pi().0 / (n * below);
            ratio * ratio
        }
        Array::UniformCircular {
            elements,
            radius_wavelengths,
        } => {
            let n = dd(elements as f64);
            let (mut re, mut im) = (DoubleDouble::ZERO, DoubleDouble::ZERO);
            for m in 0..elements {
                let phi = dd(2.0 * m as f64) / n;
                let cosine = |angle: DoubleDouble| (angle - phi).sin_cos_pi().1;
                let phase = dd(2.0 * radius_wavelengths) * (cosine(theta) - cosine(theta_k));
                let (sin, cos) = phase.sin_cos_pi();
                (re, im) = (re + cos, im + sin);
            }
            (re * re + im * im) / (n * n)
        }
        _ => unreachable!("two kinds of arrays"),
    }
}

/// Q(tau, theta), linear, in the protocol's unit; `tau` \[s\], `theta` in half turns in the
/// protocol's sense. Every path counts.
#[must_use]
pub fn q(
    config: &LabelConfig,
    paths: &[PathSample],
    tau: DoubleDouble,
    theta: DoubleDouble,
) -> DoubleDouble {
    let towards_source = match config.protocol {
        Protocol::Released => theta - DoubleDouble::ONE,
        Protocol::Paper => theta,
    };
    let send_db = dd(config.protocol.sent_power_db());
    paths
        .iter()
        .map(|path| {
            let power = (dd(path.gain_db) + send_db).from_decibel();
            let pulse = squared_sinc(dd(config.sampling_rate_hz) * (tau - dd(path.delay_s)));
            let from = dd(path.arrival_azimuth_rad) / PI;
            power * pulse * array_response(&config.array, towards_source, from)
        })
        .sum()
}
