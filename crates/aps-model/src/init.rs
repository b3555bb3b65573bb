//! Initial values of tensors: PyTorch's distributions from a generator of our own.
//!
//! The values of a tensor follow from the seed and the tensor's name alone. So they do not depend on the order in which a
//! model is built, nor on the device or the machine: the generator is ChaCha8 with the name's hash as its stream, and the
//! elementary functions are `libm`'s.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Initial values of a tensor, in PyTorch's terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Init {
    /// The same value everywhere.
    Constant(f64),
    /// Uniform in [-bound, bound].
    Uniform {
        /// Half the width.
        bound: f64,
    },
    /// Normal with mean 0.
    Normal {
        /// Standard deviation.
        std: f64,
    },
}

impl Init {
    /// Zero everywhere.
    pub const ZEROS: Self = Self::Constant(0.0);
    /// One everywhere.
    pub const ONES: Self = Self::Constant(1.0);

    /// Uniform in ±1/sqrt(fan_in): PyTorch's choice for weight and bias of linear and convolution layers. PyTorch writes
    /// this as Kaiming's uniform distribution with the slope a = sqrt(5).
    pub fn fan_in(fan_in: usize) -> Self {
        let bound = 1.0 / (fan_in as f64).sqrt();
        Self::Uniform { bound }
    }

    /// Normal with variance 2 / fan_out, which keeps the size of gradients through ReLU (He et al., "Delving deep into
    /// rectifiers", ICCV 2015, eq. 14): torchvision's choice for the convolutions of ResNets.
    pub fn kaiming_fan_out(fan_out: usize) -> Self {
        let std = (2.0 / fan_out as f64).sqrt();
        Self::Normal { std }
    }

    /// Uniform in ±sqrt(6 / (fan_in + fan_out)) (Glorot and Bengio, AISTATS 2010, eq. 16): torchvision's choice for the
    /// attention and the perceptrons of vision transformers.
    pub fn xavier(fan_in: usize, fan_out: usize) -> Self {
        let bound = (6.0 / (fan_in + fan_out) as f64).sqrt();
        Self::Uniform { bound }
    }

    /// Draws the `count` values of the tensor `name` under `seed`.
    pub(crate) fn values(self, seed: u64, name: &str, count: usize) -> Vec<f64> {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(fnv1a(name));
        match self {
            Self::Constant(value) => vec![value; count],
            Self::Uniform { bound } => (0..count)
                .map(|_| bound * (2.0 * unit(&mut generator) - 1.0))
                .collect(),
            Self::Normal { std } => {
                let mut values = Vec::with_capacity(count + 1);
                while values.len() < count {
                    let (a, b) = normal_pair(&mut generator);
                    values.extend([std * a, std * b]);
                }
                values.truncate(count);
                values
            }
        }
    }
}

/// Draws a number uniform in [0, 1), with 53 random bits.
pub(crate) fn unit(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 * (-53.0_f64).exp2()
}

/// Draws two independent standard normal values (Box and Muller, Ann. Math. Statist. 29, 1958).
fn normal_pair(generator: &mut ChaCha8Rng) -> (f64, f64) {
    // 1 - u lies in (0, 1], so that the logarithm is finite.
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - unit(generator)));
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * unit(generator));
    (radius * cos, radius * sin)
}

/// Fowler, Noll and Vo's 64-bit hash.
fn fnv1a(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        (mean, variance)
    }

    #[test]
    fn values_follow_from_seed_and_name() {
        let draw = |seed, name| Init::fan_in(16).values(seed, name, 100);
        assert_eq!(draw(1, "fc.weight"), draw(1, "fc.weight"));
        assert_ne!(draw(1, "fc.weight"), draw(2, "fc.weight"));
        assert_ne!(draw(1, "fc.weight"), draw(1, "fc.bias"));
    }

    #[test]
    fn first_values_are_the_same_on_every_machine() {
        // Values of the first run: a change here changes every seeded training.
        let uniform = Init::Uniform { bound: 1.0 }.values(7, "a", 2);
        let normal = Init::Normal { std: 1.0 }.values(7, "a", 2);
        assert_eq!(uniform, [0.35640479366106637, -0.9101713007670271]);
        assert_eq!(normal, [1.4463098824789244, 0.41934795712579115]);
    }

    #[test]
    fn distributions_have_their_moments() {
        let n = 100_000;
        let (mean, variance) = moments(&Init::Uniform { bound: 3.0 }.values(1, "u", n));
        assert!(
            mean.abs() < 0.03 && (variance - 3.0).abs() < 0.05,
            "{mean} {variance}"
        );
        let (mean, variance) = moments(&Init::Normal { std: 2.0 }.values(1, "n", n));
        assert!(
            mean.abs() < 0.03 && (variance - 4.0).abs() < 0.1,
            "{mean} {variance}"
        );
        let kurtosis = moments(
            &Init::Normal { std: 1.0 }
                .values(1, "n", n)
                .iter()
                .map(|v| v * v)
                .collect::<Vec<_>>(),
        );
        assert!(
            (kurtosis.1 - 2.0).abs() < 0.1,
            "variance of the square of a normal value: {kurtosis:?}"
        );
    }

    #[test]
    fn bounds_are_pytorch_s() {
        // torch.nn.Linear(64, 8): kaiming_uniform_(a = sqrt 5) has gain sqrt(2 / 6) and bound sqrt(3) gain / sqrt(64).
        assert_eq!(Init::fan_in(64), Init::Uniform { bound: 0.125 });
        assert_eq!(Init::xavier(10, 14), Init::Uniform { bound: 0.5 });
        assert_eq!(Init::kaiming_fan_out(8), Init::Normal { std: 0.5 });
    }
}
