//! Convolution and transposed convolution on the CPU.

use candle_core::{CpuStorage, CustomOp2, CustomOp3, DType, Layout, Result, Shape, Tensor};
use rayon::prelude::*;

use super::storage::{are_fast, made, slice, with_slices};
use crate::kernels::finish::Finish;
use crate::kernels::{ConvShape, convolution::convolve, input_gradient, weight_gradient};
use crate::portable;

/// [`portable::conv2d`], with f32 on the CPU several times as fast: unfolded tiles that stay in cache, one matrix product a
/// tile, threads over the images (or over channels where images are small or few).
///
/// Half-precision values on the CPU are widened to f32 and the result rounded back, as candle does in its matrix products
/// of bf16; its convolution knows no bf16 there.
pub fn conv2d(
    x: &Tensor,
    weight: &Tensor,
    bias: Option<&Tensor>,
    stride: usize,
    padding: (usize, usize),
) -> crate::Result<Tensor> {
    if x.device().is_cpu() && matches!(x.dtype(), DType::BF16 | DType::F16) {
        // Weights have the precision of x, whatever they are stored in.
        let wide = |t: &Tensor| t.to_dtype(x.dtype())?.to_dtype(DType::F32);
        let bias = bias.map(wide).transpose()?;
        let y = conv2d(&wide(x)?, &wide(weight)?, bias.as_ref(), stride, padding)?;
        return Ok(y.to_dtype(x.dtype())?);
    }
    let Some(shape) = shape_of(x, weight, stride, padding).filter(|s| s.is_valid()) else {
        return portable::conv2d(x, weight, bias, stride, padding);
    };
    let op = Conv(shape);
    let (x, weight) = (x.contiguous()?, weight.contiguous()?);
    Ok(match bias {
        Some(bias) if are_fast(&[bias]) => x.apply_op3(&weight, &bias.contiguous()?, op)?,
        Some(_) => return portable::conv2d(&x, &weight, bias, stride, padding),
        None => x.apply_op2(&weight, op)?,
    })
}

/// [`portable::conv_transpose2x2`]: the input gradient of a convolution, and computed as that.
pub fn conv_transpose2x2(
    x: &Tensor,
    weight: &Tensor,
    bias: Option<&Tensor>,
) -> crate::Result<Tensor> {
    let fast = are_fast(&[x, weight]) && x.rank() == 4 && x.elem_count() > 0;
    let Some(shape) = fast.then(|| transposed_shape(x, weight)).flatten() else {
        return portable::conv_transpose2x2(x, weight, bias);
    };
    let y = x
        .contiguous()?
        .apply_op2(&weight.contiguous()?, Transposed(shape))?;
    Ok(match bias {
        Some(bias) => y.broadcast_add(&bias.reshape((1, (), 1, 1))?)?,
        None => y,
    })
}

/// The sizes, if the fast path knows the tensors and they fit together.
pub(super) fn shape_of(
    x: &Tensor,
    w: &Tensor,
    stride: usize,
    padding: (usize, usize),
) -> Option<ConvShape> {
    let (batch, in_channels, height, width) = x.dims4().ok()?;
    let (out_channels, channels, kh, kw) = w.dims4().ok()?;
    (are_fast(&[x, w]) && channels == in_channels).then_some(ConvShape {
        batch,
        in_channels,
        height,
        width,
        out_channels,
        kernel: (kh, kw),
        stride,
        padding,
    })
}

/// The convolution whose input gradient the transposed one is.
fn transposed_shape(x: &Tensor, w: &Tensor) -> Option<ConvShape> {
    let (batch, channels, height, width) = x.dims4().ok()?;
    let (inputs, outputs, kh, kw) = w.dims4().ok()?;
    (channels == inputs && outputs > 0 && (kh, kw) == (2, 2)).then_some(ConvShape {
        batch,
        in_channels: outputs,
        height: 2 * height,
        width: 2 * width,
        out_channels: inputs,
        kernel: (2, 2),
        stride: 2,
        padding: (0, 0),
    })
}

struct Conv(ConvShape);

