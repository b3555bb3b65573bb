//! Batch normalisation on the CPU, with the ReLU behind it in the same pass.

use candle_core::{CpuStorage, CustomOp3, Layout, Result, Shape, Tensor, Var};

use super::storage::{are_fast, made, slice, with_slices};
use crate::kernels::batch_norm::{gradient, gradient_sums, moments, scale_shift};
use crate::portable::{self, BatchNormTensors, EPSILON, MOMENTUM};
use crate::{Error, Mode};

/// [`portable::batch_norm`], with f32 on the CPU in two passes forward and two backward.
pub fn batch_norm(
    x: &Tensor,
    tensors: BatchNormTensors<'_>,
    mode: Mode<'_>,
) -> crate::Result<Tensor> {
    match fast(x, tensors, mode, false)? {
        Some(y) => Ok(y),
        None => portable::batch_norm(x, tensors, mode),
    }
}

/// [`portable::batch_norm_relu`], as [`batch_norm`].
pub fn batch_norm_relu(
    x: &Tensor,
    tensors: BatchNormTensors<'_>,
    mode: Mode<'_>,
) -> crate::Result<Tensor> {
    match fast(x, tensors, mode, true)? {
        Some(y) => Ok(y),
        None => portable::batch_norm_relu(x, tensors, mode),
    }
}

fn fast(
    x: &Tensor,
    t: BatchNormTensors<'_>,
    mode: Mode<'_>,
    relu: bool,
) -> crate::Result<Option<Tensor>> {
    let (mean, var) = (t.running_mean.as_tensor(), t.running_var.as_tensor());
    if !are_fast(&[x, t.weight, t.bias, mean, var]) || x.rank() < 2 || x.elem_count() == 0 {
        return Ok(None);
    }
    let x = x.contiguous()?;
    let channels = x.dim(1)?;
    if t.weight.dims() != [channels] || t.bias.dims() != [channels] {
        return Ok(None);
    }
    let pixels = x.elem_count() / (x.dim(0)? * channels);
    let (mean, variance) = if mode.is_training() {
        let count = x.elem_count() / channels;
        if count < 2 {
            let found = x.dims().to_vec();
            return Err(Error::OneValueAChannel { found });
        }
        let m = with_slices([&x], |[x]| moments(x, channels, pixels))?;
        let unbiased = count as f64 / (count - 1) as f64;
        move_towards(t.running_mean, &m.mean, 1.0)?;
        move_towards(t.running_var, &m.variance, unbiased)?;
        (m.mean, m.variance)
    } else {
        (mean.to_vec1()?, var.to_vec1()?)
    };
    let op = BatchNorm {
        mean,
        inverse_std: inverse_std(&variance),
        pixels,
        relu,
        is_training: mode.is_training(),
    };
    Ok(Some(x.apply_op3(
        &t.weight.contiguous()?,
        &t.bias.contiguous()?,
        op,
    )?))
}

pub(super) fn inverse_std(variance: &[f32]) -> Vec<f32> {
    let of = |&v| (1.0 / (f64::from(v) + EPSILON).sqrt()) as f32;
    variance.iter().map(of).collect()
}

fn move_towards(running: &Var, batch: &[f32], factor: f64) -> Result<()> {
    let mut values: Vec<f32> = running.to_vec1()?;
    for (v, &b) in values.iter_mut().zip(batch) {
        *v = ((1.0 - MOMENTUM) * f64::from(*v) + MOMENTUM * factor * f64::from(b)) as f32;
    }
    running.set(&Tensor::from_vec(
        values,
        running.shape(),
        running.device(),
    )?)
}

struct BatchNorm {
    mean: Vec<f32>,
    inverse_std: Vec<f32>,
    pixels: usize,
    relu: bool,
    is_training: bool,
}

impl CustomOp3 for BatchNorm {
    fn name(&self) -> &'static str {
        "batch_norm"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
        bias: &CpuStorage,
        bias_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let weight = slice(weight, weight_layout)?;
        let bias = slice(bias, bias_layout)?;
        let scale: Vec<f32> = weight
            .iter()
            .zip(&self.inverse_std)
            .map(|(w, i)| w * i)
            .collect();
        let x = slice(x, x_layout)?;
        let y = scale_shift(x, &self.mean, &scale, bias, self.pixels, self.relu);
        made(y, x_layout.shape().clone())
    }

    fn bwd(
        &self,
        x: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
        y: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let grad = grad.contiguous()?;
        let (by_input, by_weight, by_bias) = with_slices([x, weight, y, &grad], |[x, w, y, g]| {
            let y = self.relu.then_some(y);
            let moments = (&self.mean[..], &self.inverse_std[..]);
            let (sum, product) = gradient_sums(x, y, g, moments, self.pixels);
            let count = (x.len() / w.len()) as f32;
            let factors: Vec<[f32; 4]> = (0..w.len())
                .map(|c| {
                    let a = w[c] * self.inverse_std[c];
                    if !self.is_training {
                        return [a, 0.0, 0.0, 0.0];
                    }
                    // a (g - mean(g) - x^ mean(g x^)), with x^ = (x - mean) inverse_std.
                    let b = -a * product[c] / count * self.inverse_std[c];
                    [a, b, -a * sum[c] / count, self.mean[c]]
                })
                .collect();
            (gradient(x, y, g, &factors, self.pixels), product, sum)
        })?;
        Ok((
            Some(Tensor::from_vec(by_input, x.shape(), x.device())?),
            Some(Tensor::from_vec(
                by_weight,
                weight.shape(),
                weight.device(),
            )?),
            Some(Tensor::from_vec(by_bias, bias.shape(), bias.device())?),
        ))
    }
}
