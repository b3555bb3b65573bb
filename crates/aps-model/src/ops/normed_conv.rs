//! A convolution with the batch normalisation behind it.

use candle_core::{CpuStorage, CustomOp2, CustomOp3, Layout, Result, Shape, Tensor};

use super::conv2d::shape_of;
use super::norm::inverse_std;
use super::storage::{are_fast, made, slice};
use super::{BatchNormTensors, add_relu, batch_norm, batch_norm_relu, conv2d};
use crate::Mode;
use crate::kernels::finish::Finish;
use crate::kernels::{ConvShape, KeptKernels, convolution::convolve};

/// Kernel cache of the fast path, empty at first: it keeps the kernels of a convolution's weight, as they are multiplied
/// with, from one forward pass to the next. They take up to four times the memory of the weight.
#[derive(Debug, Default)]
pub struct Kept(KeptKernels);

/// The tensors and sizes of a convolution, as [`conv2d`] takes them.
#[derive(Debug, Clone, Copy)]
pub struct ConvTensors<'a> {
    /// (out, in, height, width)
    pub weight: &'a Tensor,
    /// (out)
    pub bias: Option<&'a Tensor>,
    /// Pixels from one output to the next.
    pub stride: usize,
    /// Zeros on each side: (vertical, horizontal).
    pub padding: (usize, usize),
    /// Kernel cache of the weight, which must never change; a cache belongs to one weight alone.
    pub kept: Option<&'a Kept>,
}

/// Operation after a normalised convolution.
#[derive(Debug, Clone, Copy)]
pub enum After<'a> {
    /// Nothing.
    Nothing,
    /// ReLU.
    Relu,
    /// ReLU of the sum with a tensor of the result's shape.
    AddRelu(&'a Tensor),
}

/// [`conv2d`], then [`batch_norm`], then the operation `after`: one function, because without training (in
/// [`Mode::Eval`], with tensors no gradient is asked of) f32 on the CPU does it all while the sums are in cache.
pub fn normed_conv2d(
    x: &Tensor,
    conv: ConvTensors<'_>,
    norm: BatchNormTensors<'_>,
    after: After<'_>,
    mode: Mode<'_>,
) -> crate::Result<Tensor> {
    if let Some(op) = at_once(x, conv, norm, after, mode)? {
        let (x, weight) = (x.contiguous()?, conv.weight.contiguous()?);
        return Ok(match after {
            After::AddRelu(shortcut) => {
                x.apply_op3_no_bwd(&weight, &shortcut.contiguous()?, &op)?
            }
            _ => x.apply_op2_no_bwd(&weight, &op)?,
        });
    }
    let y = conv2d(x, conv.weight, conv.bias, conv.stride, conv.padding)?;
    match after {
        After::Nothing => batch_norm(&y, norm, mode),
        After::Relu => batch_norm_relu(&y, norm, mode),
        After::AddRelu(shortcut) => add_relu(&batch_norm(&y, norm, mode)?, shortcut),
    }
}

/// The operation that does all of it, where there is one.
fn at_once<'a>(
    x: &Tensor,
    conv: ConvTensors<'a>,
    norm: BatchNormTensors<'_>,
    after: After<'_>,
    mode: Mode<'_>,
) -> crate::Result<Option<NormedConv<'a>>> {
    let shape = shape_of(x, conv.weight, conv.stride, conv.padding).filter(|s| s.is_valid());
    let Some(shape) = shape else {
        return Ok(None);
    };
    let of_channels = [
        Some(norm.weight),
        Some(norm.bias),
        Some(norm.running_mean.as_tensor()),
        Some(norm.running_var.as_tensor()),
        conv.bias,
    ];
    let shortcut = match after {
        After::AddRelu(shortcut) => Some(shortcut),
        After::Nothing | After::Relu => None,
    };
    let out_dims = [
        shape.batch,
        shape.out_channels,
        shape.out_height(),
        shape.out_width(),
    ];
    let fits = of_channels
        .iter()
        .flatten()
        .all(|t| t.dims() == [shape.out_channels])
        && shortcut.is_none_or(|s| s.dims() == out_dims);
    let learns = [x, conv.weight, norm.weight, norm.bias]
        .into_iter()
        .chain(conv.bias)
        .chain(shortcut)
        .any(|t| t.track_op());
    let mut read: Vec<&Tensor> = of_channels.into_iter().flatten().collect();
    read.extend(shortcut);
    if mode.is_training() || learns || !fits || !are_fast(&read) {
        return Ok(None);
    }
    let (scale, shift) = folded(norm, conv.bias)?;
    Ok(Some(NormedConv {
        shape,
        kept: conv.kept.map(|kept| &kept.0),
        scale,
        shift,
        relu: !matches!(after, After::Nothing),
    }))
}

/// Batch normalisation with the running statistics, a bias before it included, as a factor and a summand a channel.
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

struct NormedConv<'a> {
    shape: ConvShape,
    kept: Option<&'a KeptKernels>,
    scale: Vec<f32>,
    shift: Vec<f32>,
    relu: bool,
}

impl NormedConv<'_> {
    fn forward(
        &self,
        x: &[f32],
        weight: &[f32],
        shortcut: Option<&[f32]>,
    ) -> Result<(CpuStorage, Shape)> {
        let s = &self.shape;
        let finish = Finish {
            scale: Some(&self.scale),
            shift: Some(&self.shift),
            shortcut,
            relu: self.relu,
        };
        let mut out = vec![0.0; s.output_len()];
        convolve(s, x, weight, self.kept, finish, &mut out);
        made(
            out,
            (s.batch, s.out_channels, s.out_height(), s.out_width()),
        )
    }
}

impl CustomOp2 for NormedConv<'_> {
    fn name(&self) -> &'static str {
        "normalised conv2d"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        self.forward(slice(x, x_layout)?, slice(weight, weight_layout)?, None)
    }
}

impl CustomOp3 for NormedConv<'_> {
    fn name(&self) -> &'static str {
        "normalised conv2d with shortcut"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
        shortcut: &CpuStorage,
        shortcut_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let shortcut = slice(shortcut, shortcut_layout)?;
        self.forward(
            slice(x, x_layout)?,
            slice(weight, weight_layout)?,
            Some(shortcut),
        )
    }
}
