//! Targets of all examples on the device.

use candle_core::{DType, Device, Tensor};
use rayon::prelude::*;

use crate::ANGLE_BINS;
use crate::data::Examples;

/// Most bytes that targets take on a device: room for 23 million links.
const MAX_BYTES: usize = 8 << 30;

/// Examples that are written at a time.
const AT_ONCE: usize = 1 << 16;

/// Targets of all examples in half precision, (examples, bins), so that of a batch only the numbers of its examples are sent. 360
/// bytes an example, mirror images included: 0.83 GB for 2.3 million.
///
/// Rounding is at most 2^-11 of a value, less than the half precision of stored decibels leaves.
#[derive(Debug)]
pub(super) struct HeldTargets(Tensor);

impl HeldTargets {
    /// Puts the targets onto a device; `None` if it has no room for them, or they would take more than 8 GiB.
    pub fn new(examples: &dyn Examples, device: &Device) -> candle_core::Result<Option<Self>> {
        let count = examples.len();
        if count.saturating_mul(ANGLE_BINS * DType::F16.size_in_bytes()) > MAX_BYTES {
            return Ok(None);
        }
        // A device without room refuses.
        let Ok(all) = Tensor::zeros((count, ANGLE_BINS), DType::F16, device) else {
            return Ok(None);
        };
        for first in (0..count).step_by(AT_ONCE) {
            let numbers = first..(first + AT_ONCE).min(count);
            let shape = (numbers.len(), ANGLE_BINS);
            let values: Vec<f32> = numbers
                .into_par_iter()
                .flat_map_iter(|example| {
                    let mut target = [0.0; ANGLE_BINS];
                    examples.write_target(example, &mut target);
                    target
                })
                .collect();
            let part = Tensor::from_vec(values, shape, device)?.to_dtype(DType::F16)?;
            all.slice_set(&part, 0, first)?;
        }
        Ok(Some(Self(all)))
    }

    /// Targets of some examples, in f32.
    pub fn of(&self, examples: &[u32]) -> candle_core::Result<Tensor> {
        let numbers = Tensor::from_slice(examples, examples.len(), self.0.device())?;
        self.0.index_select(&numbers, 0)?.to_dtype(DType::F32)
    }
}