impl Conv {
    fn forward(
        &self,
        x: &[f32],
        weight: &[f32],
        bias: Option<&[f32]>,
    ) -> Result<(CpuStorage, Shape)> {
        let s = &self.0;
        let mut out = vec![0.0; s.output_len()];
        convolve(s, x, weight, None, Finish::bias(bias), &mut out);
        made(
            out,
            (s.batch, s.out_channels, s.out_height(), s.out_width()),
        )
    }
}

/// Gradients by input and weight, the former only where something asks for it.
fn gradients(
    s: &ConvShape,
    x: &Tensor,
    weight: &Tensor,
    grad: &Tensor,
) -> Result<(Option<Tensor>, Option<Tensor>)> {
    let (by_input, by_weight) = with_slices([x, weight, grad], |[x_, w, g]| {
        let by_input = x.track_op().then(|| {
            let mut out = vec![0.0; s.input_len()];
            input_gradient(s, g, w, &mut out);
            out
        });
        let mut by_weight = vec![0.0; s.weight_len()];
        weight_gradient(s, x_, g, &mut by_weight);
        (by_input, by_weight)
    })?;
    let by_input = by_input.map(|v| Tensor::from_vec(v, x.shape(), x.device()));
    let by_weight = Tensor::from_vec(by_weight, weight.shape(), weight.device())?;
    Ok((by_input.transpose()?, Some(by_weight)))
}

impl CustomOp2 for Conv {
    fn name(&self) -> &'static str {
        "conv2d"
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

    fn bwd(
        &self,
        x: &Tensor,
        weight: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        gradients(&self.0, x, weight, &grad.contiguous()?)
    }
}

impl CustomOp3 for Conv {
    fn name(&self) -> &'static str {
        "conv2d with bias"
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
        let bias = slice(bias, bias_layout)?;
        self.forward(
            slice(x, x_layout)?,
            slice(weight, weight_layout)?,
            Some(bias),
        )
    }

    fn bwd(
        &self,
        x: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let grad = grad.contiguous()?;
        let (by_input, by_weight) = gradients(&self.0, x, weight, &grad)?;
        let by_bias = with_slices([&grad], |[g]| {
            sums(g, self.0.out_channels, self.0.out_pixels())
        })?;
        let by_bias = Tensor::from_vec(by_bias, bias.shape(), bias.device())?;
        Ok((by_input, by_weight, Some(by_bias)))
    }
}

/// Sum over images and pixels of each channel, in f64.
fn sums(values: &[f32], channels: usize, pixels: usize) -> Vec<f32> {
    let sum_of = |c: usize| {
        let images = values.chunks_exact(channels * pixels);
        let planes = images.flat_map(|image| &image[c * pixels..][..pixels]);
        planes.map(|&v| f64::from(v)).sum::<f64>() as f32
    };
    (0..channels).into_par_iter().map(sum_of).collect()
}

struct Transposed(ConvShape);

impl CustomOp2 for Transposed {
    fn name(&self) -> &'static str {
        "transposed conv2d"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let s = &self.0;
        let mut out = vec![0.0; s.input_len()];
        input_gradient(
            s,
            slice(x, x_layout)?,
            slice(weight, weight_layout)?,
            &mut out,
        );
        made(out, (s.batch, s.in_channels, s.height, s.width))
    }

    fn bwd(
        &self,
        x: &Tensor,
        weight: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let s = &self.0;
        let grad = grad.contiguous()?;
        let (by_input, by_weight) = with_slices([x, weight, &grad], |[x, w, g]| {
            let mut by_input = vec![0.0; s.output_len()];
            convolve(s, g, w, None, Finish::default(), &mut by_input);
            let mut by_weight = vec![0.0; s.weight_len()];
            weight_gradient(s, g, x, &mut by_weight);
            (by_input, by_weight)
        })?;
        Ok((
            Some(Tensor::from_vec(by_input, x.shape(), x.device())?),
            Some(Tensor::from_vec(
                by_weight,
                weight.shape(),
                weight.device(),
            )?),
        ))
    }
}
