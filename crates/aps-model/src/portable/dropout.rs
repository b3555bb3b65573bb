//! Dropout.

use candle_core::Tensor;

use crate::init::unit;
use crate::{Mode, Result};

/// In training, zeroes each element with `probability` and scales the others by 1 / (1 - probability) (Srivastava et al.,
/// JMLR 15, 2014); else the identity.
///
/// The mask is drawn on the host, so that it is the same on every device.
pub fn dropout(x: &Tensor, probability: f64, mode: Mode<'_>) -> Result<Tensor> {
    if probability <= 0.0 {
        return Ok(x.clone());
    }
    let Some(mut generator) = mode.generator() else {
        return Ok(x.clone());
    };
    let scale = (1.0 / (1.0 - probability)) as f32;
    let mask: Vec<f32> = (0..x.elem_count())
        .map(|_| {
            if unit(&mut generator) < probability {
                0.0
            } else {
                scale
            }
        })
        .collect();
    let mask = Tensor::from_vec(mask, x.dims(), x.device())?.to_dtype(x.dtype())?;
    Ok((x * mask)?)
}
