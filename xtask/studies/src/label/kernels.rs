//! A label's spectrum by plain loops, in any precision.
//!
//! The maximum over delay is taken on an axis, so that nothing but rounding is different from one kernel to the next.

use aps_label::{Labeler, PathSample};

use super::number::Number;

const ELEMENTS: usize = 16;
const SPACING: f64 = 0.5;
const RATE_HZ: f64 = 200e6;

/// Delays and directions of the grid.
pub struct Grid {
    delays_s: Vec<f64>,
    /// In the sense of the paths' angles [rad].
    angles_rad: Vec<f64>,
}

impl Grid {
    /// Takes the grid of a labeler whose angles are the direction of travel.
    pub fn of(labeler: &Labeler) -> Self {
        let towards_source = |deg: &f64| deg.to_radians() - std::f64::consts::PI;
        Self {
            delays_s: labeler.delays_s().to_vec(),
            angles_rad: labeler.angles_deg().iter().map(towards_source).collect(),
        }
    }
}

/// The maximum of Q over the delays, in every direction [dB].
pub fn spectrum<T: Number>(grid: &Grid, paths: &[PathSample]) -> Vec<f64> {
    let best = product::<T>(grid, paths).into_iter();
    best.map(|power| decibel(power.to_f64())).collect()
}

fn decibel(power: f64) -> f64 {
    10.0 * (power + 1e-35).log10()
}

/// pi d (sin theta - sin theta_k) in half turns.
fn half_turns<T: Number>(theta: f64, path: &PathSample) -> T {
    T::of(SPACING) * (T::of(theta).sin() - T::of(path.arrival_azimuth_rad).sin())
}

fn power<T: Number>(path: &PathSample) -> T {
    T::of(10_f64.powf(0.1 * path.gain_db))
}

fn squared_sinc<T: Number>(x: T) -> T {
    if x == T::of(0.0) {
        return T::of(1.0);
    }
    let sinc = x.sin_pi() / (T::of(std::f64::consts::PI) * x);
    sinc * sinc
}

/// sin(N psi) / (N sin psi), psi in half turns.
fn dirichlet<T: Number>(psi: T) -> T {
    let n = T::of(ELEMENTS as f64);
    let below = psi.sin_pi();
    match below == T::of(0.0) {
        true => T::of(1.0),
        false => (n * psi).sin_pi() / (n * below),
    }
}

fn pulse<T: Number>(tau_s: f64, path: &PathSample) -> T {
    squared_sinc(T::of(RATE_HZ) * (T::of(tau_s) - T::of(path.delay_s)))
}

/// Pulse and array response as two thin matrices, then the largest element of each column of their product.
fn product<T: Number>(grid: &Grid, paths: &[PathSample]) -> Vec<T> {
    let pulses = |path: &PathSample| -> Vec<T> {
        let delays = grid.delays_s.iter();
        delays.map(|&tau_s| pulse(tau_s, path)).collect()
    };
    let pulses: Vec<Vec<T>> = paths.iter().map(pulses).collect();
    let maximum = |&theta: &f64| {
        let mut sums = vec![T::of(0.0); grid.delays_s.len()];
        for (row, path) in pulses.iter().zip(paths) {
            let response = dirichlet(half_turns::<T>(theta, path));
            let weight = power::<T>(path) * response * response;
            for (sum, &pulse) in sums.iter_mut().zip(row) {
                *sum = *sum + weight * pulse;
            }
        }
        let larger = |best: T, sum: T| if sum > best { sum } else { best };
        sums.into_iter().fold(T::of(0.0), larger)
    };
    grid.angles_rad.iter().map(maximum).collect()
}

#[cfg(test)]
mod tests {
    use aps_label::LabelConfig;
    use aps_tests::double_double::DoubleDouble;

    use super::*;
    use crate::errors::SpectrumError;

    #[test]
    fn plain_loops_make_the_same_label() {
        let paths = [
            PathSample {
                delay_s: 200e-9,
                arrival_azimuth_rad: 0.4,
                gain_db: -80.0,
            },
            PathSample {
                delay_s: 333e-9,
                arrival_azimuth_rad: -2.0,
                gain_db: -91.0,
            },
        ];
        let labeler = Labeler::new(&LabelConfig::released()).unwrap();
        let grid = Grid::of(&labeler);
        let own = labeler.label(&paths).unwrap().unwrap();
        let own: Vec<f64> = own
            .aps_db
            .iter()
            .map(|db| db - labeler.config().protocol.sent_power_db())
            .collect();
        let plain = spectrum::<f64>(&grid, &paths);
        let error = SpectrumError::of(&own, Some(&plain)).worst_db;
        assert!(error < 1e-9, "{error:e} dB");
        let exact = spectrum::<DoubleDouble>(&grid, &paths);
        assert!(SpectrumError::of(&own, Some(&exact)).worst_db < 1e-9);
    }
}
