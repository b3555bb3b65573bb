//! Weights, images and targets in closed form, as in `models.py`.

use candle_core::{Device, Tensor};
use candle_nn::VarMap;

use crate::ANGLE_BINS;
use crate::parameters::sorted;
use crate::random::fnv1a;

pub const BATCH: usize = 2;

/// SplitMix64 of name and index: one number an element.
pub fn mix(name: &str, count: usize) -> impl Iterator<Item = u64> {
    let start = fnv1a(name.bytes());
    (1..=count as u64).map(move |i| {
        let mut z = start.wrapping_add(i.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    })
}

/// Uniform in [-1, 1), multiples of 2^-23.
pub fn values(name: &str, count: usize) -> impl Iterator<Item = f64> {
    mix(name, count).map(|z| (z >> 40) as f64 / f64::from(1 << 23) - 1.0)
}

fn weights(name: &str, shape: &[usize]) -> Tensor {
    let last = name.rsplit('.').next().unwrap();
    let (centre, spread) = match (last, shape.len()) {
        ("running_var", _) => (1.0, 0.5),
        ("weight", 1) => (1.0, 0.2),
        (_, 1) | ("class_token" | "pos_embedding", _) => (0.0, 0.1),
        _ => {
            let gain = if name.contains(".block.") { 6.0 } else { 3.0 };
            let fan_in: usize = shape[1..].iter().product();
            (0.0, f64::sqrt(gain / fan_in as f64))
        }
    };
    let values = values(name, shape.iter().product());
    let data: Vec<f32> = values.map(|u| (centre + spread * u) as f32).collect();
    Tensor::from_vec(data, shape, &Device::Cpu).unwrap()
}

/// Overwrites every tensor but single numbers.
pub fn set_weights(parameters: &VarMap) {
    for (name, var) in sorted(parameters) {
        if var.rank() > 0 {
            let values = weights(&name, var.dims());
            var.set(&values.to_dtype(var.dtype()).unwrap()).unwrap();
        }
    }
}

/// Blocks of buildings and two bumps: (2, 3, size, size).
pub fn images(size: usize) -> Tensor {
    let side = size / 8;
    let blocks: Vec<f64> = values("blocks", BATCH * side * side).collect();
    let end = |u: f64| ((u + 1.0) / 2.0 * size as f64).floor();
    let ends: Vec<f64> = values("ends", BATCH * 4).map(end).collect();
    let mut data = Vec::with_capacity(BATCH * 3 * size * size);
    for b in 0..BATCH {
        for channel in 0..3 {
            for y in 0..size {
                for x in 0..size {
                    let value = match channel {
                        0 => f64::from(blocks[(b * side + y / 8) * side + x / 8] > 0.0),
                        _ => {
                            let end = &ends[(b * 2 + channel - 1) * 2..];
                            let (dx, dy) = (x as f64 - end[0], y as f64 - end[1]);
                            1.0 / (1.0 + (dx * dx + dy * dy) / 100.0)
                        }
                    };
                    data.push(value as f32);
                }
            }
        }
    }
    Tensor::from_vec(data, (BATCH, 3, size, size), &Device::Cpu).unwrap()
}

/// Spectra to learn: (2, 180).
pub fn targets() -> Tensor {
    let values = values("targets", BATCH * ANGLE_BINS);
    // Exact in single precision.
    let data: Vec<f32> = values.map(|u| (2.0 * u) as f32).collect();
    Tensor::from_vec(data, (BATCH, ANGLE_BINS), &Device::Cpu).unwrap()
}
