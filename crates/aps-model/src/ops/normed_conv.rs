//! A convolution with the batch normalisation behind it.

use std::sync::Arc;

use candle_core::{Result, Tensor};

use super::conv2d::conv_shape;
use super::cpu::{apply, are_fast};
use super::norm::inverse_std;
use super::{BatchNormTensors, add_relu, batch_norm, conv2d};
use crate::kernels::KernelCache;
use crate::kernels::convolution::convolve;
use crate::kernels::epilogue::Epilogue;

/// The tensors and sizes of a convolution, as [`conv2d`] takes them.
#[derive(Debug, Clone)]
pub(crate) struct ConvTensors {
    /// (out, in, height, width)
    pub weight: Tensor,
    /// (out)
    pub bias: Option<Tensor>,
    /// Pixels from one output to the next.
    pub stride: usize,
    /// Zeros on each side: (vertical, horizontal).
    pub padding: (usize, usize),
    /// Kernel cache of the weight, which must then never change; a cache belongs to one weight alone.
    pub cache: Option<Arc<KernelCache>>,
}

/// Activation after a normalised convolution.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Activation<'a> {
    Identity,
    Relu,
    /// ReLU of the sum with a tensor of the result's shape.
    AddRelu(&'a Tensor),
}

/// [`conv2d`], then [`batch_norm`], then the `activation`: one function, because without training (in evaluation, with
/// tensors no gradient is asked of) f32 on the CPU does it all while the sums are in cache.
pub(crate) fn normed_conv2d(
    x: &Tensor,
    conv: &ConvTensors,
    norm: BatchNormTensors<'_>,
    activation: Activation<'_>,
    train: bool,
) -> Result<Tensor> {
    if !train && let Some(y) = fused(x, conv, norm, activation)? {
        return Ok(y);
    }
    let bias = conv.bias.as_ref();
    let y = conv2d(x, &conv.weight, bias, conv.stride, conv.padding)?;
    match activation {
        Activation::Identity => batch_norm(&y, norm, train, false),
        Activation::Relu => batch_norm(&y, norm, train, true),
        Activation::AddRelu(shortcut) => add_relu(&batch_norm(&y, norm, train, false)?, shortcut),
    }
}

/// Computes all of it in one operation, where a gradient is asked of nothing and the fast path knows the tensors.
fn fused(
    x: &Tensor,
    conv: &ConvTensors,
    norm: BatchNormTensors<'_>,
    activation: Activation<'_>,
) -> Result<Option<Tensor>> {
    let Some(s) = conv_shape(x, &conv.weight, conv.stride, conv.padding) else {
        return Ok(None);
    };
    let (running_mean, running_var) = (norm.running_mean.as_tensor(), norm.running_var.as_tensor());
    let shortcut = match activation {
        Activation::AddRelu(shortcut) => Some(shortcut),
        Activation::Identity | Activation::Relu => None,
    };
    let mut of_channels = vec![norm.weight, norm.bias, running_mean, running_var];
    of_channels.extend(&conv.bias);
    let fits = of_channels.iter().all(|t| t.dims() == [s.out_channels])
        && shortcut.is_none_or(|t| t.dims() == s.out_dims());
    let mut learnt = vec![x, &conv.weight, norm.weight, norm.bias];
    learnt.extend(conv.bias.iter().chain(shortcut));
    let is_known = are_fast(&of_channels) && shortcut.is_none_or(|t| are_fast(&[t]));
    if !fits || !is_known || learnt.iter().any(|t| t.track_op()) {
        return Ok(None);
    }
    let (scale, shift) = folded(norm, conv.bias.as_ref())?;
    let (cache, relu) = (
        conv.cache.clone(),
        !matches!(activation, Activation::Identity),
    );
    let forward = move |x: &[f32], weight: &[f32], shortcut: Option<&[f32]>| {
        let epilogue = Epilogue {
            scale: Some(&scale),
            shift: Some(&shift),
            shortcut,
            relu,
        };
        convolve(&s, x, weight, cache.as_deref(), epilogue)
    };
    let (name, dims, weight) = ("normalised conv2d", s.out_dims(), &conv.weight);
    let y = match shortcut {
        None => {
            let forward = move |[x, w]: [&[f32]; 2]| forward(x, w, None);
            apply(name, [x, weight], &dims, forward, |_| [None, None])
        }
        Some(added) => {
            let forward = move |[x, w, added]: [&[f32]; 3]| forward(x, w, Some(added));
            apply(name, [x, weight, added], &dims, forward, |_| {
                [None, None, None]
            })
        }
    };
    y.map(Some)
}

/// Returns batch normalisation with the running statistics, a bias before it included, as a factor and a summand a channel.
fn folded(norm: BatchNormTensors<'_>, bias: Option<&Tensor>) -> Result<(Vec<f32>, Vec<f32>)> {
    let mut scale: Vec<f32> = norm.weight.to_vec1()?;
    let mut shift: Vec<f32> = norm.bias.to_vec1()?;
    let mean: Vec<f32> = norm.running_mean.to_vec1()?;
    let inverse_std = inverse_std(&norm.running_var.to_vec1()?);
    let bias: Vec<f32> = match bias {
        Some(bias) => bias.to_vec1()?,
        None => vec![0.0; scale.len()],
    };
    for (c, scale) in scale.iter_mut().enumerate() {
        *scale *= inverse_std[c];
        // One sum in f64: the mean may be large against the deviation.
        let moved = f64::from(bias[c]) - f64::from(mean[c]);
        shift[c] = (f64::from(shift[c]) + moved * f64::from(*scale)) as f32;
    }
    Ok((scale, shift))
}
