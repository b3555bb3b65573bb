//! A label's spectrum by plain loops, in any precision.
//!
//! The maximum over delay is taken on an axis, so that nothing but rounding is different from one kernel to the next.

use aps_label::{Labeler, PathSample};

use super::number::Number;

const ELEMENTS: usize = 16;
const SPACING: f64 = 0.5;
const RATE_HZ: f64 = 200e6;

/// The ways to a label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kernel {
    /// Every term of Q by the formula: delays x angles x paths sines.
    Direct,
    /// Pulse and array response as two thin matrices, then their product.
    Product,
    /// The same, its sines by recurrence: along the axis for the pulse, over the elements for the array.
    Recurrence,
}

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

impl Kernel {
    /// Every kernel.
    pub const ALL: [Self; 3] = [Self::Direct, Self::Product, Self::Recurrence];

    /// Name in a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Product => "product",
            Self::Recurrence => "recurrence",
        }
    }
}

/// The maximum of Q over the delays, in every direction [dB].
pub fn spectrum<T: Number>(kernel: Kernel, grid: &Grid, paths: &[PathSample]) -> Vec<f64> {
    let best: Vec<T> = match kernel {
        Kernel::Direct => direct(grid, paths),
        Kernel::Product => product(grid, paths, pulses_direct, |psi: T| {
            let below = psi.sin_pi();
            (T::of(ELEMENTS as f64) * psi).sin_pi() / (T::of(ELEMENTS as f64) * below)
        }),
        Kernel::Recurrence => product(grid, paths, pulses_by_rotation, dirichlet_by_recurrence),
    };
    best.into_iter()
        .map(|power| decibel(power.to_f64()))
        .collect()
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

pub fn squared_sinc<T: Number>(x: T) -> T {
    if x == T::of(0.0) {
        return T::of(1.0);
    }
    let sinc = x.sin_pi() / (T::of(std::f64::consts::PI) * x);
    sinc * sinc
}

fn direct<T: Number>(grid: &Grid, paths: &[PathSample]) -> Vec<T> {
    let n = T::of(ELEMENTS as f64);
    let maximum = |&theta: &f64| {
        let mut best = T::of(0.0);
        for &tau in &grid.delays_s {
            let mut sum = T::of(0.0);
            for path in paths {
                let psi = half_turns::<T>(theta, path);
                let below = psi.sin_pi();
                let response = match below == T::of(0.0) {
                    true => T::of(1.0),
                    false => (n * psi).sin_pi() / (n * below),
                };
                let x = T::of(RATE_HZ) * (T::of(tau) - T::of(path.delay_s));
                sum = sum + power::<T>(path) * squared_sinc(x) * response * response;
            }
            best = if sum > best { sum } else { best };
        }
        best
    };
    grid.angles_rad.iter().map(maximum).collect()
}

fn product<T: Number>(
    grid: &Grid,
    paths: &[PathSample],
    pulses: impl Fn(&Grid, &PathSample) -> Vec<T>,
    dirichlet: impl Fn(T) -> T,
) -> Vec<T> {
    let pulses: Vec<Vec<T>> = paths.iter().map(|path| pulses(grid, path)).collect();
    let maximum = |&theta: &f64| {
        let weight = |path: &PathSample| {
            let psi = half_turns::<T>(theta, path);
            let response = match psi.sin_pi() == T::of(0.0) {
                true => T::of(1.0),
                false => dirichlet(psi),
            };
            power::<T>(path) * response * response
        };
        let weights: Vec<T> = paths.iter().map(weight).collect();
        let mut sums = vec![T::of(0.0); grid.delays_s.len()];
        for (row, &weight) in pulses.iter().zip(&weights) {
            for (sum, &pulse) in sums.iter_mut().zip(row) {
                *sum = *sum + weight * pulse;
            }
        }
        sums.into_iter()
            .fold(T::of(0.0), |best, sum| if sum > best { sum } else { best })
    };
    grid.angles_rad.iter().map(maximum).collect()
}

pub fn pulse_places<T: Number>(delays_s: &[f64], delay_s: f64) -> impl Iterator<Item = T> {
    delays_s
        .iter()
        .map(move |&tau| T::of(RATE_HZ) * (T::of(tau) - T::of(delay_s)))
}

fn pulses_direct<T: Number>(grid: &Grid, path: &PathSample) -> Vec<T> {
    pulse_places(&grid.delays_s, path.delay_s)
        .map(squared_sinc)
        .collect()
}

fn pulses_by_rotation<T: Number>(grid: &Grid, path: &PathSample) -> Vec<T> {
    rotated_pulses(&grid.delays_s, path.delay_s)
}

/// The sines of equally spaced arguments, each from the one before by a rotation.
pub fn rotated_pulses<T: Number>(delays_s: &[f64], delay_s: f64) -> Vec<T> {
    let step = T::of(RATE_HZ) * T::of(delays_s[1] - delays_s[0]);
    let (step_sin, step_cos) = (step.sin_pi(), step.cos_pi());
    let first = T::of(RATE_HZ) * (T::of(delays_s[0]) - T::of(delay_s));
    let (mut sin, mut cos) = (first.sin_pi(), first.cos_pi());
    let pulse = |x: T| {
        let sinc = match x == T::of(0.0) {
            true => T::of(1.0),
            false => sin / (T::of(std::f64::consts::PI) * x),
        };
        (sin, cos) = (
            sin * step_cos + cos * step_sin,
            cos * step_cos - sin * step_sin,
        );
        sinc * sinc
    };
    pulse_places(delays_s, delay_s).map(pulse).collect()
}

/// sin(N psi) / (N sin psi) as the Chebyshev polynomial of the second kind, U_{N-1}(cos psi) / N.
fn dirichlet_by_recurrence<T: Number>(psi: T) -> T {
    let twice = T::of(2.0) * psi.cos_pi();
    let (mut before, mut now) = (T::of(1.0), twice);
    for _ in 2..ELEMENTS {
        (before, now) = (now, twice * now - before);
    }
    now / T::of(ELEMENTS as f64)
}

#[cfg(test)]
mod tests {
    use aps_label::LabelConfig;
    use aps_tests::double_double::DoubleDouble;

    use super::*;
    use crate::errors::SpectrumError;

    #[test]
    fn all_kernels_make_the_same_label() {
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
        for kernel in Kernel::ALL {
            let found = spectrum::<f64>(kernel, &grid, &paths);
            let error = SpectrumError::of(&own, Some(&found)).worst_db;
            assert!(error < 1e-9, "{kernel:?}: {error:e} dB");
        }
        let exact = spectrum::<DoubleDouble>(Kernel::Product, &grid, &paths);
        assert!(SpectrumError::of(&own, Some(&exact)).worst_db < 1e-9);
    }
}
