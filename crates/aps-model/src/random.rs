//! Random numbers with the same bits on every machine: ChaCha8, and the elementary functions of `libm`.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Use of random numbers in training; each has streams of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    /// Shuffling of an epoch.
    Order,
    /// Dropout of a step.
    Dropout,
}

/// Returns the generator of one epoch or step.
pub(crate) fn generator(seed: u64, purpose: Purpose, number: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(number << 1 | purpose as u64);
    generator
}

/// Returns the generator of the initial values of the tensor `name`.
pub(crate) fn generator_of_tensor(seed: u64, name: &str) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(fnv1a(name.bytes()));
    generator
}

/// Draws a number uniform in [0, 1), with 53 random bits.
pub(crate) fn unit(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 * (-53.0_f64).exp2()
}

/// Draws two independent standard normal values (Box and Muller, Ann. Math. Statist. 29, 1958).
pub(crate) fn normal_pair(generator: &mut ChaCha8Rng) -> [f64; 2] {
    // 1 - u lies in (0, 1], so that the logarithm is finite.
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - unit(generator)));
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * unit(generator));
    [radius * cos, radius * sin]
}

/// Computes Fowler, Noll and Vo's 64-bit hash.
pub(crate) fn fnv1a(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
